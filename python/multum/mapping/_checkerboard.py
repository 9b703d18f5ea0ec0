"""The checkerboard that shows a mapping."""

from typing import Any, SupportsFloat

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _multum
from ._numbers import Vector, pair


def checkerboard(
    uv: ArrayLike, cells: SupportsFloat | Vector = 10, jacobian: ArrayLike | None = None
) -> NDArray[Any]:
    """The checkerboard that shows a mapping: 1 where floor(cells u) + floor(cells v) is even, else 0.

    Parameters
    ----------
    uv : (..., 2)
    cells : number or pair
        Cells along u and v for one unit.
    jacobian : (..., 2, 2), optional
        d(u, v) / d(x, y): the result is then the exact mean over each pixel's parallelogram. Footprints
        that are infinite or span more than 65536 cells are 0.5.

    Returns
    -------
    (...), in the precision of ``uv``; NaN where uv is not finite

    Examples
    --------
    >>> checkerboard([[0.05, 0.05], [0.15, 0.05]]).tolist()
    [1.0, 0.0]
    >>> checkerboard([0.1, 0.05], jacobian=[[0.02, 0.0], [0.0, 0.02]]).round(12).tolist()
    0.5
    """
    array = np.asarray(uv)
    given = np.asarray(cells)
    both = np.broadcast_to(given, 2) if given.ndim == 0 else given
    values = None if jacobian is None else np.asarray(jacobian)
    if values is not None and array.ndim > 0:
        shape = (*array.shape[:-1], 2, 2)
        if values.shape != shape and values.shape == (2, 2):
            values = np.broadcast_to(values, shape)
    return _multum.checkerboard(array, pair("cells", both.tolist()), values)
