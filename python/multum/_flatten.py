"""One disk-like patch laid flat with little distortion: LSCM, then ARAP."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._transfer import needed

Floats = NDArray[np.float64]


def plane_corners(points: Floats, faces: NDArray[np.int64]) -> Floats:
    """Each face in its own plane, (F, 3, 2): corner 0 at the origin, corner 1 on the x axis."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    ab, ac = b - a, c - a
    length = np.linalg.norm(ab, axis=1)
    x = np.divide((ab * ac).sum(1), length, out=np.zeros_like(length), where=length > 0)
    y = np.sqrt(np.maximum((ac * ac).sum(1) - x * x, 0.0))
    flat = np.zeros((len(faces), 3, 2))
    flat[:, 1, 0], flat[:, 2, 0], flat[:, 2, 1] = length, x, y
    return flat


def check_disk(faces: NDArray[np.int64]) -> None:
    """Refuse what cannot be laid flat: anything but one piece with one rim and no handle."""
    directed = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    edges, uses = np.unique(np.sort(directed, axis=1), axis=0, return_counts=True)
    rim = edges[uses == 1]
    euler = len(np.unique(faces)) - len(edges) + len(faces)
    twice = len(np.unique(directed, axis=0)) != len(directed)
    starts = len(np.unique(rim))
    if twice or uses.max(initial=0) > 2 or euler != 1 or len(rim) == 0 or starts != len(rim):
        raise ValueError(
            f"mesh: got a surface of Euler number {euler} with {len(rim)} edges on its rim, expected a piece "
            "that is a disk: one rim, no handle, edges with at most two faces; method='xatlas' cuts others"
        )


def lscm(points: Floats, faces: NDArray[np.int64]) -> Floats:
    """Least-squares conformal map, (V, 2), scaled to the surface's area.

    Levy, Petitjean, Ray, Maillot, "Least squares conformal maps for automatic texture atlas generation",
    SIGGRAPH 2002: of all maps of two fixed vertices the one whose triangles keep their angles best.
    """
    sparse = needed("scipy.sparse", "scipy", "unwrap.flatten")
    solver = needed("scipy.sparse.linalg", "scipy", "unwrap.flatten")
    count = len(points)
    flat = plane_corners(points, faces)
    double_area = flat[:, 1, 0] * flat[:, 2, 1]
    edge = np.roll(flat, -2, axis=1) - np.roll(flat, -1, axis=1)
    weight = edge / np.sqrt(np.maximum(double_area, 1e-300))[:, None, None]
    weight[double_area <= 0] = 0.0
    row = np.repeat(np.arange(len(faces)), 3)
    column = faces.reshape(-1)
    real = sparse.csr_matrix((weight[..., 0].reshape(-1), (row, column)), (len(faces), count))
    imaginary = sparse.csr_matrix((weight[..., 1].reshape(-1), (row, column)), (len(faces), count))
    system = sparse.bmat([[real, -imaginary], [imaginary, real]]).tocsc()
    # Two vertices far apart, found by going to the farthest twice.
    first = int(np.linalg.norm(points - points[0], axis=1).argmax())
    second = int(np.linalg.norm(points - points[first], axis=1).argmax())
    fixed = np.array([first, second, first + count, second + count])
    known = np.array([0.0, float(np.linalg.norm(points[second] - points[first])), 0.0, 0.0])
    free = np.setdiff1d(np.arange(2 * count), fixed)
    a, b = system[:, free], -(system[:, fixed] @ known)
    solved = np.zeros(2 * count)
    solved[fixed] = known
    solved[free] = solver.spsolve((a.T @ a).tocsc(), a.T @ b)
    uv = solved.reshape(2, count).T
    area = np.abs(_double_areas(uv, faces)).sum()
    return uv * np.sqrt(double_area.sum() / area) if area > 0 else uv


def arap(points: Floats, faces: NDArray[np.int64], uv: Floats, iterations: int) -> Floats:
    """Iterations that make every triangle as rigid as it can be, from a start ``uv``.

    Liu, Zhang, Xu, Gotsman, Gortler, "A local/global approach to mesh parameterization", SGP 2008: the best
    rotation of each triangle, then the vertices that fit all of them best, with the same matrix each time.
    """
    sparse = needed("scipy.sparse", "scipy", "unwrap.flatten")
    solver = needed("scipy.sparse.linalg", "scipy", "unwrap.flatten")
    count = len(points)
    flat = plane_corners(points, faces)
    double_area = np.maximum(flat[:, 1, 0] * flat[:, 2, 1], 1e-300)
    # Cotangent of the corner opposite to edge (k, k + 1).
    edges = np.roll(flat, -1, axis=1) - flat
    opposite = np.stack(
        [-(np.roll(edges, -1, axis=1)[:, k] * np.roll(edges, -2, axis=1)[:, k]).sum(1) for k in range(3)],
        axis=1,
    )
    cotangent = np.clip(opposite / double_area[:, None], -1e6, 1e6)
    i, j = faces, np.roll(faces, -1, axis=1)
    w = cotangent.reshape(-1)
    rows, columns = i.reshape(-1), j.reshape(-1)
    laplacian = sparse.coo_matrix(
        (
            np.concatenate([w, w, -w, -w]),
            (np.concatenate([rows, columns, rows, columns]), np.concatenate([rows, columns, columns, rows])),
        ),
        (count, count),
    ).tocsc()
    # One vertex stays: the rest is free to turn and move.
    factor = solver.splu(laplacian[1:, 1:])
    for _ in range(iterations):
        now = np.roll(uv[faces], -1, axis=1) - uv[faces]
        covariance = np.einsum("fk,fki,fkj->fij", cotangent, now, edges)
        u, _, vt = np.linalg.svd(covariance)
        u[np.linalg.det(u @ vt) < 0, :, 1] *= -1.0
        turned = np.einsum("fij,fkj->fki", u @ vt, edges) * cotangent[..., None]
        right = np.zeros((count, 2))
        np.add.at(right, i, -turned)
        np.add.at(right, j, turned)
        uv = np.vstack([np.zeros((1, 2)), factor.solve(right[1:])])
    return uv


def _double_areas(uv: Floats, faces: NDArray[Any]) -> Floats:
    a, b, c = (uv[faces[:, k]] for k in range(3))
    areas: Floats = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    return areas
