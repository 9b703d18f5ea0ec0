"""``remap`` and its maps."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ... import _multum
from . import _arrays
from ._arrays import Array
from ._call import REFUSALS, receivers, refusal, settle
from ._constants import ALGO_HINT_DEFAULT, BORDER_CONSTANT, INTER_NEAREST, WARP_RELATIVE_MAP
from ._resample import resample


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
    try:
        made: Array | None = _multum.cv2_remap(
            src, map1, map2, interpolation, dst, borderMode, borderValue, antialias
        )
        if made is not None:
            return made
        receivers(("dst", dst))
        first, second = _positions(map1, map2, interpolation)
        kind = interpolation & ~WARP_RELATIVE_MAP
        return resample(
            src,
            (first.shape[1], first.shape[0]),
            dst,
            borderMode,
            borderValue,
            kind == INTER_NEAREST,
            (first, second),
            lambda source, into, colour: _multum.cv2_remap(
                source, first, second, kind, into, borderMode, colour, antialias
            ),
        )
    except REFUSALS as reason:
        raise refusal(reason) from None


def _positions(map1: ArrayLike, map2: ArrayLike | None, flags: int) -> tuple[Array, Array | None]:
    """A map in order, from offsets where the flags say so."""
    first, second = _arrays.maps(map1, map2)
    if flags & WARP_RELATIVE_MAP:
        across = np.arange(first.shape[1], dtype=first.dtype)
        down = np.arange(first.shape[0], dtype=first.dtype)[:, np.newaxis]
        if first.ndim == 3:
            first = first + np.stack(np.broadcast_arrays(across, down), -1)
        elif second is not None:
            first, second = first + across, second + down
    return first, second


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
    try:
        made = _multum.cv2_convert(map1, map2, dstmap1type, dstmap1, dstmap2, nninterpolation)
        if made is not None:
            return made
        receivers(("dstmap1", dstmap1), ("dstmap2", dstmap2))
        first, second = _arrays.maps(map1, map2)
        one, two = _arrays.made(_multum.cv2_convert(first, second, dstmap1type, None, None, nninterpolation))
        return settle(one, dstmap1), None if two is None else settle(two, dstmap2)
    except REFUSALS as reason:
        raise refusal(reason) from None
