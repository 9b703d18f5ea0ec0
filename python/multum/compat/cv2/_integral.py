"""Integral images."""

from typing import Any

from numpy.typing import ArrayLike

from ... import _multum
from . import _arrays
from ._arrays import Array
from ._call import REFUSALS, receivers, refusal, settle


def _tables(src: Any, given: tuple[Any, ...], sdepth: int, sqdepth: int) -> Any:
    made = _multum.cv2_integral(src, given, sdepth, sqdepth)
    if made is not None:
        return made
    receivers(*zip(("sum", "sqsum", "tilted"), given, strict=False))
    source = _arrays.image("src", src)
    made = _multum.cv2_integral(source, (None,) * len(given), sdepth, sqdepth)
    if len(given) == 1:
        return settle(made, given[0])
    return tuple(settle(table, dst) for table, dst in zip(made, given, strict=True))


def integral(src: ArrayLike, sum: Array | None = None, sdepth: int = -1) -> Array:
    """``cv2.integral``: ``sum[y, x]`` is the sum of all pixels above and left of corner (x, y).

    Parameters
    ----------
    src : array, shape (H, W) or (H, W, C)
        ``uint8``, ``uint16``, ``int16``, ``float16``, ``float32`` or ``float64``.
    sum : array, optional
        Receives the result if its shape, (H + 1, W + 1) or (H + 1, W + 1, C), and dtype are right.
    sdepth : int
        ``CV_32S``, the default for ``uint8`` and for it alone, which wraps at 2^31; ``CV_64F``, the default for
        others; or ``CV_32F`` for ``uint8`` and ``float32``, which is summed in doubles and stored in singles.

    Raises
    ------
    error
        For arguments that are not as above.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> cv2.integral(np.uint8([[1, 2], [3, 4]])).tolist()
    [[0, 0, 0], [0, 1, 3], [0, 4, 10]]
    """
    try:
        found: Array = _tables(src, (sum,), sdepth, 6)
    except REFUSALS as reason:
        raise refusal(reason) from None
    return found


def integral2(
    src: ArrayLike,
    sum: Array | None = None,
    sqsum: Array | None = None,
    sdepth: int = -1,
    sqdepth: int = -1,
) -> tuple[Array, Array]:
    """``cv2.integral2``: the sums of :func:`integral` and those of the squares.

    ``sqdepth`` is ``CV_64F``, the default; with ``sdepth`` ``CV_32S`` also ``CV_32S`` or ``CV_32F``, with
    ``sdepth`` ``CV_32F`` also ``CV_32F``.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> total, squares = cv2.integral2(np.uint8([[1, 2], [3, 4]]))
    >>> int(total[-1, -1]), float(squares[-1, -1])
    (10, 30.0)
    """
    try:
        found: tuple[Array, Array] = _tables(src, (sum, sqsum), sdepth, sqdepth)
    except REFUSALS as reason:
        raise refusal(reason) from None
    return found


def integral3(
    src: ArrayLike,
    sum: Array | None = None,
    sqsum: Array | None = None,
    tilted: Array | None = None,
    sdepth: int = -1,
    sqdepth: int = -1,
) -> tuple[Array, Array, Array]:
    """``cv2.integral3``: the tables of :func:`integral2` and the sums over triangles.

    ``tilted[Y, X]`` is the sum of all pixels ``(x, y)`` with ``y < Y`` and ``abs(x - X + 1) <= Y - y - 1``: a
    triangle that stands on its tip (Lienhart and Maydt 2002).

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> cv2.integral3(np.uint8([[1, 2, 4], [8, 16, 32]]))[2].tolist()
    [[0, 0, 0, 0], [0, 1, 2, 4], [1, 11, 23, 38]]
    """
    try:
        found: tuple[Array, Array, Array] = _tables(src, (sum, sqsum, tilted), sdepth, sqdepth)
    except REFUSALS as reason:
        raise refusal(reason) from None
    return found
