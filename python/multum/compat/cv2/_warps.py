"""Warps by matrices, to polar coordinates, and patches."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ... import _multum
from . import _arrays
from ._arrays import Array, error
from ._call import REFUSALS, receivers, refusal, settle
from ._constants import (
    ALGO_HINT_DEFAULT,
    BORDER_CONSTANT,
    BORDER_TRANSPARENT,
    CV_8U,
    CV_32F,
    INTER_LINEAR,
    INTER_MAX,
    INTER_NEAREST,
    WARP_FILL_OUTLIERS,
    WARP_INVERSE_MAP,
)
from ._resample import output_size, resample


def warpAffine(
    src: ArrayLike,
    M: ArrayLike,
    dsize: Sequence[int],
    dst: Array | None = None,
    flags: int = INTER_LINEAR,
    borderMode: int = BORDER_CONSTANT,
    borderValue: Any = None,
    hint: int = ALGO_HINT_DEFAULT,
    *,
    antialias: bool = True,
) -> Array:
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
    return _warped(src, M, 2, dsize, dst, flags, borderMode, borderValue, antialias)


def warpPerspective(
    src: ArrayLike,
    M: ArrayLike,
    dsize: Sequence[int],
    dst: Array | None = None,
    flags: int = INTER_LINEAR,
    borderMode: int = BORDER_CONSTANT,
    borderValue: Any = None,
    hint: int = ALGO_HINT_DEFAULT,
    *,
    antialias: bool = True,
) -> Array:
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
    return _warped(src, M, 3, dsize, dst, flags, borderMode, borderValue, antialias)


def _warped(
    src: ArrayLike,
    m: ArrayLike,
    rows: int,
    dsize: Sequence[int],
    dst: Array | None,
    flags: int,
    border: int,
    value: Any,
    antialias: bool,
) -> Array:
    """Both warps: at once where the arguments are in order."""
    try:
        made: Array | None = _multum.cv2_warp(src, m, rows, dsize, dst, flags, border, value, antialias)
        if made is not None:
            return made
        receivers(("dst", dst))
        matrix = _arrays.matrix("M", m, rows)
        size = output_size(dsize, src)
        return resample(
            src,
            size,
            dst,
            border,
            value,
            flags & INTER_MAX == INTER_NEAREST,
            (),
            lambda source, into, colour: _multum.cv2_warp(
                source, matrix, rows, size, into, flags, border, colour, antialias
            ),
        )
    except REFUSALS as reason:
        raise refusal(reason) from None


def getRectSubPix(
    image: ArrayLike,
    patchSize: Sequence[int],
    center: Sequence[float],
    patch: Array | None = None,
    patchType: int = -1,
) -> Array:
    """``cv2.getRectSubPix``: a patch (width, height) around a centre (x, y), linear between pixels.

    The last pixels go on outside. ``patchType`` ``CV_32F`` gives ``float32`` of a ``uint8`` image.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> cv2.getRectSubPix(np.uint8([[10, 20, 30]]), (2, 1), (1.0, 0.0)).tolist()
    [[15, 25]]
    """
    try:
        if patchType == -1:
            made: Array | None = _multum.cv2_patch(image, patchSize, center, patch)
            if made is not None:
                return made
        receivers(("patch", patch))
        source = _arrays.image("image", image)
        if patchType == CV_32F and source.dtype == np.uint8:
            source = source.astype(np.float32)
        elif patchType not in (-1, {"uint8": CV_8U, "float32": CV_32F}.get(source.dtype.name, -1)):
            raise error(f"patchType: got {patchType}, expected CV_32F, or the image's own depth")
        size, at = _arrays.size("patchSize", patchSize), _center(center)
        return settle(_arrays.made(_multum.cv2_patch(source, size, at, None)), patch)
    except REFUSALS as reason:
        raise refusal(reason) from None


def _center(value: Sequence[float]) -> tuple[float, float]:
    try:
        x, y = (float(c) for c in value)
    except (TypeError, ValueError):
        raise error(f"center: got {value!r}, expected a pair (x, y) of numbers") from None
    return x, y


def warpPolar(
    src: ArrayLike,
    dsize: Sequence[int],
    center: Sequence[float],
    maxRadius: float,
    flags: int,
    dst: Array | None = None,
    *,
    antialias: bool = True,
) -> Array:
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
    try:
        receivers(("dst", dst))
        return _polar(src, dsize, center, maxRadius, flags, dst, antialias)
    except REFUSALS as reason:
        raise refusal(reason) from None


def _polar(
    src: ArrayLike,
    dsize: Sequence[int],
    center: Sequence[float],
    maxRadius: float,
    flags: int,
    dst: Array | None,
    antialias: bool,
) -> Array:
    source = src if isinstance(src, np.ndarray) else np.asarray(src)
    radius = float(maxRadius)
    if not 0 < radius < float("inf"):
        raise error(f"maxRadius: got {maxRadius!r}, expected a positive number")
    if source.ndim not in (2, 3) or source.size == 0:
        raise error(f"src: got shape {source.shape}, expected (H, W) or (H, W, C) without empty axes")
    w, h = _polar_size(dsize, radius)
    at = _center(center)
    height, width = source.shape[:2]
    if flags & WARP_INVERSE_MAP:
        # A row of the other end at each end: the angle goes round.
        source = np.concatenate([source[-1:], source, source[:1]])
    size = (int(w), int(h))
    made: Array | None = _multum.cv2_polar(source, width, height, size, at, radius, flags, dst, antialias)
    if made is not None:
        return made
    border = BORDER_CONSTANT if flags & WARP_FILL_OUTLIERS else BORDER_TRANSPARENT
    return resample(
        source,
        size,
        dst,
        border,
        None,
        flags & INTER_MAX == INTER_NEAREST,
        (),
        lambda source, into, _: _multum.cv2_polar(
            source, width, height, size, at, radius, flags, into, antialias
        ),
    )


def _polar_size(dsize: Sequence[int], radius: float) -> tuple[int, int]:
    """The size asked for: a height of 0 is the circumference of the width or, where that is 0, of the radius."""
    try:
        w, h = (int(n) for n in dsize)
    except (TypeError, ValueError):
        raise error(f"dsize: got {dsize!r}, expected a pair (width, height) of whole numbers") from None
    if w <= 0 and h <= 0:
        w, h = round(radius), round(radius * np.pi)
    elif h <= 0:
        h = round(w * np.pi)
    return _arrays.size("dsize", (w, h))
