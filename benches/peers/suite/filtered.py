"""Filtered look-ups and warps beside every peer that the chart knows: the chart's own contest, read as ratios."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import multum as mt


@dataclass(frozen=True)
class Contest:
    """Ours against a peer's in one scene."""

    scene: str
    kind: str
    peer: str
    theirs: tuple[str, float, float]
    """Method, nanoseconds a pixel, rms error in codes of 255."""
    ours: tuple[str, float, float]
    goal: float | None

    @property
    def ratio(self) -> float:
        return self.theirs[1] / self.ours[1]


PAIRS = [
    ("warp", "OpenCV", "8x8", ("area", "auto"), 8.0),
    ("warp", "reproject", "Hann", ("area", "auto"), 60.0),
    ("warp", "scikit", "", ("area", "auto"), None),
    ("sample", "OpenImageIO", "trilinear", ("trilinear",), 20.0),
    ("sample", "OpenImageIO", "anisotropic 16", ("anisotropic 16",), 20.0),
    ("sample", "llvmpipe", "trilinear", ("trilinear",), 2.0),
    ("sample", "llvmpipe", "anisotropic 16", ("anisotropic 16",), None),
]


METHODS = ["8x8", "adaptive", "warp order 1", "trilinear", "anisotropic 16", "area", "auto"]
"""First letters of the methods' names."""


def contests(quick: bool, tell: Callable[[str], None]) -> Iterator[Contest]:
    """The photograph in perspective and on a ball, one thread."""
    for scene in ("homography", "sphere"):
        made = mt.chart(scenes=[scene], textures=["photo"], methods=METHODS, quick=quick, tell=tell)
        for kind, family, word, names, goal in PAIRS:
            mine = [p for p in made.points if p.kind == kind and p.family == "multum" and p.method in names]
            for other in made.points:
                if other.kind != kind or family not in other.family or word not in other.method:
                    continue
                # The fastest of ours that is no less accurate, else the most accurate.
                fit = [p for p in mine if p.rms <= other.rms * 1.02] or sorted(mine, key=lambda p: p.rms)[:1]
                if fit:
                    best = min(fit, key=lambda p: p.ns_median)
                    yield Contest(
                        scene,
                        kind,
                        other.family,
                        (other.method, other.ns_median, other.rms),
                        (best.method, best.ns_median, best.rms),
                        goal if scene == "homography" else None,
                    )
