"""OpenCV's image warps: the same names, signatures, flags, defaults and rules, without OpenCV.

Every function that resamples takes ``antialias``. With ``False`` it is OpenCV 5's plain interpolation: equal
within one step of integers and the rounding of floats. With ``True``, the default, it is the same where the map
magnifies; where a pixel covers more than a pixel of the input, it is the filtered value, so that reductions do
not alias. ``INTER_NEAREST`` is never filtered: labels have no average.

Beyond OpenCV: images of any size and number of channels, ``float64`` maps, ``float16`` images.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _multum
from .._warp import warp as _warp
from . import _cv2_arrays as _arrays
from ._cv2_arrays import error

INTER_NEAREST, INTER_LINEAR, INTER_CUBIC, INTER_AREA, INTER_LANCZOS4 = 0, 1, 2, 3, 4
INTER_LINEAR_EXACT, INTER_NEAREST_EXACT, INTER_MAX = 5, 6, 7
INTER_BITS, INTER_BITS2, INTER_TAB_SIZE, INTER_TAB_SIZE2 = 5, 10, 32, 1024
WARP_FILL_OUTLIERS, WARP_INVERSE_MAP, WARP_RELATIVE_MAP = 8, 16, 32
WARP_POLAR_LINEAR, WARP_POLAR_LOG = 0, 256
BORDER_CONSTANT, BORDER_REPLICATE, BORDER_REFLECT, BORDER_WRAP = 0, 1, 2, 3
BORDER_REFLECT_101, BORDER_REFLECT101, BORDER_DEFAULT = 4, 4, 4
BORDER_TRANSPARENT, BORDER_ISOLATED = 5, 16
CV_8U, CV_8S, CV_16U, CV_16S, CV_32S, CV_32F, CV_64F = 0, 1, 2, 3, 4, 5, 6
CV_16SC2, CV_32FC1, CV_32FC2 = 35, 5, 37
ALGO_HINT_DEFAULT, ALGO_HINT_ACCURATE, ALGO_HINT_APPROX = 0, 1, 2

_Array = NDArray[Any]
_INTERPOLATIONS = {
    INTER_NEAREST: "nearest",
    INTER_LINEAR: "bilinear",
    INTER_CUBIC: "bicubic",
    INTER_AREA: "bilinear",
    INTER_LANCZOS4: "lanczos4",
}
_WRAPS = {
    BORDER_CONSTANT: "border",
    BORDER_REPLICATE: "clamp",
    BORDER_REFLECT: "mirror",
    BORDER_WRAP: "repeat",
    BORDER_REFLECT_101: "mirror_101",
    BORDER_TRANSPARENT: "border",
}

__all__ = [
    "ALGO_HINT_ACCURATE",
    "ALGO_HINT_APPROX",
    "ALGO_HINT_DEFAULT",
    "BORDER_CONSTANT",
    "BORDER_DEFAULT",
    "BORDER_ISOLATED",
    "BORDER_REFLECT",
    "BORDER_REFLECT101",
    "BORDER_REFLECT_101",
    "BORDER_REPLICATE",
    "BORDER_TRANSPARENT",
    "BORDER_WRAP",
    "CV_8S",
    "CV_8U",
    "CV_16S",
    "CV_16SC2",
    "CV_16U",
    "CV_32F",
    "CV_32FC1",
    "CV_32FC2",
    "CV_32S",
    "CV_64F",
    "INTER_AREA",
    "INTER_BITS",
    "INTER_BITS2",
    "INTER_CUBIC",
    "INTER_LANCZOS4",
    "INTER_LINEAR",
    "INTER_LINEAR_EXACT",
    "INTER_MAX",
    "INTER_NEAREST",
    "INTER_NEAREST_EXACT",
    "INTER_TAB_SIZE",
    "INTER_TAB_SIZE2",
    "WARP_FILL_OUTLIERS",
    "WARP_INVERSE_MAP",
    "WARP_POLAR_LINEAR",
    "WARP_POLAR_LOG",
    "WARP_RELATIVE_MAP",
    "convertMaps",
    "error",
    "getRectSubPix",
    "integral",
    "remap",
    "resize",
    "warpAffine",
    "warpPerspective",
    "warpPolar",
]


class _Places:
    """Where the pixels of an output of ``size`` (width, height) are read: maps or a matrix."""

    def __init__(
        self,
        size: tuple[int, int],
        first: _Array | None = None,
        second: _Array | None = None,
        matrix: _Array | None = None,
    ) -> None:
        self.size, self.first, self.second = size, first, second
        self.matrix: list[float] | None = None if matrix is None else [float(v) for v in matrix.ravel()]

    def minify(self) -> bool:
        return _multum.map_minifies(self.first, self.second, self.matrix, *self.size)

    def mapping(self) -> _Array:
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


def _resample(
    src: ArrayLike,
    places: _Places,
    interpolation: int,
    dst: _Array | None,
    border_mode: int,
    border_value: Any,
    antialias: bool,
    *,
    quantised: str = "thirtyseconds",
    exact: bool = False,
) -> _Array:
    kind = _INTERPOLATIONS.get(interpolation)
    if kind is None:
        raise error(
            f"interpolation: got {interpolation}, expected INTER_NEAREST, _LINEAR, _CUBIC, _AREA or _LANCZOS4"
        )
    wrap = _WRAPS.get(border_mode & ~BORDER_ISOLATED)
    if wrap is None:
        raise error(f"borderMode: got {border_mode}, expected one of BORDER_CONSTANT to BORDER_TRANSPARENT")
    source = _arrays.image("src", src, nearest=kind == "nearest")
    channels = source.shape[2]
    colour = _arrays.border_colour(border_value, channels)
    dtype = source.dtype
    transparent = border_mode & ~BORDER_ISOLATED == BORDER_TRANSPARENT
    work = _arrays.target(dst, (places.size[1], places.size[0], channels), dtype, source, transparent)
    if dtype not in _arrays.KERNEL_TYPES:
        # Only copied: the bits travel as another type.
        carrier = _arrays.CARRIERS[dtype.itemsize]
        bits = np.array(np.clip(colour, *_limits(dtype))).round().astype(dtype)
        colour = [float(v) for v in bits.view(carrier)]
        source, carried = source.view(carrier), work.view(carrier)
    else:
        carried = work
    # OpenCV's own linear interpolation is exact for these, and in steps of 1/32 pixel for others.
    fine = (
        exact
        or kind in ("nearest", "bicubic")
        or (
            kind == "bilinear"
            and dtype.type in _arrays.EXACT_LINEAR
            and channels in _arrays.CHANNELS_OF_EXACT_LINEAR
        )
    )
    outside = "colour"
    if transparent:
        outside = "previous" if fine and kind != "nearest" else "keep"
    manner = {
        "interpolation": kind,
        "slope": -0.75,
        "grid": "exact" if fine else quantised,
        "wrap": (wrap, wrap),
        "outside": outside,
        "border": colour,
        "threads": None,
    }
    _multum.interpolate(source, places.first, places.second, places.matrix, manner, carried)
    if antialias and kind != "nearest" and places.minify():
        _filter(source, places, kind, wrap, colour, transparent, work)
    return _arrays.delivered(work, dst)


def _output_size(dsize: Sequence[int], src: ArrayLike) -> tuple[int, int]:
    """The size asked for; zeros stand for that of the source."""
    shape = np.shape(src)
    return _arrays.size("dsize", dsize, (shape[1], shape[0]) if len(shape) > 1 else None)


def _limits(dtype: np.dtype[Any]) -> tuple[int, int]:
    if dtype.kind == "b":
        return 0, 1
    limits = np.iinfo(dtype)
    return int(limits.min), int(limits.max)


def _filter(
    source: _Array,
    places: _Places,
    kind: str,
    wrap: str,
    colour: list[float],
    transparent: bool,
    work: _Array,
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
            filtered = np.rint(filtered).clip(*_limits(work.dtype))
        filtered = filtered.astype(work.dtype)
    if kind == "bilinear" and not transparent:
        # What the filters do where the map magnifies is this interpolation.
        work[...] = filtered
    else:
        np.copyto(work, filtered, where=~places.magnified()[..., np.newaxis])


def remap(
    src: ArrayLike,
    map1: ArrayLike,
    map2: ArrayLike | None,
    interpolation: int,
    dst: _Array | None = None,
    borderMode: int = BORDER_CONSTANT,
    borderValue: Any = None,
    hint: int = ALGO_HINT_DEFAULT,
    *,
    antialias: bool = True,
) -> _Array:
    """``cv2.remap``: output pixel (x, y) is read at ``(map1[y, x], map2[y, x])``, in pixels of ``src``.

    Parameters
    ----------
    src : array, shape (H, W) or (H, W, C)
        ``uint8``, ``uint16``, ``int16``, ``float16``, ``float32`` or ``float64``; other integers with
        ``INTER_NEAREST``.
    map1, map2 : arrays
        Columns and rows, (h, w) ``float32`` or ``float64``; or one array (h, w, 2) and None; or a fixed-point
        map of :func:`convertMaps`.
    interpolation : int
        ``INTER_NEAREST``, ``INTER_LINEAR``, ``INTER_CUBIC`` or ``INTER_LANCZOS4``; plus ``WARP_RELATIVE_MAP``
        where the maps hold offsets. As in OpenCV 5, positions are rounded to 1/32 pixel for ``INTER_LANCZOS4``,
        and for ``INTER_LINEAR`` unless ``src`` is ``uint8``, ``uint16`` or ``float32`` of 1, 3 or 4 channels.
    dst : array, optional
        Receives the result if its shape and dtype are right; its content shows under ``BORDER_TRANSPARENT``.
    borderMode, borderValue
        What lies outside. Positions that are not finite have ``borderValue``.
    hint : int
        Taken for OpenCV's sake; without effect.
    antialias : bool
        Filter where the map minifies.

    Raises
    ------
    error
        For arguments that are not as above.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> x, y = np.meshgrid(np.float32([0, 0.5, 1]), np.float32([0]))
    >>> cv2.remap(np.uint8([[10, 20]]), x, y, cv2.INTER_LINEAR).tolist()
    [[10, 15, 20]]
    """
    first, second = _arrays.maps(map1, map2)
    if interpolation & WARP_RELATIVE_MAP:
        across = np.arange(first.shape[1], dtype=first.dtype)
        down = np.arange(first.shape[0], dtype=first.dtype)[:, np.newaxis]
        if first.ndim == 3:
            first = first + np.stack(np.broadcast_arrays(across, down), -1)
        elif second is not None:
            first, second = first + across, second + down
        interpolation -= WARP_RELATIVE_MAP
    places = _Places((first.shape[1], first.shape[0]), first, second)
    if first.dtype == np.int16:
        # The codes are the grid.
        return _resample(src, places, interpolation, dst, borderMode, borderValue, antialias, exact=False)
    return _resample(src, places, interpolation, dst, borderMode, borderValue, antialias)


def warpAffine(
    src: ArrayLike,
    M: ArrayLike,
    dsize: Sequence[int],
    dst: _Array | None = None,
    flags: int = INTER_LINEAR,
    borderMode: int = BORDER_CONSTANT,
    borderValue: Any = None,
    hint: int = ALGO_HINT_DEFAULT,
    *,
    antialias: bool = True,
) -> _Array:
    """``cv2.warpAffine``: moves pixel (x, y) to ``M @ (x, y, 1)``; with ``WARP_INVERSE_MAP``, reads it there.

    Positions are computed in double precision, never stored as a map.

    Parameters
    ----------
    src : array, shape (H, W) or (H, W, C)
        As for :func:`remap`.
    M : array, shape (2, 3)
        ``float32`` or ``float64``.
    dsize : (width, height)
        Of the result; (0, 0) for that of ``src``.
    flags : int
        An interpolation of :func:`remap`, plus ``WARP_INVERSE_MAP``.
    dst, borderMode, borderValue, hint, antialias
        As for :func:`remap`.

    Raises
    ------
    error
        For arguments that are not as above.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> stripes = np.tile(np.uint8([0, 200]), (4, 8))
    >>> half = np.float32([[0.5, 0, -0.25], [0, 0.5, -0.25]])
    >>> cv2.warpAffine(stripes, half, (3, 1), borderMode=cv2.BORDER_WRAP).tolist()
    [[100, 100, 100]]
    """
    matrix = _arrays.matrix("M", M, 2)
    if not flags & WARP_INVERSE_MAP:
        det = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
        scale = 1 / det if det != 0 else 0.0
        a, b = matrix[1, 1] * scale, -matrix[0, 1] * scale
        c, d = -matrix[1, 0] * scale, matrix[0, 0] * scale
        x, y = matrix[:, 2]
        matrix = np.array([[a, b, -a * x - b * y], [c, d, -c * x - d * y]])
    full = np.vstack([matrix, [[0.0, 0.0, 1.0]]])
    places = _Places(_output_size(dsize, src), matrix=full)
    kind = flags & INTER_MAX
    return _resample(src, places, kind, dst, borderMode, borderValue, antialias, quantised="accumulated")


def warpPerspective(
    src: ArrayLike,
    M: ArrayLike,
    dsize: Sequence[int],
    dst: _Array | None = None,
    flags: int = INTER_LINEAR,
    borderMode: int = BORDER_CONSTANT,
    borderValue: Any = None,
    hint: int = ALGO_HINT_DEFAULT,
    *,
    antialias: bool = True,
) -> _Array:
    """``cv2.warpPerspective``: moves pixel (x, y) to ``M @ (x, y, 1)``, divided by its third number.

    Parameters
    ----------
    src : array, shape (H, W) or (H, W, C)
        As for :func:`remap`.
    M : array, shape (3, 3)
        ``float32`` or ``float64``.
    dsize : (width, height)
        Of the result; (0, 0) for that of ``src``.
    flags : int
        An interpolation of :func:`remap`, plus ``WARP_INVERSE_MAP``: read there instead.
    dst, borderMode, borderValue, hint, antialias
        As for :func:`remap`.

    Raises
    ------
    error
        For arguments that are not as above.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> shift = np.float64([[1, 0, 1], [0, 1, 0], [0, 0, 1]])
    >>> cv2.warpPerspective(np.uint8([[10, 20, 30]]), shift, (3, 1)).tolist()
    [[0, 10, 20]]
    """
    matrix = _arrays.matrix("M", M, 3)
    if not flags & WARP_INVERSE_MAP:
        (a, b, c), (d, e, f), (g, h, i) = matrix
        adjugate = np.array(
            [
                [e * i - f * h, c * h - b * i, b * f - c * e],
                [f * g - d * i, a * i - c * g, c * d - a * f],
                [d * h - e * g, b * g - a * h, a * e - b * d],
            ]
        )
        det = a * adjugate[0, 0] + b * adjugate[1, 0] + c * adjugate[2, 0]
        matrix = adjugate / det if det != 0 else np.zeros((3, 3))
    places = _Places(_output_size(dsize, src), matrix=matrix)
    return _resample(src, places, flags & INTER_MAX, dst, borderMode, borderValue, antialias)


def convertMaps(
    map1: ArrayLike,
    map2: ArrayLike | None,
    dstmap1type: int,
    dstmap1: _Array | None = None,
    dstmap2: _Array | None = None,
    nninterpolation: bool = False,
) -> tuple[_Array, _Array | None]:
    """``cv2.convertMaps``: between float maps and fixed-point ones (``CV_16SC2``).

    A fixed-point map has whole pixels (h, w, 2) ``int16`` and fractions (h, w) ``uint16``: ``32 * fy + fx`` in
    1/32 pixel. With ``nninterpolation`` it has the nearest pixels and no fractions.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> whole, codes = cv2.convertMaps(np.float32([[1.5]]), np.float32([[2.25]]), cv2.CV_16SC2)
    >>> whole.tolist(), codes.tolist()
    ([[[1, 2]]], [[272]])
    """
    first, second = _arrays.maps(map1, map2)
    pairs = _Places((first.shape[1], first.shape[0]), first, second).mapping()
    if dstmap1type == CV_16SC2:
        steps = 1 if nninterpolation else INTER_TAB_SIZE
        fixed = np.rint(pairs.astype(np.float64) * steps).clip(-(2.0**31), 2.0**31 - 1)
        fixed = np.nan_to_num(fixed, nan=-(2.0**31)).astype(np.int64)
        whole = (fixed // steps).clip(-32768, 32767).astype(np.int16)
        if nninterpolation:
            return whole, None
        rest = (fixed & (steps - 1)).astype(np.uint16)
        return whole, rest[..., 1] * np.uint16(steps) + rest[..., 0]
    if dstmap1type == CV_32FC2:
        return pairs.astype(np.float32), None
    if dstmap1type == CV_32FC1:
        single = pairs.astype(np.float32)
        return np.ascontiguousarray(single[..., 0]), np.ascontiguousarray(single[..., 1])
    raise error(f"dstmap1type: got {dstmap1type}, expected CV_16SC2, CV_32FC1 or CV_32FC2")


def getRectSubPix(
    image: ArrayLike,
    patchSize: Sequence[int],
    center: Sequence[float],
    patch: _Array | None = None,
    patchType: int = -1,
) -> _Array:
    """``cv2.getRectSubPix``: a patch (width, height) around a centre (x, y), linear between pixels.

    The last pixels go on outside. ``patchType`` ``CV_32F`` gives ``float32`` of a ``uint8`` image.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> cv2.getRectSubPix(np.uint8([[10, 20, 30]]), (2, 1), (1.0, 0.0)).tolist()
    [[15, 25]]
    """
    source = _arrays.image("image", image)
    if patchType == CV_32F and source.dtype == np.uint8:
        source = source.astype(np.float32)
    elif patchType not in (-1, {"uint8": CV_8U, "float32": CV_32F}.get(source.dtype.name, -1)):
        raise error(f"patchType: got {patchType}, expected CV_32F, or the image's own depth")
    width, height = _arrays.size("patchSize", patchSize)
    x, y = (float(c) - 0.5 * (n - 1) for c, n in zip(center, (width, height), strict=True))
    places = _Places((width, height), matrix=np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]]))
    return _resample(source, places, INTER_LINEAR, patch, BORDER_REPLICATE, None, False, exact=True)


def integral(src: ArrayLike, sum: _Array | None = None, sdepth: int = -1) -> _Array:
    """``cv2.integral``: ``sum[y, x]`` is the sum of all pixels above and left of corner (x, y).

    Shape (H + 1, W + 1) or (H + 1, W + 1, C); ``int32`` for ``uint8``, else ``float64``, unless ``sdepth`` is
    ``CV_32S``, ``CV_32F`` or ``CV_64F``.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> cv2.integral(np.uint8([[1, 2], [3, 4]])).tolist()
    [[0, 0, 0], [0, 1, 3], [0, 4, 10]]
    """
    source = _arrays.image("src", src)
    depths = {-1: np.int32 if source.dtype == np.uint8 else np.float64, CV_32S: np.int32, CV_32F: np.float32}
    depths[CV_64F] = np.float64
    if sdepth not in depths or (depths[sdepth] == np.int32 and source.dtype != np.uint8):
        raise error(
            f"sdepth: got {sdepth} for {source.dtype}, expected -1, CV_32F or CV_64F, or CV_32S for uint8"
        )
    height, width, channels = source.shape
    dtype = np.dtype(depths[sdepth])
    work = _arrays.target(sum, (height + 1, width + 1, channels), dtype, source, False)
    work[0], work[:, 0] = 0, 0
    inner = work[1:, 1:]
    wide = np.cumsum(source, axis=1, dtype=np.float64 if dtype.kind == "f" else dtype)
    inner[...] = np.cumsum(wide, axis=0, out=wide)
    return _arrays.delivered(work, sum)


def resize(
    src: ArrayLike,
    dsize: Sequence[int] | None,
    dst: _Array | None = None,
    fx: float = 0,
    fy: float = 0,
    interpolation: int = INTER_LINEAR,
    *,
    antialias: bool = True,
) -> _Array:
    """``cv2.resize``: to ``dsize`` (width, height), or by the factors ``fx`` and ``fy`` where that is None.

    Pixel edges lie on pixel edges. ``INTER_NEAREST`` takes pixel ``floor(x W / w)``, ``INTER_NEAREST_EXACT``
    the one nearest to the centre. ``INTER_AREA`` is the mean over the pixel's area where both sides shrink.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> cv2.resize(np.uint8([[0, 10, 20, 30]]), (2, 1), interpolation=cv2.INTER_AREA).tolist()
    [[5, 25]]
    """
    source = _arrays.image("src", src, nearest=interpolation in (INTER_NEAREST, INTER_NEAREST_EXACT))
    height, width = source.shape[:2]
    scaled = None
    if fx > 0 and fy > 0:
        scaled = (max(1, round(width * fx)), max(1, round(height * fy)))
    w, h = _arrays.size("dsize", dsize, scaled)
    given = dsize is not None and tuple(dsize) != (0, 0)
    sx, sy = (width / w, height / h) if given else (1 / fx, 1 / fy)
    shrinks = sx >= 1 and sy >= 1 and sx * sy > 1
    if interpolation == INTER_AREA and shrinks:
        return _arrays.delivered(_area(source, w, h, sx, sy), dst)
    if interpolation == INTER_LINEAR and sx == 2 and sy == 2:
        return _arrays.delivered(_area(source, w, h, sx, sy), dst)
    if interpolation in (INTER_NEAREST, INTER_NEAREST_EXACT):
        if interpolation == INTER_NEAREST:
            # The factor is rounded before its inverse is taken, as OpenCV does.
            xs = np.floor(np.arange(w) * (1 / (w / width))).astype(np.int64).clip(0, width - 1)
            ys = np.floor(np.arange(h) * (1 / (h / height))).astype(np.int64).clip(0, height - 1)
        else:
            xs, ys = _nearest_exact(width, w), _nearest_exact(height, h)
        return _arrays.delivered(source[ys[:, np.newaxis], xs], dst)
    kinds = {
        INTER_LINEAR: INTER_LINEAR,
        INTER_LINEAR_EXACT: INTER_LINEAR,
        INTER_CUBIC: INTER_CUBIC,
        INTER_LANCZOS4: INTER_LANCZOS4,
    }
    if interpolation == INTER_AREA:
        matrix = None
        first, second = _area_enlarged(width, w, sx), _area_enlarged(height, h, sy)
        x, y = (np.ascontiguousarray(v) for v in np.broadcast_arrays(first, second[:, np.newaxis]))
        places = _Places((w, h), x, y)
        return _resample(source, places, INTER_LINEAR, dst, BORDER_REPLICATE, None, False, exact=True)
    if interpolation not in kinds:
        raise error(
            f"interpolation: got {interpolation}, expected one of INTER_NEAREST to INTER_NEAREST_EXACT"
        )
    matrix = np.array([[sx, 0.0, 0.5 * sx - 0.5], [0.0, sy, 0.5 * sy - 0.5], [0.0, 0.0, 1.0]])
    places = _Places((w, h), matrix=matrix)
    kind = kinds[interpolation]
    return _resample(source, places, kind, dst, BORDER_REPLICATE, None, antialias, exact=True)


def _nearest_exact(n: int, m: int) -> NDArray[np.int64]:
    """For each of ``m`` output pixels the one of ``n`` that holds its centre."""
    found: NDArray[np.int64] = (2 * np.arange(m, dtype=np.int64) + 1) * n // (2 * m)
    return found.clip(0, n - 1)


def _area_enlarged(n: int, m: int, scale: float) -> NDArray[np.float64]:
    """Positions along an axis where ``INTER_AREA`` enlarges: each pixel keeps its colour but near its edges."""
    at = np.arange(m, dtype=np.float64)
    whole = np.floor(at * scale)
    rest = (at + 1) - (whole + 1) / scale
    rest = np.where(rest <= 0, 0.0, rest - np.floor(rest))
    positions: NDArray[np.float64] = (whole + rest).clip(0, n - 1)
    return positions


def _shares(n: int, m: int, scale: float) -> NDArray[np.float64]:
    """Row ``i`` holds the shares of ``n`` pixels in output pixel ``i``, which covers ``scale`` of them."""
    edges = np.arange(n + 1, dtype=np.float64)
    low, high = np.arange(m)[:, np.newaxis] * scale, (np.arange(m)[:, np.newaxis] + 1) * scale
    inside = np.clip(edges, low, np.minimum(high, n))
    lengths = np.diff(inside, axis=1)
    shares: NDArray[np.float64] = lengths / lengths.sum(axis=1, keepdims=True)
    return shares


def _area(source: _Array, w: int, h: int, sx: float, sy: float) -> _Array:
    """The mean over the area of each output pixel."""
    height, width, channels = source.shape
    across = _shares(width, w, sx)
    rows = np.empty((height, w, channels))
    for c in range(channels):
        rows[..., c] = source[..., c].astype(np.float64) @ across.T
    mean = np.tensordot(_shares(height, h, sy), rows, axes=1)
    if source.dtype.kind in "iu":
        mean = np.rint(mean).clip(*_limits(source.dtype))
    return mean.astype(source.dtype)


def warpPolar(
    src: ArrayLike,
    dsize: Sequence[int],
    center: Sequence[float],
    maxRadius: float,
    flags: int,
    dst: _Array | None = None,
    *,
    antialias: bool = True,
) -> _Array:
    """``cv2.warpPolar``: radius along x, angle along y; or back, with ``WARP_INVERSE_MAP``.

    ``WARP_POLAR_LOG`` makes the radius logarithmic. ``dsize`` (0, 0) takes the radius as width and its
    circumference as height.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> disc = np.full((9, 9), 7, np.uint8)
    >>> cv2.warpPolar(disc, (4, 8), (4, 4), 4, cv2.INTER_LINEAR).shape
    (8, 4)
    """
    source = _arrays.image("src", src, nearest=flags & INTER_MAX == INTER_NEAREST)
    radius = float(maxRadius)
    if not radius > 0:
        raise error(f"maxRadius: got {maxRadius!r}, expected a positive number")
    default = (max(1, round(radius)), max(1, round(radius * np.pi)))
    if flags & WARP_INVERSE_MAP:
        w, h = _arrays.size("dsize", dsize)
        height, width = source.shape[:2]
        x, y = np.meshgrid(np.arange(w) - float(center[0]), np.arange(h) - float(center[1]))
        rho = np.hypot(x, y)
        first = np.log1p(rho) * (width / np.log(radius)) if flags & WARP_POLAR_LOG else rho * (width / radius)
        second = np.mod(np.arctan2(y, x), 2 * np.pi) * (height / (2 * np.pi))
        wrapped = np.concatenate([source, source[:1]])
        places = _Places((w, h), first.astype(np.float32), second.astype(np.float32))
        border = BORDER_TRANSPARENT if not flags & WARP_FILL_OUTLIERS else BORDER_CONSTANT
        return _resample(wrapped, places, flags & INTER_MAX, dst, border, None, antialias)
    w, h = _arrays.size("dsize", dsize, default)
    if flags & WARP_POLAR_LOG:
        rho = np.exp(np.arange(w) * (np.log(radius) / w)) - 1.0
    else:
        rho = np.arange(w) * (radius / w)
    angle = np.arange(h)[:, np.newaxis] * (2 * np.pi / h)
    first = (rho * np.cos(angle) + float(center[0])).astype(np.float32)
    second = (rho * np.sin(angle) + float(center[1])).astype(np.float32)
    border = BORDER_TRANSPARENT if not flags & WARP_FILL_OUTLIERS else BORDER_CONSTANT
    return _resample(source, _Places((w, h), first, second), flags & INTER_MAX, dst, border, None, antialias)
