"""Barycentric coordinates."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _multum


class Barycentric(NamedTuple):
    """Weights (..., 3) of the corners A, B and C, and whether each point is inside, edges included."""

    weights: NDArray[Any]
    inside: NDArray[np.bool_]


def barycentric(points: ArrayLike, triangle: ArrayLike) -> Barycentric:
    """Barycentric coordinates in the plane, by the 2x2 inverse, right to the last digits for slivers too.

    Parameters
    ----------
    points : (..., 2)
    triangle : (3, 2), or (..., 3, 2) with one triangle a point

    Raises
    ------
    ValueError
        For a triangle without area (determinant 0) or with corners that are not finite.

    Examples
    --------
    >>> weights, inside = barycentric([0.25, 0.25], [[0, 0], [1, 0], [0, 1]])
    >>> weights.tolist(), bool(inside)
    ([0.5, 0.25, 0.25], True)
    """
    weights, inside = _multum.barycentric(np.asarray(points), np.asarray(triangle))
    return Barycentric(weights, inside != 0)
