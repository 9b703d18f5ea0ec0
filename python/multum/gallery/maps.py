"""The maps that are shown, brought to shapes within [-1, 1]³ whose z axis points upwards."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .. import mapping
from .shapes import EYE, View

Array = NDArray[np.float64]
Answer = tuple[Array, Array]
Applied = Callable[[View], Answer]
Vector = tuple[float, float, float]

_BOX = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
#: From the shapes' frame (z up) to that of directions (x right, y up, z forward), forward away from the eye.
_FORWARD = -np.array(EYE) / np.linalg.norm(EYE)
_RIGHT = np.cross(_FORWARD, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(_FORWARD, [0.0, 0.0, 1.0]))
_FRAME = np.stack([_RIGHT, np.cross(_RIGHT, _FORWARD), _FORWARD])
#: The same with forward towards the eye, for maps that do not see all directions.
_FACING = np.array([[-1.0], [1.0], [-1.0]]) * _FRAME


@dataclass(frozen=True)
class Shown:
    """One figure: a map, or several of one kind, and what there is to see."""

    title: str
    text: str
    maps: dict[str, Applied] = field(default_factory=dict)


def of_points(m: mapping.Mapping) -> Applied:
    """A map of points (and normals, where it reads them)."""

    def apply(view: View) -> Answer:
        return m(view.point, view.normal, view.dpdx, view.dpdy, dndx=view.dndx, dndy=view.dndy)

    return apply


def of_directions(m: mapping.Mapping, frame: Array = _FRAME) -> Applied:
    """A map of directions: the point as seen from the middle of the shape."""

    def apply(view: View) -> Answer:
        point, dpdx, dpdy = (a @ frame.T for a in (view.point, view.dpdx, view.dpdy))
        uv, jacobian = m(point, dpdx=dpdx, dpdy=dpdy)
        return uv, jacobian

    return apply


def after(first: Applied, second: mapping.Mapping) -> Applied:
    """A map of parameters after a map of points."""

    def apply(view: View) -> Answer:
        uv, jacobian = first(view)
        mapped, slope = second(uv, dpdx=jacobian[..., 0], dpdy=jacobian[..., 1])
        return mapped, slope

    return apply


def _two_stage(intermediate: str, projection: str) -> Applied:
    height = (-1.5, 1.5)
    return of_points(mapping.TwoStage(intermediate, projection, eye=EYE, radius=1.5, height=height))


def projector_matrix(place: Vector, target: Vector) -> Array:
    """From points to the picture of a projector at ``place`` that shines at ``target``, z upwards."""
    at = np.array(place)
    forward = np.array(target) - at
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    rows = np.zeros((4, 4))
    for k, axis in enumerate((right, down)):
        rows[k, :3] = 1.8 * axis + 0.5 * forward
    rows[2, :3] = rows[3, :3] = forward
    rows[:, 3] = -rows[:, :3] @ at
    return rows


_PROJECTIONS = ("centroid", "object_normal", "intermediate_normal", "reflected_ray")
_slides = projector_matrix((2.0, -1.0, 2.5), (0.0, 0.0, 0.0))
_planar = of_points(mapping.Planar("y", _BOX))
_spherical = of_points(mapping.Spherical())

MAPS: dict[str, Shown] = {
    "planar": Shown(
        "Planar",
        "(z, x) over the bounding box: stretched without bound where the plane is seen edge on.",
        {"": _planar},
    ),
    "facets": Shown(
        "Facets",
        "X, Y or Z plane by the normal's largest component: never stretched by more than √3, with seams.",
        {"": of_points(mapping.Facets(_BOX))},
    ),
    "cube": Shown(
        "Cube",
        "A sky box around the centroid, its six faces in a cross.",
        {"": of_directions(mapping.Cube("cross"))},
    ),
    "spherical": Shown(
        "Spherical",
        "Longitude and colatitude: cells crowd at the poles; the seam shows in no footprint.",
        {"": _spherical},
    ),
    "cylindrical": Shown(
        "Cylindrical",
        "Longitude and height: keeps areas on a cylinder, is singular on the axis.",
        {"": of_points(mapping.Cylindrical(height=(-1.0, 1.0)))},
    ),
    "linear": Shown(
        "Linear",
        "u = a s + b t + c, v = d s + e t + f after the planar map.",
        {"": after(_planar, mapping.Linear(1, 0.5, 0, -0.5, 1, 0.25))},
    ),
    "patch": Shown(
        "Patch",
        "A piece of the spherical map's parameters onto the whole texture.",
        {"": after(_spherical, mapping.Patch(s=(0.5, 1.0), t=(0.0, 0.5)))},
    ),
    "projective": Shown(
        "Projective",
        "A slide projector: back faces and what lies behind it have no answer.",
        {"": of_points(mapping.Projective(_slides, back_faces=False))},
    ),
    "polygon": Shown(
        "Polygon",
        "Coordinates given by hand at the corners of a concave polygon in the plane z = 0; other points have no "
        "answer.",
        {
            "": of_points(
                mapping.Polygon(
                    np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [0, 0.2, 0], [-1, 1, 0]]),
                    np.array([[0, 1], [1, 1], [1, 0], [0.5, 0.4], [0, 0]]),
                )
            )
        },
    ),
    **{
        f"two_stage_{intermediate}": Shown(
            f"Two stages by a {intermediate}",
            "From the intermediate surface by the object's centroid, its normal, the intermediate's normal, and "
            "the reflected view ray. Rays that miss have no answer.",
            {
                projection.replace("_", " "): _two_stage(intermediate, projection)
                for projection in _PROJECTIONS
            },
        )
        for intermediate in ("sphere", "cylinder", "plane", "cube")
    },
    **{
        name: Shown(title, text, {"": of_directions(m)})
        for name, title, text, m in (
            (
                "sphere_map",
                "Sphere map",
                "OpenGL's: singular in one direction, at the rim.",
                mapping.SphereMap(),
            ),
            ("light_probe", "Light probe", "The angular map: singular straight back.", mapping.LightProbe()),
            (
                "mirror_ball",
                "Mirror ball",
                "The photograph of a chrome ball: singular straight forward.",
                mapping.MirrorBall(),
            ),
            (
                "equirect",
                "Equirectangular",
                "The panorama's longitude and latitude, forward in the middle.",
                mapping.Equirect(),
            ),
            (
                "dual_paraboloid",
                "Dual paraboloid",
                "Two discs, one for each half of the directions.",
                mapping.DualParaboloid(),
            ),
            (
                "octahedral",
                "Octahedral",
                "The octahedron unfolded: finite everywhere, folded along eight edges.",
                mapping.Octahedral(),
            ),
        )
    },
    **{
        name: Shown(title, text, {"": of_directions(m, _FACING)})
        for name, title, text, m in (
            (
                "stereographic",
                "Stereographic",
                "Keeps angles, forward towards the eye: the heat map of angles is flat on the sphere.",
                mapping.Stereographic(300),
            ),
            (
                "fisheye",
                "Fisheye",
                "Equal solid angles, equal areas; 120 degrees around the eye's direction, nothing past them.",
                mapping.Fisheye("equisolid", 120),
            ),
            (
                "perspective",
                "Perspective",
                "A pinhole camera in the middle of the shape that looks at the eye, 100 degrees across: past its "
                "picture coordinates leave [0, 1], behind it there are none.",
                mapping.Perspective(100),
            ),
        )
    },
}
