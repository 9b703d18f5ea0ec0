"""Maps of points, and of parameters."""

from typing import SupportsFloat

from numpy.typing import ArrayLike

from .. import _multum
from ._map import Invertible, Mapping
from ._numbers import Bounds, Vector, box, floats, pair, single, triple


class Planar(Mapping):
    """Projection along an axis onto a bounding box: M(p) = (p_a / w, p_b / h).

    ``axis="z"`` takes (a, b) = (x, y), ``"x"`` takes (y, z) and ``"y"`` takes (z, x). ``bounds`` is the
    box as (min, max), by default the unit box; a box that is flat across the axis is refused.

    >>> Planar(bounds=((0, 0, 0), (4, 2, 1)))([1.0, 1.0, 5.0]).tolist()
    [0.25, 0.5]
    """

    def __init__(self, axis: str = "z", bounds: Bounds | None = None) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.planar(axis, *box(bounds)))


class Facets(Mapping):
    """The planar map along X, Y or Z, by the normal's largest component (ties: X, Y, Z). Needs normals.

    >>> Facets()([0.25, 0.5, 1.0], normals=[0.0, 0.0, 1.0]).tolist()
    [0.25, 0.5]
    """

    def __init__(self, bounds: Bounds | None = None) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.facets(*box(bounds)))


class Cube(Invertible):
    """The sky box. Faces are OpenGL's, in the order +X -X +Y -Y +Z -Z, seen from inside.

    ``layout="cross"`` is one picture of 4 by 3 cells, ``"strip"`` of 6 by 1, ``"stacked"`` of 1 by 6::

             +Y
        -X   +Z   +X   -Z
             -Y

    ``"faces"`` answers with (face, u, v), shape (..., 3), and takes that in :meth:`inverse`. The Jacobian
    is always that of (u, v). Ties between faces go to X before Y before Z; the centre itself has no
    answer.

    >>> Cube("faces")([0.0, 0.0, 2.0]).tolist()
    [4.0, 0.5, 0.5]
    """

    def __init__(self, layout: str = "cross", center: Vector = (0, 0, 0)) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.cube(layout, triple("center", center)))


class Spherical(Invertible):
    """u = phi / 2 pi in [0, 1), v = theta / pi, theta from +axis.

    For axis z, phi runs from x to y; for x from y to z; for y from z to x. On the axis u is 0 and its row
    of the Jacobian infinite where the point moves off the axis. :meth:`inverse` gives points at distance
    1 from the centre.

    >>> Spherical()([0.0, 1.0, 0.0]).tolist()
    [0.25, 0.5]
    """

    def __init__(self, axis: str = "z", center: Vector = (0, 0, 0)) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.spherical(axis, triple("center", center)))


class Cylindrical(Invertible):
    """u = phi / 2 pi in [0, 1), v = (p . axis - h0) / (h1 - h0), both about the centre.

    ``height=(1, 0)`` puts v = 0 at the top. :meth:`inverse` gives points at distance 1 from the axis.

    >>> Cylindrical(height=(0, 4))([0.0, -1.0, 1.0]).tolist()
    [0.75, 0.25]
    """

    def __init__(self, axis: str = "z", center: Vector = (0, 0, 0), height: Vector = (0.0, 1.0)) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.cylindrical(axis, triple("center", center), pair("height", height)))


class Linear(Mapping):
    """(s, t) -> (a s + b t + c, d s + e t + f), for points (..., 2).

    >>> Linear(2, 0, 0.1, 0, 4, 0.2).inverse()([2.1, 4.2]).round(12).tolist()
    [1.0, 1.0]
    """

    def __init__(
        self,
        a: SupportsFloat,
        b: SupportsFloat,
        c: SupportsFloat,
        d: SupportsFloat,
        e: SupportsFloat,
        f: SupportsFloat,
    ) -> None:
        """See the class."""
        names = zip("abcdef", (a, b, c, d, e, f), strict=True)
        self._coefficients = [single(name, x) for name, x in names]
        super().__init__(_multum.Mapping.linear(*self._coefficients))

    def inverse(self) -> "Linear":
        """The map from (u, v) back to (s, t); ValueError where a e = b d."""
        return Linear(*_multum.linear_inverse(*self._coefficients))


class Patch(Invertible):
    """One patch of a group: parameters (s, t) in their ranges onto the ranges u and v of the texture.

    :meth:`inverse` gives (s, t), shape (..., 2).

    >>> Patch(s=(0, 2), t=(0, 1), u=(0.5, 1), v=(0, 1))([1.0, 0.5]).tolist()
    [0.75, 0.5]
    """

    def __init__(
        self, s: Vector = (0, 1), t: Vector = (0, 1), u: Vector = (0, 1), v: Vector = (0, 1)
    ) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.patch(pair("s", s), pair("t", t), pair("u", u), pair("v", v)))


class TwoStage(Mapping):
    """A texture wrapped around a simple surface (S stage) and carried to the object (O stage).

    ``intermediate``: a ``"sphere"`` of ``radius`` about ``center``; a ``"cylinder"`` of that radius about
    ``axis``, an open, endless tube with v over ``height``; a ``"plane"`` across the axis at distance
    ``radius``, with [0, 1]² over twice the radius; a ``"cube"`` with sides of twice the radius along x, y
    and z, in its ``layout``.

    ``projection``: ``"centroid"`` (from the centre through the point), ``"object_normal"`` (from the
    point along its normal), ``"intermediate_normal"`` (to the foot of the perpendicular) or
    ``"reflected_ray"`` (the view ray from ``eye``, mirrored by the normal). Rays that miss have uv NaN.
    ``object_normal`` and ``reflected_ray`` need normals.

    >>> TwoStage("sphere", "object_normal")([0.0, 0.0, 0.0], normals=[0.0, 1.0, 0.0]).tolist()
    [0.25, 0.5]
    """

    def __init__(
        self,
        intermediate: str = "sphere",
        projection: str = "centroid",
        eye: Vector | None = None,
        *,
        center: Vector = (0, 0, 0),
        radius: SupportsFloat = 1.0,
        axis: str = "z",
        height: Vector = (-1.0, 1.0),
        layout: str = "cross",
    ) -> None:
        """See the class."""
        super().__init__(
            _multum.Mapping.two_stage(
                intermediate,
                projection,
                None if eye is None else triple("eye", eye),
                triple("center", center),
                single("radius", radius),
                axis,
                pair("height", height),
                layout,
            )
        )


class Projective(Mapping):
    """(s, t, r, q) = matrix @ (p, 1), uv = (s/q, t/q): a decal, a slide projector, a shadow map.

    The matrix ends in texture space. Points with q <= 0 are behind the projector: uv NaN.
    ``back_faces=False`` leaves out faces turned away from the projector too and needs normals; parallel
    light shines along increasing r.

    >>> import numpy as np
    >>> Projective(np.eye(4))([0.25, 0.5, 7.0]).tolist()
    [0.25, 0.5]
    """

    def __init__(self, matrix: ArrayLike, *, back_faces: bool = True) -> None:
        """See the class."""
        rows = floats("matrix", matrix, (4, 4)).tolist()
        super().__init__(_multum.Mapping.projective(rows, back_faces))


class Polygon(Mapping):
    """(u, v) given by hand at the corners of a planar polygon, convex or concave; points outside have none.

    >>> Polygon([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0], [1, 0], [0, 1]])([0.25, 0.5, 0.0]).tolist()
    [0.25, 0.5]
    """

    def __init__(self, corners: ArrayLike, uv: ArrayLike) -> None:
        """See the class."""
        points = floats("corners", corners, (-1, 3)).tolist()
        super().__init__(_multum.Mapping.polygon(points, floats("uv", uv, (-1, 2)).tolist()))
