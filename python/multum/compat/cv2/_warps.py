"""Warps by matrices, to polar coordinates, and patches."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays
from ._arrays import Array, error
from ._constants import (
    ALGO_HINT_DEFAULT,
    BORDER_CONSTANT,
    BORDER_REPLICATE,
    BORDER_TRANSPARENT,
    CV_8U,
    CV_32F,
    INTER_LINEAR,
    INTER_MAX,
    INTER_NEAREST,
    WARP_FILL_OUTLIERS,
    WARP_INVERSE_MAP,
    WARP_POLAR_LOG,
)
from ._resample import Places, output_size, resample


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
    matrix = _arrays.matrix("M", M, 2)
    if not flags & WARP_INVERSE_MAP:
        det = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
        scale = 1 / det if det != 0 else 0.0
        a, b = matrix[1, 1] * scale, -matrix[0, 1] * scale
        c, d = -matrix[1, 0] * scale, matrix[0, 0] * scale
        x, y = matrix[:, 2]
        matrix = np.array([[a, b, -a * x - b * y], [c, d, -c * x - d * y]])
    full = np.vstack([matrix, [[0.0, 0.0, 1.0]]])
    places = Places(output_size(dsize, src), matrix=full)
    kind = flags & INTER_MAX
    return resample(src, places, kind, dst, borderMode, borderValue, antialias, quantised="accumulated")


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
    places = Places(output_size(dsize, src), matrix=matrix)
    return resample(src, places, flags & INTER_MAX, dst, borderMode, borderValue, antialias)


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
    source = _arrays.image("image", image)
    if patchType == CV_32F and source.dtype == np.uint8:
        source = source.astype(np.float32)
    elif patchType not in (-1, {"uint8": CV_8U, "float32": CV_32F}.get(source.dtype.name, -1)):
        raise error(f"patchType: got {patchType}, expected CV_32F, or the image's own depth")
    width, height = _arrays.size("patchSize", patchSize)
    x, y = (float(c) - 0.5 * (n - 1) for c, n in zip(center, (width, height), strict=True))
    places = Places((width, height), matrix=np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]]))
    return resample(source, places, INTER_LINEAR, patch, BORDER_REPLICATE, None, False, exact=True)


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
    source = _arrays.image("src", src, nearest=flags & INTER_MAX == INTER_NEAREST)
    radius = float(maxRadius)
    if not 0 < radius < np.inf:
        raise error(f"maxRadius: got {maxRadius!r}, expected a positive number")
    try:
        center_x, center_y = (float(v) for v in center)
    except (TypeError, ValueError):
        raise error(f"center: got {center!r}, expected two numbers") from None
    default = (max(1, round(radius)), max(1, round(radius * np.pi)))
    if flags & WARP_INVERSE_MAP:
        w, h = _arrays.size("dsize", dsize)
        height, width = source.shape[:2]
        x, y = np.meshgrid(np.arange(w) - center_x, np.arange(h) - center_y)
        rho = np.hypot(x, y)
        first = np.log1p(rho) * (width / np.log(radius)) if flags & WARP_POLAR_LOG else rho * (width / radius)
        second = np.mod(np.arctan2(y, x), 2 * np.pi) * (height / (2 * np.pi))
        wrapped = np.concatenate([source, source[:1]])
        places = Places((w, h), first.astype(np.float32), second.astype(np.float32))
        border = BORDER_TRANSPARENT if not flags & WARP_FILL_OUTLIERS else BORDER_CONSTANT
        return resample(wrapped, places, flags & INTER_MAX, dst, border, None, antialias)
    w, h = _arrays.size("dsize", dsize, default)
    if flags & WARP_POLAR_LOG:
        rho = np.exp(np.arange(w) * (np.log(radius) / w)) - 1.0
    else:
        rho = np.arange(w) * (radius / w)
    angle = np.arange(h)[:, np.newaxis] * (2 * np.pi / h)
    first = (rho * np.cos(angle) + center_x).astype(np.float32)
    second = (rho * np.sin(angle) + center_y).astype(np.float32)
    border = BORDER_TRANSPARENT if not flags & WARP_FILL_OUTLIERS else BORDER_CONSTANT
    return resample(source, Places((w, h), first, second), flags & INTER_MAX, dst, border, None, antialias)
