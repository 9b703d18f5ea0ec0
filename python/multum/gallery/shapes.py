"""What maps are shown on: shapes within [-1, 1]³, the z axis upwards, and what a camera sees of them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .. import mapping
from .._camera import Camera
from .._mesh import Mesh
from .._raster import Fragments, rasterize

Array = NDArray[np.float64]

EYE = (2.6, -3.2, 2.2)


@dataclass(frozen=True)
class View:
    """Points that are seen, with their normals and how both move from pixel to pixel; all (H, W, 3)."""

    inside: NDArray[np.bool_]
    point: Array
    normal: Array
    dpdx: Array
    dpdy: Array
    dndx: Array
    dndy: Array


@dataclass(frozen=True)
class Shape:
    """Triangles whose corners have their own normals: faces (F, 3) of positions (V, 3), normals (F, 3, 3)."""

    positions: Array
    faces: NDArray[np.int64]
    normals: Array

    def seen(self, size: int) -> View:
        """What the camera sees in a square picture."""
        clip = Camera(EYE, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), fov=34).project(self.positions, (size, size))
        fragments: Fragments = rasterize(clip, self.faces, (size, size), cull="back")
        point, dp = fragments.interpolate(self.positions, True)
        normal, dn = fragments.interpolate(self.normals, True)
        parts = [np.asarray(a, dtype=np.float64) for a in (point, normal)]
        moves = [np.asarray(d[..., k], dtype=np.float64) for d in (dp, dn) for k in (0, 1)]
        return View(fragments.triangle >= 0, *parts, *moves)


def _grid(place: Callable[[Array], tuple[Array, Array]], columns: int, rows: int) -> Shape:
    """A shape from points and normals at (u, v)."""
    u, v = np.meshgrid(np.arange(columns + 1) / columns, np.arange(rows + 1) / rows)
    point, normal = place(np.stack([u, v], -1))
    at = np.arange((columns + 1) * (rows + 1)).reshape(rows + 1, columns + 1)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]))
    faces = np.concatenate([np.stack([a, d, c], -1), np.stack([a, c, b], -1)])
    return _outward(point.reshape(-1, 3), faces, normal.reshape(-1, 3)[faces])


def _outward(positions: Array, faces: NDArray[np.int64], normals: Array) -> Shape:
    """Faces without area left out, the others turned so that they are counter-clockwise seen from outside."""
    corners = positions[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    side = (across * normals.mean(1)).sum(-1)
    turned = np.where((side < 0)[:, None], faces[:, ::-1], faces)
    normals = np.where((side < 0)[:, None, None], normals[:, ::-1], normals)
    there = np.linalg.norm(across, axis=-1) > 1e-12
    return Shape(positions, turned[there], normals[there])


def _surface(surface: mapping.Surface, columns: int, rows: int) -> Shape:
    def place(uv: Array) -> tuple[Array, Array]:
        at = surface(uv)
        return at.point, at.normal

    return _grid(place, columns, rows)


def _joined(parts: list[Shape]) -> Shape:
    starts = np.cumsum([0, *(len(part.positions) for part in parts[:-1])])
    return Shape(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)]),
        np.concatenate([part.normals for part in parts]),
    )


def _disc(z: float, radius: float) -> Shape:
    def place(uv: Array) -> tuple[Array, Array]:
        angle, r = 2 * np.pi * uv[..., 0], radius * uv[..., 1]
        point = np.stack([r * np.cos(angle), r * np.sin(angle), np.full_like(r, z)], -1)
        return point, np.broadcast_to([0.0, 0.0, np.sign(z)], point.shape)

    return _grid(place, 96, 8)


def _side(axis: int, sign: float, half: float) -> Shape:
    def place(uv: Array) -> tuple[Array, Array]:
        point = np.full((*uv.shape[:-1], 3), sign * half)
        point[..., (axis + 1) % 3], point[..., (axis + 2) % 3] = (half * (2 * uv[..., k] - 1) for k in (0, 1))
        normal = np.zeros(3)
        normal[axis] = sign
        return point, np.broadcast_to(normal, point.shape)

    return _grid(place, 16, 16)


def _rock() -> Shape:
    def place(uv: Array) -> tuple[Array, Array]:
        def point(uv: Array) -> Array:
            d = mapping.Sphere()(uv).point
            waves = [np.sin(k * d @ np.array(w) + k) for k, w in ((3, (1, 2, 0.5)), (5, (-1, 0.3, 1)))]
            radius = 0.8 + 0.09 * waves[0] + 0.05 * waves[1]
            return np.asarray(d * radius[..., None])

        h = 1e-4
        steps = [point(uv + s * np.array(e)) for e in ((h, 0), (0, h)) for s in (1, -1)]
        normal = np.cross(steps[2] - steps[3], steps[0] - steps[1])
        length = np.linalg.norm(normal, axis=-1, keepdims=True)
        outward = mapping.Sphere()(uv).normal
        return point(uv), np.where(length > 1e-12, normal / np.maximum(length, 1e-300), outward)

    return _grid(place, 128, 64)


def of_mesh(mesh: Mesh) -> Shape:
    """A mesh, its y axis turned upwards, centred and brought to size."""
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    positions = mesh.positions.astype(np.float64) @ turn.T
    low, high = positions.min(0), positions.max(0)
    positions = (positions - (low + high) / 2) / max(float((high - low).max()) / 2, 1e-30)
    faces = mesh.faces.astype(np.int64)
    return Shape(positions, faces, (mesh.normals.astype(np.float64) @ turn.T)[faces])


@lru_cache(maxsize=1)
def shapes() -> dict[str, Shape]:
    """The shapes by name."""
    tube = _surface(mapping.Cylinder(radius=0.75, height=(-0.9, 0.9)), 96, 16)
    return {
        "sphere": _surface(mapping.Sphere(), 96, 48),
        "cylinder": _joined([tube, _disc(0.9, 0.75), _disc(-0.9, 0.75)]),
        "cube": _joined([_side(axis, sign, 0.75) for axis in range(3) for sign in (1.0, -1.0)]),
        "torus": _surface(mapping.Torus(0.72, 0.3), 128, 48),
        "rock": _rock(),
    }
