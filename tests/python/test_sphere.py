"""Textures of directions against a smooth function on the sphere, on every level and by every filter."""

import doctest
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from multum import _sphere, mapping

Array = NDArray[np.float64]

RNG = np.random.default_rng(3)
FILTERS = ["bilinear", "trilinear", "linear_mipmap_nearest", "anisotropic", "ewa", "area", "exact", "auto"]


def smooth(d: Array) -> Array:
    """A smooth function of direction without symmetry."""
    x, y, z = (d / np.linalg.norm(d, axis=-1, keepdims=True)).T
    return np.asarray(0.5 + (np.sin(2 * x + 1) + np.cos(3 * y - 0.5 * z) + np.sin(2.5 * z - x * y)) / 6)


def texture(form: str, side: int) -> mt.SphereTexture:
    """Texel means of the smooth function."""
    m: Any = mapping.Equirect() if form == "equirect" else mapping.Cube("strip")
    width, height = (4 * side, 2 * side) if form == "equirect" else (6 * side, side)
    k = 4
    x, y = np.meshgrid(
        (np.arange(width * k) + 0.5) / (width * k), (np.arange(height * k) + 0.5) / (height * k)
    )
    values = smooth(m.inverse(np.stack([x, y], -1)).reshape(-1, 3)).reshape(height, k, width, k).mean((1, 3))
    return mt.SphereTexture(values, form, layout="strip")


def frames(d: Array) -> tuple[Array, Array]:
    """Two unit tangents, turned at random."""
    a = np.cross(d, RNG.normal(size=d.shape))
    a /= np.linalg.norm(a, axis=-1, keepdims=True)
    return a, np.cross(d, a)


def seen(d: Array, dx: Array, dy: Array) -> Array:
    """The mean of the smooth function over each pixel."""
    steps = (np.arange(5) + 0.5) / 5 - 0.5
    mean: Array = np.mean([smooth(d + a * dx + b * dy) for a in steps for b in steps], axis=0)
    return mean


def special(form: str, d: Array, near: float) -> NDArray[np.bool_]:
    """Directions within ``near`` radians of seam, pole or edge."""
    if form == "equirect":
        seam = (np.abs(d[:, 0]) < near) & (d[:, 2] < 0)
        return np.asarray(seam | (np.hypot(d[:, 0], d[:, 2]) < near))
    order = np.sort(np.abs(d), -1)
    return np.asarray((order[:, 2] - order[:, 1]) / np.sqrt(2) < near)


def directions(form: str, near: float) -> Array:
    """Half of them next to what is special, half anywhere."""
    d = RNG.normal(size=(400_000, 3))
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    chosen = special(form, d, near)
    poles = (
        np.array([[0.0, s, 0.0] for s in (1, -1)]) if form == "equirect" else np.ones((2, 3)) * [[1], [-1]]
    )
    around = np.repeat(poles, 1000, 0) + RNG.normal(size=(2000, 3)) * near / 3
    around /= np.linalg.norm(around, axis=-1, keepdims=True)
    return np.concatenate([d[chosen][:6000], around, d[~chosen][:6000]])


@pytest.mark.parametrize("form", ["equirect", "cube"])
@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("texels", [0.0, 1.0, 2.0, 5.0])
def test_errors_at_seam_pole_and_edge_are_those_of_elsewhere(form: str, filter: str, texels: float) -> None:
    side = 32
    sky = texture(form, side)
    texel = np.pi / 2 / side
    d = directions(form, max(texels, 1) * texel)
    a, b = (x * texel * texels for x in frames(d))
    got = sky.sample(d, a, b, filter=filter)[:, 0] if texels else sky.sample(d, filter=filter)[:, 0]
    error = np.abs(got - seen(d, a, b))
    here = special(form, d, max(texels, 1) * texel)
    assert here.sum() > 2000
    assert (~here).sum() > 2000
    rms = [float(np.sqrt(np.mean(error[mask] ** 2))) for mask in (here, ~here)]
    # The floor is the rounding of what is interpolated, far below what the levels lose.
    assert rms[0] < 1.5 * rms[1] + 1e-5


@pytest.mark.parametrize("form", ["equirect", "cube"])
@pytest.mark.parametrize("filter", ["linear_mipmap_nearest", "trilinear"])
@pytest.mark.parametrize("level", range(4))
def test_every_level_goes_on(form: str, filter: str, level: int) -> None:
    sky = texture(form, 32)
    texel = np.pi / 2 / 32 * 2**level
    near = min(texel, 0.25)
    d = directions(form, near)
    got = sky.sample(d, lod=np.full(len(d), level), filter=filter)[:, 0]
    here = special(form, d, near)
    a, b = (x * texel for x in frames(d))
    error = got - seen(d, a, b)
    rms = [float(np.sqrt(np.mean(error[mask] ** 2))) for mask in (here, ~here)]
    assert rms[0] < 1.5 * rms[1] + 1e-5


@pytest.mark.parametrize("form", ["equirect", "cube"])
@pytest.mark.parametrize("filter", [f for f in FILTERS if f != "linear_mipmap_nearest"])
def test_a_walk_over_poles_and_corners_is_smooth(form: str, filter: str) -> None:
    """White noise along great circles through what is special: steps are no larger there than elsewhere."""
    shape = (32, 64, 1) if form == "equirect" else (6, 16, 16, 1)
    sky = mt.SphereTexture(RNG.random(shape), form)
    for start, towards in (
        ([0, 1, 0], [1, 0.1, 0.3]),
        ([1, 1, 1], [-1, 0.3, 0.6]),
        ([1, 1, 0.2], [1, -1, 0.1]),
    ):
        s = np.array(start) / np.linalg.norm(start)
        t = np.array(towards) - s * np.dot(s, towards)
        t /= np.linalg.norm(t)
        angle = np.linspace(-0.6, 0.6, 24_001)[:, None]
        d = np.cos(angle) * s + np.sin(angle) * t
        side = np.cross(s, t)
        pixel = 0.2
        forward = (np.cos(angle) * t - np.sin(angle) * s) * pixel
        got = sky.sample(d, forward, np.broadcast_to(side * pixel, d.shape), filter=filter)[:, 0]
        # A step is 1/4000 of a pixel, and texels differ by up to 1: a filter that is continuous moves by that and
        # by what single probes weigh as they come and go.
        assert np.abs(np.diff(got)).max() < (
            0.003 if filter in ("bilinear", "trilinear", "anisotropic") else 0.03
        )


def test_directions_of_any_length_and_kind() -> None:
    sky = texture("equirect", 8)
    d = RNG.normal(size=(50, 3))
    want = sky.sample(d)
    for scale in (1e-300, 1e-3, 1e200):
        np.testing.assert_allclose(sky.sample(d * scale), want, rtol=1e-12)
    np.testing.assert_allclose(sky.sample(d.astype(np.float32)), want, atol=1e-5)
    dx, dy = (x * 0.1 for x in frames(d))
    one = sky.sample(d, dx, dy)
    np.testing.assert_allclose(sky.sample(d * 7, dx * 7, dy * 7), one, rtol=1e-9)
    out = np.empty((50, 1))
    assert sky.sample(d, dx, dy, out=out) is out
    assert np.array_equal(out, one)
    many = RNG.normal(size=(20_000, 3))
    wide = [np.array([0.1, 0, 0]), np.array([0, 0.1, 0])]
    assert np.array_equal(sky.sample(many, *wide, threads=1), sky.sample(many, *wide, threads=3))
    for bad in ([0, 0, 0], [np.nan, 0, 1], [np.inf, 0, 0]):
        assert sky.sample(bad).tolist() == [0.0]
    coarse = sky.sample([0, 0, 1], [np.inf, 0, 0], [0, 1, 0])
    assert abs(coarse.item() - want.mean()) < 0.3
    assert sky.sample(np.zeros((0, 3))).shape == (0, 1)


def test_dtypes_layouts_and_alpha() -> None:
    faces = RNG.integers(0, 256, (6, 8, 8, 3), dtype=np.uint8)
    cross = mt.panorama.convert(faces, "cube", "cube", 8, layout="cross")
    strip = mt.panorama.convert(faces, "cube", "cube", 8, layout="strip")
    d = RNG.normal(size=(500, 3))
    want = mt.SphereTexture(faces, "cube").sample(d, lod=np.full(500, 1.3))
    for image, layout in ((cross, "cross"), (strip, "strip")):
        got = mt.SphereTexture(image, "cube", layout=layout).sample(d, lod=np.full(500, 1.3))
        assert np.array_equal(got, want)
    for dtype in (np.uint16, np.float16, np.float32, np.float64):
        image = np.full((4, 8), 100, dtype)
        value = mt.SphereTexture(image).sample(d)
        assert value.dtype == (np.float64 if dtype == np.float64 else np.float32)
        assert len(np.unique(value)) == 1
    clear = np.zeros((6, 4, 4, 4), np.float32)
    clear[:3] = [1, 0, 0, 0]
    clear[3:] = [0, 1, 0, 1]
    seen_through = mt.SphereTexture(clear, "cube", alpha="straight").sample(d, lod=np.full(500, 1.5))
    assert seen_through[seen_through[:, 3] > 1e-3][:, 0].max() == 0


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: mt.SphereTexture(np.zeros((4, 8)), "globe"), "form"),
        (lambda: mt.SphereTexture(np.zeros((4, 8)), "cube"), "image"),
        (lambda: mt.SphereTexture(np.zeros((4, 8)), "cube", layout="cross"), "image"),
        (lambda: mt.SphereTexture(np.zeros((4, 8)), "cube", layout="dice"), "layout"),
        (lambda: mt.SphereTexture(np.zeros(4)), "image"),
        (lambda: mt.SphereTexture(np.zeros((4, 8))).sample([0.0, 1.0]), "directions"),
        (lambda: mt.SphereTexture(np.zeros((4, 8))).sample([0.0, 1.0, 0.0], [1, 0, 0]), "ddx, ddy"),
        (lambda: mt.SphereTexture(np.zeros((4, 8))).sample([0.0, 1.0, 0.0], [1, 0], [0, 1]), "ddx"),
        (
            lambda: mt.SphereTexture(np.zeros((4, 8))).sample([0.0, 1, 0], [1, 0, 0], [0, 0, 1], lod=1.0),
            "lod",
        ),
        (lambda: mt.SphereTexture(np.zeros((4, 8))).sample([0.0, 1, 0], lod=[1.0, 2.0]), "lod"),
        (lambda: mt.SphereTexture(np.zeros((4, 8))).sample([0.0, 1, 0], filter="best"), "filter"),
    ],
)
def test_refusals(call: Callable[[], object], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        call()


def test_docstrings() -> None:
    assert doctest.testmod(_sphere).failed == 0
