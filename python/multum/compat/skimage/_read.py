"""Reading a picture at the places of a matrix, or at planes of columns and rows."""

import math

import numpy as np
from numpy.typing import NDArray

from ... import _multum
from ._images import (
    EVERYTHING,
    Array,
    Floats,
    clip_to_input,
    element,
    joined,
    limits,
    plain,
)

Planes = tuple[NDArray[np.float64], NDArray[np.float64]]
_WRAPS = {
    "constant": "border",
    "edge": "clamp",
    "symmetric": "mirror",
    "reflect": "mirror_101",
    "wrap": "repeat",
}


def clipped(out: Array, source: Floats, mode: str, cval: float, clip: bool) -> None:
    """Draws results into the range of the source, if that is wanted."""
    if clip:
        bounds = limits(Floats(plain(source.array), 1.0))
        np.clip(out, *joined(bounds, mode, cval), out=out)
        clip_to_input(out, bounds, mode, cval)


def _pixels(array: Array) -> Array:
    """(H, W, C), of the same memory."""
    return array[..., np.newaxis] if array.ndim == 2 else array


def by_matrix(
    source: Floats, matrix: Array, size: tuple[int, int], order: int, mode: str, cval: float, clip: bool
) -> Array:
    """At the places of a matrix: linear, or Catmull and Rom's cubic (orders 1 and 3)."""
    if order == 1:
        return linear(source, size, mode, cval, clip, matrix=matrix)
    array = _pixels(source.whole())
    out = np.empty((*size, array.shape[2]), array.dtype)
    manner = {
        "interpolation": "bicubic",
        "slope": -0.5,
        "grid": "exact",
        "wrap": (_WRAPS[mode], _WRAPS[mode]),
        "outside": "colour",
        "border": [float(cval)] * array.shape[2],
        "threads": None,
    }
    _multum.interpolate(array, None, None, [float(v) for v in matrix.flat], manner, out)
    clipped(out, Floats(array, 1.0), mode, cval, clip)
    return out[..., 0] if source.array.ndim == 2 else out


def linear(
    source: Floats,
    size: tuple[int, ...],
    mode: str,
    cval: float,
    clip: bool,
    *,
    matrix: Array | None = None,
    planes: Planes | None = None,
) -> Array:
    """Linear interpolation, in singles for single images."""
    array = _pixels(source.array)
    out = np.empty((*size, array.shape[2]), source.dtype)
    bounds = limits(source) if clip else EVERYTHING
    numbers = None if matrix is None else [float(v) for v in matrix.flat]
    nowhere = math.nan if mode in ("constant", "edge") else float(cval)
    if out.size:
        _multum.lerp_image(
            array, numbers, planes, mode, source.factor, float(cval), nowhere, joined(bounds, mode, cval), out
        )
    if clip:
        clip_to_input(out, bounds, mode, cval)
    return out[..., 0] if source.array.ndim == 2 else out


def nearest(
    image: Array,
    size: tuple[int, int],
    mode: str,
    cval: float,
    clip: bool,
    *,
    matrix: Array | None = None,
    planes: Planes | None = None,
) -> Array:
    """Copies of pixels of any type; their bytes travel as unsigned integers."""
    array = _pixels(plain(image))
    itemsize = array.dtype.itemsize
    carrier = np.dtype(f"u{min(itemsize, 8)}") if itemsize in (1, 2, 4, 8, 16) else None
    if carrier is None or array.dtype.kind not in "biufc":
        raise TypeError(f"image: got dtype {array.dtype}, expected numbers")
    beyond = np.full(array.shape[2], element(cval, array.dtype))
    out = np.empty((*size, array.shape[2]), array.dtype)
    numbers = None if matrix is None else [float(v) for v in matrix.flat]
    if out.size:
        _multum.nearest_image(
            array.view(carrier), numbers, planes, mode, beyond.view(carrier), out.view(carrier)
        )
    if clip and mode == "constant" and out.size and array.dtype.kind in "iub" and beyond[0] != cval:
        # What lies outside was rounded, perhaps beyond the input's range, which alone counts then.
        low, high = array.min(), array.max()
        if not low <= cval <= high and out.min() <= cval <= out.max():
            low, high = min(low, array.dtype.type(cval)), max(high, array.dtype.type(cval))
        np.clip(out, low, high, out=out)
    return out[..., 0] if np.ndim(image) == 2 else out
