"""Pyramids and summed-area tables against OpenCV, one thread, alternating in one process.

python benches/peers/build_tables.py [--size 4096] [--repeats 9]
"""

from __future__ import annotations

import argparse
import platform
import statistics
import time
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import multum as mt

Array = NDArray[Any]


def chain(image: Array) -> list[Array]:
    """All levels by area resizes; each from the codes of the one before, not in linear light."""
    levels = [image]
    while levels[-1].shape[0] > 1 or levels[-1].shape[1] > 1:
        height, width = levels[-1].shape[:2]
        size = (max(1, width // 2), max(1, height // 2))
        levels.append(cv2.resize(levels[-1], size, interpolation=cv2.INTER_AREA))
    return levels


def seconds(job: Callable[[], object]) -> float:
    start = time.perf_counter()
    job()
    return time.perf_counter() - start


def cases(size: int) -> list[tuple[str, Callable[[], object], Callable[[], object]]]:
    random = np.random.default_rng(0)
    rgba = random.integers(0, 256, (size, size, 4), np.uint8)
    rgb = np.ascontiguousarray(rgba[..., :3])
    grey = np.ascontiguousarray(rgba[..., 0])
    singles = random.random((size, size, 3), np.float32)
    rgba_singles = random.random((size, size, 4), np.float32)

    # Compared before they are timed: one level of the linear pyramid, and the tables.
    area = chain(rgba)[1]
    difference = np.abs(mt.build_pyramid(rgba)[1].astype(int) - area)
    assert difference.max() <= 1, difference.max()
    np.testing.assert_array_equal(mt.SummedAreaTable(rgb).table, cv2.integral(rgb).view(np.uint32))

    def pyramid(image: Array, **options: str) -> Callable[[], object]:
        return lambda: mt.build_pyramid(image, **options)

    rows: list[tuple[str, Callable[[], object], Callable[[], object]]] = [
        ("pyramid u8 RGBA, linear light from sRGB", pyramid(rgba, encoding="srgb"), lambda: chain(rgba)),
        (
            "pyramid u8 RGBA, sRGB and straight alpha",
            pyramid(rgba, encoding="srgb", alpha="straight"),
            lambda: chain(rgba),
        ),
        ("pyramid u8 RGB, linear light from sRGB", pyramid(rgb, encoding="srgb"), lambda: chain(rgb)),
        ("pyramid u8 RGBA, linear", pyramid(rgba), lambda: chain(rgba)),
        ("pyramid u8 RGB, linear", pyramid(rgb), lambda: chain(rgb)),
        ("pyramid u8 grey, linear", pyramid(grey), lambda: chain(grey)),
        ("pyramid f32 RGB, linear", pyramid(singles), lambda: chain(singles)),
        ("pyramid f32 RGBA, linear", pyramid(rgba_singles), lambda: chain(rgba_singles)),
        ("pyramid u8 RGBA, sRGB, kaiser", pyramid(rgba, encoding="srgb", kind="kaiser"), lambda: chain(rgba)),
        ("summed-area table u8 RGB to u32", lambda: mt.SummedAreaTable(rgb), lambda: cv2.integral(rgb)),
        (
            "summed-area table f32 RGB to f64",
            lambda: mt.SummedAreaTable(singles),
            lambda: cv2.integral(singles, sdepth=cv2.CV_64F),
        ),
    ]
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=4096)
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    mt.set_num_threads(1)
    print(f"{platform.processor() or platform.machine()}, OpenCV {cv2.__version__}, NumPy {np.__version__}")
    print(f"{options.size} x {options.size}, median of {options.repeats}, one thread\n")
    print("| work | multum ms | OpenCV ms | OpenCV / multum |\n|---|---|---|---|")
    for name, ours, theirs in cases(options.size):
        if options.only not in name:
            continue
        pairs = [(seconds(ours), seconds(theirs)) for _ in range(options.repeats)]
        mine, other = (statistics.median(column) * 1e3 for column in zip(*pairs, strict=True))
        print(f"| {name} | {mine:.1f} | {other:.1f} | {other / mine:.2f} |", flush=True)


if __name__ == "__main__":
    main()
