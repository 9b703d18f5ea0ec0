"""How maps stretch areas and angles."""

from typing import Any, NamedTuple, SupportsFloat

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _multum
from ._map import Mapping
from ._numbers import Vector, floats, like, single


class Distortion(NamedTuple):
    """Stretch of a map in texture units per unit of length; each array has one number a point."""

    sigma1: NDArray[Any]
    """Largest stretch."""
    sigma2: NDArray[Any]
    """Smallest stretch."""
    area: NDArray[Any]
    """sigma1 sigma2"""
    angle: NDArray[Any]
    """sigma1 / sigma2, 1 where angles are kept."""


def distortion(
    mapping: Mapping, points: ArrayLike, normals: ArrayLike, *, size: Vector = (1, 1)
) -> Distortion:
    """How a map stretches areas and angles of a surface: singular values of its differential.

    ``normals`` (..., 3) tell the tangent plane. ``size`` is the (width, height) of the texture, so that a
    panorama of 2 by 1 is judged as it is stored. Where the map has no answer all are infinite.

    >>> import multum as mt
    >>> d = distortion(mt.mapping.Planar(), [[0.0, 0.0, 0.0]], [[0.0, 0.6, 0.8]])
    >>> d.area.round(12).tolist(), d.angle.round(12).tolist()
    ([0.8], [1.25])
    """
    array = np.asarray(points)
    frame = _multum.tangents(np.array(like("normals", normals, array, 3)))
    _, jacobian = mapping(array, normals, dpdx=frame[..., 0, :], dpdy=frame[..., 1, :])
    scale = floats("size", size, (2,)).astype(jacobian.dtype)
    numbers = _multum.distortion(jacobian * scale[:, None])
    return Distortion(numbers[..., 0], numbers[..., 1], numbers[..., 2], numbers[..., 3])


def distortion_picture(values: ArrayLike, *, limit: SupportsFloat = 4.0) -> NDArray[np.uint8]:
    """A heat map of stretches (H, W) on a logarithmic scale: (H, W, 3) uint8, 1 at the middle colour.

    Values of ``limit`` and more are the warmest colour, those of 1 / ``limit`` and less the coldest; NaN
    is grey. Needs matplotlib.

    >>> distortion_picture([[1.0, 4.0]]).shape
    (1, 2, 3)
    """
    try:
        from matplotlib import colormaps
    except ImportError:
        raise ImportError("distortion_picture needs matplotlib: pip install 'multum[demo]'") from None
    top = single("limit", limit)
    if not top > 1:
        raise ValueError(f"limit: got {top}, expected a number above 1")
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"values: got {values!r}, expected numbers of shape (H, W)") from None
    if array.ndim != 2:
        raise ValueError(f"values: got shape {array.shape}, expected (H, W)")
    with np.errstate(divide="ignore", invalid="ignore"):
        place = np.clip(0.5 + 0.5 * np.log(array) / np.log(top), 0, 1)
    picture = np.asarray(colormaps["coolwarm"](np.nan_to_num(place)))[..., :3]
    picture = np.where(np.isnan(place)[..., None], 0.5, picture)
    return np.asarray(np.floor(picture * 255 + 0.5), dtype=np.uint8)
