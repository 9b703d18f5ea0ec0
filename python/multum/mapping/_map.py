"""What all maps share."""

from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _multum
from ._numbers import like


class Mapping:
    """What all maps share: the call, and :meth:`inverse` where the map has one."""

    _map: _multum.Mapping

    def __init__(self, compiled: _multum.Mapping) -> None:
        """Wrap a compiled map; the classes below make theirs."""
        self._map = compiled

    @overload
    def __call__(
        self,
        points: ArrayLike,
        normals: ArrayLike | None = None,
        dpdx: None = None,
        dpdy: None = None,
        *,
        dndx: ArrayLike | None = None,
        dndy: ArrayLike | None = None,
    ) -> NDArray[Any]: ...
    @overload
    def __call__(
        self,
        points: ArrayLike,
        normals: ArrayLike | None = None,
        *,
        dpdx: ArrayLike,
        dpdy: ArrayLike,
        dndx: ArrayLike | None = None,
        dndy: ArrayLike | None = None,
    ) -> tuple[NDArray[Any], NDArray[Any]]: ...
    @overload
    def __call__(
        self,
        points: ArrayLike,
        normals: ArrayLike | None,
        dpdx: ArrayLike,
        dpdy: ArrayLike,
        *,
        dndx: ArrayLike | None = None,
        dndy: ArrayLike | None = None,
    ) -> tuple[NDArray[Any], NDArray[Any]]: ...
    def __call__(
        self,
        points: ArrayLike,
        normals: ArrayLike | None = None,
        dpdx: ArrayLike | None = None,
        dpdy: ArrayLike | None = None,
        *,
        dndx: ArrayLike | None = None,
        dndy: ArrayLike | None = None,
    ) -> NDArray[Any] | tuple[NDArray[Any], NDArray[Any]]:
        """Texture coordinates of points, and their Jacobian where ``dpdx`` and ``dpdy`` are given.

        Parameters
        ----------
        points : (..., 3), or (..., 2) for maps of parameters
            float32 or float64; whole numbers become float64.
        normals : (..., 3), optional
            Of any length; needed by the maps that say so.
        dpdx, dpdy : like points, optional
            Movement of the point for one pixel right and one pixel down. Arrays with fewer axes are
            repeated.
        dndx, dndy : (..., 3), optional
            The same of the normals; without them the normal stays (a flat facet).

        Returns
        -------
        uv : (..., 2), in the precision of ``points``
        jacobian : (..., 2, 2), only with ``dpdx`` and ``dpdy``
            ``jacobian[..., i, j]`` is the derivative of (u, v)[i] by (x, y)[j].

        Raises
        ------
        ValueError, TypeError
            For arrays of the wrong shape or dtype, missing normals, and one derivative without the other.

        Examples
        --------
        >>> import multum as mt
        >>> m = mt.mapping.Spherical()
        >>> m([[0.0, 2.0, 0.0]]).tolist()
        [[0.25, 0.5]]
        >>> uv, jacobian = m([[0.0, 2.0, 0.0]], dpdx=[-12.5, 0.0, 0.0], dpdy=[0.0, 0.0, -6.25])
        >>> jacobian.round(3).tolist()
        [[[0.995, 0.0], [0.0, 0.995]]]
        """
        array = np.asarray(points)
        if (dpdx is None) != (dpdy is None):
            raise ValueError("dpdx, dpdy: got only one of them, expected both or none")
        if (dndx is None) != (dndy is None):
            raise ValueError("dndx, dndy: got only one of them, expected both or none")
        size = self._map.dimensions
        if array.ndim == 0:
            raise ValueError(f"points: got a single number, expected shape (..., {size})")
        uv, jacobian = self._map.apply(
            array,
            like("normals", normals, array, 3),
            like("dpdx", dpdx, array, size),
            like("dpdy", dpdy, array, size),
            like("dndx", dndx, array, 3),
            like("dndy", dndy, array, 3),
        )
        return uv if jacobian is None else (uv, jacobian)


class Invertible(Mapping):
    def inverse(self, uv: ArrayLike) -> NDArray[Any]:
        """Points or unit directions that the map sends to ``uv``; NaN where the picture has none.

        Parameters
        ----------
        uv : (..., 2)

        Returns
        -------
        (..., 3), in the precision of ``uv``

        Examples
        --------
        >>> import multum as mt
        >>> mt.mapping.Equirect().inverse([0.5, 0.5]).round(12).tolist()
        [0.0, 0.0, 1.0]
        """
        return self._map.inverse(np.asarray(uv))
