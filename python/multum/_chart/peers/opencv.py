"""OpenCV: interpolation at one point, and the mean of k x k of them in each pixel.

Maps are made before the clock starts; timed are ``remap`` and, where supersampled, the mean by ``resize`` with
``INTER_AREA``.
"""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..method import Case, Method, Run

FAMILY = f"OpenCV {cv2.__version__}"
cv2.setNumThreads(1)


def _plain(case: Case, interpolation: int) -> Run:
    x, y = case.view.maps()
    out = np.empty((*x.shape, case.image.shape[2]), np.uint8)

    def work() -> NDArray[Any]:
        cv2.remap(case.image, x, y, interpolation, dst=out, borderMode=cv2.BORDER_WRAP)
        return out

    return Run(work)


def _supersampled(case: Case, times: int) -> Run:
    x, y = case.view.maps(times)
    size = case.view.size
    large = np.empty((*x.shape, case.image.shape[2]), np.uint8)
    out = np.empty((size, size, case.image.shape[2]), np.uint8)

    def work() -> NDArray[Any]:
        cv2.remap(case.image, x, y, cv2.INTER_LINEAR, dst=large, borderMode=cv2.BORDER_WRAP)
        cv2.resize(large, (size, size), dst=out, interpolation=cv2.INTER_AREA)
        return out

    return Run(work)


METHODS = [
    Method("remap linear", FAMILY, "warp", lambda case: _plain(case, cv2.INTER_LINEAR)),
    Method("remap cubic", FAMILY, "warp", lambda case: _plain(case, cv2.INTER_CUBIC)),
    Method("2x2 supersampled", FAMILY, "warp", lambda case: _supersampled(case, 2)),
    Method("4x4 supersampled", FAMILY, "warp", lambda case: _supersampled(case, 4)),
    Method("8x8 supersampled", FAMILY, "warp", lambda case: _supersampled(case, 8)),
]
