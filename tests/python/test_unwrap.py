"""Simplifying, unwrapping, and the measures and pictures of it."""

import dataclasses
import doctest
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from test_bake import QUAD, ball, data, quad


def patch(bend: Any, n: int = 12) -> mt.Mesh:
    """A grid over [0, 1]^2, each vertex by a function of its place."""
    y, x = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).reshape(-1, 1)
    faces = np.concatenate([corner + np.array([0, 1, n + 1]), corner + np.array([0, n + 1, n])])
    return mt.Mesh.build(np.stack(bend(x, y), -1).reshape(-1, 3), faces)


def cylinder(x: NDArray[Any], y: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    return np.sin(2 * x), y, np.cos(2 * x)


def dome(x: NDArray[Any], y: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    u, v = 2 * x - 1, 2 * y - 1
    return u, v, 1 - 0.5 * (u * u + v * v)


def edges(mesh: mt.Mesh, places: NDArray[Any]) -> NDArray[np.float64]:
    corners = places[mesh.faces].astype(np.float64)
    lengths: NDArray[np.float64] = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    return lengths


def test_docstrings() -> None:
    assert doctest.testmod(mt.unwrap).failed == 0


def test_a_developable_patch_is_laid_flat_without_distortion() -> None:
    mesh = patch(cylinder)
    # The polygon of the cylinder is itself developable: all edges keep their length.
    uv = mt.unwrap.flatten(mesh, iterations=60)
    assert abs(edges(mesh, uv) / edges(mesh, mesh.positions) - 1).max() < 1e-5
    conformal = mt.unwrap.flatten(mesh, method="lscm")
    ratio = edges(mesh, conformal) / edges(mesh, mesh.positions)
    assert abs(ratio / ratio.mean() - 1).max() < 1e-6


def test_lscm_keeps_angles_and_arap_keeps_sizes_better_each_than_the_other() -> None:
    mesh = patch(dome)
    lscm = mt.unwrap.metrics(mesh.unwrap(256, method="lscm"), 256)
    arap = mt.unwrap.metrics(mesh.unwrap(256, method="arap", iterations=50), 256)
    assert lscm.mean_angle_stretch < arap.mean_angle_stretch < 1.4
    assert arap.mean_area_stretch < lscm.mean_area_stretch
    for found in (lscm, arap):
        assert (found.flipped_faces, found.overlapping_texels, found.charts) == (0, 0, 1)
        assert found.seam_length == 0.0
        assert not found.mirrored.any()


def test_what_is_no_disk_is_refused() -> None:
    with pytest.raises(ValueError, match="disk"):
        mt.unwrap.flatten(ball(6))
    two = mt.Mesh.build(
        np.concatenate([np.array(QUAD[0]), np.array(QUAD[0]) + 3]), [*QUAD[1], [4, 5, 6], [4, 6, 7]]
    )
    with pytest.raises(ValueError, match=r"disk|pieces"):
        mt.unwrap.flatten(two)
    flat = mt.Mesh.build([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
    with pytest.raises(ValueError, match="without an area"):
        mt.unwrap.flatten(flat)
    for keywords, match in (
        ({"method": "magic"}, "method"),
        ({"size": 0}, "size"),
        ({"padding": -1}, "padding"),
    ):
        with pytest.raises(ValueError, match=match):
            quad().unwrap(**keywords)


@pytest.mark.parametrize(("size", "level"), [(128, 1), (256, 2), (256, 3)])
def test_charts_stay_apart_by_the_texels_asked_for(size: int, level: int) -> None:
    mesh = ball(10, 0.05).unwrap(size, lowest_level=level)
    assert mesh.uv is not None
    assert mesh.uv.min() >= 0
    assert mesh.uv.max() <= 1
    found = mt.unwrap.metrics(mesh, size)
    assert found.overlapping_texels == 0
    assert found.flipped_faces == 0
    assert not found.mirrored.any()
    assert found.charts > 1
    assert found.seam_length > 1
    # Distances between texels of different charts, by each chart's own drawing.
    clip = np.concatenate([2 * mesh.uv[:, :1] - 1, 1 - 2 * mesh.uv[:, 1:], np.zeros_like(mesh.uv)], 1)
    clip[:, 2:] = (0, 1)
    triangle = mt.rasterize(clip, mesh.faces, (size, size)).triangle
    from multum._transfer import components, uv_faces

    label = np.where(triangle >= 0, components(uv_faces(mesh), len(mesh.faces))[triangle], -1)
    nearest = size
    for dy in range(0, 12):
        for dx in range(-11, 12):
            a, b = label[: size - dy], label[dy:]
            a, b = (a[:, : size - dx], b[:, dx:]) if dx >= 0 else (a[:, -dx:], b[:, :dx])
            if ((a >= 0) & (b >= 0) & (a != b)).any():
                nearest = min(nearest, max(abs(dx), dy))
    # Texels whose centres are drawn, with the gap between their charts from edge to edge.
    assert nearest >= min(2 << level, 11)


def test_no_face_lies_on_another_or_is_mirrored() -> None:
    # Rough and coarse: charts of such meshes fold when they are laid flat.
    meshes = [ball(40, bump).simplify(share) for bump, share in ((0.1, 0.05), (0.2, 0.1), (0.3, 0.03))]
    asteroid = data("obj/asteroid/asteroid-high.obj")
    if asteroid is not None:
        meshes += [mt.Mesh.open(asteroid).simplify(share) for share in (0.01, 0.1)]
    for mesh in meshes:
        found = mt.unwrap.metrics(mesh.unwrap(512), 512)
        assert found.overlapping_texels == 0
        assert not found.mirrored.any()
        assert found.flipped_faces == 0
        assert found.utilization > 0.25


def test_charts_without_room_are_told() -> None:
    # 64 charts of one square each, with 8 texels between them.
    squares = mt.Mesh.join(quad(float(z)) for z in range(64))
    with pytest.warns(mt.bake.BakeWarning, match=r"64 charts with 8 texels between them use \d\.\d %"):
        squares.unwrap(96)
    with pytest.raises(ValueError, match="mesh: got no face with an area"):
        mt.Mesh.build(np.zeros((3, 3)), [[0, 1, 2]]).unwrap(64)
    with pytest.raises(ValueError, match="64 charts do not fit"):
        squares.unwrap(32)


def test_unwrapping_keeps_what_a_mesh_has() -> None:
    import dataclasses

    mesh = dataclasses.replace(
        ball(6),
        uv_sets=[ball(6).positions[:, :2].copy()],
        colors=np.concatenate([ball(6).positions, np.ones_like(ball(6).positions[:, :1])], 1),
    )
    made = mesh.unwrap(128)
    assert made.colors is not None
    # Colours were the places, and the old uv two of the coordinates.
    assert (made.colors[:, :3] == made.positions).all()
    assert (made.uv_sets[1] == made.positions[:, :2]).all()
    assert (made.positions[made.faces] == mesh.positions[mesh.faces]).all()
    assert (made.normals[made.faces] == mesh.normals[mesh.faces]).all()


def test_measures_of_a_known_map() -> None:
    mesh = mt.Mesh.build(QUAD[0], QUAD[1], uv=np.array([[0, 0.5], [1, 0.5], [1, 0], [0, 0]]))
    found = mt.unwrap.metrics(mesh, (64, 128))
    # 64 texels along x, and half of 128 along y: squares stay squares.
    assert abs(found.angle_stretch - 1).max() < 1e-12
    assert abs(found.texel_density - 64).max() < 1e-9
    assert found.utilization == 0.5
    slanted = mt.unwrap.metrics(mesh, 64)
    assert abs(slanted.mean_angle_stretch - 2) < 1e-12
    mirrored = mt.Mesh.build(QUAD[0], QUAD[1], uv=[[1, 1], [0, 1], [0, 0], [1, 0]])
    assert mt.unwrap.metrics(mirrored, 8).mirrored.all()
    # Two squares that share an edge in space and not on the map.
    points = [[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0], [1, 0, 0], [2, 0, 0], [2, 2, 0], [1, 2, 0]]
    uv = np.array([[0, 1], [0.4, 1], [0.4, 0], [0, 0], [0.5, 1], [0.9, 1], [0.9, 0], [0.5, 0]])
    faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
    cut = mt.unwrap.metrics(mt.Mesh.build(points, faces, uv=uv), 32)
    assert (cut.seam_length, cut.charts) == (2.0, 2)
    # A fold: one triangle of the chart lies over the other.
    folded = mt.Mesh.build(QUAD[0], QUAD[1], uv=np.array([[0, 1], [1, 1], [1, 0], [1, 0.9]]))
    found = mt.unwrap.metrics(folded, 32)
    assert found.flipped_faces == 1
    assert found.overlapping_texels > 50


def test_pictures() -> None:
    mesh = patch(dome).unwrap(64, method="lscm")
    heat = mt.unwrap.heat_map(mesh, 64)
    assert heat.shape == (64, 64, 3)
    found = mt.unwrap.metrics(mesh, 64)
    # Red where the texture has more room than the mean, blue where it has less, black outside.
    assert (heat[..., 0].astype(int) > heat[..., 2]).any() == bool((found.area_stretch > 1.01).any())
    assert (heat[..., 2].astype(int) > heat[..., 0]).any() == bool((found.area_stretch < 0.99).any())
    assert (heat[0, 0] == 0).all()
    board = mt.unwrap.checkerboard(mesh, (96, 64))
    assert board.shape == (64, 96, 3)
    assert np.unique(board).size > 10
    for picture in (mt.unwrap.heat_map, mt.unwrap.checkerboard, mt.unwrap.metrics):
        with pytest.raises(ValueError, match="uv"):
            picture(mt.Mesh.build(*QUAD))


def test_simplifying_keeps_the_shape() -> None:
    high = ball(40)
    low = high.simplify(0.1)
    assert abs(len(low.faces) - 0.1 * len(high.faces)) <= 2
    # Places stay near the unit sphere: 632 faces of 0.02 each have edges of 0.22 and a sagitta of 0.006.
    radius = np.linalg.norm(low.positions, axis=1)
    assert abs(radius - 1).max() < 0.012
    for ratio in (0, -1, 1.5, math.nan):
        with pytest.raises(ValueError, match="ratio"):
            high.simplify(ratio)
    assert len(high.simplify(1.0).faces) == len(high.faces)


def test_no_face_of_a_simplified_mesh_lies_on_its_back() -> None:
    for bump, ratio in ((0.1, 0.1), (0.1, 0.01), (0.3, 0.1)):
        low = ball(100, bump).simplify(ratio)
        corners = low.positions[low.faces].astype(np.float64)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert ((normals * low.normals[low.faces].sum(axis=1)).sum(axis=1) > 0).all()


def test_simplifying_heals_cracks_of_rounding() -> None:
    whole = ball(20)
    # Each face has corners of its own, a ten-millionth apart.
    corners = whole.positions[whole.faces].reshape(-1, 3)
    rng = np.random.default_rng(2)
    torn = mt.Mesh.build(
        corners + rng.uniform(-1e-7, 1e-7, corners.shape), np.arange(len(corners)).reshape(-1, 3)
    )
    low = torn.simplify(0.2)
    used = np.unique(low.positions, axis=0)
    # A closed surface has half as many vertices as faces, and two.
    assert len(used) == len(low.faces) // 2 + 2


def test_simplifying_keeps_the_edges_of_charts() -> None:
    high = ball(24).unwrap(256)
    low = high.simplify(0.5)
    assert len(low.faces) < 0.75 * len(high.faces)
    assert high.uv is not None
    assert low.uv is not None
    before, after = mt.unwrap.metrics(high, 256), mt.unwrap.metrics(low, 256)
    assert after.charts == before.charts
    assert after.flipped_faces == 0
    # Vertices that stay are vertices that were there, uv and all, on both sides of cuts.
    rows = {row.tobytes() for row in np.hstack([high.positions, high.uv]) + np.float32(0)}
    assert all(row.tobytes() in rows for row in np.hstack([low.positions, low.uv]) + np.float32(0))
    # A closed surface stays closed: it has half as many vertices as faces, and two.
    assert len(np.unique(low.positions + 0.0, axis=0)) == len(low.faces) // 2 + 2
    # Chords of chords: cuts only get shorter.
    assert 0.9 * before.seam_length < after.seam_length <= before.seam_length * (1 + 1e-6)


def test_simplifying_a_mesh_with_cuts_reaches_its_number() -> None:
    high = ball(48).unwrap(256)
    low = high.simplify(0.02)
    assert len(low.faces) <= 0.03 * len(high.faces)
    assert mt.unwrap.metrics(low, 256).charts == mt.unwrap.metrics(high, 256).charts


def test_simplifying_keeps_colours_and_materials_apart() -> None:
    high = ball(24)
    upper = high.positions[high.faces].mean(axis=1)[:, 2] > 0
    painted = dataclasses.replace(
        high,
        face_material=upper.astype(np.uint32),
        materials=[mt.Material(name="lower"), mt.Material(name="upper")],
        colors=np.hstack([np.abs(high.positions), np.ones((len(high.positions), 1))]).astype(np.float32),
    )
    low = painted.simplify(0.1)
    assert [material.name for material in low.materials] == ["lower", "upper"]
    assert low.colors is not None
    assert abs(low.colors[:, :3] - np.abs(low.positions)).max() < 1e-6
    # The border of the two was on the equator, and still is: no face is on both sides of it by more than chords.
    height = low.positions[low.faces][..., 2]
    assert (height[low.face_material == 1] > -0.01).all()
    assert (height[low.face_material == 0] < 0.01).all()


def test_simplifying_hostile_meshes() -> None:
    point = mt.Mesh.build(np.zeros((3, 3)), [[0, 1, 2]])
    assert len(point.simplify(0.5).faces) == 1
    assert len(mt.Mesh.build(np.zeros((0, 3)), np.zeros((0, 3), int)).simplify(0.5).faces) == 0
    for scale in (1e-30, 1e30, 3e38):
        small = ball(12)
        scaled = dataclasses.replace(small, positions=small.positions * np.float32(scale)).simplify(0.2)
        assert len(scaled.faces) <= 0.25 * len(small.faces)
    wild = dataclasses.replace(ball(12), uv_sets=[np.full((len(ball(12).positions), 2), np.nan, np.float32)])
    assert 0 < len(wild.simplify(0.2).faces) <= 0.25 * len(wild.faces)
    heap = mt.Mesh.build(*QUAD).faces.repeat(500, axis=0)
    assert len(mt.Mesh.build(QUAD[0], heap).simplify(0.01).faces) > 0
    with pytest.raises(ValueError, match="ratio"):
        ball(4).simplify(1e-300)
    with pytest.raises(TypeError, match="ratio"):
        ball(4).simplify("half")  # type: ignore[arg-type]
