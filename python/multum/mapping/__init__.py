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

from ._barycentric import Barycentric, barycentric
from ._checkerboard import checkerboard
from ._directions import (
    DualParaboloid,
    Equirect,
    Fisheye,
    LightProbe,
    MirrorBall,
    Octahedral,
    Perspective,
    SphereMap,
    Stereographic,
)
from ._distortion import Distortion, distortion, distortion_picture
from ._map import Mapping
from ._points import (
    Cube,
    Cylindrical,
    Facets,
    Linear,
    Patch,
    Planar,
    Polygon,
    Projective,
    Spherical,
    TwoStage,
)
from ._surfaces import BezierPatch, Cylinder, Sphere, Surface, SurfacePlace, Torus

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
