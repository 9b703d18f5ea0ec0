"""``pyrDown``, ``pyrUp``, ``buildPyramid``."""

import operator
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ... import _multum
from . import _arrays
from ._arrays import Array, error
from ._call import REFUSALS, receivers, refusal, settle
from ._constants import BORDER_DEFAULT


def _level(src: Any, dst: Any, dstsize: Any, border: int, enlarge: bool) -> Array:
    size = dstsize if dstsize is None else tuple(dstsize)
    made: Array | None = _multum.cv2_pyramid(src, dst, size, border, enlarge)
    if made is not None:
        return made
    receivers(("dst", dst))
    return settle(
        _arrays.made(_multum.cv2_pyramid(_arrays.image("src", src), None, size, border, enlarge)), dst
    )


def pyrDown(
    src: ArrayLike,
    dst: Array | None = None,
    dstsize: Sequence[int] | None = None,
    borderType: int = BORDER_DEFAULT,
) -> Array:
    """``cv2.pyrDown``: half the size, smoothed by (1, 4, 6, 4, 1) / 16 along each axis.

    Pixel (x, y) is centred on pixel (2x, 2y) of ``src``. Integers are rounded to nearest, halves up.

    Parameters
    ----------
    src : array, shape (H, W) or (H, W, C)
        ``uint8``, ``uint16``, ``int16``, ``float16``, ``float32`` or ``float64``.
    dst : array, optional
        Receives the result if its shape and dtype are right.
    dstsize : (width, height), optional
        Half of each side, or one more or less; by default ``((W + 1) // 2, (H + 1) // 2)``.
    borderType : int
        What lies outside: ``BORDER_REPLICATE``, ``_REFLECT``, ``_WRAP`` or ``_REFLECT_101``.

    Raises
    ------
    error
        For arguments that are not as above.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> cv2.pyrDown(np.uint8([[0, 0, 160, 0, 0]])).tolist()
    [[20, 60, 20]]
    """
    try:
        return _level(src, dst, dstsize, borderType, False)
    except REFUSALS as reason:
        raise refusal(reason) from None


def pyrUp(
    src: ArrayLike,
    dst: Array | None = None,
    dstsize: Sequence[int] | None = None,
    borderType: int = BORDER_DEFAULT,
) -> Array:
    """``cv2.pyrUp``: twice the size, smoothed by (1, 4, 6, 4, 1) / 8 along each axis of zeros and pixels in turn.

    Parameters
    ----------
    src, dst
        As for :func:`pyrDown`.
    dstsize : (width, height), optional
        Twice each side, the default, or an odd number next to that.
    borderType : int
        ``BORDER_DEFAULT``.

    Raises
    ------
    error
        For arguments that are not as above.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> cv2.pyrUp(np.uint8([[0, 160]])).tolist()
    [[40, 80, 140, 160], [40, 80, 140, 160]]
    """
    try:
        return _level(src, dst, dstsize, borderType, True)
    except REFUSALS as reason:
        raise refusal(reason) from None


def buildPyramid(
    src: ArrayLike, maxlevel: int, dst: Sequence[Array] | None = None, borderType: int = BORDER_DEFAULT
) -> list[Array]:
    """``cv::buildPyramid``: ``src`` and ``maxlevel`` times :func:`pyrDown` of the level before.

    Parameters
    ----------
    src : array
        As for :func:`pyrDown`; it is the first of the list, not copied.
    maxlevel : int
        Number of levels below ``src``.
    dst : sequence of arrays, optional
        Receive the levels from the second on, as ``dst`` of :func:`pyrDown`.
    borderType : int
        As for :func:`pyrDown`.

    Raises
    ------
    error
        For arguments that are not as above.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> [level.shape for level in cv2.buildPyramid(np.zeros((9, 6), np.uint8), 3)]
    [(9, 6), (5, 3), (3, 2), (2, 1)]
    """
    try:
        count = operator.index(maxlevel)
        if not 0 <= count <= 64:
            raise error(f"maxlevel: got {maxlevel}, expected 0 to 64")
        levels = [np.asarray(src)]
        if levels[0].ndim not in (2, 3) or levels[0].size == 0:
            raise error(f"src: got shape {levels[0].shape}, expected (H, W) or (H, W, C) without empty axes")
        for level in range(count):
            into = dst[level] if dst is not None and level < len(dst) else None
            levels.append(pyrDown(levels[-1], into, borderType=borderType))
        return levels
    except REFUSALS as reason:
        raise refusal(reason) from None
