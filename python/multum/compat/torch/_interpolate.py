"""Resizing of images (N, C, H, W)."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ... import _multum
from ..skimage._bands import Band
from ..skimage._images import EVERYTHING, plain
from ._tensors import FLOATS, Array, array, error, like, one_of

MODES = ("nearest", "nearest-exact", "bilinear", "bicubic", "area")


def _pair(argument: str, value: Any) -> tuple[float, float]:
    numbers = (value, value) if np.ndim(value) == 0 else tuple(value)
    try:
        pair = tuple(float(n) for n in numbers)
    except OverflowError:
        pair = ()
    if len(pair) != 2 or not all(math.isfinite(n) for n in pair):
        raise error(f"{argument}: got {value!r}, expected a finite number or (height, width)")
    return pair[0], pair[1]


def interpolate(
    input: Any,
    size: int | Sequence[int] | None = None,
    scale_factor: float | Sequence[float] | None = None,
    mode: str = "nearest",
    align_corners: bool | None = None,
    recompute_scale_factor: bool | None = None,
    antialias: bool = False,
) -> Any:
    """``torch.nn.functional.interpolate`` for images.

    Parameters
    ----------
    input : array or tensor, shape (N, C, H, W)
        ``float32``, ``float64`` or ``float16``; any dtype for the two nearest modes.
    size : int or (height, width), optional
        Of the output.
    scale_factor : float or (along height, along width), optional
        Or so many times the input's size, rounded down.
    mode : str
        ``"nearest"`` (the pixel at ``floor(i s)``), ``"nearest-exact"`` (at ``floor((i + 1/2) s)``),
        ``"bilinear"``, ``"bicubic"`` (slope -0.75), ``"area"`` (means of whole pixels).
    align_corners : bool, optional
        For bilinear and bicubic: whether the centres of the corner pixels stay where they are.
    recompute_scale_factor : bool, optional
        Take the scale from the two sizes even where ``scale_factor`` is given.
    antialias : bool
        For bilinear and bicubic: widen the kernel (of slope -0.5) by the reduction.

    Returns
    -------
    array or tensor, shape (N, C, height, width)

    Examples
    --------
    >>> import numpy as np
    >>> board = np.indices((8, 8)).sum(0).reshape(1, 1, 8, 8) % 2.0
    >>> interpolate(board, size=(3, 3), mode="bilinear", antialias=True).round(2)[0, 0, 1, 1].item()
    0.5
    """
    one_of("mode", mode, MODES)
    images = array("input", input)
    if images.ndim != 4:
        raise error(f"input: got shape {images.shape}, expected (N, C, H, W)")
    if align_corners is not None and mode not in ("bilinear", "bicubic"):
        raise error(f"align_corners: got {align_corners} for mode {mode!r}, expected bilinear or bicubic")
    if antialias and mode not in ("bilinear", "bicubic"):
        raise error(f"antialias: got True for mode {mode!r}, expected bilinear or bicubic")
    if (size is None) == (scale_factor is None):
        raise error("size, scale_factor: got none or both, expected one")
    if recompute_scale_factor and size is not None:
        raise error("recompute_scale_factor: got True with a size, expected a scale_factor")
    old = images.shape[2:]
    factors: tuple[float | None, float | None] = (None, None)
    if size is not None:
        new = tuple(int(n) for n in _pair("size", size))
    else:
        pair = _pair("scale_factor", scale_factor)
        new = tuple(int(np.floor(n * factor)) for n, factor in zip(old, pair, strict=True))
        if not recompute_scale_factor:
            factors = pair
    if mode == "area" and min(new) == 0 and min(images.shape[1:]) > 0:
        return like(np.empty((*images.shape[:2], *new), images.dtype), input)
    if max(new) > 1 << 30 or math.prod((*images.shape[:2], *new)) > 1 << 40:
        raise error(
            f"size: got {new} from an input of {images.shape}, expected at most 2^30 a side and 2^40 in all"
        )
    if min(new) < 1 or min(images.shape[1:]) < 1:
        raise error(f"size: got {new} from an input of {images.shape}, expected positive numbers")
    steps = [_step(n, m, factor, bool(align_corners)) for n, m, factor in zip(old, new, factors, strict=True)]
    if mode.startswith("nearest"):
        out = _nearest(images, (new[0], new[1]), steps, 0.5 if mode == "nearest-exact" else 0.0)
        return like(out, input)
    if images.dtype not in FLOATS:
        raise error(f"input: got dtype {images.dtype}, expected float32, float64 or float16")
    bands = [
        _area(n, m) if mode == "area" else _band(n, m, step, mode, bool(align_corners), antialias)
        for n, m, step in zip(old, new, steps, strict=True)
    ]
    return like(_banded(images, bands), input)


def _step(old: int, new: int, factor: float | None, align: bool) -> float:
    """Pixels of the input to one of the output."""
    if align:
        return (old - 1) / (new - 1) if new > 1 else 0.0
    return old / new if factor is None else 1 / factor


def _nearest(images: Array, new: tuple[int, int], steps: list[float], shift: float) -> Array:
    picked = images
    for axis, (count, step) in enumerate(zip(new, steps, strict=True), start=2):
        size = images.shape[axis]
        if shift == 0 and count in (size, 2 * size):
            # Whatever the scale says.
            if count != size:
                picked = np.repeat(picked, 2, axis=axis)
            continue
        # In singles, as there.
        at = np.floor((np.arange(count, dtype=np.float32) + np.float32(shift)) * np.float32(step))
        picked = np.take(picked, np.minimum(at.astype(np.int64), images.shape[axis] - 1), axis=axis)
    return picked.copy() if picked is images else picked


def _area(old: int, new: int) -> Band:
    """Means of all pixels that a pixel of the output touches."""
    j = np.arange(new)
    first, last = j * old // new, -(-(j + 1) * old // new)
    taps = np.arange((last - first).max())
    weights = (taps < (last - first)[:, np.newaxis]) / (last - first)[:, np.newaxis]
    return Band(first, weights)


def _kernel(distance: Array, mode: str, slope: float) -> Array:
    """Triangle or cubic convolution at distances that are not negative."""
    if mode == "bilinear":
        near: Array = np.maximum(1 - distance, 0)
        return near
    a, d = slope, distance
    near = ((a + 2) * d - (a + 3)) * d * d + 1
    far = ((a * d - 5 * a) * d + 8 * a) * d - 4 * a
    return np.where(d < 1, near, np.where(d < 2, far, 0.0))


def _band(old: int, new: int, step: float, mode: str, align: bool, antialias: bool) -> Band:
    reach = 1 if mode == "bilinear" else 2
    j = np.arange(new)
    if antialias and old == new:
        return Band(j, np.ones((new, 1)))
    if antialias:
        width = max(step, 1.0)
        centre = step * (j + 0.5)
        low = np.maximum(np.floor(centre - reach * width + 0.5), 0).astype(np.int64)
        high = np.minimum(np.floor(centre + reach * width + 0.5), old).astype(np.int64)
        taps = low[:, np.newaxis] + np.arange(max(int((high - low).max()), 1))
        weights = _kernel(np.abs(taps + 0.5 - centre[:, np.newaxis]) / width, mode, -0.5)
        weights[taps >= high[:, np.newaxis]] = 0
        return Band(low, weights / weights.sum(axis=1, keepdims=True))
    if align:
        at = j * step
    elif old == new and mode == "bilinear":
        # Whatever the scale says.
        at = j.astype(np.float64)
    else:
        at = step * (j + 0.5) - 0.5
    if mode == "bilinear":
        at = np.maximum(at, 0)
    first = np.floor(at).astype(np.int64) - (reach - 1)
    taps = first[:, np.newaxis] + np.arange(2 * reach)
    return Band(first, _kernel(np.abs(taps - at[:, np.newaxis]), mode, -0.75))


def _banded(images: Array, bands: list[Band]) -> Array:
    """Every plane through the matrices of both axes; what lies outside is the outermost pixel."""
    is_half = images.dtype == np.float16
    source = np.ascontiguousarray(images, np.float32 if is_half else images.dtype)
    rows, columns = ((plain(b.first.astype(np.int64)), plain(b.weights.astype(np.float64))) for b in bands)
    out = np.empty((*source.shape[:2], len(rows[0]), len(columns[0])), source.dtype)
    planes = source.reshape(-1, *source.shape[2:], 1)
    targets = out.reshape(-1, *out.shape[2:], 1)
    for plane, target in zip(planes, targets, strict=True):
        _multum.resample_image(plane, rows, columns, "edge", (1.0, 0.0, EVERYTHING), target)
    return out.astype(images.dtype) if is_half else out
