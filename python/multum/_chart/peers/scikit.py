"""scikit-image's warp and SciPy's map_coordinates: interpolation at one point, in doubles.

Channels are warped one by one, which is the quick way of both; the picture is given in doubles.
"""

from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from skimage import transform

from ..method import Case, Method, Run


def _doubles(case: Case) -> NDArray[np.float64]:
    return np.ascontiguousarray(np.moveaxis(case.image, 2, 0), np.float64)


def _coordinates(case: Case) -> NDArray[np.float64]:
    x, y = case.view.maps()
    return np.stack([y, x]).astype(np.float64)


def _warp(case: Case) -> Run:
    planes, shape = _doubles(case), (case.view.size, case.view.size)
    matrix = case.view.matrix
    mapping = _coordinates(case) if matrix is None else transform.ProjectiveTransform(matrix)
    out = np.empty((*shape, len(planes)))

    def work() -> NDArray[Any]:
        for c, plane in enumerate(planes):
            out[..., c] = transform.warp(plane, mapping, output_shape=shape, order=1, mode="wrap")
        return out

    return Run(work)


def _map_coordinates(case: Case, order: int) -> Run:
    planes, places = _doubles(case), _coordinates(case)
    out = np.empty((*places.shape[1:], len(planes)))

    def work() -> NDArray[Any]:
        for c, plane in enumerate(planes):
            out[..., c] = ndimage.map_coordinates(plane, places, order=order, mode="grid-wrap")
        return out

    return Run(work)


_SKIMAGE, _SCIPY = f"scikit-image {version('scikit-image')}", f"SciPy {version('scipy')}"

METHODS = [
    Method("warp order 1", _SKIMAGE, "warp", _warp),
    Method("map_coordinates order 1", _SCIPY, "warp", lambda case: _map_coordinates(case, 1)),
    Method("map_coordinates order 3", _SCIPY, "warp", lambda case: _map_coordinates(case, 3)),
]
