"""What meshes made from a mesh keep of it."""

from __future__ import annotations

import dataclasses
import importlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _multum
from ._mesh import Mesh


def needed(module: str, package: str, what: str) -> Any:
    """An optional package, or an error that tells how to get it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        text = f"{what} needs the package {package}: pip install 'multum[bake]'"
        raise ImportError(text) from None


def closest(
    mesh: Mesh, points: NDArray[Any]
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
    """Face, distance and corner weights of the point of the mesh closest to each point."""
    return _multum.closest_points(mesh.positions, mesh.faces, points)


def carried(mesh: Mesh, points: NDArray[np.float32], faces: NDArray[np.int64]) -> Mesh:
    """A mesh of new points and faces with the materials, uv and colours that a mesh has closest to them.

    Pieces of the new mesh that hang together are on one chart of the old one: the chart closest to most of
    their faces. So a vertex on a cut finds the uv of its own side.
    """
    near = closest(mesh, points[faces].mean(axis=1))[0]
    uv = None if mesh.uv is None else np.zeros((len(points), 2), np.float32)
    colors = None if mesh.colors is None else np.zeros((len(points), 4), np.float32)
    charts = components(uv_faces(mesh), mesh.faces.shape[0])
    pieces = components(faces, len(faces))
    chart_of_piece = np.zeros(len(faces), np.int64)
    for piece in np.unique(pieces):
        chart_of_piece[piece] = np.bincount(charts[near[pieces == piece]]).argmax()
    chart_of_face = chart_of_piece[pieces]
    for chart in np.unique(chart_of_face):
        old = np.flatnonzero(charts == chart)
        new = np.unique(faces[chart_of_face == chart])
        part = dataclasses.replace(mesh, faces=mesh.faces[old], face_material=mesh.face_material[old])
        at, _, weights = closest(part, points[new])
        for target, values in ((uv, mesh.uv), (colors, mesh.colors)):
            if target is not None and values is not None:
                target[new] = np.einsum("vc,vck->vk", weights, values[part.faces[at]])
    made = Mesh.build(points, faces, uv=uv)
    source = sources(made, faces)
    return dataclasses.replace(
        made,
        colors=None if colors is None else colors[source],
        face_material=mesh.face_material[near],
        materials=mesh.materials,
        images=mesh.images,
    )


def sources(made: Mesh, faces: NDArray[Any]) -> NDArray[np.int64]:
    """For each vertex of a mesh made from arrays the vertex of the arrays: faces keep their order."""
    source = np.zeros(len(made.positions), np.int64)
    source[made.faces.reshape(-1)] = np.asarray(faces, np.int64).reshape(-1)
    return source


def uv_faces(mesh: Mesh) -> NDArray[np.int64]:
    """Faces over vertices that are one where place and (if there is) uv are."""
    keys = mesh.positions if mesh.uv is None else np.concatenate([mesh.positions, mesh.uv], axis=1)
    # Adding 0 makes one zero of the two.
    _, welded = np.unique(keys + 0.0, axis=0, return_inverse=True)
    faces: NDArray[np.int64] = welded.reshape(-1).astype(np.int64)[mesh.faces.astype(np.int64)]
    return faces


def components(faces: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """For each face the lowest index of the faces that hang together with it by vertices."""
    label = np.arange(count)
    vertex = np.full(int(faces.max(initial=-1)) + 1, count)
    while True:
        np.minimum.at(vertex, faces, label[:, None])
        lower = vertex[faces].min(axis=1)
        # A face takes the label of its label too: long strips then need few rounds.
        lower = np.minimum(lower, lower[lower])
        if (lower == label).all():
            return label
        label = lower
