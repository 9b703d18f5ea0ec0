"""`multum.reference` against closed forms, NumPy supersampling, SciPy and written-out pictures."""

from __future__ import annotations

import doctest
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

import multum as mt
from multum import reference

Array = NDArray[Any]
MODES: tuple[reference.Wrap, ...] = (
    "clamp",
    "repeat",
    "mirror",
    "mirror_once",
    "mirror_101",
    "border",
    "extend",
)
KERNELS: tuple[reference.Reconstruction, ...] = ("nearest", "bilinear", "bicubic")


def noise(*shape: int, seed: int = 0) -> Array:
    return np.random.default_rng(seed).random(shape)


def written_out(image: Array, mode: str, times: int = 5) -> Array:
    """The picture with what lies outside, `times` as large on each axis; the border colour is 0.3."""
    if mode == "extend":
        reach = (times // 2) * np.array(image.shape) - 2 * (times // 2)
        return np.pad(image, [(n - 1, n - 1) for n in reach], mode="edge")
    if mode == "border":
        return np.pad(image, [(times // 2 * n,) * 2 for n in image.shape], constant_values=0.3)
    if mode == "mirror_once":
        for axis in (0, 1):
            n = image.shape[axis]
            reach = times // 2 * n
            left = np.concatenate(
                [np.repeat(np.take(image, [-1], axis), reach - n, axis), np.flip(image, axis)], axis
            )
            right = np.repeat(np.take(image, [-1], axis), reach, axis)
            image = np.concatenate([left, image, right], axis)
        return image
    names = {"clamp": "edge", "repeat": "wrap", "mirror": "symmetric", "mirror_101": "reflect"}
    pad: Callable[..., Array] = np.pad
    return pad(image, [(times // 2 * n,) * 2 for n in image.shape], mode=names[mode])


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("kernel", KERNELS)
def test_wraps_equal_the_written_out_picture(mode: reference.Wrap, kernel: reference.Reconstruction) -> None:
    image = noise(6, 8, seed=1)
    height, width = (4, 6) if mode == "extend" else image.shape
    big = written_out(image, mode)
    assert big.shape == (5 * height, 5 * width)
    random = np.random.default_rng(2)
    # Footprints of up to two pictures, centres in the middle three.
    uv = random.uniform(-0.4, 1.4, (60, 2))
    jacobian = random.uniform(-1, 1, (60, 2, 2)) * 10 ** random.uniform(-2, 0, (60, 1, 1))
    filters: tuple[reference.PixelFilter, ...] = ("point", "box", "tent")
    for pixel_filter in filters:
        if pixel_filter == "tent":
            jacobian = jacobian / 2
        small = reference.sample(
            image,
            uv,
            jacobian,
            wrap=mode,
            border=0.3,
            reconstruction=kernel,
            pixel_filter=pixel_filter,
        )
        large = reference.sample(
            big,
            (uv + 2) / 5,
            jacobian / 5,
            wrap="clamp",
            reconstruction=kernel,
            pixel_filter=pixel_filter,
        )
        np.testing.assert_allclose(small, large, rtol=0, atol=1e-12)


SCIPY = {
    "clamp": "nearest",
    "repeat": "grid-wrap",
    "mirror": "reflect",
    "mirror_101": "mirror",
    "border": "grid-constant",
}


@pytest.mark.parametrize("mode", ["clamp", "repeat", "mirror", "mirror_101", "border"])
@pytest.mark.parametrize("shape", [(5, 7), (1, 1), (1, 4), (2, 3)])
def test_points_equal_scipy(mode: reference.Wrap, shape: tuple[int, int]) -> None:
    image = noise(*shape, seed=3)
    uv = np.random.default_rng(4).uniform(-3, 4, (500, 2))
    texel = uv * shape[::-1] - 0.5
    if mode == "mirror_101" and 1 in shape:
        texel = np.where(np.array(shape[::-1]) == 1, 0.0, texel)  # SciPy's rule needs two texels
    expected = ndimage.map_coordinates(image, texel.T[::-1], order=1, mode=SCIPY[mode], cval=0.3)
    got = reference.sample(image, uv, wrap=mode, border=0.3)
    np.testing.assert_allclose(got[:, 0], expected, rtol=0, atol=1e-12)


def bilinear(image: Array, x: Array, y: Array, mode: str) -> Array:
    """Reconstruction at texel positions (centres at integers), by SciPy."""
    result: Array = ndimage.map_coordinates(image, [y, x], order=1, mode=SCIPY[mode], cval=0.3)
    return result


def grid(count: int, reach: float) -> tuple[Array, Array]:
    """Midpoints of `count` by `count` squares on [-reach, reach]²."""
    line = ((np.arange(count) + 0.5) / count * 2 - 1) * reach
    s, t = np.meshgrid(line, line)
    return s, t


WEIGHTS: dict[reference.PixelFilter, tuple[float, Callable[[Array, Array], Array]]] = {
    "box": (0.5, lambda s, t: np.ones_like(s)),
    "tent": (1.0, lambda s, t: (1 - abs(s)) * (1 - abs(t))),
    "gaussian": (2.0, lambda s, t: np.exp(-2 * (s * s + t * t))),
}


@pytest.mark.parametrize("mode", ["clamp", "repeat", "border"])
@pytest.mark.parametrize("pixel_filter", ["box", "tent", "gaussian"])
def test_dense_supersampling(mode: reference.Wrap, pixel_filter: reference.PixelFilter) -> None:
    image = noise(9, 12, seed=5)
    height, width = image.shape
    count = 400
    reach, weight = WEIGHTS[pixel_filter]
    s, t = grid(count, reach)
    w = weight(s, t)
    random = np.random.default_rng(6)
    for _ in range(8):
        j = random.uniform(-4, 4, (2, 2))
        center = random.uniform(-3, 12, 2)
        x, y = center[0] + j[0, 0] * s + j[0, 1] * t, center[1] + j[1, 0] * s + j[1, 1] * t
        expected = (bilinear(image, x, y, mode) * w).sum() / w.sum()
        size = np.array([width, height])
        got = reference.sample(
            image,
            (center + 0.5) / size,
            j / size[:, None],
            wrap=mode,
            border=0.3,
            pixel_filter=pixel_filter,
        )
        # The midpoint rule on a function whose gradient changes by at most 4 a texel on each axis.
        step = 2 * reach / count * abs(j).sum()
        assert abs(got[0] - expected) < step**2


@pytest.mark.parametrize("frequency", [0.03, 0.2, 0.45])
@pytest.mark.parametrize("box", [1, 3, 8])
def test_sinusoids_are_attenuated_as_theory_says(frequency: float, box: int) -> None:
    # Samples of cos(2 pi f x) reconstruct to the sum over k of sinc²(f + k) cos(2 pi (f + k) x), x from a
    # texel's centre, and a box of width w multiplies each term by sinc(w (f + k)).
    n = 200
    image = np.cos(2 * np.pi * frequency * np.arange(n))[None, :]
    k = frequency + np.arange(-200000, 200001)
    for offset in (0.0, 0.31):
        x = 100 + offset
        expected = np.sum(np.sinc(k) ** 2 * np.sinc(box * k) * np.cos(2 * np.pi * k * x))
        got = reference.sample(image, ((x + 0.5) / n, 0.5), [[box / n, 0], [0, 0.7]], wrap="clamp")
        assert abs(got[0] - expected) < 1e-9


def test_footprints_without_area() -> None:
    image = noise(16, 16, seed=7)
    uv = (0.43, 0.61)
    direction = np.array([3.1, -2.3]) / 16
    line = reference.sample(image, uv, np.stack([direction, 0 * direction], 1))
    # The mean along the segment, by many points.
    s = (np.arange(20000) + 0.5) / 20000 - 0.5
    points = reference.sample(image, np.array(uv) + s[:, None] * direction)
    assert abs(line[0] - points.mean()) < 1e-7
    # Columns that are parallel: the box of one after the other.
    double = reference.sample(image, uv, np.stack([direction, direction], 1))
    tent = (1 - abs(2 * s)) * 2
    points = reference.sample(image, np.array(uv) + 2 * s[:, None] * direction)
    assert abs(double[0] - (points[:, 0] * tent).mean()) < 1e-7
    # Nearly no area: continuous.
    thin = reference.sample(image, uv, np.stack([direction, direction[::-1] * [1e-9, -1e-9]], 1))
    assert abs(line[0] - thin[0]) < 1e-8
    zero = reference.sample(image, uv, np.zeros((2, 2)))
    np.testing.assert_array_equal(zero, reference.sample(image, uv))


@pytest.mark.parametrize("mode", MODES)
def test_what_is_not_finite(mode: reference.Wrap) -> None:
    image = noise(5, 6, 2, seed=8)
    nan, inf = float("nan"), float("inf")
    for uv in [(nan, 0.5), (0.5, inf), (-inf, nan)]:
        got = reference.sample(image, uv, np.eye(2), wrap=mode, border=(0.1, 0.2))
        np.testing.assert_array_equal(got, [0.1, 0.2])
    inner = image[1:-1, 1:-1] if mode == "extend" else image
    for entry in (nan, inf, -inf):
        got = reference.sample(image, (0.5, 0.5), np.diag([entry, 1]), wrap=mode)
        np.testing.assert_allclose(got, inner.mean((0, 1)), rtol=0, atol=1e-14)
    for u in (1e300, -1e300, 1.7e308, 1e15):
        assert np.isfinite(reference.sample(image, (u, -u), wrap=mode)).all()
        assert np.isfinite(reference.sample(image, (u, -u), np.eye(2), wrap=mode)).all()


def test_whole_periods_and_huge_footprints() -> None:
    image = noise(5, 8, seed=9)
    periods: dict[reference.Wrap, int] = {"repeat": 1, "mirror": 2}
    for times in (1, 2, 7, 1000):
        for mode, factor in periods.items():
            got = reference.sample(image, (0.123, 4.56), np.eye(2) * times * factor, wrap=mode)
            assert abs(got[0] - image.mean()) < 1e-12
    turned = reference.sample(image, (0.1, 0.2), np.array([[600, -800], [800, 600]]))
    assert abs(turned[0] - image.mean()) < 1e-3
    far = reference.sample(image, (1e6 + 0.3, -1e6 + 0.4), np.eye(2) * 0.2)
    near = reference.sample(image, (0.3, 0.4), np.eye(2) * 0.2)
    np.testing.assert_allclose(far, near, atol=1e-9)  # 1e6 + 0.3 is rounded by 6e-11
    # Without repetition nothing is too large: half of a plane is the left edge, half the right.
    halves = reference.sample([[0.0, 1.0]], (0.5, 0.5), np.diag([1e9, 1]), wrap="clamp")
    assert abs(halves[0] - 0.5) < 1e-9
    with pytest.raises(ValueError, match="jacobian: got a footprint"):
        reference.sample(image, (0.5, 0.5), np.eye(2) * 1e9)
    with pytest.raises(ValueError, match="jacobian: got a footprint"):
        reference.sample(image, (0.5, 0.5), np.eye(2) * 1e5, pixel_filter="tent")


def test_encodings_and_types() -> None:
    codes = np.random.default_rng(10).integers(0, 256, (6, 7, 4), dtype=np.uint8)
    value = codes / 255
    light = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    light[..., 3] = value[..., 3]
    uv = noise(20, 2, seed=11)
    jacobian = np.eye(2) * 0.3
    plain = reference.sample(light, uv, jacobian)
    np.testing.assert_allclose(reference.sample(codes, uv, jacobian, encoding="srgb"), plain, atol=1e-14)
    product = light.copy()
    product[..., :3] *= light[..., 3:]
    multiplied = reference.sample(product, uv, jacobian)
    straight = reference.sample(codes, uv, jacobian, encoding="srgb", alpha="straight")
    np.testing.assert_allclose(straight[:, 3], multiplied[:, 3], atol=1e-14)
    np.testing.assert_allclose(straight[:, :3], multiplied[:, :3] / multiplied[:, 3:], atol=1e-13)
    left = reference.sample(product, uv, jacobian, alpha="premultiplied")
    np.testing.assert_array_equal(left, multiplied)
    hidden = np.zeros((2, 2, 4))
    hidden[..., 0] = 1
    assert not reference.sample(hidden, (0.5, 0.5), jacobian, alpha="straight").any()

    normals = codes[..., :3]
    signed = np.maximum((normals.astype(float) - 128) / 127, -1)
    got = reference.sample(normals, uv, jacobian, encoding="normal")
    np.testing.assert_allclose(got, reference.sample(signed, uv, jacobian), atol=1e-14)
    got = reference.sample(signed / 2 + 0.5, uv, jacobian, encoding="normal")
    np.testing.assert_allclose(got, reference.sample(signed, uv, jacobian), atol=1e-14)

    wide = np.arange(42, dtype=np.uint16).reshape(6, 7) * 1500
    for other, scale in ((wide, 65535), (wide.astype(np.float32), 1), (codes[..., 0].astype(np.float16), 1)):
        got = reference.sample(other, uv, jacobian)
        expected = reference.sample(other.astype(float) / scale, uv, jacobian)
        np.testing.assert_allclose(got, expected, rtol=1e-14)


def project(matrix: Array, x: Array, y: Array) -> tuple[Array, Array]:
    w = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
    first = (matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]) / w
    return first, (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]) / w


def as_callable(matrix: Array) -> reference.Mapping:
    return lambda p: np.stack(project(matrix, p[:, 0], p[:, 1]), -1)


TILTED = np.array([[2.5, 0.6, -3.0], [-0.4, 3.0, 2.0], [0.01, 0.03, 1.0]])


@pytest.mark.parametrize("mode", ["clamp", "repeat", "mirror_101", "border"])
@pytest.mark.parametrize("pixel_filter", ["box", "tent", "gaussian"])
def test_perspectives_against_supersampling(
    mode: reference.Wrap, pixel_filter: reference.PixelFilter
) -> None:
    image = noise(20, 30, seed=12)
    got, error = reference.warp(
        image, TILTED, (3, 4), wrap=mode, border=0.3, pixel_filter=pixel_filter, return_error=True
    )
    assert error.max() <= 1e-6
    count = 300
    reach, weight = WEIGHTS[pixel_filter]
    s, t = grid(count, reach)
    w = weight(s, t)
    for row in range(3):
        for column in range(4):
            x, y = project(TILTED, column + s, row + t)
            expected = (bilinear(image, x, y, mode) * w).sum() / w.sum()
            step = 2 * reach / count * 8  # texels: the four derivatives sum to less than 8 here
            assert abs(got[row, column] - expected) < step**2


@pytest.mark.parametrize("kernel", KERNELS)
def test_matrices_agree_with_each_other_and_with_callables(kernel: reference.Reconstruction) -> None:
    image = noise(20, 30, 2, seed=13)
    options: dict[str, Any] = {"wrap": "repeat", "reconstruction": kernel}
    truth = reference.warp(image, TILTED, (5, 6), **options)
    for factor in (-1.0, 1e-20, 3e7):
        again = reference.warp(image, factor * TILTED, (5, 6), **options)
        np.testing.assert_allclose(again, truth, rtol=0, atol=1e-9)
    tol = 1e-4
    values, error = reference.warp(image, as_callable(TILTED), (5, 6), tol=tol, return_error=True, **options)
    assert error.max() <= tol
    assert reference.max_error(values, truth) <= tol
    flat = TILTED.copy()
    flat[2] = (0, 0, 1)
    exact = reference.warp(image, flat[:2], (5, 6), **options)
    np.testing.assert_array_equal(reference.warp(image, flat, (5, 6), **options), exact)
    np.testing.assert_allclose(reference.warp(image, flat * 2, (5, 6), **options), exact, atol=1e-13)
    values, error = reference.warp(image, as_callable(flat), (5, 6), return_error=True, **options)
    np.testing.assert_allclose(values, exact, rtol=0, atol=1e-12)
    # The same pixels one by one.
    y, x = np.mgrid[:5, :6]
    size = np.array([30, 20])
    uv = (np.stack([x, y], -1) @ flat[:2, :2].T + flat[:2, 2] + 0.5) / size
    samples = reference.sample(image, uv, flat[:2, :2] / size[:, None], **options)
    np.testing.assert_allclose(samples, exact, rtol=0, atol=1e-12)


def test_points_of_warps() -> None:
    image = noise(20, 30, seed=14)
    y, x = np.mgrid[:5, :6].astype(float)
    expected = bilinear(image, *project(TILTED, x, y), "clamp")
    for mapping in (TILTED, as_callable(TILTED)):
        got = reference.warp(image, mapping, (5, 6), wrap="clamp", pixel_filter="point")
        np.testing.assert_allclose(got, expected, rtol=0, atol=1e-12)


def test_horizons() -> None:
    # w = 0 runs through the third row; both sides of it see the texture.
    matrix = np.array([[3.0, 0, -9], [0, 0, 40], [0, 1, -2.1]])
    image = noise(16, 16, seed=15)
    s, t = grid(1000, 0.5)
    wraps: tuple[reference.Wrap, ...] = ("clamp", "border", "repeat")
    for mode in wraps:
        got, error = reference.warp(image, matrix, (5, 3), wrap=mode, border=0.3, return_error=True, tol=1e-5)
        for row in range(5):
            for column in range(3):
                expected = bilinear(image, *project(matrix, column + s, row + t), mode).mean()
                # One in a thousand sample rows may be wrong near the horizon, where the footprint explodes.
                assert abs(got[row, column] - expected) < 4e-3 + error[row, column]
        # On the horizon itself a repeated texture is known in part only, and the estimate says so.
        assert np.delete(error, 2, 0).max() <= 1e-5
        assert error[2].max() < (0.5 if mode == "repeat" else 1e-5)


def test_a_seam_is_none_and_a_hole_is_the_border() -> None:
    # An equirectangular view: the jump of the angle by a period changes nothing.
    image = noise(32, 64, seed=16)

    def view(turn: float) -> reference.Mapping:
        def mapping(p: Array) -> Array:
            x, y = (p[:, 0] - 7.5) / 8, (p[:, 1] - 3.5) / 8
            angle = np.arctan2(-x, -1.0) if turn else np.arctan2(x, 1.0)
            u = angle / (2 * np.pi) * 64 + (0 if turn else 32)
            v = np.arctan2(np.hypot(x, 1), y) / np.pi * 32
            return np.stack([u - 0.5, v - 0.5], -1)

        return mapping

    options: dict[str, Any] = {"wrap": ("repeat", "clamp"), "tol": 1e-5, "return_error": True}
    smooth, _ = reference.warp(image, view(0), (8, 16), **options)
    seam, error = reference.warp(image, view(1), (8, 16), **options)
    assert error.max() <= 1e-5
    np.testing.assert_allclose(seam, smooth, rtol=0, atol=2e-5)

    def hole(p: Array) -> Array:
        return np.where(p[:, :1] < 1.2, p, np.nan)

    values, error = reference.warp(np.ones((4, 4)), hole, border=0.25, return_error=True, tol=1e-3)
    # Pixel 1 reaches from 0.5 to 1.5, and the edge pixels fade into the border by an eighth.
    expected = 1 - 0.75 * 0.3
    assert abs(values[1, 1] - expected) <= max(error[1, 1], 1e-3)
    np.testing.assert_allclose(values[1:3, 2:], 0.25, atol=1e-12)


def test_quads() -> None:
    image = noise(11, 13, 3, seed=17)
    random = np.random.default_rng(18)
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) / 2
    uv = random.uniform(0, 1, (20, 2))
    jacobian = random.uniform(-1, 1, (20, 2, 2))
    quads = uv[:, None] + np.einsum("nij,kj->nki", jacobian, corners)
    expected = reference.sample(image, uv, jacobian)
    np.testing.assert_allclose(reference.quad(image, quads), expected, rtol=0, atol=1e-10)
    np.testing.assert_allclose(reference.quad(image, quads[:, ::-1]), expected, rtol=0, atol=1e-10)
    # A convex quad as the image of a square: dense points, weighted by the area that they stand for.
    quad = np.array([(0.1, 0.2), (0.9, 0.1), (1.3, 1.2), (0.2, 0.8)])
    s, t = (g + 0.5 for g in grid(500, 0.5))
    s, t = s[..., None], t[..., None]
    a, b, c, d = quad
    place = (1 - s) * (1 - t) * a + s * (1 - t) * b + s * t * c + (1 - s) * t * d
    ds, dt = (1 - t) * (b - a) + t * (c - d), (1 - s) * (d - a) + s * (c - b)
    weight = (ds[..., 0] * dt[..., 1] - ds[..., 1] * dt[..., 0])[..., None]
    expected = (reference.sample(image, place) * weight).sum((0, 1)) / weight.sum()
    np.testing.assert_allclose(reference.quad(image, quad), expected, rtol=0, atol=(30 / 500) ** 2)
    for bad in (quad[[0, 2, 1, 3]], quad * 0, quad * np.nan, np.array([(0, 0), (1, 0), (0.2, 0.2), (0, 1)])):
        with pytest.raises(ValueError, match="corners"):
            reference.quad(image, bad)


def test_judging() -> None:
    assert reference.rms(np.zeros(4), [1, 1, 1, 1]) == 1.0
    assert reference.max_error(np.array([250], np.uint8), np.array([255], np.uint8)) == 5.0
    with pytest.raises(ValueError, match="shape"):
        reference.rms(np.zeros(3), np.zeros((3, 1)))


@pytest.mark.parametrize(
    ("error", "arguments"),
    [
        (ValueError, {"wrap": "tile"}),
        (ValueError, {"reconstruction": "cubic"}),
        (ValueError, {"encoding": "gamma"}),
        (ValueError, {"alpha": "straight"}),
        (ValueError, {"pixel_filter": "disc"}),
        (ValueError, {"pixel_filter": "gaussian", "sigma": 0.0}),
        (ValueError, {"border": (0, 0, 0, 0)}),
        (ValueError, {"tol": 0.0}),
        (ValueError, {"mapping": np.eye(4)}),
        (ValueError, {"mapping": np.full((3, 3), np.nan)}),
        (ValueError, {"mapping": lambda p: p[:1]}),
        (ValueError, {"mapping": lambda p: p[:, :1]}),
        (ValueError, {"mapping": lambda p: "elsewhere"}),
        (ZeroDivisionError, {"mapping": lambda p: 1 // 0}),
        (ValueError, {"shape": (0, 3)}),
        (TypeError, {"image": np.zeros((3, 3), complex)}),
        (ValueError, {"image": np.zeros((0, 3))}),
        (ValueError, {"image": np.zeros((2, 2, 3)), "wrap": "extend"}),
    ],
)
def test_bad_arguments(error: type[Exception], arguments: dict[str, Any]) -> None:
    given: dict[str, Any] = {"image": np.zeros((3, 3, 3)), "mapping": np.eye(3)[:2], **arguments}
    with pytest.raises(error):
        reference.warp(**given)


def test_examples() -> None:
    assert doctest.testmod(reference).failed == 0
    assert mt.reference is reference
