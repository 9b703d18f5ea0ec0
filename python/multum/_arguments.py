"""Arguments that several functions take, brought into one form."""

import operator
import sys
from collections.abc import Sequence
from typing import Any, SupportsFloat, SupportsIndex, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray


def wrap_pair(wrap: str | Sequence[str]) -> tuple[str, str]:
    """The wrap modes of the two axes; one word stands for both."""
    if isinstance(wrap, str):
        return wrap, wrap
    pair = tuple(wrap) if isinstance(wrap, Sequence) else ()
    if len(pair) != 2 or not all(isinstance(mode, str) for mode in pair):
        raise TypeError(f"wrap: got {wrap!r}, expected a name or a pair (u, v) of names")
    return pair[0], pair[1]


@overload
def count(argument: str, value: SupportsIndex, least: int = 1, most: int = sys.maxsize) -> int: ...
@overload
def count(
    argument: str, value: SupportsIndex | None, least: int = 1, most: int = sys.maxsize
) -> int | None: ...
def count(argument: str, value: SupportsIndex | None, least: int = 1, most: int = sys.maxsize) -> int | None:
    """A whole number from ``least`` to ``most``, or None."""
    if value is None:
        return None
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{argument}: got {value!r}, expected a whole number") from None
    if not least <= number <= most:
        raise ValueError(f"{argument}: got {number}, expected at least {least} and at most {most}")
    return number


@overload
def number(argument: str, value: SupportsFloat) -> float: ...
@overload
def number(argument: str, value: SupportsFloat | None) -> float | None: ...
def number(argument: str, value: SupportsFloat | None) -> float | None:
    """A number, or None."""
    if value is None:
        return None
    # Text has a __float__ of sorts in float(), but is no number.
    if isinstance(value, (str, bytes, bytearray)):
        raise TypeError(f"{argument}: got {value!r}, expected a number")
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{argument}: got {value!r}, expected a number") from None


def name(argument: str, value: str) -> str:
    """A word."""
    if not isinstance(value, str):
        raise TypeError(f"{argument}: got {value!r}, expected a name")
    return value


def numbers(argument: str, value: ArrayLike | None, channels: int) -> list[float]:
    """One number a channel from one number, several, or None (zeros)."""
    if value is None:
        return [0.0] * channels
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{argument}: got {value!r}, expected numbers") from None
    if array.ndim > 1 or array.size not in (1, channels):
        expected = "one number" if channels == 1 else f"one number or {channels}"
        raise ValueError(f"{argument}: got shape {array.shape}, expected {expected}")
    return [float(x) for x in np.broadcast_to(array, channels)]


def broadcast(argument: str, value: ArrayLike | None, shape: tuple[int, ...]) -> NDArray[Any] | None:
    """An array of this shape, repeated along axes where it has fewer or single ones."""
    if value is None:
        return None
    array = np.asarray(value)
    if array.shape == shape:
        return array
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise ValueError(
            f"{argument}: got shape {array.shape}, expected {shape} or one that broadcasts to it"
        ) from None


def size_pair(
    argument: str, value: Sequence[SupportsIndex], order: str = "(height, width)"
) -> tuple[int, int]:
    """Two whole numbers of at least 1."""
    try:
        first, second = (operator.index(n) for n in value)
    except (TypeError, ValueError):
        raise TypeError(f"{argument}: got {value!r}, expected two whole numbers {order}") from None
    if not (1 <= first <= sys.maxsize and 1 <= second <= sys.maxsize):
        raise ValueError(
            f"{argument}: got {(first, second)}, expected numbers of at least 1 that memory can hold"
        )
    return first, second


def image_size(value: Sequence[SupportsIndex]) -> tuple[int, int]:
    """The argument ``size``: width and height."""
    return size_pair("size", value, "(width, height)")


def finite_matrix(argument: str, value: ArrayLike, shapes: Sequence[tuple[int, int]]) -> NDArray[np.float64]:
    """Finite numbers of one of the shapes."""
    expected = f"finite numbers of shape {' or '.join(map(str, shapes))}"
    try:
        matrix = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{argument}: got {value!r}, expected {expected}") from None
    if matrix.shape not in shapes or not np.isfinite(matrix).all():
        got = f"shape {matrix.shape}" if matrix.shape not in shapes else "a number that is not finite"
        raise ValueError(f"{argument}: got {got}, expected {expected}")
    return matrix


def side_or_size(value: SupportsIndex | Sequence[SupportsIndex]) -> tuple[int, int]:
    """The argument ``size`` where one number stands for both sides."""
    if isinstance(value, np.ndarray):
        return image_size(value.tolist())
    if isinstance(value, Sequence):
        return image_size(value)
    return image_size((value, value))
