"""Who is beaten by whom."""

from collections.abc import Sequence
from dataclasses import dataclass

from .measure import Point

_SAME_ERROR = 1.005
"""Errors this close are one: positions in singles and doubles differ by as much."""


@dataclass(frozen=True)
class Verdict:
    """A peer's point and the own point that comes nearest to beating it."""

    peer: Point
    own: Point | None
    """The quickest of the own points that are at least as accurate; None where there is none."""

    @property
    def ratio(self) -> float:
        """The peer's time over the own point's; 0 where no own point is as accurate."""
        return 0.0 if self.own is None else self.peer.ns / self.own.ns

    @property
    def dominated(self) -> bool:
        """Whether some own point is at least as accurate and at least as fast."""
        return self.ratio >= 1.0


def front(costs: Sequence[float], errors: Sequence[float]) -> list[int]:
    """Indices of the points that no other beats in both, by rising cost.

    >>> front([1, 2, 3, 4], [9, 5, 6, 1])
    [0, 1, 3]
    """
    kept: list[int] = []
    for i in sorted(range(len(costs)), key=lambda i: (costs[i], errors[i])):
        if not kept or errors[i] < errors[kept[-1]]:
            kept.append(i)
    return kept


def verdicts(points: Sequence[Point], family: str) -> list[Verdict]:
    """One for each point of another family, among the own points of its scene, texture and kind."""
    found = []
    for peer in points:
        if peer.family == family:
            continue
        place = (peer.scene, peer.texture, peer.kind)
        able = [
            p
            for p in points
            if p.family == family
            and (p.scene, p.texture, p.kind) == place
            and p.rms <= peer.rms * _SAME_ERROR
        ]
        found.append(Verdict(peer, min(able, key=lambda p: p.ns, default=None)))
    return found


@dataclass(frozen=True)
class Price:
    """What a setting that chooses for itself costs, beside the cheapest fixed one that is as accurate."""

    chooser: Point
    fixed: Point

    @property
    def ratio(self) -> float:
        """Time over the fixed setting's time."""
        return self.chooser.ns / self.fixed.ns


def prices(points: Sequence[Point], family: str, chooser: str) -> list[Price]:
    """One for each scene, texture and kind in which another own setting is as accurate as ``chooser``."""
    own = [p for p in points if p.family == family]
    found = []
    for point in own:
        if point.method != chooser:
            continue
        able = [
            p
            for p in own
            if (p.scene, p.texture, p.kind) == (point.scene, point.texture, point.kind)
            and p.rms <= point.rms * _SAME_ERROR
            and not p.method.startswith("auto")
        ]
        if able:
            found.append(Price(point, min(able, key=lambda p: p.ns)))
    return found
