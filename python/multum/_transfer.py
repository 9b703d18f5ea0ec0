"""What unwrapping needs: optional packages, and how faces hang together."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._mesh import Mesh


def needed(module: str, package: str, what: str) -> Any:
    """An optional package, or an error that tells how to get it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        text = f"{what} needs the package {package}: pip install 'multum[bake]'"
        raise ImportError(text) from None


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
