"""Warps against OpenCV, scikit-image, brute force, and against each other."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import skimage.transform
from numpy.typing import NDArray

import multum as mt
from reference_numpy import Brute

Array = NDArray[Any]
DATA = Path(os.environ.get("MULTUM_DATA", Path(__file__).parents[2] / ".." / "shared" / "data"))
BORDERS = {
    "border": cv2.BORDER_CONSTANT,
    "clamp": cv2.BORDER_REPLICATE,
    "repeat": cv2.BORDER_WRAP,
    "mirror": cv2.BORDER_REFLECT,
    "mirror_101": cv2.BORDER_REFLECT_101,
}
DTYPES = ["uint8", "uint16", "float16", "float32", "float64"]


def generated() -> dict[str, Array]:
    rng = np.random.default_rng(0)
    y, x = np.mgrid[:90, :140]
    waves = np.stack([np.sin(x / 5 + y / 9), np.cos(x * y / 400), np.sin(y / 3)], -1)
    return {
        "noise": rng.integers(0, 256, (61, 83, 3), np.uint8),
        "waves": np.round(127 * (waves + 1)).astype(np.uint8),
        "grey": rng.integers(0, 256, (40, 33), np.uint8),
    }


def pictures() -> dict[str, Array]:
    """Generated images always, photographs where the data set is there."""
    found = generated()
    for name in ("astronaut.png", "coffee.png", "text.png"):
        path = DATA / "images" / name
        if path.is_file():
            found[name] = mt.read_image(path)[:300, :320]
    if len(found) == len(generated()):
        print(f"no photographs in {DATA}: generated images only")
    return found


PICTURES = pictures()


def colours(image: Array, value: float) -> Any:
    return value if image.ndim == 2 else [value] * image.shape[2]


def close(ours: Array, theirs: Array, most: float = 1) -> None:
    assert ours.shape == theirs.shape
    assert ours.dtype == theirs.dtype
    assert np.abs(ours.astype(np.float64) - theirs.astype(np.float64)).max() <= most


@pytest.mark.parametrize("name", PICTURES)
@pytest.mark.parametrize("wrap", BORDERS)
def test_remap_is_opencvs(name: str, wrap: str) -> None:
    """No minification, no anti-aliasing: within a step of 8 bits, with every border and every kind of map."""
    image = PICTURES[name]
    height, width = image.shape[:2]
    rng = np.random.default_rng(1)
    y, x = np.mgrid[:80, :100].astype(np.float32)
    smooth = (width * 0.3 + x * 0.7 + 9 * np.sin(y / 11), height * 0.2 + y * 0.6 + 9 * np.cos(x / 13))
    wild = (rng.uniform(-0.9, 1.9, x.shape) * width, rng.uniform(-0.9, 1.9, x.shape) * height)
    for map_x, map_y in (smooth, wild):
        map_x, map_y = map_x.astype(np.float32), map_y.astype(np.float32)
        theirs = cv2.remap(
            image, map_x, map_y, cv2.INTER_LINEAR, borderMode=BORDERS[wrap], borderValue=(40,) * 4
        )
        ours = mt.remap(image, map_x, map_y, filter="bilinear", wrap=wrap, border=40)
        close(ours, theirs)
    # "auto" is the interpolation where nothing is minified.
    map_x, map_y = (m.astype(np.float32) for m in (width * 0.2 + x * 0.4, height * 0.1 + y * 0.4))
    theirs = cv2.remap(image, map_x, map_y, cv2.INTER_LINEAR, borderMode=BORDERS[wrap], borderValue=(40,) * 4)
    close(mt.remap(image, map_x, map_y, wrap=wrap, border=40), theirs)


@pytest.mark.parametrize("name", PICTURES)
@pytest.mark.parametrize("wrap", BORDERS)
def test_affine_and_perspective_are_opencvs(name: str, wrap: str) -> None:
    image = PICTURES[name]
    height, width = image.shape[:2]
    options: dict[str, Any] = {"borderMode": BORDERS[wrap], "borderValue": (7,) * 4}
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    affine = np.array([[0.8, 0.3, -20.25], [-0.2, 0.7, 15.5]])
    theirs = cv2.warpAffine(image, affine, (150, 120), flags=flags, **options)
    close(mt.warp(image, affine, shape=(120, 150), filter="bilinear", wrap=wrap, border=7), theirs)
    forward = cv2.invertAffineTransform(affine)
    close(theirs, cv2.warpAffine(image, forward, (150, 120), flags=cv2.INTER_LINEAR, **options), 2)
    perspective = np.array([[0.9, 0.1, -9.3], [0.05, 0.8, 4.4], [3e-4, -2e-4, 1.0]])
    theirs = cv2.warpPerspective(image, perspective, (150, 120), flags=flags, **options)
    ours = mt.warp(image, perspective, shape=(120, 150), filter="bilinear", wrap=wrap, border=7)
    close(ours, theirs)
    assert width > 20
    assert height > 20


@pytest.mark.parametrize("name", PICTURES)
def test_resize_is_opencvs(name: str) -> None:
    """Enlarging by INTER_LINEAR: the same rule of edges on edges; nearest: floor of the scaled column."""
    image = PICTURES[name]
    height, width = image.shape[:2]
    for shape in ((height * 2, width * 2), (height + 7, width + 30), (height * 3 + 1, width)):
        theirs = cv2.resize(image, shape[::-1], interpolation=cv2.INTER_LINEAR)
        close(mt.resize(image, shape), theirs)
        close(mt.resize(image, shape, "bilinear"), theirs)
    # Area means of whole blocks, by the level that was made for them.
    even = image[: height // 4 * 4, : width // 4 * 4]
    theirs = cv2.resize(even, (even.shape[1] // 2, even.shape[0] // 2), interpolation=cv2.INTER_AREA)
    lod = mt.Texture(even).level(1)
    close(lod, theirs)


@pytest.mark.parametrize("mode", ["constant", "edge", "symmetric", "reflect", "wrap"])
def test_warp_is_scikit_images(mode: str) -> None:
    """Orders 0, 1 and 3 of a matrix; order 3 of a matrix is Catmull and Rom's cubic."""
    wrap = {
        "constant": "border",
        "edge": "clamp",
        "symmetric": "mirror",
        "reflect": "mirror_101",
        "wrap": "repeat",
    }[mode]
    image = np.random.default_rng(2).random((37, 53))
    affine = np.array([[0.8, 0.3, -20.2518], [-0.2, 0.7, 15.5313], [0, 0, 1]])
    perspective = np.array([[0.9, 0.1, -9.3149], [0.05, 0.8, 4.4371], [3e-3, -2e-3, 1.0]])
    for matrix in (affine, perspective):
        for order, filter in ((0, "nearest"), (1, "bilinear"), (3, "bicubic")):
            theirs = skimage.transform.warp(
                image, matrix, output_shape=(60, 70), order=order, mode=mode, cval=0.3, clip=False
            )
            ours = mt.warp(image, matrix, shape=(60, 70), filter=filter, wrap=wrap, border=0.3)
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-6)


def test_bilinear_is_exact_where_old_tables_are_not() -> None:
    """A ramp moved by hundredths of a pixel is that ramp, not one of 32 steps."""
    ramp = np.broadcast_to(np.arange(200, dtype=np.float64), (3, 200))
    for step in range(100):
        moved = mt.warp(ramp, [[1.0, 0.0, step / 100], [0.0, 1.0, 0.0]], shape=(3, 150), filter="bilinear")
        np.testing.assert_allclose(moved, ramp[:, :150] + step / 100, rtol=0, atol=1e-12)


def test_a_constant_border_fades_over_one_pixel() -> None:
    image = np.full((5, 5), 100, np.uint8)
    x = np.linspace(-2, 6, 81)
    got = mt.remap(image, x[None], np.full((1, 81), 2.0), border=20, filter="bilinear")[0]
    inside = np.minimum(x + 1, 5 - x).clip(0, 1)
    np.testing.assert_array_equal(got, np.floor(20 + 80 * inside + 0.5 + 1e-9))


@pytest.mark.parametrize(
    "filter", ["auto", "nearest", "bilinear", "bicubic", "mitchell", "trilinear", "anisotropic"]
)
def test_matrix_map_and_callable_agree(filter: str) -> None:
    """Differences of an affine map are its matrix, so that all three see the same footprints."""
    image = generated()["waves"].astype(np.float64)
    matrix = np.array([[2.5, 0.5, -9.3], [-0.25, 1.5, 8.7]])
    y, x = np.mgrid[:40, :50].astype(np.float64)
    places = np.stack([x, y, np.ones_like(x)], -1) @ matrix.T
    by_matrix = mt.warp(image, matrix, shape=(40, 50), filter=filter)
    options: dict[str, Any] = {
        "rtol": 0,
        "atol": 1e-3 if filter in ("auto", "anisotropic", "trilinear") else 1e-9,
    }
    np.testing.assert_allclose(mt.warp(image, places, filter=filter), by_matrix, **options)
    np.testing.assert_allclose(
        mt.remap(image, places[..., 0], places[..., 1], filter=filter), by_matrix, **options
    )
    affine = matrix.T

    def function(points: Array) -> Array:
        moved: Array = np.concatenate([points, np.ones((len(points), 1))], 1) @ affine
        return moved

    np.testing.assert_allclose(mt.warp(image, function, shape=(40, 50), filter=filter), by_matrix, **options)
    perspective = np.vstack([matrix, [0, 0, 1]]) * 2
    np.testing.assert_allclose(
        mt.warp(image, perspective, shape=(40, 50), filter=filter), by_matrix, **options
    )


@pytest.mark.parametrize("filter", ["auto", "bilinear", "bicubic", "trilinear", "anisotropic"])
@pytest.mark.parametrize("shape", [(13, 20), (90, 140), (200, 41), (1, 1), (30, 300)])
def test_resize_warp_and_sample_agree(shape: tuple[int, int], filter: str) -> None:
    image = generated()["waves"].astype(np.float64)
    (h, w), (height, width) = image.shape[:2], shape
    sx, sy = w / width, h / height
    resized = mt.resize(image, shape, filter)
    warped = mt.warp(
        image, [[sx, 0, sx / 2 - 0.5], [0, sy, sy / 2 - 0.5]], shape, filter=filter, wrap="clamp"
    )
    np.testing.assert_allclose(resized, warped, rtol=0, atol=1e-9)
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    jacobian = np.diag([1 / width, 1 / height])
    sampled = mt.Texture(image).sample(np.stack([u, v], -1), jacobian, filter=filter)
    # Values up to 254; the level of detail is single precision: 3e-7 of the blend of two levels.
    np.testing.assert_allclose(resized, sampled, rtol=0, atol=1e-3)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("channels", [0, 1, 2, 3, 4, 5, 7])
def test_the_dtype_stays(dtype: str, channels: int) -> None:
    """What comes out is what went in, rounded to nearest and saturated."""
    rng = np.random.default_rng(3)
    shape = (9, 11) if channels == 0 else (9, 11, channels)
    full = {"uint8": 255, "uint16": 65535}.get(dtype, 1)
    image = (rng.random(shape) * full).astype(dtype)
    for filter in ("auto", "bilinear", "bicubic", "nearest"):
        got = mt.warp(image, [[0.7, 0.1, 1.3], [0, 0.8, 0.9]], filter=filter, wrap="mirror")
        assert got.dtype == image.dtype
        assert got.shape == image.shape
        np.testing.assert_array_equal(mt.warp(image, np.eye(3), filter=filter), image)
        assert mt.resize(image, (4, 30), filter).dtype == image.dtype
    y, x = np.mgrid[:9, :11]
    uv = np.stack([(0.7 * x + 0.1 * y + 1.3 + 0.5) / 11, (0.8 * y + 0.9 + 0.5) / 9], -1).reshape(-1, 2)
    exact = Brute(image, "mirror").sample(uv, "bicubic").reshape(9, 11, -1) * full
    ours = mt.warp(image, [[0.7, 0.1, 1.3], [0, 0.8, 0.9]], filter="bicubic", wrap="mirror").reshape(
        exact.shape
    )
    # Half a step of the dtype, and the rounding of singles.
    step = {"uint8": 0.5, "uint16": 0.5, "float16": 2.0**-11, "float32": 0, "float64": 0}[dtype]
    slack = 24 * full * (2.0**-53 if dtype == "float64" else 2.0**-24) + 1e-12
    over = np.abs(
        ours.astype(np.float64) - exact.clip(0, full) if full > 1 else ours.astype(np.float64) - exact
    )
    assert over.max() <= step * max(1.0, float(np.abs(exact).max()) if full == 1 else 1.0) + slack


def test_a_cubic_saturates() -> None:
    edge = np.zeros((4, 20), np.uint8)
    edge[:, 10:] = 255
    got = mt.resize(edge, (4, 200), "bicubic")
    assert got.min() == 0
    assert got.max() == 255
    assert (np.diff(got[0].astype(int)) >= 0).all()


@pytest.mark.parametrize("shape", [(40_000, 3), (3, 40_000), (70_001, 1)])
def test_images_beyond_32767_a_side(shape: tuple[int, int]) -> None:
    image = (
        (np.arange(shape[0] * shape[1], dtype=np.uint32) * 2654435761 >> 24).astype(np.uint8).reshape(shape)
    )
    np.testing.assert_array_equal(mt.warp(image, np.eye(3)), image)
    # Backwards: every place is beyond 16 bits somewhere.
    flip = [[-1, 0, shape[1] - 1], [0, -1, shape[0] - 1]]
    np.testing.assert_array_equal(mt.warp(image, flip), image[::-1, ::-1])
    y, x = np.mgrid[: shape[0], : shape[1]][:, ::-1, ::-1]
    for dtype in (np.float32, np.float64):
        np.testing.assert_array_equal(mt.remap(image, x.astype(dtype), y.astype(dtype)), image[::-1, ::-1])
    tall = mt.resize(image, (max(1, shape[0] // 4), max(1, shape[1] // 4)))
    assert abs(float(tall.mean()) - float(image.mean())) < 2


@pytest.mark.parametrize("filter", ["auto", "bilinear", "bicubic", "nearest", "anisotropic"])
def test_places_that_are_not_finite(filter: str) -> None:
    image = np.full((6, 6, 3), 200, np.uint8)
    y, x = np.mgrid[:6, :6].astype(np.float64)
    x[1, 2], y[3, 3], x[5, 5], x[0, 0], y[2, 0] = np.nan, np.inf, -np.inf, 1e300, -1e30
    for dtype in (np.float32, np.float64):
        with np.errstate(over="ignore"):
            map_x, map_y = x.astype(dtype), y.astype(dtype)
        places = np.stack([map_x, map_y], -1)
        got, covered = mt.warp(image, places, filter=filter, border=[10, 20, 30], coverage=True)
        outside = np.zeros((6, 6), bool)
        outside[[1, 3, 5, 0, 2], [2, 3, 5, 0, 0]] = True
        np.testing.assert_array_equal(got[outside], np.broadcast_to([10, 20, 30], (5, 3)))
        np.testing.assert_array_equal(got[~outside], 200)
        np.testing.assert_array_equal(covered == 0, outside)
        np.testing.assert_array_equal(mt.remap(image, map_x, map_y, filter=filter, border=[10, 20, 30]), got)
        clamped = mt.remap(image, map_x, map_y, filter=filter, border=10, wrap="repeat")
        assert (clamped[[1, 3, 5], [2, 3, 5]] == 10).all()


def test_a_horizon_is_no_place() -> None:
    """Where w = 0 there is no input pixel: border, not a crash."""
    image = np.full((8, 8), 50, np.uint8)
    got = mt.warp(image, [[1, 0, 0], [0, 1, 0], [0, 1, -4]], shape=(9, 8), border=7)
    assert (got[4] == 7).all()


def test_coverage_is_the_share_inside() -> None:
    image = np.zeros((10, 10), np.float32)
    # A reduction by two, half a result pixel to the left: columns are outside by half, or not.
    _, covered = mt.warp(image, [[2, 0, -0.5], [0, 2, 0.5]], shape=(5, 6), coverage=True)
    assert covered.dtype == np.float32
    assert covered.shape == (5, 6)
    assert covered.min() >= 0
    assert covered.max() <= 1
    np.testing.assert_allclose(covered[1:4, 1:5], 1, atol=1e-6)
    assert (covered[:, 0] < 1).all()
    assert (covered[:, 5] < 1).all()
    for wrap in ("clamp", "repeat", "mirror"):
        assert (mt.warp(image, np.eye(3) * 3, wrap=wrap, coverage=True)[1] == 1).all()


def test_out_receives_the_result() -> None:
    image = generated()["noise"]
    want = mt.resize(image, (20, 30))
    out = np.zeros((20, 30, 3), np.uint8)
    assert mt.resize(image, (20, 30), out=out) is out
    np.testing.assert_array_equal(out, want)
    y, x = np.mgrid[:20, :30].astype(np.float32)
    assert mt.remap(image, x, y, out=out) is out
    np.testing.assert_array_equal(out, mt.remap(image, x, y))


def test_linear_light_and_hidden_colour_by_keyword() -> None:
    checker = (np.indices((32, 32)).sum(0) % 2 * 255).astype(np.uint8)
    assert (mt.resize(checker, (16, 16), encoding="srgb")[2:-2, 2:-2] == 188).all()
    assert (np.abs(mt.resize(checker, (16, 16))[2:-2, 2:-2].astype(int) - 128) <= 1).all()
    image = np.zeros((16, 16, 4), np.uint8)
    image[::2] = (255, 0, 0, 255)
    image[1::2] = (0, 255, 0, 0)
    small = mt.resize(image, (4, 4), alpha="straight")
    assert (small[..., 1] == 0).all()
    assert (small[..., 0] == 255).all()


def test_huge_maps_do_not_crash() -> None:
    rng = np.random.default_rng(5)
    image = rng.integers(0, 256, (7, 9, 2), np.uint8)
    values = [
        0.0,
        1.0,
        -1.0,
        3.3,
        1e6,
        -1e6,
        1e30,
        -1e30,
        1e300,
        -1e300,
        np.nan,
        np.inf,
        -np.inf,
        1e-300,
        2.0**31,
        -(2.0**31),
        2.0**63,
    ]
    places = rng.choice(values, (60, 50, 2))
    for wrap in (*BORDERS, "mirror_once", ("repeat", "border")):
        for filter in ("auto", "nearest", "bilinear", "bicubic", "mitchell", "trilinear", "anisotropic"):
            with np.errstate(over="ignore"):
                for dtype in (np.float32, np.float64):
                    assert mt.warp(image, places.astype(dtype), filter=filter, wrap=wrap).shape == (60, 50, 2)
