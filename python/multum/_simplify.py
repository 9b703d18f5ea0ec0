"""Fewer triangles for the same shape, through fast-simplification (quadric error metrics)."""

from __future__ import annotations

from typing import SupportsFloat

import numpy as np
from numpy.typing import NDArray

from ._arguments import number
from ._mesh import Mesh
from ._transfer import carried, needed, uv_faces


def simplify(mesh: Mesh, ratio: SupportsFloat) -> Mesh:
    """Leave about ``ratio`` of the faces; see :meth:`Mesh.simplify`."""
    share = number("ratio", ratio)
    if not 0.0 < share <= 1.0:
        raise ValueError(f"ratio: got {share}, expected a number above 0 and at most 1")
    package = needed("fast_simplification", "fast-simplification", "Mesh.simplify")
    # With uv, vertices are shared where the uv is too: a cut of the texture is then an edge of the surface,
    # which is kept. Without, only the place counts, to a millionth of the mesh: cracks would tear it open.
    if mesh.uv is None:
        welded = _near(mesh.positions.astype(np.float64))[mesh.faces.astype(np.int64)]
    else:
        welded = uv_faces(mesh)
    faces = welded[(welded != np.roll(welded, 1, axis=1)).all(axis=1)]
    places = np.zeros((int(welded.max(initial=-1)) + 1, 3))
    places[welded] = mesh.positions[mesh.faces]
    target = max(1, round(share * len(mesh.faces)))
    if target >= len(faces):
        return mesh
    points, kept = package.simplify(
        places, faces.astype(np.int32), target_count=target, preserve_border=mesh.uv is not None
    )
    points, kept = _tidy(np.asarray(points, np.float32), np.asarray(kept, np.int64))
    if len(kept) == 0:
        raise ValueError(f"ratio: got {share}, which leaves no face; expected more")
    return carried(mesh, points, kept)


def _near(places: NDArray[np.float64]) -> NDArray[np.int64]:
    """The same number for vertices that differ by rounding: along each axis, values without a gap are one."""
    extent = float(np.ptp(places, axis=0).max(initial=0.0))
    # In large meshes unlike values come close to each other by chance: a twentieth of their mean distance.
    gap = extent * min(1e-6, 0.05 / max(len(places), 1))
    groups = np.zeros(places.shape, np.int64)
    for axis in range(3):
        order = np.argsort(places[:, axis], kind="stable")
        groups[order[1:], axis] = np.cumsum(np.diff(places[order, axis]) > gap)
    _, numbers = np.unique(groups, axis=0, return_inverse=True)
    return numbers.reshape(-1).astype(np.int64)


def _tidy(
    points: NDArray[np.float32], faces: NDArray[np.int64]
) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Only faces with three corners, and the vertices that they use."""
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    used, again = np.unique(faces, return_inverse=True)
    return points[used], again.reshape(-1, 3)
