"""Texture coordinates for a mesh: charts cut and packed, or one patch laid flat; and how good they are.

:meth:`multum.Mesh.unwrap` makes them; here are the parts, the measures and the pictures.
"""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from . import _multum
from ._arguments import count, name, side_or_size
from ._flatten import arap, check_disk, lscm, plane_corners
from ._material import Material, TextureSlot
from ._mesh import Mesh
from ._raster import rasterize
from ._scene import Scene
from ._transfer import components, needed, sources, uv_faces
from .bake import BakeWarning, check_mesh
from .mapping import checkerboard as _checkerboard

__all__ = ["Metrics", "checkerboard", "flatten", "heat_map", "metrics", "unwrap"]

_METHODS = ("xatlas", "lscm", "arap")
# Packings that are tried: each halves how far the scale may be from the largest.
_TRIES = 8
# Share of the map that charts use at least, or else a warning.
_LEAST_USE = 0.1


@dataclass(frozen=True, eq=False)
class Metrics:
    """How far texture coordinates are from an isometry; numbers per face are (F,)."""

    area_stretch: NDArray[np.float64] = field(repr=False)
    """Area in texture space per area of the surface, 1 for the mean of the mesh: the product of the singular
    values."""
    angle_stretch: NDArray[np.float64] = field(repr=False)
    """Longest by shortest stretch, 1 where angles are kept: the ratio of the singular values."""
    texel_density: NDArray[np.float64] = field(repr=False)
    """Texels per unit of length: the root of the area in texels by the area of the surface."""
    mirrored: NDArray[np.bool_] = field(repr=False)
    """Faces that lie mirrored in texture space."""
    mean_area_stretch: float
    """Of max(s, 1 / s), weighted by the surface's area; 1 is perfect."""
    mean_angle_stretch: float
    """Weighted by the surface's area; 1 is perfect."""
    flipped_faces: int
    """Faces that lie the other way round than most of their chart."""
    overlapping_texels: int
    """Texels that several faces share."""
    degenerate_faces: int
    """Faces without an area on the surface or in texture space."""
    charts: int
    """Pieces of texture space that hang together."""
    seam_length: float
    """Length of the edges where the surface goes on and the texture does not, in the mesh's unit."""
    utilization: float
    """Share of the map's texels that some face covers."""


def unwrap(
    mesh: Mesh,
    size: SupportsIndex = 1024,
    *,
    padding: SupportsIndex | None = None,
    lowest_level: SupportsIndex = 2,
    method: str = "xatlas",
    iterations: SupportsIndex = 20,
) -> Mesh:
    """Make texture coordinates; see :meth:`multum.Mesh.unwrap`."""
    check_mesh("mesh", mesh)
    side = count("size", size, most=16384)
    level = count("lowest_level", lowest_level, least=0, most=12)
    gap = count("padding", padding, least=0, most=side // 4) if padding is not None else 2 << level
    if name("method", method) not in _METHODS:
        raise ValueError(f"method: got {method!r}, expected one of {', '.join(map(repr, _METHODS))}")
    if len(mesh.faces) == 0:
        raise ValueError("mesh: got a mesh without faces, expected at least one")
    if not (plane_corners(mesh.positions.astype(np.float64), mesh.faces.astype(np.int64))[:, 2, 1] > 0).any():
        raise ValueError("mesh: got no face with an area, expected at least one")
    if method == "xatlas":
        vertex, faces, uv = _atlas(mesh, side, gap)
    else:
        uv = flatten(mesh, method=method, iterations=iterations)
        vertex, faces = np.arange(len(uv)), mesh.faces.astype(np.int64)
        low, high = uv.min(axis=0), uv.max(axis=0)
        margin = gap / side
        scale = (1.0 - 2.0 * margin) / max(float((high - low).max()), 1e-300)
        uv = margin + (uv - low) * scale
    made = Mesh.build(mesh.positions[vertex], faces, uv=uv, normals=mesh.normals[vertex])
    source = vertex[sources(made, faces)]
    materials = [_later(material) for material in mesh.materials]
    return dataclasses.replace(
        made,
        uv_sets=[*made.uv_sets, *(old[source] for old in mesh.uv_sets)],
        colors=None if mesh.colors is None else mesh.colors[source],
        face_material=mesh.face_material,
        materials=materials,
        images=mesh.images,
    )


def _later(material: Material) -> Material:
    """The material with its slots naming uv sets one later."""

    def moved(slot: TextureSlot) -> TextureSlot:
        return dataclasses.replace(slot, uv_set=slot.uv_set + 1)

    slots: dict[str, Any] = {
        name: moved(value) for name, value in vars(material).items() if isinstance(value, TextureSlot)
    }
    layers = tuple(dataclasses.replace(layer, texture=moved(layer.texture)) for layer in material.layers)
    return dataclasses.replace(material, **slots, layers=layers)


Charts = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]


def _atlas(mesh: Mesh, side: int, gap: int) -> Charts:
    """Vertices, faces and uv of charts that are cut and packed."""
    xatlas = needed("xatlas", "xatlas", "Mesh.unwrap")
    faces = np.zeros((len(mesh.faces), 3), np.int64)
    label = np.zeros(len(mesh.faces), np.int64)
    vertices: list[NDArray[np.int64]] = []
    places: list[NDArray[np.float64]] = []
    count, charts, pending = 0, 0, [np.arange(len(mesh.faces))]
    for round in range(_TRIES):
        vertex, corners, uv = _cut(xatlas, mesh, pending)
        own = np.concatenate(pending)
        _, chart = np.unique(components(corners, len(corners)), return_inverse=True)
        faces[own], label[own] = corners + count, chart + charts
        vertices.append(vertex)
        places.append(uv)
        count, charts = count + len(vertex), charts + int(chart.max()) + 1
        if round == _TRIES - 1:
            break
        # Charts that lie on themselves are made of pieces; the others stay as they are.
        flat = uv / max(float(uv.max()), 1e-300)
        shared = _multum.uv_layout(flat, corners, (side, side), 8)[2]
        pending = [
            part
            for bad in np.unique(chart[shared])
            for part in _parts(mesh, own[chart == bad], own[shared[chart[shared] == bad]])
        ]
        if not pending:
            break
    used, faces = np.unique(faces, return_inverse=True)
    _, label = np.unique(label, return_inverse=True)
    whole = np.concatenate(vertices)[used], faces.reshape(-1, 3), np.concatenate(places)[used]
    packed = _pack(xatlas, whole, label, side, gap)
    share = 0.5 * float(np.abs(_turns(packed[2][packed[1]])).sum())
    if share < _LEAST_USE:
        warnings.warn(
            f"{label.max() + 1} charts with {gap} texels between them use {100 * share:.1f} % of a map of {side} "
            "texels a side; a larger size, or a smaller padding or lowest_level, gives them more",
            BakeWarning,
            stacklevel=4,
        )
    return packed


def _upright(xatlas: Any) -> Any:
    """How to pack without turns by a right angle: they swap the axes, which mirrors a chart."""
    options = xatlas.PackOptions()
    options.rotate_charts = False
    return options


def _cut(xatlas: Any, mesh: Mesh, pieces: list[NDArray[np.int64]]) -> Charts:
    """Charts of pieces of the mesh, in its unit, apart from each other; faces in the order of the pieces."""
    atlas = xatlas.Atlas()
    for piece in pieces:
        atlas.add_mesh(mesh.positions, mesh.faces[piece], mesh.normals)
    chart_options, options = xatlas.ChartOptions(), _upright(xatlas)
    # Without it some charts come out mirrored.
    chart_options.fix_winding = True
    options.padding = 2
    atlas.generate(chart_options=chart_options, pack_options=options)
    vertices, faces, places, count = [], [], [], 0
    for i in range(len(pieces)):
        vertex, corners, uv = atlas.get_mesh(i)
        faces.append(np.asarray(corners, np.int64).reshape(-1, 3) + count)
        vertices.append(np.asarray(vertex, np.int64))
        places.append(np.asarray(uv, np.float64) * [atlas.width, atlas.height] / atlas.texels_per_unit)
        count += len(vertex)
    return np.concatenate(vertices), np.concatenate(faces), np.concatenate(places)


def _parts(mesh: Mesh, faces: NDArray[np.int64], shared: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """The faces of a chart in two: few that lie on others, and the rest; or halves across its longest way."""
    if 4 * len(shared) < len(faces):
        return [shared, np.setdiff1d(faces, shared)]
    if len(faces) < 2:
        return [faces]
    centres = mesh.positions[mesh.faces[faces]].astype(np.float64).mean(axis=1)
    centres -= centres.mean(axis=0)
    along = centres @ np.linalg.svd(centres, full_matrices=False)[2][0]
    order = np.argsort(along, kind="stable")
    middle = len(order) // 2
    return [np.sort(faces[order[:middle]]), np.sort(faces[order[middle:]])]


def _pack(xatlas: Any, charts: Charts, label: NDArray[np.int64], side: int, gap: int) -> Charts:
    """The charts side by side, as large as they fit."""
    vertex, faces, uv = charts

    def packed(resolution: int) -> Any:
        atlas = xatlas.Atlas()
        atlas.add_uv_mesh(uv.astype(np.float32), faces.astype(np.uint32), label[:, None].astype(np.uint32))
        options = _upright(xatlas)
        # It keeps its padding free around each of two neighbours.
        options.resolution, options.padding = resolution, (gap + 1) // 2
        atlas.generate(pack_options=options)
        fits = atlas.atlas_count == 1 and 0 < max(atlas.width, atlas.height) <= side
        return atlas if fits else None

    # The resolution is a wish to xatlas, not a limit: halve the interval around the largest that fits.
    atlas, least, most = None, 1, 2 * side
    for _ in range(_TRIES):
        middle = (least + most) // 2
        found = packed(middle)
        if found is None:
            most = middle
        else:
            atlas, least = found, middle
    if atlas is None:
        raise ValueError(
            f"size: got {side} with padding {gap}, where {label.max() + 1} charts do not fit; expected a larger map"
        )
    again, corners, places = atlas.get_mesh(0)
    texels = np.asarray(places, np.float64) * [atlas.width, atlas.height] / side
    # Texture coordinates of xatlas turn as the surface does; here v runs down.
    texels[:, 1] = 1.0 - texels[:, 1]
    return vertex[np.asarray(again, np.int64)], np.asarray(corners, np.int64).reshape(-1, 3), texels


def _turns(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Twice the signed area of triangles (F, 3, 2)."""
    turns: NDArray[np.float64] = np.linalg.det(corners[:, 1:] - corners[:, :1])
    return turns


def flatten(mesh: Mesh, *, method: str = "arap", iterations: SupportsIndex = 20) -> NDArray[np.float64]:
    """Lay a disk-like patch flat, in the unit of the mesh.

    Parameters
    ----------
    mesh : Mesh
        One piece with one rim and no handle; vertices at the same place are one.
    method : str
        ``"lscm"``, which keeps angles, or ``"arap"``, which begins with it and keeps shapes.
    iterations : int
        Of ``"arap"``.

    Returns
    -------
    uv : array, shape (V, 2)
        v runs down; not in [0, 1].

    Raises
    ------
    ValueError
        When the mesh is no disk.
    ImportError
        Without SciPy, whose sparse solvers are used.

    Examples
    --------
    >>> import multum as mt, numpy as np
    >>> x, y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5))
    >>> corner = np.arange(20).reshape(4, 5)[:, :4].reshape(-1, 1)
    >>> faces = np.concatenate([corner + [0, 1, 6], corner + [0, 6, 5]])
    >>> bent = np.stack([np.sin(x), y, np.cos(x)], -1).reshape(-1, 3)
    >>> uv = mt.unwrap.flatten(mt.Mesh.build(bent, faces))
    >>> bool(abs(np.linalg.norm(uv[24] - uv[0]) - 2 ** 0.5) < 0.02)
    True
    """
    check_mesh("mesh", mesh)
    if name("method", method) not in ("lscm", "arap"):
        raise ValueError(f"method: got {method!r}, expected 'lscm' or 'arap'")
    rounds = count("iterations", iterations, least=0)
    places, welded = np.unique(mesh.positions + 0.0, axis=0, return_inverse=True)
    welded = welded.reshape(-1)
    used, faces = np.unique(welded[mesh.faces.astype(np.int64)], return_inverse=True)
    faces = faces.reshape(-1, 3)
    points = places[used].astype(np.float64)
    solid = plane_corners(points, faces)[:, 2, 1] > 0
    if not solid.all():
        raise ValueError(f"mesh: got {int((~solid).sum())} faces without an area, expected none")
    check_disk(faces)
    if components(faces, len(faces)).any():
        raise ValueError("mesh: got several pieces, expected one")
    flat = lscm(points, faces)
    if method == "arap":
        flat = arap(points, faces, flat, rounds)
    uv = np.zeros((len(places), 2))
    uv[used] = flat
    uv[:, 1] *= -1.0
    return uv[welded]


def _uv(mesh: Mesh) -> NDArray[np.float32]:
    """The texture coordinates of what must have some."""
    check_mesh("mesh", mesh)
    if mesh.uv is None:
        raise ValueError("mesh: got a mesh without uv, expected one with uv")
    return mesh.uv


def metrics(mesh: Mesh, size: SupportsIndex | Sequence[SupportsIndex] = 1024) -> Metrics:
    """Measure texture coordinates on a map of ``size`` texels.

    Sander, Snyder, Gortler, Hoppe, "Texture mapping progressive meshes", SIGGRAPH 2001: the singular values
    of the map from the surface to the texture.

    Raises
    ------
    ValueError
        When the mesh has no uv.

    Examples
    --------
    >>> import multum as mt
    >>> square = mt.Mesh.build([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]],
    ...                              uv=[[0, 1], [1, 1], [1, 0], [0, 0]])
    >>> found = mt.unwrap.metrics(square, 64)
    >>> round(found.mean_angle_stretch, 6), found.texel_density.round(6).tolist(), found.charts
    (1.0, [32.0, 32.0], 1)
    """
    uv = _uv(mesh)
    width, height = side_or_size(size)
    faces = mesh.faces.astype(np.int64)
    flat = plane_corners(mesh.positions.astype(np.float64), faces)
    texels = uv.astype(np.float64)[faces] * [width, height]
    along = np.stack([flat[:, 1], flat[:, 2]], axis=2)
    to = np.stack([texels[:, 1] - texels[:, 0], texels[:, 2] - texels[:, 0]], axis=2)
    area = 0.5 * np.linalg.det(along)
    signed = 0.5 * np.linalg.det(to)
    sound = (area > 0) & (signed != 0) & np.isfinite(signed)
    jacobian = np.zeros_like(to)
    jacobian[sound] = to[sound] @ np.linalg.inv(along[sound])
    values = np.linalg.svd(jacobian, compute_uv=False)
    product, ratio = np.full(len(faces), np.nan), np.full(len(faces), np.nan)
    product[sound] = values[sound].prod(axis=1)
    ratio[sound] = values[sound, 0] / values[sound, 1]
    whole = area[sound].sum()
    mean = np.abs(signed[sound]).sum() / whole if whole > 0 else np.nan
    stretch = product / mean
    weight = area[sound] / whole if whole > 0 else area[sound]
    # v runs down: what is not mirrored turns the other way than the surface.
    mirrored = signed > 0
    label = components(uv_faces(mesh), len(faces))
    charts, chart = np.unique(label, return_inverse=True)
    turned = np.bincount(chart, weights=np.where(mirrored, -1.0, 1.0) * area, minlength=len(charts))
    touched, overlapping, _ = _multum.uv_layout(uv, mesh.faces, (width, height), 3)
    return Metrics(
        area_stretch=stretch,
        angle_stretch=ratio,
        texel_density=np.sqrt(product),
        mirrored=mirrored & sound,
        mean_area_stretch=float((np.maximum(stretch[sound], 1.0 / stretch[sound]) * weight).sum()),
        mean_angle_stretch=float((ratio[sound] * weight).sum()),
        flipped_faces=int((sound & (mirrored == (turned[chart] > 0))).sum()),
        overlapping_texels=overlapping,
        degenerate_faces=int((~sound).sum()),
        charts=len(charts),
        seam_length=_seams(mesh),
        utilization=touched / (width * height),
    )


def _seams(mesh: Mesh) -> float:
    """Length of the edges in space with two faces or more whose uv differ along it."""
    _, place = np.unique(mesh.positions + 0.0, axis=0, return_inverse=True)
    space = place.reshape(-1)[mesh.faces.astype(np.int64)]
    texture = uv_faces(mesh)
    pairs = [(k, (k + 1) % 3) for k in range(3)]
    ends = np.concatenate([space[:, pair] for pair in pairs])
    own = np.concatenate([texture[:, pair] for pair in pairs])
    corners = np.concatenate([mesh.faces[:, pair] for pair in pairs])
    swap = ends[:, 0] > ends[:, 1]
    ends[swap], own[swap] = ends[swap, ::-1], own[swap, ::-1]
    _, first, edge, uses = np.unique(ends, axis=0, return_index=True, return_inverse=True, return_counts=True)
    edge = edge.reshape(-1)
    same = np.ones(len(first), bool)
    np.logical_and.at(same, edge, (own == own[first][edge]).all(axis=1))
    cut = first[~same & (uses > 1)]
    points = mesh.positions.astype(np.float64)[corners[cut]]
    return float(np.linalg.norm(points[:, 0] - points[:, 1], axis=1).sum())


def heat_map(
    mesh: Mesh, size: SupportsIndex | Sequence[SupportsIndex] = 512, *, measure: str = "area"
) -> NDArray[np.uint8]:
    """Draw a measure over texture space: blue for small, white for 1, red for large.

    Parameters
    ----------
    mesh : Mesh
        With uv.
    size : int or (int, int)
        Width and height of the picture.
    measure : str
        ``"area"`` (colours end at a quarter and at 4) or ``"angle"`` (white at 1, red at 4).

    Returns
    -------
    array, shape (H, W, 3), uint8
        Black where no face is.
    """
    if name("measure", measure) not in ("area", "angle"):
        raise ValueError(f"measure: got {measure!r}, expected 'area' or 'angle'")
    uv = _uv(mesh)
    found = metrics(mesh, size)
    value = found.area_stretch if measure == "area" else found.angle_stretch
    heat = np.clip(np.nan_to_num(np.log2(value)) / 2.0, -1.0, 1.0)
    colors = np.stack([1.0 + np.minimum(heat, 0.0), 1.0 - np.abs(heat), 1.0 - np.maximum(heat, 0.0)], axis=1)
    clip = np.zeros((len(uv), 4))
    clip[:, 0], clip[:, 1], clip[:, 3] = 2.0 * uv[:, 0] - 1.0, 1.0 - 2.0 * uv[:, 1], 1.0
    triangle = rasterize(clip, mesh.faces, side_or_size(size)).triangle
    picture = np.where((triangle >= 0)[..., None], np.round(255.0 * colors)[triangle], 0.0)
    return picture.astype(np.uint8)


def checkerboard(
    mesh: Mesh, size: SupportsIndex | Sequence[SupportsIndex] = 512, *, cells: SupportsIndex = 32
) -> NDArray[np.uint8]:
    """Draw the mesh with a checkerboard of ``cells`` x ``cells`` over its texture, lit from the eye.

    Even squares of one size are what a good unwrapping shows.

    Returns
    -------
    array, shape (H, W, 3), uint8
    """
    uv = _uv(mesh)
    wide = side_or_size(size)
    camera = Scene(mesh).camera("auto")
    fragments = rasterize(camera.project(mesh.positions, wide), mesh.faces, wide)
    places, jacobian = fragments.interpolate(uv, derivatives=True)
    normal = fragments.interpolate(mesh.normals)
    towards = camera.eye - fragments.interpolate(mesh.positions)
    lit = (normal * towards).sum(-1) / np.maximum(
        np.linalg.norm(normal, axis=-1) * np.linalg.norm(towards, axis=-1), 1e-30
    )
    value = _checkerboard(places, cells=count("cells", cells), jacobian=jacobian)
    shade = (0.35 + 0.65 * np.clip(lit, 0.0, 1.0)) * (0.25 + 0.7 * value.reshape(lit.shape))
    picture = np.where(fragments.triangle >= 0, shade, 1.0)
    return np.repeat(np.round(255.0 * picture).astype(np.uint8)[..., None], 3, axis=-1)
