"""The drop-ins beside the functions that they stand for: one thread, one process, alternating calls.

    python benches/peers/compat.py [side ...]

Prints CPU and versions, then for each call the best of both in microseconds and the ratio (above 1: multum is
faster). Small sides measure what a call costs beside its work. Results are compared before anything is timed.
PyTorch is timed where it is installed.
"""

import platform
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import skimage
import skimage.transform

import multum as mt


def cpu():
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor()


def alternate(peer, own, least=0.1):
    """The best time of each, in microseconds, of as many calls as fit into so many seconds."""
    best, spent = [float("inf")] * 2, 0.0
    count = 1
    while spent < least:
        for i, work in enumerate((peer, own)):
            start = time.perf_counter()
            for _ in range(count):
                work()
            taken = time.perf_counter() - start
            spent += taken
            best[i] = min(best[i], taken / count)
        count = max(1, min(50, int(2e-3 / max(best))))
    return [b * 1e6 for b in best]


def picture(side, dtype, channels):
    numbers = np.random.default_rng(0).random((side, side, channels)) * (255 if np.dtype(dtype).kind == "u" else 1)
    return np.squeeze(numbers, 2).astype(dtype) if channels == 1 else numbers.astype(dtype)


def opencv_calls(side):
    """Names, arguments and options that mean the same in both."""
    # None of them reduces: multum would average, and the two would not do the same work.
    turn = np.array([[0.8, -0.5, side / 3], [0.5, 0.8, -side / 6]])
    tilt = np.vstack([0.8 * turn, [0.1 / side, -0.05 / side, 1]])
    x, y = np.meshgrid(np.arange(side, dtype=np.float32), np.arange(side, dtype=np.float32))
    maps = tuple((m[0] * x + m[1] * y + m[2]).astype(np.float32) for m in turn)
    camera = np.array([[side * 1.0, 0, side / 2], [0, side * 1.0, side / 2], [0, 0, 1]])
    size, back = (side, side), cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    for dtype, channels in ((np.uint8, 1), (np.uint8, 3), (np.uint8, 4), (np.uint16, 3), (np.float32, 1), (np.float32, 3)):
        image = picture(side, dtype, channels)
        kind = f"{np.dtype(dtype).name} c{channels}"
        yield f"remap {kind}", "remap", (image, *maps, cv2.INTER_LINEAR), {}
        yield f"warpAffine {kind}", "warpAffine", (image, turn, size), {"flags": back}
        yield f"warpPerspective {kind}", "warpPerspective", (image, tilt, size), {"flags": back}
    for dtype, channels in ((np.uint8, 3), (np.float32, 3)):
        image = picture(side, dtype, channels)
        kind = f"{np.dtype(dtype).name} c{channels}"
        yield f"remap, nearest {kind}", "remap", (image, *maps, cv2.INTER_NEAREST), {}
        yield f"remap, cubic {kind}", "remap", (image, *maps, cv2.INTER_CUBIC), {}
        yield f"remap, Lanczos {kind}", "remap", (image, *maps, cv2.INTER_LANCZOS4), {}
        yield f"resize by 3/2 {kind}", "resize", (image, (side * 3 // 2,) * 2), {}
        yield f"resize, nearest {kind}", "resize", (image, (side * 3 // 2,) * 2), {"interpolation": cv2.INTER_NEAREST}
        yield f"resize, area by 2 {kind}", "resize", (image, (side // 2,) * 2), {"interpolation": cv2.INTER_AREA}
        yield f"resize, area by 2.7 {kind}", "resize", (image, (int(side / 2.7),) * 2), {"interpolation": cv2.INTER_AREA}
        flags = cv2.INTER_LINEAR | cv2.WARP_FILL_OUTLIERS
        yield f"warpPolar {kind}", "warpPolar", (image, size, (side / 2,) * 2, side / 2, flags), {"antialias": False}
        yield f"undistort {kind}", "undistort", (image, camera, np.array([-0.1, 0.01, 0, 0])), {"antialias": False}
        yield f"getRectSubPix {kind}", "getRectSubPix", (image, (side // 2,) * 2, (side / 2 + 0.3, side / 2 - 0.2)), {}
        yield f"integral {kind}", "integral", (image,), {}
        yield f"pyrDown {kind}", "pyrDown", (image,), {}
        yield f"pyrUp {kind}", "pyrUp", (image,), {}
    yield "convertMaps", "convertMaps", (*maps, cv2.CV_16SC2), {}


def skimage_calls(side):
    turn = skimage.transform.SimilarityTransform(rotation=0.4, scale=0.8, translation=(side / 4, -side / 9)).params
    image = picture(side, np.float64, 1)
    half = (side // 2, side // 2)
    yield "warp", "warp", (image, turn), {}
    yield "warp, cubic", "warp", (image, turn), {"order": 3}
    yield "rotate", "rotate", (image, 20), {}
    yield "resize", "resize", (image, half), {}
    yield "rescale 0.37", "rescale", (image, 0.37), {"anti_aliasing": True}
    yield "swirl", "swirl", (image,), {"strength": 2}
    yield "warp_polar", "warp_polar", (image,), {}
    yield "pyramid_reduce", "pyramid_reduce", (image,), {}
    yield "downscale_local_mean", "downscale_local_mean", (image, (2, 2)), {}
    yield "resize_local_mean", "resize_local_mean", (image, half), {}
    yield "integral_image", "integral_image", (image,), {}


def torch_calls(torch, side):
    image = torch.rand(1, 3, side, side)
    grid = torch.rand(1, side, side, 2) * 2 - 1
    for mode in ("bilinear", "bicubic"):
        yield f"grid_sample, {mode}", "grid_sample", (image, grid), {"mode": mode, "align_corners": False}
    options = {"size": (side // 3, side // 3), "mode": "bilinear", "antialias": True}
    yield "interpolate, anti-aliased", "interpolate", (image,), options


def first(result):
    return np.asarray(result[0] if isinstance(result, tuple) else result).astype(np.float64)


def row(title, side, peer, own, name, arguments, options):
    theirs = {k: v for k, v in options.items() if (k, v) != ("antialias", False)}
    work = (lambda: getattr(peer, name)(*arguments, **theirs)), (lambda: getattr(own, name)(*arguments, **options))
    want, got = (first(w()) for w in work)
    scale = max(np.abs(want).max(), 1)
    # One step of integers, or what a last bit of a position makes of noise.
    close = np.abs(want - got) <= max(1 if scale > 1 else 0, 1e-3 * scale)
    assert want.shape == got.shape and close.mean() > 0.99, title
    peer_us, own_us = alternate(*work)
    print(f"| {title} | {side} | {peer_us:.1f} | {own_us:.1f} | {peer_us / own_us:.2f} |")


def main():
    sides = [int(a) for a in sys.argv[1:]] or [32, 512, 2048]
    mt.set_num_threads(1)
    cv2.setNumThreads(1)
    try:
        import torch

        torch.set_num_threads(1)
    except ImportError:
        torch = None
    versions = f"OpenCV {cv2.__version__}, scikit-image {skimage.__version__}, NumPy {np.__version__}"
    print(f"{cpu()}, one thread; multum {mt.__version__}, {versions}\n")
    print("| call | side | peer, us | multum, us | ratio |")
    print("|---|---|---|---|---|")
    for side in sides:
        for title, *call in opencv_calls(side):
            row(f"cv2.{title}", side, cv2, mt.compat.cv2, *call)
        for title, *call in skimage_calls(side):
            row(f"skimage {title}", side, skimage.transform, mt.compat.skimage, *call)
        if torch is not None:
            for title, *call in torch_calls(torch, side):
                row(f"torch {title}", side, torch.nn.functional, mt.compat.torch, *call)


if __name__ == "__main__":
    main()
