"""``remap`` and its maps."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays
from ._arrays import Array, error
from ._constants import (
    ALGO_HINT_DEFAULT,
    BORDER_CONSTANT,
    CV_16SC2,
    CV_32FC1,
    CV_32FC2,
    INTER_TAB_SIZE,
    WARP_RELATIVE_MAP,
)
from ._resample import Places, resample


def remap(
    src: ArrayLike,
    map1: ArrayLike,
    map2: ArrayLike | None,
    interpolation: int,
    dst: Array | None = None,
    borderMode: int = BORDER_CONSTANT,
    borderValue: Any = None,
    hint: int = ALGO_HINT_DEFAULT,
    *,
    antialias: bool = True,
) -> Array:
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
    places = Places((first.shape[1], first.shape[0]), first, second)
    if first.dtype == np.int16:
        # The codes are the grid.
        return resample(src, places, interpolation, dst, borderMode, borderValue, antialias, exact=False)
    return resample(src, places, interpolation, dst, borderMode, borderValue, antialias)


def convertMaps(
    map1: ArrayLike,
    map2: ArrayLike | None,
    dstmap1type: int,
    dstmap1: Array | None = None,
    dstmap2: Array | None = None,
    nninterpolation: bool = False,
) -> tuple[Array, Array | None]:
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
    pairs = Places((first.shape[1], first.shape[0]), first, second).mapping()
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
