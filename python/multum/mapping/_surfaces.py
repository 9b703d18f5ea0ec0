"""Parametric surfaces."""

from typing import Any, NamedTuple, SupportsFloat

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _multum
from ._numbers import Vector, floats, pair, single, triple


class SurfacePlace(NamedTuple):
    """Places of a surface, each (..., 3): the point, its derivatives by u and v, the unit normal."""

    point: NDArray[Any]
    p_u: NDArray[Any]
    p_v: NDArray[Any]
    normal: NDArray[Any]


class Surface:
    """A parametric surface over (u, v) in [0, 1]²."""

    _surface: _multum.Surface

    def __init__(self, compiled: _multum.Surface) -> None:
        """Wrap a compiled surface; the classes below make theirs."""
        self._surface = compiled

    def __call__(self, uv: ArrayLike) -> SurfacePlace:
        """Places at ``uv`` (..., 2).

        >>> place = Sphere(radius=2)([0.25, 0.5])
        >>> place.point.round(12).tolist(), place.normal.round(12).tolist()
        ([0.0, 2.0, 0.0], [0.0, 1.0, 0.0])
        """
        places = self._surface.at(np.asarray(uv))
        return SurfacePlace(places[..., 0, :], places[..., 1, :], places[..., 2, :], places[..., 3, :])


class Sphere(Surface):
    """center + r (sin pi v cos 2 pi u, sin pi v sin 2 pi u, cos pi v): undone by :class:`Spherical`."""

    def __init__(self, radius: SupportsFloat = 1.0, center: Vector = (0, 0, 0)) -> None:
        """See the class."""
        super().__init__(_multum.Surface.sphere(single("radius", radius), triple("center", center)))


class Cylinder(Surface):
    """center + (r cos 2 pi u, r sin 2 pi u, h0 + v (h1 - h0)): undone by :class:`Cylindrical`."""

    def __init__(
        self,
        radius: SupportsFloat = 1.0,
        height: Vector = (0.0, 1.0),
        center: Vector = (0, 0, 0),
    ) -> None:
        """See the class."""
        super().__init__(
            _multum.Surface.cylinder(
                single("radius", radius), pair("height", height), triple("center", center)
            )
        )


class Torus(Surface):
    """A tube of radius ``minor`` around a circle of radius ``major`` in the plane z = 0."""

    def __init__(
        self,
        major: SupportsFloat = 1.0,
        minor: SupportsFloat = 0.25,
        center: Vector = (0, 0, 0),
    ) -> None:
        """See the class."""
        super().__init__(
            _multum.Surface.torus(single("major", major), single("minor", minor), triple("center", center))
        )


class BezierPatch(Surface):
    """A bicubic Bézier patch with a control net (4, 4, 3) whose rows run along u."""

    def __init__(self, control: ArrayLike) -> None:
        """See the class."""
        super().__init__(_multum.Surface.bezier(floats("control", control, (4, 4, 3)).tolist()))
