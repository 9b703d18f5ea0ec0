"""Nearest, bilinear and both cubics against brute force in exact positions and doubles.

The bound. With e the unit roundoff of the arithmetic (2^-24 for f32, 2^-53 for f64) and M the largest
magnitude of a texel or of the border:

- bilinear: three interpolations a + t (b - a), each with errors e|b - a| of the difference, of t and of the
  product, and e of the sum: at most 7 e M one after the other in two stages, and a division: 16 e M;
- cubic: the absolute weights sum to at most 1.25 an axis (Catmull-Rom at f = 1/2), each weight is rounded
  once, and four products are summed twice: 2 (4 + 2) 1.25^2 e M, below 20 e M; for integers a division;
- a table of decoded codes is single, and so is the result of all but f64: 2 e M more;
- the place: u W is rounded in f64 and reduced by the period, each to 2^-53 of its magnitude: the place moves
  by at most 2^-51 (|u| W + W), and the reconstruction's slope is at most 3 M a texel (2 M for bilinear; the
  cubic's absolute slopes sum to 2.5 at most, times 1.25 across).

24 e M plus the place's part covers all of them. Straight colour is divided by alpha: both parts are divided
by the alpha there, and doubled for the error of alpha itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from reference_numpy import FULL_SCALE, WRAPS, Brute

Array = NDArray[Any]
FILTERS = ["nearest", "bilinear", "bicubic", "mitchell"]
DTYPES = ["uint8", "uint16", "float16", "float32", "float64"]
SIZES = [(1, 1), (1, 5), (2, 2), (3, 1), (3, 2), (5, 8), (8, 8), (17, 3), (2, 17)]
MODES = [(a, b) for a in WRAPS for b in WRAPS]


def noise(shape: tuple[int, ...], dtype: str, seed: int = 1) -> Array:
    """Codes over the whole range; floats beyond 0 to 1 too."""
    rng = np.random.default_rng(seed)
    if dtype in FULL_SCALE:
        return rng.integers(0, int(FULL_SCALE[dtype]), shape, dtype, endpoint=True)
    return rng.normal(0.5, 1.0, shape).astype(dtype)


def places(rng: np.random.Generator, count: int = 24) -> Array:
    """Inside, in the tiles around, far away, exactly on edges and centres."""
    near = rng.uniform(-3.5, 4.5, (count, 2))
    exact = rng.integers(-24, 32, (count, 2)) / 8.0
    far = rng.uniform(-1e6, 1e6, (4, 2))
    return np.concatenate([near, exact, far])


def off_edges(uv: Array, size: tuple[int, int]) -> Array:
    """Places so far from texel edges that rounding cannot choose the other texel."""
    texel = uv.astype(np.float64) * size
    gap = np.abs(texel - np.round(texel)).min(-1)
    clear: Array = gap > 2**-50 * np.abs(texel).max(-1)
    return clear


def bound(uv: Array, texture: mt.Texture, brute: Brute) -> Array:
    """The rounding bound of the module's head, (N, 1)."""
    e = 2.0**-53 if texture.dtype == np.float64 else 2.0**-24
    largest = max(np.abs(brute.value).max(), np.abs(brute.border).max())
    size = (brute.width, brute.height)
    with np.errstate(all="ignore"):
        moved = (2.0**-51 * (np.abs(uv.astype(np.float64)) + 1) * size).sum(-1, keepdims=True)
    limit = (24 * e + 3 * moved) * largest
    finite: Array = np.nan_to_num(limit, nan=e, posinf=np.inf)
    return finite


def image_size(size: tuple[int, int], modes: tuple[str, str]) -> tuple[int, int]:
    """(height, width) of the image for a texture of (width, height)."""
    return size[1] + 2 * (modes[1] == "extend"), size[0] + 2 * (modes[0] == "extend")


@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("dtype", DTYPES)
def test_every_size_wrap_pair_and_channel_count(filter: str, dtype: str) -> None:
    rng = np.random.default_rng(5)
    for case, modes in enumerate(MODES):
        size = SIZES[case % len(SIZES)]
        channels = case % 5 + 1
        image = noise((*image_size(size, modes), channels), dtype, case)
        border = rng.uniform(-1, 2, channels)
        texture = mt.Texture(image, modes, border)
        brute = Brute(image, modes, [float(b) for b in border])
        assert (texture.width, texture.height, texture.channels) == (*size, channels)
        for coordinates in ("float32", "float64"):
            uv = places(rng).astype(coordinates)
            if filter == "nearest":
                uv = uv[off_edges(uv, size)]
            got = texture.sample(uv, filter=filter)
            assert got.dtype == (np.float64 if dtype == "float64" else np.float32)
            excess = np.abs(got - brute.sample(uv, filter)) - bound(uv, texture, brute)
            assert excess.max() <= 0, (modes, size, channels, coordinates, uv[excess.max(-1).argmax()])


@pytest.mark.parametrize("filter", ["bilinear", "bicubic"])
@pytest.mark.parametrize("size", [(w, h) for w in (1, 2, 3, 5, 8, 17) for h in (1, 2, 3, 5, 8, 17)])
def test_all_sizes(size: tuple[int, int], filter: str) -> None:
    rng = np.random.default_rng(6)
    for mode in WRAPS:
        image = noise(image_size(size, (mode, mode)), "uint8")
        texture, brute = mt.Texture(image, mode, 0.25), Brute(image, mode, 0.25)
        uv = places(rng, 12)
        excess = np.abs(texture.sample(uv, filter=filter) - brute.sample(uv, filter))
        assert (excess <= bound(uv, texture, brute)).all(), mode


@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("mode", WRAPS)
def test_huge_coordinates(mode: str, filter: str) -> None:
    """Beyond 2^53 every double is a whole number: a multiple of every period, or far outside."""
    image = noise(image_size((4, 8), (mode, mode)), "float64")
    texture, brute = mt.Texture(image, mode, 7.0), Brute(image, mode, 7.0)
    numbers = [1e6, 1e15, 2.0**60, 1e30, 1e300, 1.7e308]
    uv = np.array([(s * n, 0.3) for n in numbers for s in (-1, 1)] + [(0.3, -n) for n in numbers])
    got = texture.sample(uv, filter=filter)
    # Sizes are powers of two, so that u W is exact and the answer is one number (1.7e308 W overflows).
    finite = (np.abs(uv) < 1e308).all(-1)
    largest = max(7.0, np.abs(image).max())
    limit = 24 * 2.0**-53 * largest
    np.testing.assert_allclose(got[finite], brute.sample(uv, filter)[finite], rtol=0, atol=limit)
    np.testing.assert_array_equal(got[~finite], 7.0)


@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("mode", ["clamp", "repeat", "mirror", "mirror_once", "mirror_101"])
@pytest.mark.parametrize("width", [3, 5, 7, 41, 47])
def test_huge_coordinates_of_other_sizes_stay_in_the_picture(mode: str, filter: str, width: int) -> None:
    image = noise((3, width), "uint8")
    texture = mt.Texture(image, mode)
    uv = np.array([(s * 10.0**n, s * 10.0**n) for n in range(6, 300, 7) for s in (-1, 1)])
    got = texture.sample(uv, filter=filter)
    # Absolute weights sum to 1.25 an axis at most: a cubic overshoots by (1.25^2 - 1)/2 of the range.
    over = 0.3 if filter in ("bicubic", "mitchell") else 1e-6
    assert np.isfinite(got).all()
    assert got.min() >= image.min() / 255 - over
    assert got.max() <= image.max() / 255 + over


@pytest.mark.parametrize("filter", [*FILTERS, "trilinear", "anisotropic", "auto", "nearest_mipmap_nearest"])
@pytest.mark.parametrize("dtype", ["uint8", "float32", "float64"])
def test_coordinates_that_are_not_finite_show_the_border(filter: str, dtype: str) -> None:
    bad = [(np.nan, 0.5), (0.5, np.nan), (np.inf, 0.5), (0.5, -np.inf), (np.nan, np.inf)]
    for mode in WRAPS:
        texture = mt.Texture(noise((5, 5, 3), dtype), mode, [0.25, 0.5, -2.0])
        for uv in (np.array(bad), np.array(bad, np.float32)):
            for jacobian in (None, np.eye(2, dtype=uv.dtype)):
                got = texture.sample(uv, jacobian, filter=filter)
                np.testing.assert_array_equal(got, np.broadcast_to([0.25, 0.5, -2.0], got.shape))


@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize(
    ("encoding", "alpha", "channels"),
    [
        ("srgb", "none", 1),
        ("srgb", "none", 3),
        ("srgb", "straight", 4),
        ("srgb", "premultiplied", 4),
        ("srgb", "straight", 2),
        ("linear", "straight", 4),
        ("linear", "straight", 2),
        ("normal", "none", 3),
        ("normal", "straight", 4),
    ],
)
def test_codes_are_decoded_before_any_weight(
    filter: str, dtype: str, encoding: str, alpha: str, channels: int
) -> None:
    image = noise((5, 7, channels), dtype)
    if dtype not in FULL_SCALE:
        image = np.abs(image)
    border = np.linspace(0.2, 0.8, channels)
    uv = np.random.default_rng(2).uniform(-2, 3, (64, 2))
    for mode in ("repeat", "border"):
        texture = mt.Texture(image, mode, border, encoding, alpha)
        brute = Brute(image, mode, [float(b) for b in border], encoding, alpha)
        limit = bound(uv, texture, brute)
        if encoding == "srgb" and dtype == "float16":
            # Decoded once, to single precision.
            limit = limit + 2.0**-24
        if alpha == "straight":
            average = brute.averages(uv, filter)
            with np.errstate(divide="ignore"):
                # |P/A - p/a| <= (dP + |P/A| dA)/|a|, for both.
                grown = 2 * limit * (1 + np.abs(brute.finish(average))) / np.abs(average[:, -1:])
            limit = np.maximum(limit, grown)
        got = texture.sample(uv, filter=filter)
        assert (np.abs(got - brute.sample(uv, filter)) <= limit).all(), mode


def test_hidden_colour_never_shows() -> None:
    image = np.zeros((8, 8, 4), np.uint8)
    image[:, :4] = (255, 0, 0, 255)
    image[:, 4:] = (0, 255, 0, 0)
    texture = mt.Texture(image, "repeat", alpha="straight", encoding="srgb")
    uv = np.random.default_rng(0).random((500, 2))
    for filter, extent in (("bilinear", 0.0), ("trilinear", 0.4), ("anisotropic", 0.3), ("auto", 0.5)):
        got = texture.sample(uv, np.eye(2) * extent, filter=filter)
        assert np.isfinite(got).all()
        assert not got[:, 1].any()
        np.testing.assert_allclose(got[:, 0], got[:, 3] > 0, rtol=0, atol=1e-6)


def test_the_border_is_premultiplied_and_linear() -> None:
    image = np.full((4, 4, 4), 255, np.uint8)
    texture = mt.Texture(image, "border", [0.1, 0.0, 0.0, 0.5], "srgb", "straight")
    far = texture.sample([[9.0, 9.0]], filter="bilinear")[0]
    np.testing.assert_allclose(far, [0.2, 0, 0, 0.5], rtol=1e-6)
    edge = texture.sample([[0.0, 0.5]], filter="bilinear")[0]
    np.testing.assert_allclose(edge, [1.1 / 1.5, 1 / 1.5, 1 / 1.5, 0.75], rtol=1e-6)


def test_border_fades_over_one_texel_on_every_level() -> None:
    """White picture, black border: on level l the fade is the texel of level l, from -1/2 to +1/2 of it."""
    texture = mt.Texture(np.full((64, 64), 255, np.uint8), "border", 0.0)
    u = np.linspace(-1.5, 1.5, 601)
    for lod in range(texture.num_levels):
        uv = np.stack([u, np.full_like(u, 0.5)], -1)
        got = texture.sample(uv, lod=float(lod), filter="trilinear")[:, 0]
        n = 64 >> lod
        across = np.minimum(u * n + 0.5, (1 - u) * n + 0.5).clip(0, 1)
        np.testing.assert_allclose(got, across, rtol=0, atol=1e-6)


def test_nearest_at_every_period_multiple() -> None:
    """Sizes 1 to 256: a whole u is the first texel, texel centres are themselves, in every tile."""
    for n in range(1, 257):
        row = np.arange(n, dtype=np.float64)[None]
        tiles = np.array([-300.0, -7.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 1000.0])
        uv = np.stack([tiles, np.full_like(tiles, 0.5)], -1)
        repeat = mt.Texture(row, "repeat").sample(uv, filter="nearest")[:, 0]
        assert not repeat.any(), n
        mirror = mt.Texture(row, "mirror").sample(uv, filter="nearest")[:, 0]
        # Tile edges of the mirror: the same texel on both sides.
        np.testing.assert_array_equal(mirror, np.where(tiles % 2 == 0, 0, n - 1))
        clamp = mt.Texture(row, "clamp").sample(uv, filter="nearest")[:, 0]
        np.testing.assert_array_equal(clamp, np.where(tiles <= 0, 0, n - 1))
        centres = (np.arange(n) + 0.5) / n
        for tile in (-3.0, 0.0, 5.0):
            uv = np.stack([centres + tile, np.full_like(centres, 0.5)], -1)
            got = mt.Texture(row, "repeat").sample(uv, filter="nearest")[:, 0]
            np.testing.assert_array_equal(got, row[0])


def test_just_beside_whole_numbers() -> None:
    """u = -1e-9, 1 - ulp, nextafter(k): the fraction may round to a whole period, the texel may not."""
    row = np.arange(8, dtype=np.float64)[None]
    texture, brute = mt.Texture(row, "repeat"), Brute(row, "repeat")
    for dtype in (np.float32, np.float64):
        whole = np.arange(-3, 4).astype(dtype)
        u = np.concatenate(
            [np.nextafter(whole, dtype(-9)), whole, np.nextafter(whole, dtype(9)), np.array([-1e-9], dtype)]
        )
        uv = np.stack([u, np.full_like(u, 0.5)], -1)
        for filter in FILTERS:
            got, want = texture.sample(uv, filter=filter), brute.sample(uv, filter)
            np.testing.assert_allclose(got, want, rtol=0, atol=bound(uv, texture, brute).max())


def test_texel_centres_are_the_texels_on_every_level() -> None:
    image = noise((37, 50, 3), "uint8")
    for mode in WRAPS[:6]:
        texture = mt.Texture(image, mode)
        for lod in range(texture.num_levels):
            level = texture.level(lod)
            h, w = level.shape[:2]
            u, v = np.meshgrid((np.arange(w) + 0.5) / w, (np.arange(h) + 0.5) / h)
            uv = np.stack([u, v], -1)
            near = texture.sample(uv, lod=float(lod), filter="nearest_mipmap_nearest")
            np.testing.assert_array_equal(
                near, (level.astype(np.float32) / np.float32(255)).astype(np.float32)
            )
            linear = texture.sample(uv, lod=float(lod), filter="linear_mipmap_nearest")
            np.testing.assert_allclose(linear, level / 255, rtol=0, atol=1e-6)


def test_flipping_image_and_coordinate() -> None:
    image = noise((6, 9), "float64")
    uv = np.random.default_rng(3).uniform(-1, 2, (200, 2))
    jacobian = np.random.default_rng(4).normal(0, 0.2, (200, 2, 2))
    for mode in ("clamp", "repeat", "mirror", "border", "mirror_101"):
        a, b = mt.Texture(image, mode), mt.Texture(image[::-1], mode)
        for filter in ("bilinear", "bicubic", "trilinear", "anisotropic", "auto"):
            flipped = jacobian * [[1], [-1]]
            one = a.sample(uv, jacobian, filter=filter)
            two = b.sample(uv * [1, -1] + [0, 1], flipped, filter=filter)
            np.testing.assert_allclose(
                one, two, rtol=0, atol=2e-6 if filter in ("anisotropic", "auto", "trilinear") else 1e-13
            )


@pytest.mark.parametrize("mode", WRAPS)
def test_sixteenth_steps_against_whole_number_arithmetic(mode: str) -> None:
    """u from -3 to 3 in steps of a sixteenth of a texel, edges included, in tiles of every kind."""
    for n in (1, 2, 4, 8, 16):
        image = np.arange(n + 2 * (mode == "extend"), dtype=np.float64)[None] + 1
        texture, brute = mt.Texture(image, (mode, "clamp")), Brute(image, (mode, "clamp"))
        u = np.arange(-3 * 16 * n, 3 * 16 * n + 1) / (16 * n)
        uv = np.stack([u, np.full_like(u, 0.5)], -1)
        for filter in ("nearest", "bilinear"):
            np.testing.assert_array_equal(texture.sample(uv, filter=filter), brute.sample(uv, filter))
