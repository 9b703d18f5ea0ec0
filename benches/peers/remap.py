"""Plain remapping beside OpenCV: one thread, one process, alternating calls.

    python benches/peers/remap.py [side] [repeats]

Prints CPU and versions, then for each case both medians (Mpx/s), their spreads (interquartile range over median)
and the ratio. Results are compared before anything is timed. ``MULTUM_SIMD=avx2`` measures the AVX2 kernels.
"""

import os
import platform
import sys
import time
from pathlib import Path

import cv2
import numpy as np

import multum as mt

ours = mt.compat.cv2


def cpu():
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor()


def alternate(peer, own, repeats):
    times = ([], [])
    for _ in range(repeats):
        for work, kept in zip((peer, own), times, strict=True):
            start = time.perf_counter()
            work()
            kept.append(time.perf_counter() - start)
    return [(np.median(t), (np.percentile(t, 75) - np.percentile(t, 25)) / np.median(t)) for t in times]


def main():
    side = int(sys.argv[1]) if len(sys.argv) > 1 else 2048
    repeats = int(sys.argv[2]) if len(sys.argv) > 2 else 11
    cv2.setNumThreads(1)
    mt.set_num_threads(1)
    print(f"{cpu()}, MULTUM_SIMD={os.environ.get('MULTUM_SIMD', 'best')}, one thread, {side} x {side}")
    print(f"multum {mt.__version__}, OpenCV {cv2.__version__}, NumPy {np.__version__}\n")
    print("| case | OpenCV Mpx/s | spread | multum Mpx/s | spread | ratio |")
    print("|---|---|---|---|---|---|")
    random = np.random.default_rng(0)
    c, s, k = np.cos(0.4), np.sin(0.4), side / 2
    affine = np.array([[c, -s, k - c * k + s * k], [s, c, k - s * k - c * k]])
    projective = np.vstack([affine, [1e-5, 2e-5, 1]])
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    turned = tuple((r[0] * x + r[1] * y + r[2]).astype(np.float32) for r in affine)
    scattered = tuple((random.random((side, side)) * (side - 2)).astype(np.float32) for _ in range(2))
    inverse = ours.INTER_LINEAR | ours.WARP_INVERSE_MAP
    cases = []
    for dtype in (np.uint8, np.uint16, np.float32):
        for channels in (1, 3, 4):
            name = f"remap linear, {np.dtype(dtype).name} c{channels}"
            cases.append((name, dtype, channels, "remap", (*turned, ours.INTER_LINEAR), {}))
    cases += [
        ("remap linear, random, uint8 c3", np.uint8, 3, "remap", (*scattered, ours.INTER_LINEAR), {}),
        ("remap nearest, uint8 c3", np.uint8, 3, "remap", (*turned, ours.INTER_NEAREST), {}),
        ("remap cubic, uint8 c3", np.uint8, 3, "remap", (*turned, ours.INTER_CUBIC), {}),
        ("remap Lanczos4, uint8 c3", np.uint8, 3, "remap", (*turned, ours.INTER_LANCZOS4), {}),
        (
            "warpAffine linear, uint8 c3",
            np.uint8,
            3,
            "warpAffine",
            (affine, (side, side)),
            {"flags": inverse},
        ),
        (
            "warpPerspective linear, uint8 c3",
            np.uint8,
            3,
            "warpPerspective",
            (projective, (side, side)),
            {"flags": inverse},
        ),
    ]
    for name, dtype, channels, function, arguments, keywords in cases:
        image = (random.random((side, side, channels)) * 255).astype(dtype)
        image = image[..., 0] if channels == 1 else image
        outputs = [np.empty_like(image) for _ in range(2)]

        def peer():
            getattr(cv2, function)(image, *arguments, dst=outputs[0], **keywords)

        def own():
            getattr(ours, function)(image, *arguments, dst=outputs[1], antialias=False, **keywords)

        peer()
        own()
        difference = np.abs(outputs[0].astype(np.float64) - outputs[1])
        if (difference > (1 if np.issubdtype(dtype, np.integer) else 0.05)).mean() > 1e-4:
            raise SystemExit(f"{name}: results differ by up to {difference.max()}")
        (a, da), (b, db) = alternate(peer, own, repeats)
        n = side * side / 1e6
        print(f"| {name} | {n / a:.0f} | {da:.0%} | {n / b:.0f} | {db:.0%} | {a / b:.2f} |", flush=True)


if __name__ == "__main__":
    main()
