"""Arguments that several functions take, brought into one form."""

import operator
from collections.abc import Sequence
from typing import SupportsIndex


def wrap_pair(wrap: str | Sequence[str]) -> tuple[str, str]:
    """The wrap modes of the two axes; one word stands for both."""
    if isinstance(wrap, str):
        return wrap, wrap
    pair = tuple(wrap) if isinstance(wrap, Sequence) else ()
    if len(pair) != 2 or not all(isinstance(mode, str) for mode in pair):
        raise TypeError(f"wrap: got {wrap!r}, expected a name or a pair (u, v) of names")
    return pair[0], pair[1]


def count(argument: str, value: SupportsIndex | None) -> int | None:
    """A whole number of at least 1, or None."""
    if value is None:
        return None
    number = operator.index(value)
    if number < 1:
        raise ValueError(f"{argument}: got {number}, expected at least 1")
    return number
