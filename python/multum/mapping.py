"""Mapping functions: from a point of a surface, or a direction, to (u, v), with the derivative.

Every map is an object that is called with points::

    uv = m(points)                                  # points (..., 3) -> uv (..., 2)
    uv, jacobian = m(points, dpdx=dpdx, dpdy=dpdy)  # jacobian (..., 2, 2) = d(u, v) / d(x, y)

``dpdx`` and ``dpdy`` are the movement of the point for one pixel to the right and one pixel down. The
Jacobian is analytic: u's jump at a seam never shows in it. Points where a map has no answer (the centre
of a map of directions, a ray that misses, what lies behind a projector, NaN and infinite input) have uv
NaN and an infinite Jacobian; at poles and axes uv is finite and the unbounded row of the Jacobian
infinite. No Jacobian has a NaN.

Directions are seen in the frame of OpenGL's cube faces: x right, y up, z forward. v runs down.
Arithmetic is in float64; results have the precision of ``points`` (whole numbers count as float64).
"""

from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple, SupportsFloat, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum

__all__ = [
    "Barycentric",
    "BezierPatch",
    "Cube",
    "Cylinder",
    "Cylindrical",
    "Distortion",
    "DualParaboloid",
    "Equirect",
    "Facets",
    "Fisheye",
    "LightProbe",
    "Linear",
    "Mapping",
    "MirrorBall",
    "Octahedral",
    "Patch",
    "Perspective",
    "Planar",
    "Polygon",
    "Projective",
    "Sphere",
    "SphereMap",
    "Spherical",
    "Stereographic",
    "Surface",
    "SurfacePlace",
    "Torus",
    "TwoStage",
    "barycentric",
    "checkerboard",
    "distortion",
    "distortion_picture",
]

Vector = Sequence[SupportsFloat] | NDArray[Any]
Bounds = tuple[Vector, Vector] | Sequence[Vector] | NDArray[Any]


def _floats(argument: str, value: object, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Numbers of this shape; -1 stands for any count."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{argument}: got {value!r}, expected numbers of shape {shape}") from None
    if array.ndim != len(shape) or any(s not in (-1, n) for s, n in zip(shape, array.shape, strict=True)):
        raise ValueError(f"{argument}: got shape {array.shape}, expected {shape}")
    return array


def _triple(argument: str, value: object) -> tuple[float, float, float]:
    x, y, z = _floats(argument, value, (3,)).tolist()
    return x, y, z


def _pair(argument: str, value: object) -> tuple[float, float]:
    a, b = _floats(argument, value, (2,)).tolist()
    return a, b


def _number(argument: str, value: object) -> float:
    return float(_floats(argument, value, ()))


def _box(bounds: Bounds | None) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    if bounds is None:
        return (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    low, high = _floats("bounds", bounds, (2, 3))
    return _triple("bounds", low), _triple("bounds", high)


def _like(argument: str, value: ArrayLike | None, points: NDArray[Any], size: int) -> NDArray[Any] | None:
    """An array with one vector a point, repeated where it has fewer axes."""
    if value is None:
        return None
    array = np.asarray(value)
    shape = (*points.shape[:-1], size)
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise ValueError(
            f"{argument}: got shape {array.shape}, expected {shape} or one that broadcasts to it"
        ) from None


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
            _like("normals", normals, array, 3),
            _like("dpdx", dpdx, array, size),
            _like("dpdy", dpdy, array, size),
            _like("dndx", dndx, array, 3),
            _like("dndy", dndy, array, 3),
        )
        return uv if jacobian is None else (uv, jacobian)


class _Invertible(Mapping):
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


class Planar(Mapping):
    """Projection along an axis onto a bounding box: M(p) = (p_a / w, p_b / h).

    ``axis="z"`` takes (a, b) = (x, y), ``"x"`` takes (y, z) and ``"y"`` takes (z, x). ``bounds`` is the
    box as (min, max), by default the unit box; a box that is flat across the axis is refused.

    >>> Planar(bounds=((0, 0, 0), (4, 2, 1)))([1.0, 1.0, 5.0]).tolist()
    [0.25, 0.5]
    """

    def __init__(self, axis: str = "z", bounds: Bounds | None = None) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.planar(axis, *_box(bounds)))


class Facets(Mapping):
    """The planar map along X, Y or Z, by the normal's largest component (ties: X, Y, Z). Needs normals.

    >>> Facets()([0.25, 0.5, 1.0], normals=[0.0, 0.0, 1.0]).tolist()
    [0.25, 0.5]
    """

    def __init__(self, bounds: Bounds | None = None) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.facets(*_box(bounds)))


class Cube(_Invertible):
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
        super().__init__(_multum.Mapping.cube(layout, _triple("center", center)))


class Spherical(_Invertible):
    """u = phi / 2 pi in [0, 1), v = theta / pi, theta from +axis.

    For axis z, phi runs from x to y; for x from y to z; for y from z to x. On the axis u is 0 and its row
    of the Jacobian infinite where the point moves off the axis. :meth:`inverse` gives points at distance
    1 from the centre.

    >>> Spherical()([0.0, 1.0, 0.0]).tolist()
    [0.25, 0.5]
    """

    def __init__(self, axis: str = "z", center: Vector = (0, 0, 0)) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.spherical(axis, _triple("center", center)))


class Cylindrical(_Invertible):
    """u = phi / 2 pi in [0, 1), v = (p . axis - h0) / (h1 - h0), both about the centre.

    ``height=(1, 0)`` puts v = 0 at the top. :meth:`inverse` gives points at distance 1 from the axis.

    >>> Cylindrical(height=(0, 4))([0.0, -1.0, 1.0]).tolist()
    [0.75, 0.25]
    """

    def __init__(self, axis: str = "z", center: Vector = (0, 0, 0), height: Vector = (0.0, 1.0)) -> None:
        """See the class."""
        super().__init__(
            _multum.Mapping.cylindrical(axis, _triple("center", center), _pair("height", height))
        )


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
        self._coefficients = [_number(name, x) for name, x in names]
        super().__init__(_multum.Mapping.linear(*self._coefficients))

    def inverse(self) -> "Linear":
        """The map from (u, v) back to (s, t); ValueError where a e = b d."""
        return Linear(*_multum.linear_inverse(*self._coefficients))


class Patch(_Invertible):
    """One patch of a group: parameters (s, t) in their ranges onto the ranges u and v of the texture.

    :meth:`inverse` gives (s, t), shape (..., 2).

    >>> Patch(s=(0, 2), t=(0, 1), u=(0.5, 1), v=(0, 1))([1.0, 0.5]).tolist()
    [0.75, 0.5]
    """

    def __init__(
        self, s: Vector = (0, 1), t: Vector = (0, 1), u: Vector = (0, 1), v: Vector = (0, 1)
    ) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.patch(_pair("s", s), _pair("t", t), _pair("u", u), _pair("v", v)))


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
                None if eye is None else _triple("eye", eye),
                _triple("center", center),
                _number("radius", radius),
                axis,
                _pair("height", height),
                layout,
            )
        )


class _Direction(_Invertible):
    _kind: ClassVar[str]

    def __init__(self) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.direction(self._kind))


class SphereMap(_Direction):
    """OpenGL's sphere map of a reflected direction in eye space (x right, y up, +z towards the viewer).

    u = r_x/m + 1/2, v = 1/2 - r_y/m, m = 2 sqrt(r_x² + r_y² + (r_z + 1)²). At the rim, straight away from
    the viewer, the Jacobian is infinite.

    >>> SphereMap()([0.0, 0.0, 1.0]).tolist()
    [0.5, 0.5]
    """

    _kind = "sphere_map"


class LightProbe(_Direction):
    """The angular map: the angle from forward (+z) is the distance from the centre; the rim is backward.

    >>> LightProbe()([1.0, 0.0, 0.0]).tolist()
    [0.75, 0.5]
    """

    _kind = "light_probe"


class MirrorBall(_Direction):
    """The photograph of a mirror ball, the camera looking forward (+z): centre backward, rim forward.

    >>> MirrorBall()([0.0, 0.0, -1.0]).tolist()
    [0.5, 0.5]
    """

    _kind = "mirror_ball"


class Equirect(_Direction):
    """The equirectangular panorama: forward (+z) at the centre, right (+x) at u = 3/4, up (+y) at v = 0.

    >>> Equirect()([1.0, 0.0, 0.0]).tolist()
    [0.75, 0.5]
    """

    _kind = "equirect"


class DualParaboloid(_Direction):
    """Two discs side by side: forward directions on the left, backward ones on the right.

    >>> DualParaboloid()([0.0, 0.0, -1.0]).tolist()
    [0.75, 0.5]
    """

    _kind = "dual_paraboloid"


class Octahedral(_Direction):
    """The octahedron unfolded to a square: forward at the centre, backward at the four corners.

    >>> Octahedral()([1.0, 0.0, 0.0]).tolist()
    [1.0, 0.5]
    """

    _kind = "octahedral"


class Stereographic(_Invertible):
    """The stereographic picture, ``fov`` degrees wide: tan(theta/2) from the centre (forward). Keeps angles.

    >>> Stereographic(180)([1.0, 0.0, 0.0]).round(12).tolist()
    [1.0, 0.5]
    """

    def __init__(self, fov: SupportsFloat = 180.0) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.stereographic(_number("fov", fov)))


class Fisheye(_Invertible):
    """A round picture ``fov`` degrees wide: ``"equidistant"`` (angle) or ``"equisolid"`` (sin of its half).

    >>> Fisheye(fov=180)([1.0, 0.0, 1.0]).tolist()
    [0.75, 0.5]
    """

    def __init__(self, model: str = "equidistant", fov: SupportsFloat = 180.0) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.fisheye(model, _number("fov", fov)))


class Perspective(_Invertible):
    """A pinhole camera that looks forward, ``fov`` degrees across, ``aspect`` = width / height.

    >>> Perspective(90)([1.0, 0.0, 2.0]).round(12).tolist()
    [0.75, 0.5]
    """

    def __init__(self, fov: SupportsFloat = 90.0, aspect: SupportsFloat = 1.0) -> None:
        """See the class."""
        super().__init__(_multum.Mapping.perspective(_number("fov", fov), _number("aspect", aspect)))


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
        rows = _floats("matrix", matrix, (4, 4)).tolist()
        super().__init__(_multum.Mapping.projective(rows, back_faces))


class Polygon(Mapping):
    """(u, v) given by hand at the corners of a planar polygon, convex or concave; points outside have none.

    >>> Polygon([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0], [1, 0], [0, 1]])([0.25, 0.5, 0.0]).tolist()
    [0.25, 0.5]
    """

    def __init__(self, corners: ArrayLike, uv: ArrayLike) -> None:
        """See the class."""
        points = _floats("corners", corners, (-1, 3)).tolist()
        super().__init__(_multum.Mapping.polygon(points, _floats("uv", uv, (-1, 2)).tolist()))


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
        super().__init__(_multum.Surface.sphere(_number("radius", radius), _triple("center", center)))


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
                _number("radius", radius), _pair("height", height), _triple("center", center)
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
            _multum.Surface.torus(_number("major", major), _number("minor", minor), _triple("center", center))
        )


class BezierPatch(Surface):
    """A bicubic Bézier patch with a control net (4, 4, 3) whose rows run along u."""

    def __init__(self, control: ArrayLike) -> None:
        """See the class."""
        super().__init__(_multum.Surface.bezier(_floats("control", control, (4, 4, 3)).tolist()))


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
    pair = np.broadcast_to(given, 2) if given.ndim == 0 else given
    values = None if jacobian is None else np.asarray(jacobian)
    if values is not None and array.ndim > 0:
        shape = (*array.shape[:-1], 2, 2)
        if values.shape != shape and values.shape == (2, 2):
            values = np.broadcast_to(values, shape)
    return _multum.checkerboard(array, _pair("cells", pair), values)


class Distortion(NamedTuple):
    """Stretch of a map in texture units per unit of length; each array has one number a point."""

    sigma1: NDArray[Any]
    """Largest stretch."""
    sigma2: NDArray[Any]
    """Smallest stretch."""
    area: NDArray[Any]
    """sigma1 sigma2"""
    angle: NDArray[Any]
    """sigma1 / sigma2, 1 where angles are kept."""


def distortion(
    mapping: Mapping, points: ArrayLike, normals: ArrayLike, *, size: Vector = (1, 1)
) -> Distortion:
    """How a map stretches areas and angles of a surface: singular values of its differential.

    ``normals`` (..., 3) tell the tangent plane. ``size`` is the (width, height) of the texture, so that a
    panorama of 2 by 1 is judged as it is stored. Where the map has no answer all are infinite.

    >>> d = distortion(Planar(), [[0.0, 0.0, 0.0]], [[0.0, 0.6, 0.8]])
    >>> d.area.round(12).tolist(), d.angle.round(12).tolist()
    ([0.8], [1.25])
    """
    array = np.asarray(points)
    frame = _multum.tangents(np.array(_like("normals", normals, array, 3)))
    _, jacobian = mapping(array, normals, dpdx=frame[..., 0, :], dpdy=frame[..., 1, :])
    scale = _floats("size", size, (2,)).astype(jacobian.dtype)
    numbers = _multum.distortion(jacobian * scale[:, None])
    return Distortion(numbers[..., 0], numbers[..., 1], numbers[..., 2], numbers[..., 3])


def distortion_picture(values: ArrayLike, *, limit: SupportsFloat = 4.0) -> NDArray[np.uint8]:
    """A heat map of stretches (H, W) on a logarithmic scale: (H, W, 3) uint8, 1 at the middle colour.

    Values of ``limit`` and more are the warmest colour, those of 1 / ``limit`` and less the coldest; NaN
    is grey. Needs matplotlib.

    >>> distortion_picture([[1.0, 4.0]]).shape
    (1, 2, 3)
    """
    try:
        from matplotlib import colormaps
    except ImportError:
        raise ImportError("distortion_picture needs matplotlib: pip install 'multum[demo]'") from None
    top = _number("limit", limit)
    if not top > 1:
        raise ValueError(f"limit: got {top}, expected a number above 1")
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 2:
        raise ValueError(f"values: got shape {array.shape}, expected (H, W)")
    with np.errstate(divide="ignore", invalid="ignore"):
        place = np.clip(0.5 + 0.5 * np.log(array) / np.log(top), 0, 1)
    picture = np.asarray(colormaps["coolwarm"](np.nan_to_num(place)))[..., :3]
    picture = np.where(np.isnan(place)[..., None], 0.5, picture)
    return np.asarray(np.floor(picture * 255 + 0.5), dtype=np.uint8)
