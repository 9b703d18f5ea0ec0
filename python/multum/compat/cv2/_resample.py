"""Reading an image at the places of a map or a matrix: the base of all functions that resample."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ... import _multum
from ..._warp import warp as _warp
from . import _arrays
from ._arrays import Array, error, limits
from ._constants import (
    BORDER_CONSTANT,
    BORDER_ISOLATED,
    BORDER_REFLECT,
    BORDER_REFLECT_101,
    BORDER_REPLICATE,
    BORDER_TRANSPARENT,
    BORDER_WRAP,
    INTER_AREA,
    INTER_CUBIC,
    INTER_LANCZOS4,
    INTER_LINEAR,
    INTER_NEAREST,
)

INTERPOLATIONS = {
    INTER_NEAREST: "nearest",
    INTER_LINEAR: "bilinear",
    INTER_CUBIC: "bicubic",
    INTER_AREA: "bilinear",
    INTER_LANCZOS4: "lanczos4",
}
WRAPS = {
    BORDER_CONSTANT: "border",
    BORDER_REPLICATE: "clamp",
    BORDER_REFLECT: "mirror",
    BORDER_WRAP: "repeat",
    BORDER_REFLECT_101: "mirror_101",
    BORDER_TRANSPARENT: "border",
}


class Places:
    """Where the pixels of an output of ``size`` (width, height) are read: maps or a matrix."""

    def __init__(
        self,
        size: tuple[int, int],
        first: Array | None = None,
        second: Array | None = None,
        matrix: Array | None = None,
    ) -> None:
        self.size, self.first, self.second = size, first, second
        self.matrix: list[float] | None = None if matrix is None else [float(v) for v in matrix.ravel()]

    def minify(self) -> bool:
        return _multum.map_minifies(self.first, self.second, self.matrix, *self.size)

    def mapping(self) -> Array:
        """What :func:`multum.warp` takes."""
        if self.matrix is not None:
            return np.array(self.matrix).reshape(3, 3)
        first, second = self.first, self.second
        assert first is not None
        if first.dtype != np.int16:
            return first if second is None else np.dstack([first, second])
        pairs = first.astype(np.float32)
        if second is not None:
            pairs[..., 0] += (second & 31) * np.float32(1 / 32)
            pairs[..., 1] += (second >> 5 & 31) * np.float32(1 / 32)
        return pairs

    def magnified(self) -> NDArray[np.bool_]:
        """Which output pixels cover no more than a pixel of the input."""
        mapping = self.mapping()
        if mapping.shape == (3, 3):
            x, y = np.meshgrid(*(np.arange(n, dtype=np.float64) for n in self.size))
            with np.errstate(all="ignore"):
                w = mapping[2, 0] * x + mapping[2, 1] * y + mapping[2, 2]
                mapping = np.dstack([(r[0] * x + r[1] * y + r[2]) / w for r in mapping[:2]])
        mapping = mapping.astype(np.float64)
        with np.errstate(all="ignore"):
            a, b = (
                np.diff(
                    mapping, axis=axis, append=np.take(mapping, [-1], axis) * 2 - np.take(mapping, [-2], axis)
                )
                if mapping.shape[axis] > 1
                else np.zeros_like(mapping)
                for axis in (1, 0)
            )
            square = 1.001**2
            trace = (a * a + b * b).sum(-1)
            det = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
            minified: NDArray[np.bool_] = (trace > 2 * square) | (square**2 - square * trace + det**2 < 0)
        return ~minified


def resample(
    src: ArrayLike,
    places: Places,
    interpolation: int,
    dst: Array | None,
    border_mode: int,
    border_value: Any,
    antialias: bool,
    *,
    quantised: str = "thirtyseconds",
    exact: bool = False,
) -> Array:
    kind = INTERPOLATIONS.get(interpolation)
    if kind is None:
        raise error(
            f"interpolation: got {interpolation}, expected INTER_NEAREST, _LINEAR, _CUBIC, _AREA or _LANCZOS4"
        )
    wrap = WRAPS.get(border_mode & ~BORDER_ISOLATED)
    if wrap is None:
        raise error(f"borderMode: got {border_mode}, expected one of BORDER_CONSTANT to BORDER_TRANSPARENT")
    source = _arrays.image("src", src, nearest=kind == "nearest")
    channels = source.shape[2]
    colour = _arrays.border_colour(border_value, channels)
    dtype = source.dtype
    transparent = border_mode & ~BORDER_ISOLATED == BORDER_TRANSPARENT
    inputs = (source, places.first, places.second)
    work = _arrays.target(dst, (places.size[1], places.size[0], channels), dtype, inputs, transparent)
    if dtype not in _arrays.KERNEL_TYPES:
        # Only copied: the bits travel as another type.
        carrier = _arrays.CARRIERS[dtype.itemsize]
        bits = np.array(np.clip(colour, *limits(dtype))).round().astype(dtype)
        colour = [float(v) for v in bits.view(carrier)]
        source, carried = source.view(carrier), work.view(carrier)
    else:
        carried = work
    # OpenCV's own linear and nearest interpolation is exact for these, and in fixed point for others.
    direct = dtype.type in _arrays.EXACT_LINEAR and channels in _arrays.CHANNELS_OF_EXACT_LINEAR
    if places.first is not None and places.first.dtype == np.int16:
        direct = False
    fine = exact or kind in ("nearest", "bicubic") or (kind == "bilinear" and direct)
    if kind == "nearest" and direct:
        quantised = "exact"
    outside = "colour"
    if transparent:
        outside = "previous" if fine and kind != "nearest" else "keep"
    manner = {
        "interpolation": kind,
        "slope": -0.75,
        "grid": _grid(kind, fine, quantised),
        "wrap": (wrap, wrap),
        "outside": outside,
        "border": colour,
        "threads": None,
    }
    _multum.interpolate(source, places.first, places.second, places.matrix, manner, carried)
    if antialias and kind != "nearest" and places.minify():
        _filter(source, places, kind, wrap, colour, transparent, work)
    return _arrays.delivered(work, dst)


def _grid(kind: str, fine: bool, quantised: str) -> str:
    """Which positions there are."""
    if kind == "nearest" and quantised == "accumulated":
        return "accumulated_whole"
    return "exact" if fine else quantised


def output_size(dsize: Sequence[int], src: ArrayLike) -> tuple[int, int]:
    """The size asked for; zeros stand for that of the source."""
    shape = np.shape(src)
    return _arrays.size("dsize", dsize, (shape[1], shape[0]) if len(shape) > 1 else None)


def _filter(
    source: Array,
    places: Places,
    kind: str,
    wrap: str,
    colour: list[float],
    transparent: bool,
    work: Array,
) -> None:
    """Puts the filtered values where the map minifies."""
    image = source.astype(np.float32) if source.dtype == np.int16 else source
    shape = (places.size[1], places.size[0])
    border = [0.0] * len(colour) if transparent else colour
    if transparent:
        values, share = _warp(
            image.astype(np.float64), places.mapping(), shape, wrap=wrap, border=border, coverage=True
        )
        filtered = values + (1 - share[..., np.newaxis].astype(np.float64)) * work
    else:
        filtered = _warp(image, places.mapping(), shape, wrap=wrap, border=border)
    if filtered.dtype != work.dtype:
        if work.dtype.kind in "iu":
            filtered = np.rint(filtered).clip(*limits(work.dtype))
        filtered = filtered.astype(work.dtype)
    if kind == "bilinear" and not transparent:
        # What the filters do where the map magnifies is this interpolation.
        work[...] = filtered
    else:
        np.copyto(work, filtered, where=~places.magnified()[..., np.newaxis])
