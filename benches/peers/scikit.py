"""Warps and reductions beside scikit-image: one thread, one process, alternating calls.

    python benches/peers/scikit.py [side ...]

Prints CPU and versions, then for each case the best of both (Mpx/s of the input) and the ratio. Results are
compared before anything is timed. ``MULTUM_SIMD=scalar`` measures the code without vectors.
"""

import os
import platform
import sys
import time
from pathlib import Path

import numpy as np
import skimage
import skimage.transform as theirs

import multum as mt

ours = mt.compat.skimage


def cpu():
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor()


def alternate(peer, own, repeats):
    best = [float("inf")] * 2
    for _ in range(repeats):
        for i, work in enumerate((peer, own)):
            start = time.perf_counter()
            work()
            best[i] = min(best[i], time.perf_counter() - start)
    return best


def image(side, dtype, channels):
    numbers = np.random.default_rng(0).random((side, side, channels))
    numbers = np.squeeze(numbers * 255 if np.dtype(dtype).kind == "u" else numbers)
    return numbers.astype(dtype)


def main():
    sides = [int(a) for a in sys.argv[1:]] or [32, 256, 512, 1024, 2048]
    mt.set_num_threads(1)
    print(f"{cpu()}, MULTUM_SIMD={os.environ.get('MULTUM_SIMD', 'best')}, one thread")
    print(f"multum {mt.__version__}, scikit-image {skimage.__version__}, NumPy {np.__version__}\n")
    print("| case | side | scikit-image Mpx/s | multum Mpx/s | ratio |")
    print("|---|---|---|---|---|")
    for dtype, channels in ((np.float64, 3), (np.float64, 1), (np.float32, 3), (np.uint8, 3)):
        for side in sides:
            picture = image(side, dtype, channels)
            axis = -1 if picture.ndim == 3 else None
            turn = ours.SimilarityTransform(rotation=0.3, translation=(side * 0.15, -side * 0.1)).params
            small = {"anti_aliasing": True, "channel_axis": axis}
            kind = f"{np.dtype(dtype).name} c{channels}"
            for name, arguments, options in (
                (f"warp order 1, {kind}", ("warp", picture, turn), {"order": 1}),
                (f"rescale 0.37, {kind}", ("rescale", picture, 0.37), small),
                (f"pyramid_reduce, {kind}", ("pyramid_reduce", picture), {"channel_axis": axis}),
            ):
                call, *rest = arguments
                works = [lambda f=getattr(m, call): f(*rest, **options) for m in (theirs, ours)]
                np.testing.assert_allclose(works[1](), works[0](), rtol=0, atol=1e-12 if dtype != np.float32 else 2e-3)
                peer, own = alternate(*works, 4 if side > 600 else 8)
                size = side * side / 1e6
                print(f"| {name} | {side} | {size / peer:.1f} | {size / own:.1f} | {peer / own:.1f} |", flush=True)


if __name__ == "__main__":
    main()
