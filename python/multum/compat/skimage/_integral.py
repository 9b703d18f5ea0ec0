"""Summed-area tables."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from ._images import IndicesError


def integral_image(image: NDArray[Any], *, dtype: DTypeLike | None = None) -> NDArray[Any]:
    """``skimage.transform.integral_image``: the sum of all elements up to each, along every axis.

    Parameters
    ----------
    image : array
    dtype : data type, optional
        Of sums and result; default: that of ``numpy.cumsum``, and at least double for floats.

    Examples
    --------
    >>> import numpy as np
    >>> integral_image(np.ones((2, 3))).tolist()
    [[1.0, 2.0, 3.0], [2.0, 4.0, 6.0]]
    """
    image = np.asarray(image)
    if dtype is None and image.real.dtype.kind == "f":
        dtype = np.promote_types(image.dtype, np.float64)
    # Narrow integers are summed in wide ones.
    sums = np.cumsum(image.ravel()[:0], dtype=None).dtype if dtype is None else np.dtype(dtype)
    table = image
    for axis in range(image.ndim):
        # The first sum makes the array, the others work in it.
        table = np.add.accumulate(table, axis=axis, dtype=sums, out=table if axis else None)
    return table


def integrate(ii: NDArray[Any], start: ArrayLike, end: ArrayLike) -> NDArray[np.float64]:
    """``skimage.transform.integrate``: sums over windows, from a summed-area table.

    Parameters
    ----------
    ii : array
        From :func:`integral_image`.
    start, end : one tuple or a list of them
        First and last index of each window, both inside; negative ones count from the end.

    Returns
    -------
    array of float64, one number a window

    Examples
    --------
    >>> import numpy as np
    >>> table = integral_image(np.ones((5, 6)))
    >>> integrate(table, [(1, 0), (3, 3)], [(1, 2), (4, 5)]).tolist()
    [3.0, 6.0]
    """
    ii = np.asarray(ii)
    given = [np.atleast_2d(np.array(corner)) for corner in (start, end)]
    if any(corner.dtype.kind not in "iu" or corner.ndim != 2 for corner in given):
        raise IndicesError(f"start, end: got {start!r} and {end!r}, expected whole numbers")
    if any(corner.shape[1] != ii.ndim for corner in given) or not ii.ndim:
        raise IndicesError(f"start, end: got {start!r} and {end!r}, expected {ii.ndim} indices each")
    first, last = (np.where(corner < 0, corner + np.array(ii.shape), corner) for corner in given)
    if (last < first).any():
        raise IndicesError(f"end: got {end!r}, expected no index below that of start, {start!r}")
    if (first < 0).any() or (last >= ii.shape).any():
        raise IndicesError(f"start, end: got {start!r} and {end!r}, expected indices of shape {ii.shape}")
    sums = np.zeros(len(first))
    for corner in np.ndindex(*(2,) * ii.ndim):
        lower = np.array(corner, bool)
        at = np.where(lower, first - 1, last)
        # Before the first index, the table is zero.
        inside = ~((at < 0) & lower).any(axis=1)
        values = ii[tuple(at[inside].T)]
        sums[inside] += (-1.0 if lower.sum() % 2 else 1.0) * values.astype(np.float64)
    return sums
