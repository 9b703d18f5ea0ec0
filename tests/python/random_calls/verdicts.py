"""A call, and what became of it."""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


@dataclass
class Call:
    """One call of both libraries."""

    name: str
    """Of the function."""
    theirs: Callable[[], Any]
    ours: Callable[[], Any]
    text: str
    """What was drawn, for people."""
    step: float = 1.0
    """Difference that integers may show."""
    rounding: float = 1e-5
    """Difference that floats may show, in units of the greatest number that they hold."""
    warnings: bool = False
    """Whether both must warn alike."""
    reason: str | None = None
    """The paragraph of docs/peers.md that this call falls under, if it does."""


@dataclass
class Verdict:
    """How many calls of a function there were, and which differed."""

    calls: int = 0
    refused: int = 0
    """By both."""
    explained: dict[str, int] = field(default_factory=dict)
    different: list[str] = field(default_factory=list)

    @property
    def equal(self) -> int:
        return self.calls - len(self.different) - sum(self.explained.values())


def outcome(work: Callable[[], Any]) -> tuple[Any, set[str]]:
    """The result or the exception, and the names of the warnings' kinds."""
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        try:
            result = work()
        except Exception as reason:
            result = reason
    return result, {warning.category.__name__ for warning in heard}


def arrays(result: Any) -> list[Array]:
    if result is None:
        return []
    if isinstance(result, tuple | list):
        return [a for part in result for a in arrays(part)]
    return [np.asarray(result)]


def difference(call: Call, want: Any, got: Any) -> str | None:
    """What is different, in words."""
    if isinstance(want, Exception) or isinstance(got, Exception):
        if isinstance(want, Exception) and isinstance(got, Exception):
            return None
        refused, taken = ("theirs", want) if isinstance(want, Exception) else ("ours", got)
        return f"{refused} raises {type(taken).__name__}: {str(taken).strip()[-160:]}"
    theirs, ours = arrays(want), arrays(got)
    if len(theirs) != len(ours):
        return f"{len(ours)} arrays for {len(theirs)}"
    for w, g in zip(theirs, ours, strict=True):
        if w.shape != g.shape or w.dtype != g.dtype:
            return f"{g.dtype} {g.shape} for {w.dtype} {w.shape}"
        a, b = w.astype(np.float64), g.astype(np.float64)
        strange = ~(np.isfinite(a) & np.isfinite(b))
        same = (a == b) | (np.isnan(a) & np.isnan(b))
        if (strange & ~same).any():
            return f"{int((strange & ~same).sum())} numbers are finite in one alone"
        apart = np.where(strange, 0, np.abs(a - b)) if a.size else np.zeros(1)
        scale = float(np.abs(a[~strange]).max(initial=1.0))
        bound = call.step if w.dtype.kind in "iu" else call.rounding * scale
        if apart.max() > bound:
            return f"{int((apart > bound).sum())} of {a.size} by more than {bound:.3g}, at most {apart.max():.4g}"
    return None


def run(calls: Iterator[Call]) -> dict[str, Verdict]:
    """Makes the calls and sums up by function."""
    found: dict[str, Verdict] = {}
    for call in calls:
        verdict = found.setdefault(call.name, Verdict())
        verdict.calls += 1
        (want, warned), (got, heard) = outcome(call.theirs), outcome(call.ours)
        if isinstance(want, Exception) and isinstance(got, Exception):
            verdict.refused += 1
        what = difference(call, want, got)
        if what is None and call.warnings and warned != heard and not isinstance(want, Exception):
            what = f"warns {sorted(heard)} for {sorted(warned)}"
        if what is None:
            continue
        if call.reason is None:
            verdict.different.append(f"{call.text}: {what}")
        else:
            verdict.explained[call.reason] = verdict.explained.get(call.reason, 0) + 1
    return found
