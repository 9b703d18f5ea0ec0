"""The same warp as OpenCV does it, and clocks."""

import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._warp import remap

cv2: Any
try:
    import cv2
except ImportError:
    cv2 = None

NAME = f"OpenCV {cv2.__version__}" if cv2 else "plain bilinear"
NOTE = (
    ""
    if cv2
    else "OpenCV is not installed: its place is taken by plain bilinear interpolation, which it does too."
)


def plain_warp(
    image: NDArray[Any], matrix: NDArray[np.float64], shape: tuple[int, int], repeat: bool
) -> NDArray[Any]:
    """A warp by interpolation alone: each pixel shows the picture at one point."""
    y, x = np.mgrid[: shape[0], : shape[1]].astype(np.float64)
    w = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
    u, v = ((matrix[i, 0] * x + matrix[i, 1] * y + matrix[i, 2]) / w for i in (0, 1))
    if cv2 is None:
        return remap(image, u, v, filter="bilinear", wrap="repeat" if repeat else "border")
    if not repeat:
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return np.asarray(cv2.warpPerspective(image, matrix, shape[::-1], flags=flags))
    u, v = u % image.shape[1], v % image.shape[0]
    border = cv2.BORDER_WRAP
    return np.asarray(
        cv2.remap(image, u.astype(np.float32), v.astype(np.float32), cv2.INTER_LINEAR, borderMode=border)
    )


def milliseconds(work: Callable[[], object], repeats: int = 5) -> float:
    """Median time of some runs after one to warm up."""
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(1000.0 * (time.perf_counter() - start))
    return statistics.median(times)
