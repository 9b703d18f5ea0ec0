"""Growth: nanoseconds a pixel against sizes, footprints and threads."""

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import multum as mt

from .clock import codes, nanoseconds
from .plain import turned, turned_map

ours = mt.compat.cv2
LINEAR, AREA, INVERSE = 1, 3, 16
Curve = tuple[str, str, list[tuple[float, float]]]
"""What varies, the curve's name, pairs of value and nanoseconds a pixel."""


def _repeated(work: Callable[[], Any], times: int) -> Callable[[], None]:
    def loop() -> None:
        for _ in range(times):
            work()

    return loop


MEMORY = 3 << 30
"""Bytes that a case may need for what it reads and makes."""


def sizes(largest: int) -> Iterator[Curve]:
    """Images from 64 squared on."""
    random = np.random.default_rng(5)
    curves: dict[str, list[tuple[float, float]]] = {}
    side = 64
    while side <= largest:
        image = codes(random, (side, side, 3), np.uint8)
        out = np.empty_like(image)
        times = max(1, (1 << 20) // side**2)
        # Bytes a pixel: the picture, the result, and positions in two singles or sums of 32 or 64 bits.
        line = turned_map(side) if side**2 * (6 + 8 + 32) < MEMORY else None
        works: dict[str, tuple[int, Callable[[], Any]]] = {
            "warpAffine linear": (
                6,
                lambda: ours.warpAffine(
                    image, turned(side), (side, side), dst=out, flags=LINEAR | INVERSE, antialias=False
                ),
            ),
            "remap linear": (46, lambda: ours.remap(image, *line, LINEAR, dst=out, antialias=False)),
            "resize area by 2": (
                6,
                lambda: ours.resize(image, (side // 2, side // 2), interpolation=AREA),
            ),
            "pyramid, linear light": (7, lambda: mt.build_pyramid(image, encoding="srgb")),
            "summed-area table": (
                15 if side <= 4096 else 27,
                lambda: mt.SummedAreaTable(image),
            ),
        }
        for name, (needed, work) in works.items():
            if needed * side**2 > MEMORY:
                continue
            ns = nanoseconds(_repeated(work, times), side * side * times, 3)
            curves.setdefault(name, []).append((side, ns))
        side *= 2
    for name, points in curves.items():
        yield "image side", name, points


def textures(largest: int) -> Iterator[Curve]:
    """The same turned view of textures of growing size, a texel a pixel."""
    random = np.random.default_rng(6)
    view = 512
    y, x = np.mgrid[:view, :view] - (view - 1) / 2
    turn = np.array([[0.9, -0.4], [0.4, 0.9]])
    for name in ("bilinear", "trilinear", "anisotropic"):
        points = []
        side = 64
        while side <= largest:
            texture = mt.Texture(codes(random, (side, side, 4), np.uint8), wrap="repeat")
            uv = (np.stack([x, y], -1) @ turn.T / side).astype(np.float32)
            jacobian = np.broadcast_to(turn / side, (view, view, 2, 2)).astype(np.float32)
            out = np.empty((view, view, 4), np.float32)
            points.append(
                (side, nanoseconds(lambda: texture.sample(uv, jacobian, filter=name, out=out), view**2))
            )
            side *= 4
        yield "texture side", name, points


def footprints() -> Iterator[Curve]:
    """Ratio of the footprint's axes at a minor axis of a texel, and texels along both."""
    random = np.random.default_rng(7)
    texture = mt.Texture(codes(random, (1024, 1024, 4), np.uint8), wrap="repeat")
    view = 256
    uv = random.random((view, view, 2), np.float32)
    out = np.empty((view, view, 4), np.float32)
    for what, values, shape in (
        ("footprint ratio", (1, 2, 4, 8, 16), lambda v: np.diag([v, 1.0])),
        ("minification", (1, 2, 4, 8, 16, 32), lambda v: np.diag([v, 0.99 * v])),
    ):
        for name in ("trilinear", "anisotropic", "ewa", "area", "auto"):
            points = []
            for value in values:
                jacobian = np.broadcast_to(shape(value) / 1024, (view, view, 2, 2)).astype(np.float32)
                work = lambda j=jacobian, n=name: texture.sample(uv, j, filter=n, out=out)  # noqa: E731
                points.append((float(value), nanoseconds(work, view**2, 3)))
            yield what, name, points


def threads(most: int) -> Iterator[Curve]:
    """The same work on one thread and more, by the clock on the wall: the least of nine."""
    random = np.random.default_rng(8)
    side = 1024
    image = codes(random, (side, side, 3), np.uint8)
    singles = random.random((side, side, 3), np.float32)
    out = np.empty_like(image)
    line = turned_map(side)
    texture = mt.Texture(image, wrap="repeat")
    uv = random.random((512, 512, 2), np.float32)
    jacobian = np.broadcast_to(np.eye(2) * 4 / side, (512, 512, 2, 2)).astype(np.float32)
    matrix = turned(side) * 2.5
    works: dict[str, tuple[Callable[[], Any], int]] = {
        "remap linear": (lambda: ours.remap(image, *line, LINEAR, dst=out, antialias=False), side**2),
        "warpAffine linear": (
            lambda: ours.warpAffine(
                image, turned(side), (side, side), dst=out, flags=LINEAR | INVERSE, antialias=False
            ),
            side**2,
        ),
        "warp, averaged": (lambda: mt.warp(image, matrix, (384, 384)), 384**2),
        "resize area by 2.7": (lambda: ours.resize(singles, (380, 380), interpolation=AREA), side**2),
        "pyramid, linear light": (lambda: mt.build_pyramid(image, encoding="srgb"), side**2),
        "summed-area table": (lambda: mt.SummedAreaTable(image), side**2),
        "panorama": (
            lambda: mt.panorama.convert(image, source="equirect", target="fisheye", size=512),
            512**2,
        ),
    }
    for name in ("bilinear", "trilinear", "anisotropic", "ewa", "area", "auto"):
        works[name] = (lambda n=name: texture.sample(uv, jacobian, filter=n), 512**2)  # type: ignore[misc]
    for name, (work, pixels) in works.items():
        points = []
        for count in range(1, most + 1):
            mt.set_num_threads(count)
            work()
            times = []
            for _ in range(9):
                start = time.perf_counter()
                work()
                times.append(time.perf_counter() - start)
            points.append((float(count), 1e9 * min(times) / pixels))
        mt.set_num_threads(1)
        yield "threads", name, points
