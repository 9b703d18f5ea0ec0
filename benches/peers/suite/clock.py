"""Clocks: both sides in turn, in one process; results compared before anything is timed."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Work = Callable[[], Any]


@dataclass
class Case:
    """The same work for both."""

    group: str
    name: str
    peer: str
    pixels: int
    theirs: Work
    ours: Work
    goal: float | None = None
    """The ratio that is aimed at, on one thread."""
    most: float = 1.0
    """Largest difference of results, at all but one in ten thousand numbers; infinite where they may differ."""
    moved: float | None = None
    """Bytes a pixel that must be read or written at the least."""
    limit: str = ""
    """What limits a case that is lost."""


@dataclass
class Timed:
    """Times of a case, in seconds."""

    case: Case
    threads: int
    theirs: list[float] = field(default_factory=list)
    ours: list[float] = field(default_factory=list)

    @property
    def ratio(self) -> float:
        return float(np.median(self.theirs) / np.median(self.ours))

    def rate(self, who: str) -> float:
        """Mpx/s by the median."""
        return float(self.case.pixels / np.median(getattr(self, who)) / 1e6)

    def spread(self, who: str) -> float:
        """Distance between quartiles over the median."""
        low, middle, high = np.percentile(getattr(self, who), [25, 50, 75])
        return float((high - low) / middle)


def compare(case: Case) -> str:
    """What is wrong with the results, if anything."""
    results = [work() for work in (case.theirs, case.ours)]
    if np.isinf(case.most):
        return ""
    theirs, ours = (np.asarray(result, np.float64) for result in results)
    difference = np.abs(theirs.reshape(ours.shape) - ours)
    share = float((difference > case.most).mean())
    return f"{share:.1%} of the results differ, by up to {difference.max():g}" if share > 1e-4 else ""


def alternate(case: Case, threads: int, rounds: int, enough: float = 2.0) -> Timed:
    """Runs both in turn, until there are so many rounds or seconds. One thread is timed by what the processor gave it, more by
    the clock on the wall."""
    clock = time.thread_time if threads == 1 else time.perf_counter
    timed = Timed(case, threads)
    for done in range(rounds):
        for work, times in ((case.theirs, timed.theirs), (case.ours, timed.ours)):
            start = clock()
            work()
            times.append(clock() - start)
        if done >= 2 and sum(timed.theirs) + sum(timed.ours) > enough:
            break
    return timed


def nanoseconds(work: Work, pixels: int, rounds: int = 5) -> float:
    """Nanoseconds a pixel of one thread, the median."""
    work()
    times = []
    for _ in range(rounds):
        start = time.thread_time()
        work()
        times.append(time.thread_time() - start)
        if sum(times) > 1.0 and len(times) > 1:
            break
    return 1e9 * float(np.median(times)) / pixels


def codes(random: np.random.Generator, shape: tuple[int, ...], dtype: Any) -> NDArray[Any]:
    """Noise of codes 0 to 254."""
    return (random.random(shape, np.float32) * 255).astype(dtype)
