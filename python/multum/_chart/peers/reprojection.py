"""reproject's adaptive resampling, by the routine under ``reproject_adaptive`` that takes any map.

Called without its sky coordinates, which are slower than the resampling. It visits every texel under the kernel of
every pixel, so views whose pixels see too many are left out.
"""

from typing import Any

import numpy as np
import reproject
from numpy.typing import NDArray
from reproject.adaptive import deforest

from ..method import Case, Method, Run, Unavailable

FAMILY = f"reproject {reproject.__version__}"


_MOST_TEXELS = 2e8
_KERNELS = {"hann": 4.0, "gaussian": 16.0}
"""Texels under the kernel for one under the pixel."""


def _adaptive(case: Case, kernel: str) -> Run:
    if case.texels * _KERNELS[kernel] > _MOST_TEXELS:
        raise Unavailable(f"would take minutes: {case.texels:.1g} texels")
    planes = np.ascontiguousarray(np.moveaxis(case.image, 2, 0), np.float64)
    view = case.view
    out = np.empty((len(planes), view.size, view.size))

    def places(pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        return view.places(pixels.reshape(-1, 2)).reshape(pixels.shape)

    def work() -> NDArray[Any]:
        deforest.map_coordinates(
            planes, out, places, out_of_range_nan=True, kernel=kernel, x_cyclic=True, y_cyclic=True
        )
        return np.moveaxis(out, 0, 2)

    return Run(work)


METHODS = [
    Method("adaptive Hann", FAMILY, "warp", lambda case: _adaptive(case, "hann")),
    Method("adaptive Gaussian", FAMILY, "warp", lambda case: _adaptive(case, "gaussian")),
]
