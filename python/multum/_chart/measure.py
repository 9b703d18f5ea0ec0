"""Clocks and errors: every method of a case in turn, round after round, in one process on one thread."""

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .method import Case, Method, Run, Unavailable
from .truth import cut

_AT_LEAST = 0.004
"""Seconds that a round gives a method; quick ones run several times."""
_ENOUGH = 1.0
"""Seconds after which no more calls are made."""


@dataclass(frozen=True)
class Point:
    """What was measured of one method in one case."""

    scene: str
    texture: str
    method: str
    family: str
    kind: str
    ns: float
    """Nanoseconds a pixel, the least of all calls."""
    ns_median: float
    rms: float
    """Root mean square error in codes of 255."""
    max: float
    """Largest error of any channel, in codes of 255."""


@dataclass(frozen=True)
class Absence:
    """A method that took no part in a case, and why."""

    scene: str
    texture: str
    method: str
    family: str
    kind: str
    reason: str


@dataclass
class Contest:
    """One case's points, absences, and the picture that each method made."""

    points: list[Point]
    absences: list[Absence]
    pictures: dict[tuple[str, str, str], NDArray[Any]]


def errors(
    picture: NDArray[np.float64], truth: NDArray[np.float64], places: NDArray[np.int64]
) -> tuple[float, float]:
    """Root mean square and largest error at the pixels of the blocks at ``places``."""
    off = cut(picture, places) - truth
    return float(np.sqrt(np.mean(off**2))), float(np.max(np.abs(off)))


def codes(result: Any, run: Run, kind: str) -> NDArray[np.float64]:
    """The picture in codes of 255: warps rounded to 8 bits, look-ups as they are."""
    picture = np.asarray(result, np.float64) * run.scale
    return np.clip(np.rint(picture), 0, 255) if kind == "warp" else picture


def contest(
    case: Case,
    methods: list[Method],
    places: NDArray[np.int64],
    truth: NDArray[np.float64],
    rounds: int,
    tell: Callable[[str], None] = lambda text: None,
) -> Contest:
    """Measures all methods in one case."""
    pixels = case.view.size**2
    made = Contest([], [], {})
    ready: list[tuple[Method, Run, list[float]]] = []
    judged: list[tuple[float, float]] = []
    for method in methods:
        tell(f"{case.view.scene.name}, {case.texture}: {method.family} {method.name}")
        who = (case.view.scene.name, case.texture, method.name, method.family, method.kind)
        try:
            run = method.prepare(case)
        except Unavailable as reason:
            made.absences.append(Absence(*who, str(reason)))
            continue
        start = time.perf_counter()
        result = run.work()
        first = time.perf_counter() - start
        picture = codes(result, run, method.kind)
        made.pictures[method.family, method.kind, method.name] = np.clip(np.rint(picture), 0, 255).astype(
            np.uint8
        )
        judged.append(errors(picture, truth, places))
        ready.append((method, run, [first] if first > _ENOUGH else []))
    for _ in range(rounds):
        for _, run, times in ready:
            if sum(times) > _ENOUGH:
                continue
            _round(run, times)
    for (method, run, times), (rms, worst) in zip(ready, judged, strict=True):
        least, median = min(times) - run.overhead, statistics.median(times) - run.overhead
        made.points.append(
            Point(
                *(case.view.scene.name, case.texture, method.name, method.family, method.kind),
                ns=max(1e9 * least / pixels, 0.1),
                ns_median=max(1e9 * median / pixels, 0.1),
                rms=rms,
                max=worst,
            )
        )
    return made


def _round(run: Run, times: list[float]) -> None:
    spent = 0.0
    while spent < _AT_LEAST:
        start = time.perf_counter()
        run.work()
        spent += (took := time.perf_counter() - start)
        times.append(took)
