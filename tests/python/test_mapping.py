"""Mapping functions through Python: calls, shapes, dtypes, refusals, and agreement with other libraries."""

import doctest
import importlib
from collections.abc import Callable
from pkgutil import iter_modules
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import multum as mt
from multum import mapping

RNG = np.random.default_rng(7)
POINTS = RNG.normal(size=(4, 5, 3))
COUNT = 20_000
ANY: Any = mapping
NORMALS = POINTS / np.linalg.norm(POINTS, axis=-1, keepdims=True)


def maps() -> list[mapping.Mapping]:
    made: list[mapping.Mapping] = [
        mapping.Planar(),
        mapping.Facets(),
        mapping.Cube(),
        mapping.Cube("strip"),
        mapping.Cube("stacked"),
        mapping.Spherical(),
        mapping.Spherical("y", (0.1, 0.2, 0.3)),
        mapping.Cylindrical(),
        mapping.SphereMap(),
        mapping.LightProbe(),
        mapping.MirrorBall(),
        mapping.Equirect(),
        mapping.DualParaboloid(),
        mapping.Octahedral(),
        mapping.Stereographic(200),
        mapping.Fisheye("equisolid", 300),
        mapping.Perspective(100, 1.5),
        mapping.Projective(np.eye(4)),
        mapping.Polygon([[-9, -9, 0], [9, -9, 0], [0, 9, 0]], [[0, 0], [1, 0], [0, 1]]),
    ]
    for intermediate in ("sphere", "cylinder", "plane", "cube"):
        for projection in ("centroid", "object_normal", "intermediate_normal", "reflected_ray"):
            made.append(mapping.TwoStage(intermediate, projection, eye=(0, 0, 9), radius=9, height=(-9, 9)))
    return made


@pytest.mark.parametrize("m", maps(), ids=lambda m: type(m).__name__)
def test_shapes_and_precision(m: mapping.Mapping) -> None:
    right, down = np.full(3, 0.01), np.array([0.0, 0.01, -0.02])
    uv, jacobian = m(POINTS, NORMALS, dpdx=right, dpdy=down)
    assert uv.shape == (4, 5, 2)
    assert jacobian.shape == (4, 5, 2, 2)
    assert uv.dtype == jacobian.dtype == np.float64
    assert not np.isnan(jacobian).any()
    assert np.array_equal(np.isnan(uv[..., 0]), np.isnan(uv[..., 1]))
    assert np.array_equal(m(POINTS, NORMALS), uv, equal_nan=True)
    # Any strides, one point, no points, single precision.
    turned = np.asfortranarray(POINTS)
    assert np.array_equal(m(turned, NORMALS), uv, equal_nan=True)
    assert np.array_equal(m(POINTS[1, 2], NORMALS[1, 2]), uv[1, 2], equal_nan=True)
    assert m(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0, 2)
    single, j = m(POINTS.astype(np.float32), NORMALS, dpdx=right, dpdy=down)
    assert single.dtype == j.dtype == np.float32
    there = ~np.isnan(uv)
    np.testing.assert_allclose(single[there], uv[there], rtol=1e-4, atol=1e-5)
    # A point that is not finite has no answer.
    lost, j = m([[np.nan, 0, 1], [np.inf, 1, 2]], [[1.0, 0, 0]], dpdx=right, dpdy=down)
    assert np.isnan(lost).all() or isinstance(m, mapping.Facets)
    assert not np.isnan(j).any()


@pytest.mark.parametrize("m", maps(), ids=lambda m: type(m).__name__)
def test_jacobians_are_the_maps_own_differences(m: mapping.Mapping) -> None:
    points = RNG.normal(size=(COUNT, 3))
    normals = RNG.normal(size=(COUNT, 3))
    moves = [RNG.normal(size=(COUNT, 3)) for _ in range(4)]
    dpdx, dpdy, dndx, dndy = moves
    uv, jacobian = m(points, normals, dpdx=dpdx, dpdy=dpdy, dndx=dndx, dndy=dndy)
    h = 1e-5
    for j, (dp, dn) in enumerate([(dpdx, dndx), (dpdy, dndy)]):

        def near(d: NDArray[Any]) -> NDArray[Any]:
            return np.asarray(d - np.round(d) * [1, 0])

        def step(k: float, dp: NDArray[Any] = dp, dn: NDArray[Any] = dn) -> NDArray[Any]:
            return m(points + k * h * dp, normals + k * h * dn)

        slope = (8 * near(step(1) - step(-1)) - near(step(2) - step(-2))) / (12 * h)
        bend = np.abs(near(step(1) - 2 * uv + step(-1))).max(-1) / h
        scale = np.abs(jacobian).max((-1, -2))
        # Smooth here: no border between pieces, no pole, no rim within the steps.
        smooth = (bend < 1e-3 * np.minimum(scale, 30)) & (scale < 100)
        assert smooth.mean() > 0.3 or np.isnan(uv).mean() > 0.3
        error = np.abs(slope - jacobian[..., j]).max(-1) / scale
        # Differences of 1e-16 over a step of 1e-5 leave eleven digits.
        assert np.quantile(error[smooth], 0.999) < 1e-6
        assert np.median(error[smooth]) < 1e-8


def test_closed_forms_against_scipy_rotations() -> None:
    """Spherical about y is spherical about z after the rotation that carries one axis to the other."""
    turn = Rotation.from_rotvec(np.full(3, 120 / np.sqrt(3)), degrees=True)
    assert np.allclose(turn.apply([0, 1, 0]), [0, 0, 1])
    points = POINTS.reshape(-1, 3)
    turned = turn.apply(points)
    expected = mapping.Spherical()(turned)
    got = mapping.Spherical("y")(points)
    assert np.allclose((got - expected + 0.5) % 1, 0.5)


@pytest.mark.parametrize("m", [m for m in maps() if hasattr(m, "inverse")], ids=lambda m: type(m).__name__)
def test_inverses(m: Any) -> None:
    uv = RNG.random((1000, 2)) * 0.998 + 0.001
    back = m(m.inverse(uv))
    there = ~np.isnan(back[:, 0])
    assert there.mean() > 0.3
    np.testing.assert_allclose(back[there], uv[there], atol=1e-9)
    assert np.isnan(m.inverse([np.nan, 0.5])).all()


def test_faces() -> None:
    m = mapping.Cube("faces")
    answer, jacobian = m(POINTS, dpdx=[1.0, 0, 0], dpdy=[0, 1.0, 0])
    assert answer.shape == (4, 5, 3)
    assert jacobian.shape == (4, 5, 2, 2)
    assert set(np.unique(answer[..., 0])) <= set(range(6))
    back = m.inverse(answer)
    np.testing.assert_allclose(back, NORMALS, atol=1e-14)
    strip = mapping.Cube("strip")(POINTS)
    np.testing.assert_allclose(strip[..., 0] * 6, answer[..., 0] + answer[..., 1])
    assert np.isnan(m([0.0, 0, 0])).all()
    assert np.isnan(m.inverse([6, 0.5, 0.5])).all()
    assert np.isnan(m.inverse([2.5, 0.5, 0.5])).all()


def test_maps_of_parameters() -> None:
    st = RNG.normal(size=(7, 2))
    m = mapping.Linear(2, 1, 0.1, -1, 3, 0.2)
    np.testing.assert_allclose(m.inverse()(m(st)), st)
    _, jacobian = m(st, dpdx=[1.0, 0], dpdy=[0, 1.0])
    np.testing.assert_allclose(jacobian, np.broadcast_to([[2, 1], [-1, 3]], (7, 2, 2)))
    patch = mapping.Patch(s=(0, 2), t=(1, 3), u=(0.5, 0.75), v=(1, 0))
    assert patch([[0, 1], [2, 3]]).tolist() == [[0.5, 1], [0.75, 0]]
    np.testing.assert_allclose(patch.inverse(patch(st)), st)
    with pytest.raises(ValueError, match="a e - b d"):
        mapping.Linear(1, 2, 0, 2, 4, 0).inverse()


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: mapping.Planar("w"), ValueError, "axis"),
        (lambda: mapping.Planar(bounds=((0, 0, 0), (0, 1, 1))), ValueError, "bounds"),
        (lambda: ANY.Planar(bounds=(0, 1)), ValueError, "bounds"),
        (lambda: mapping.Planar(bounds=((0, 0, 0), (np.nan, 1, 1))), ValueError, "bounds"),
        (lambda: ANY.Planar(bounds="box"), TypeError, "bounds"),
        (lambda: mapping.Facets()(POINTS), ValueError, "normals"),
        (lambda: mapping.Cube("dice"), ValueError, "layout"),
        (lambda: mapping.Spherical(center=(0, 0)), ValueError, "center"),
        (lambda: mapping.Spherical()(POINTS[..., :2]), ValueError, "points"),
        (lambda: mapping.Spherical()(3.0), ValueError, "points"),
        (lambda: mapping.Spherical()([["a", "b", "c"]]), TypeError, "points"),
        (lambda: mapping.Spherical()(POINTS.astype(complex)), TypeError, "points"),
        (lambda: ANY.Spherical()(POINTS, dpdx=POINTS), ValueError, "dpdy"),
        (lambda: mapping.Spherical()(POINTS, dpdx=POINTS[:3], dpdy=POINTS), ValueError, "dpdx"),
        (lambda: mapping.Spherical()(POINTS, dndx=POINTS), ValueError, "dndx"),
        (lambda: mapping.Cylindrical(height=(1, 1)), ValueError, "height"),
        (lambda: mapping.Linear(1, 2, 3, 4, 5, np.inf), ValueError, "coefficients"),
        (lambda: mapping.Patch(s=(1, 1)), ValueError, "s:"),
        (lambda: mapping.TwoStage("torus"), ValueError, "intermediate"),
        (lambda: mapping.TwoStage("cube", "shadow"), ValueError, "projection"),
        (lambda: mapping.TwoStage("cube", "reflected_ray"), ValueError, "eye"),
        (lambda: mapping.TwoStage(radius=0), ValueError, "radius"),
        (lambda: mapping.TwoStage("sphere", "object_normal")(POINTS), ValueError, "normals"),
        (lambda: mapping.Projective(np.eye(3)), ValueError, "matrix"),
        (lambda: mapping.Projective(np.zeros((4, 4))), ValueError, "matrix"),
        (lambda: mapping.Projective(np.eye(4), back_faces=False)(POINTS), ValueError, "normals"),
        (lambda: mapping.Fisheye("wide"), ValueError, "model"),
        (lambda: mapping.Fisheye(fov=0), ValueError, "fov"),
        (lambda: mapping.Perspective(180), ValueError, "fov"),
        (lambda: mapping.Perspective(aspect=0), ValueError, "aspect"),
        (lambda: mapping.Stereographic(360), ValueError, "fov"),
        (lambda: mapping.Polygon([[0, 0, 0], [1, 0, 0]], [[0, 0], [1, 0]]), ValueError, "corners"),
        (lambda: mapping.Torus(minor=-1), ValueError, "minor"),
        (lambda: mapping.BezierPatch(np.zeros((4, 3, 3))), ValueError, "control"),
        (lambda: mapping.barycentric([0.5, 0.5], [[0, 0], [1, 1], [2, 2]]), ValueError, "determinant 0"),
        (lambda: mt.checkerboard([0.5, 0.5], cells=0), ValueError, "cells"),
        (lambda: mt.checkerboard([0.5, 0.5], cells=(1, 2, 3)), ValueError, "cells"),
        (lambda: mt.checkerboard([0.5, 0.5], jacobian=np.eye(3)), ValueError, "jacobian"),
        (lambda: mt.checkerboard(POINTS), ValueError, "uv"),
        (lambda: mapping.distortion_picture([[1.0]], limit=1), ValueError, "limit"),
    ],
)
def test_refusals(call: Callable[[], object], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        call()


def test_checkerboard_is_the_mean_of_its_points() -> None:
    uv = RNG.random((50, 2)).astype(np.float32)
    jacobian = RNG.normal(size=(50, 2, 2)) * 0.1
    got = mt.checkerboard(uv, cells=(7, 5), jacobian=jacobian)
    assert got.shape == (50,)
    assert got.dtype == np.float32
    ticks = (np.arange(500) + 0.5) / 500 - 0.5
    xy = np.stack(np.meshgrid(ticks, ticks), -1).reshape(-1, 2)
    for p, j, value in zip(uv.astype(float), jacobian, got, strict=True):
        mean = mt.checkerboard(p + xy @ j.T, cells=(7, 5)).mean()
        assert abs(value - mean) < 4e-3
    ix, iy = np.floor(uv.astype(float) * [7, 5]).T
    assert np.array_equal(mt.checkerboard(uv, (7, 5)), ((ix + iy) % 2 == 0).astype(np.float32))


def test_barycentric_against_a_linear_solve() -> None:
    triangles = RNG.normal(size=(200, 3, 2))
    points = RNG.normal(size=(200, 2))
    weights, inside = mapping.barycentric(points, triangles)
    system = np.concatenate([triangles.transpose(0, 2, 1), np.ones((200, 1, 3))], 1)
    expected = np.linalg.solve(system, np.concatenate([points, np.ones((200, 1))], 1)[..., None])[..., 0]
    np.testing.assert_allclose(weights, expected, rtol=1e-9, atol=1e-9)
    assert inside.dtype == bool
    assert np.array_equal(inside, (expected >= 0).all(-1))
    shared = mapping.barycentric(points, triangles[0])
    assert shared.weights.shape == (200, 3)


def test_surfaces_and_distortion() -> None:
    uv = RNG.random((100, 2)) * 0.9 + 0.05
    for surface, undo in [
        (mapping.Sphere(2, (1, 2, 3)), mapping.Spherical(center=(1, 2, 3))),
        (mapping.Cylinder(2, (-1, 3), (1, 2, 3)), mapping.Cylindrical(center=(1, 2, 3), height=(-1, 3))),
    ]:
        place = surface(uv)
        back, jacobian = undo(place.point, dpdx=place.p_u, dpdy=place.p_v)
        np.testing.assert_allclose(back, uv, atol=1e-12)
        np.testing.assert_allclose(jacobian, np.broadcast_to(np.eye(2), (100, 2, 2)), atol=1e-12)
    torus = mapping.Torus(2, 0.5)(uv)
    ring = np.hypot(torus.point[:, 0], torus.point[:, 1]) - 2
    np.testing.assert_allclose(ring**2 + torus.point[:, 2] ** 2, 0.25)
    np.testing.assert_allclose((torus.normal * torus.p_u).sum(-1), 0, atol=1e-12)
    net = RNG.normal(size=(4, 4, 3))
    patch = mapping.BezierPatch(net)([[0, 0], [1, 0], [0, 1], [1, 1]])
    np.testing.assert_allclose(patch.point, [net[0, 0], net[0, 3], net[3, 0], net[3, 3]])
    np.testing.assert_allclose(patch.p_u[0], 3 * (net[0, 1] - net[0, 0]))
    # The singular values are numpy's.
    m = mapping.Equirect()
    d = mapping.distortion(m, NORMALS, NORMALS, size=(2, 1))
    flat, n = NORMALS.reshape(-1, 3), NORMALS.reshape(-1, 3)
    e1 = np.cross(n, [0.3, 0.5, 0.8])
    e1 /= np.linalg.norm(e1, axis=-1, keepdims=True)
    _, j = m(flat, dpdx=e1, dpdy=np.cross(n, e1))
    sigma = np.linalg.svd(j * np.array([[2.0], [1.0]]), compute_uv=False)
    np.testing.assert_allclose(d.sigma1.ravel(), sigma[:, 0])
    np.testing.assert_allclose(d.sigma2.ravel(), sigma[:, 1])
    np.testing.assert_allclose(d.area, d.sigma1 * d.sigma2)
    picture = mapping.distortion_picture([[1, 4, 0.25, np.nan, np.inf]])
    assert picture.shape == (1, 5, 3)
    assert picture[0, 1, 0] > picture[0, 1, 2]
    assert picture[0, 2, 0] < picture[0, 2, 2]
    assert picture[0, 3].tolist() == [128, 128, 128]
    assert np.array_equal(picture[0, 4], picture[0, 1])


def test_docstrings() -> None:
    modules = [importlib.import_module(f"multum.mapping.{m.name}") for m in iter_modules(mapping.__path__)]
    results = [doctest.testmod(module) for module in modules]
    assert sum(result.attempted for result in results) > 20
    assert not any(result.failed for result in results)
