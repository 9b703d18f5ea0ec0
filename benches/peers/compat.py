"""The drop-ins beside the functions that they stand for: one thread, one process, calls in turn.

    python benches/peers/compat.py [side ...] [--only WORD] [--docs docs/peers.md]

Prints CPU and versions, then for each call the processor time of the faster half of all readings of both in
microseconds and the ratio (above 1: multum is faster), for pictures of these sides. Small sides measure what a call costs
beside its work. Results are compared before anything is timed. PyTorch is timed where it is installed. With --docs the
table goes between the marks of that document.
"""

import argparse
import platform
import re
import statistics
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


def alternate(peer, own, least=0.15):
    """The median of the faster half of readings of each, in microseconds, over so many seconds."""
    readings, spent = ([], []), 0.0
    count = 1
    while spent < least or len(readings[0]) < 5:
        for work, kept in zip((peer, own), readings, strict=True):
            start = time.thread_time()
            for _ in range(count):
                work()
            taken = time.thread_time() - start
            spent += taken
            kept.append(taken / count)
        count = max(1, min(200, int(1e-3 / max(min(kept) for kept in readings))))
    return [statistics.median(sorted(kept)[: len(kept) // 2 + 1]) * 1e6 for kept in readings]


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
        yield f"resize, cubic by 3/2 {kind}", "resize", (image, (side * 3 // 2,) * 2), {"interpolation": cv2.INTER_CUBIC}
        yield f"resize, nearest {kind}", "resize", (image, (side * 3 // 2,) * 2), {"interpolation": cv2.INTER_NEAREST}
        yield f"resize, area by 2 {kind}", "resize", (image, (side // 2,) * 2), {"interpolation": cv2.INTER_AREA}
        yield f"resize, area by 2.7 {kind}", "resize", (image, (int(side / 2.7),) * 2), {"interpolation": cv2.INTER_AREA}
        flags = cv2.INTER_LINEAR | cv2.WARP_FILL_OUTLIERS
        # Both average; OpenCV over pixels, multum over what is interpolated between them.
        yield f"resize, reduced by 2.7, anti-aliased (OpenCV: area) {kind}", "resize", (image, (int(side / 2.7),) * 2), {"interpolation": cv2.INTER_AREA, "antialias": "linear"}
        yield f"warpPolar {kind}", "warpPolar", (image, size, (side / 2,) * 2, side / 2, flags), {"antialias": False}
        yield f"undistort {kind}", "undistort", (image, camera, np.array([-0.1, 0.01, 0, 0])), {"antialias": False}
        yield f"getRectSubPix {kind}", "getRectSubPix", (image, (side // 2,) * 2, (side / 2 + 0.3, side / 2 - 0.2)), {}
        yield f"integral {kind}", "integral", (image,), {}
        yield f"pyrDown {kind}", "pyrDown", (image,), {}
        yield f"pyrUp {kind}", "pyrUp", (image,), {}
    yield "convertMaps", "convertMaps", (*maps, cv2.CV_16SC2), {}
    yield "initUndistortRectifyMap", "initUndistortRectifyMap", (camera, np.array([-0.1, 0.01, 0, 0]), None, camera, size, cv2.CV_32FC1), {}


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


def measured(title, peer, own, name, arguments, options):
    theirs = {k: v for k, v in options.items() if k != "antialias"}
    ours = dict(options)
    loose = ours.get("antialias") == "linear"
    if loose:
        ours = {"interpolation": cv2.INTER_LINEAR}
    work = (lambda: getattr(peer, name)(*arguments, **theirs)), (lambda: getattr(own, name)(*arguments, **ours))
    want, got = (first(w()) for w in work)
    scale = max(np.abs(want).max(), 1)
    # One step of integers, or what a last bit of a position makes of noise.
    close = np.abs(want - got) <= (0.5 * scale if loose else max(1 if scale > 1 else 0, 1e-3 * scale))
    assert want.shape == got.shape and close.mean() > 0.99, title
    return alternate(*work)


def calls(side, torch):
    """Every call of every library, with both sides' modules."""
    for title, *call in opencv_calls(side):
        yield f"cv2.{title}", cv2, mt.compat.cv2, *call
    for title, *call in skimage_calls(side):
        yield f"skimage {title}", skimage.transform, mt.compat.skimage, *call
    if torch is not None:
        for title, *call in torch_calls(torch, side):
            yield f"torch {title}", torch.nn.functional, mt.compat.torch, *call


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("sides", nargs="*", type=int, default=[32, 512, 2048])
    parser.add_argument("--only", default="")
    parser.add_argument("--docs", type=Path)
    given = parser.parse_args()
    mt.set_num_threads(1)
    cv2.setNumThreads(1)
    try:
        import torch

        torch.set_num_threads(1)
    except ImportError:
        torch = None
    versions = f"OpenCV {cv2.__version__}, scikit-image {skimage.__version__}, NumPy {np.__version__}"
    if torch is not None:
        versions += f", PyTorch {torch.__version__.partition('+')[0]}"
    lines = [
        f"{cpu()}, one thread; multum {mt.__version__}, {versions}.",
        "",
        "| call | " + " | ".join(f"{n} squared: peer, us | multum, us | ratio" for n in given.sides) + " |",
        "|---|" + "---:|" * 3 * len(given.sides),
    ]
    print("\n".join(lines))
    by_side = [[c for c in calls(side, torch) if given.only in c[0]] for side in given.sides]
    for row in zip(*by_side, strict=True):
        cells = []
        for call in row:
            peer, own = measured(*call)
            cells.append(f"{peer:.3g} | {own:.3g} | {peer / own:.2f}" if peer < 1000 else f"{peer:.0f} | {own:.0f} | {peer / own:.2f}")
        lines.append(f"| {row[0][0]} | " + " | ".join(cells) + " |")
        print(lines[-1], flush=True)
    if given.docs:
        marks = "<!-- begin: written by benches/peers/compat.py -->", "<!-- end: compat.py -->"
        text = given.docs.read_text(encoding="utf-8")
        table = "\n\n".join([marks[0], "\n".join(lines), marks[1]])
        pattern = re.compile(re.escape(marks[0]) + ".*?" + re.escape(marks[1]), re.S)
        given.docs.write_text(pattern.sub(lambda _: table, text), encoding="utf-8")


if __name__ == "__main__":
    main()
