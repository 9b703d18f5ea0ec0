"""Filters that read levels: against brute force on the texture's own levels, and for continuity."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from reference_numpy import Brute

Array = NDArray[Any]
WRAPS = ["clamp", "repeat", "mirror", "mirror_once", "mirror_101", "border"]
MIP_FILTERS = {
    "nearest_mipmap_nearest": ("nearest", "nearest"),
    "linear_mipmap_nearest": ("bilinear", "nearest"),
    "nearest_mipmap_linear": ("nearest", "blend"),
    "linear_mipmap_linear": ("bilinear", "blend"),
    "trilinear": ("bilinear", "blend"),
}


def noise(shape: tuple[int, ...], dtype: str = "float64", seed: int = 1) -> Array:
    numbers = np.random.default_rng(seed).random(shape)
    return np.round(numbers * 255).astype(np.uint8) if dtype == "uint8" else numbers.astype(dtype)


def by_hand(texture: mt.Texture, uv: Array, lods: Array, filter: str, border: float) -> Array:
    """OpenGL 4.6, sections 8.14.2 and 8.14.3, on the levels that the texture shows."""
    inside, between = MIP_FILTERS[filter]
    wrap = texture.wrap
    levels = [Brute(texture.level(i), wrap, border).sample(uv, inside) for i in range(texture.num_levels)]
    last = texture.num_levels - 1
    rows = []
    for row, lod in enumerate(lods):
        lod = min(max(float(lod), 0.0), float(last))
        if between == "nearest":
            rows.append(levels[max(0, math.ceil(lod + 0.5) - 1)][row])
        else:
            low = math.floor(lod)
            part = lod - low
            rows.append((1 - part) * levels[low][row] + part * levels[min(low + 1, last)][row])
    return np.array(rows)


@pytest.mark.parametrize("filter", MIP_FILTERS)
@pytest.mark.parametrize("dtype", ["uint8", "float32", "float64"])
def test_mipmap_filters_against_brute_force(filter: str, dtype: str) -> None:
    rng = np.random.default_rng(3)
    for size in [(16, 16), (17, 5), (1, 9), (33, 12)]:
        # mirror_101 folds at the centre of level 0's edge texel, which is another place than the level's own.
        for mode in (m for m in WRAPS if m != "mirror_101"):
            texture = mt.Texture(noise((size[1], size[0], 2), dtype), mode, 0.75)
            uv = rng.uniform(-2, 3, (60, 2))
            lods = np.concatenate([rng.uniform(-1, 7, 50), np.arange(5), np.arange(5) + 0.5]).astype(
                np.float32
            )
            got = texture.sample(uv, lod=lods, filter=filter)
            want = by_hand(texture, uv, lods, filter, 0.75)
            # Values up to 1; single arithmetic, and the place of a texel moves by 2^-51 of 3 * 33 texels.
            assert np.abs(got - want).max() <= (24 * 2.0**-24 if dtype != "float64" else 1e-12), (size, mode)


@pytest.mark.parametrize("filter", ["nearest_mipmap_nearest", "linear_mipmap_nearest"])
def test_halves_go_down(filter: str) -> None:
    texture = mt.Texture(noise((32, 32)), "repeat")
    uv = [0.37, 0.61]
    for k in range(4):
        half = np.float32(k + 0.5)
        below = texture.sample(uv, lod=float(k), filter=filter)
        above = texture.sample(uv, lod=float(k + 1), filter=filter)
        assert (below != above).all()
        for lod, want in (
            (np.nextafter(half, np.float32(-1)), below),
            (half, below),
            (np.nextafter(half, np.float32(9)), above),
        ):
            np.testing.assert_array_equal(texture.sample(uv, lod=lod, filter=filter), want)


def test_lod_is_the_logarithm_of_the_longest_axis_in_texels() -> None:
    """Turning a footprint changes nothing; shears and non-square textures have true singular values."""
    rng = np.random.default_rng(8)
    uv = np.array([0.3, 0.7])
    for height, width in ((256, 256), (64, 1024)):
        texture = mt.Texture(noise((height, width)), "repeat")
        cases = [rng.normal(0, 1, (2, 2)) * 10.0 ** rng.uniform(-4, 0) for _ in range(60)]
        cases += [np.array([[10, 10], [10, 10.1]]) / 256, np.array([[10, 10], [10.1, 10]]) / 256]
        for degrees in range(0, 91, 5):
            c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            cases.append(np.array([[c, -s], [s, c]]) @ np.diag([0.05, 0.01]))
        for jacobian in cases:
            texels = np.diag([width, height]) @ jacobian
            major = math.log2(np.linalg.svd(texels, compute_uv=False)[0])
            area = 0.5 * math.log2(abs(np.linalg.det(texels)))
            # A blend moves by at most 1 a level; the logarithm is single precision: 1e-5 in all.
            for rule, lod in (("major", major), ("area", area)):
                got = texture.sample(uv, jacobian, filter="trilinear", lod_rule=rule)
                want = texture.sample(uv, lod=lod, filter="trilinear")
                assert abs(got - want).max() <= 1e-5, (jacobian, rule)
                biased = texture.sample(uv, jacobian, filter="trilinear", lod_rule=rule, lod_bias=0.75)
                want = texture.sample(uv, lod=lod + 0.75, filter="trilinear")
                assert abs(biased - want).max() <= 1e-5
            swapped = texture.sample(uv, jacobian[:, ::-1], filter="anisotropic")
            np.testing.assert_allclose(
                swapped, texture.sample(uv, jacobian, filter="anisotropic"), rtol=0, atol=1e-6
            )


def test_identity_is_level_zero_and_halving_is_level_one() -> None:
    texture = mt.Texture(noise((64, 64)), "repeat")
    uv = np.random.default_rng(1).random((50, 2))
    for filter in ("trilinear", "anisotropic"):
        np.testing.assert_array_equal(
            texture.sample(uv, np.eye(2) / 64, filter=filter), texture.sample(uv, filter="bilinear")
        )
        np.testing.assert_array_equal(
            texture.sample(uv, np.eye(2) / 32, filter=filter), texture.sample(uv, lod=1.0, filter="trilinear")
        )


@pytest.mark.parametrize("filter", ["nearest_mipmap_linear", "trilinear"])
def test_level_of_detail_is_continuous(filter: str) -> None:
    texture = mt.Texture(noise((32, 32)), "repeat")
    last = texture.num_levels - 1
    edges = [np.nextafter(np.float32(k), np.float32(k + s)) for k in range(last + 1) for s in (-1, 1)]
    lods = np.sort(
        np.concatenate([np.arange(-1, last + 1, 1e-3), np.arange(last + 1.0), edges]).astype(np.float32)
    )
    for uv in np.random.default_rng(2).random((5, 2)):
        got = texture.sample(np.broadcast_to(uv, (len(lods), 2)), lod=lods, filter=filter)[:, 0]
        # Values of 0 to 1: a blend changes by at most the step.
        assert (np.abs(np.diff(got)) <= np.diff(lods) + 1e-6).all()


@pytest.mark.parametrize("filter", ["anisotropic", "auto"])
def test_footprints_are_continuous(filter: str) -> None:
    """Ratio 1 to 40 and past the limit, size through every level, sigma2 towards 0, all directions."""
    texture = mt.Texture(noise((64, 64)), "repeat")
    uv = np.array([0.31, 0.72])

    def largest_step(jacobians: list[Array]) -> float:
        stack = np.stack(jacobians)
        got = texture.sample(np.broadcast_to(uv, (len(stack), 2)), stack, filter=filter)[:, 0]
        return float(np.abs(np.diff(got)).max())

    # 4000 steps: a continuous curve over a range of 1 with bounded slope moves a little at each; a jump of
    # a probe or a level would be of the order of 1/16 or more.
    steps = np.linspace(0, 1, 4000)
    for turn in (0.0, 0.5, 1.1):
        c, s = math.cos(turn), math.sin(turn)
        rotation = np.array([[c, -s], [s, c]]) / 64
        assert largest_step([rotation @ np.diag([1.5 * (1 + 39 * t), 1.5]) for t in steps]) < 0.01
        assert largest_step([rotation @ np.diag([0.3 + 40 * t, 0.3 + 10 * t]) for t in steps]) < 0.02
        assert largest_step([rotation @ np.diag([8.0, 4.0 * (1 - t)]) for t in steps]) < 0.01
    turns = [
        np.array([[math.cos(t), -math.sin(t)], [math.sin(t), math.cos(t)]]) @ np.diag([8, 2]) / 64
        for t in steps * math.pi
    ]
    assert largest_step(turns) < 0.01


def test_nearly_round_footprints_have_no_direction() -> None:
    texture = mt.Texture(noise((64, 64)), "repeat")
    rng = np.random.default_rng(4)
    for size in (1.5, 3.0, 7.7):
        jacobian = (np.eye(2) + rng.normal(0, 1e-6, (200, 2, 2))) * size / 64
        got = texture.sample(np.broadcast_to([0.4, 0.2], (200, 2)), jacobian, filter="anisotropic")
        assert np.ptp(got) <= 1e-5


def test_degenerate_footprints() -> None:
    """0, infinity, NaN and extremes of 1e+-30: finite, and what the documentation says."""
    image = noise((16, 16), "float32")
    texture = mt.Texture(image, "repeat")
    uv = [0.3, 0.6]
    coarsest = texture.sample(uv, lod=99.0, filter="trilinear")
    point = texture.sample(uv, filter="bilinear")
    values = [0.0, 1.0, -1.0, 1e30, -1e30, 1e-30, 1e300, 1e-300, np.inf, -np.inf, np.nan]
    rng = np.random.default_rng(0)
    jacobians = rng.choice(values, (3000, 2, 2))
    for filter in ("trilinear", "anisotropic", "auto", "linear_mipmap_nearest", "nearest_mipmap_linear"):
        np.testing.assert_array_equal(
            texture.sample(uv, np.zeros((2, 2)), filter=filter),
            point if filter != "nearest_mipmap_linear" else texture.sample(uv, filter="nearest"),
        )
        for rule in ("major", "area"):
            got = texture.sample(np.broadcast_to(uv, (3000, 2)), jacobians, filter=filter, lod_rule=rule)
            assert np.isfinite(got).all()
            assert got.min() >= image.min() - 1e-6
            assert got.max() <= image.max() + 1e-6
        for bad in (np.nan, np.inf):
            wrong = texture.sample(uv, np.array([[bad, 0], [0, 1]]), filter=filter)
            np.testing.assert_array_equal(wrong, coarsest)


def test_no_limit_of_anisotropy_ends() -> None:
    texture = mt.Texture(noise((64, 64)), "repeat")
    for jacobian in (
        [[1.0, 0.0], [0.0, 0.0]],
        [[1e30, 0.0], [0.0, 0.0]],
        [[1e6, 1e6], [1e-9, 0.0]],
        [[1.0, 0.0], [0.0, 1e-12]],
    ):
        got = texture.sample([0.5, 0.5], jacobian, filter="anisotropic", max_anisotropy=None)
        assert 0 <= got[0] <= 1


def test_a_line_of_no_width_is_still_filtered() -> None:
    """A fine checker under a footprint of 64 texels by 0: near the mean, not black or white."""
    checker = (np.indices((128, 128)).sum(0) % 2).astype(np.float64)
    texture = mt.Texture(checker, "repeat")
    for filter in ("anisotropic", "auto"):
        got = texture.sample([0.5 / 128, 0.5 / 128], [[0.5, 0.0], [0.0, 0.0]], filter=filter)
        assert abs(got[0] - 0.5) < 0.1


def test_a_ratio_of_one_is_trilinear() -> None:
    texture = mt.Texture(noise((64, 64, 3), "float32"), "repeat")
    uv = np.random.default_rng(5).random((100, 2))
    for size in (0.2, 1.0, 1.7, 4.0, 11.3):
        jacobian = np.array([[0, -size], [size, 0]]) / 64
        one = texture.sample(uv, jacobian, filter="anisotropic")
        np.testing.assert_array_equal(one, texture.sample(uv, jacobian, filter="trilinear"))


def test_probes_have_the_variance_of_the_footprint() -> None:
    """On a parabola a filter shows its variance: footprint minus probe, (s1^2 - s2^2)/12, within 2 %."""
    n = 4096
    x = np.arange(n) - n / 2 + 0.5
    texture = mt.Texture(np.broadcast_to(x**2, (64, n)), "clamp")
    uv = np.array([0.5, 0.5])
    for minor in (1.0, 2.0, 4.0):
        scale = np.array([[1 / n, 0], [0, 1 / 64]])
        own = texture.sample(uv, scale * minor, filter="trilinear")[0]
        for ratio in (1.5, 2.0, 2.5, 3.0, 4.0, 5.5, 8.0, 15.0, 16.0):
            got = texture.sample(uv, scale @ np.diag([minor * ratio, minor]), filter="anisotropic")[0]
            want = (ratio**2 - 1) * minor**2 / 12
            # Linear interpolation of a parabola rides f(1 - f) above it, wherever a probe stands: up to a
            # quarter of a texel squared, at most as much below the centre's own.
            ripple = minor**2 / 4
            assert abs(got - own - want) <= 0.02 * want + ripple, (minor, ratio)


def test_the_limit_of_anisotropy_is_continuous_and_monotone() -> None:
    """At the clamp the level follows major/limit: no jump, and blur across never shrinks."""
    texture = mt.Texture(noise((256, 256)), "repeat")
    uv = np.random.default_rng(6).random((400, 2))
    before = None
    for ratio in np.linspace(15.9, 16.1, 41):
        jacobian = np.diag([2 * ratio, 2]) / 256
        got = texture.sample(uv, jacobian, filter="anisotropic", max_anisotropy=16)
        if before is not None:
            assert np.abs(got - before).max() < 0.01
        before = got
    spread = [
        float(texture.sample(uv, np.diag([64, 64 / r]) / 256, filter="anisotropic", max_anisotropy=4).std())
        for r in (1, 2, 4, 8, 16)
    ]
    # Thinner footprints show more contrast until the limit, and the same from there on.
    assert spread[0] <= spread[1] <= spread[2]
    np.testing.assert_allclose(spread[2:], spread[2], rtol=1e-6)


@pytest.mark.parametrize("encoding", ["linear", "srgb"])
def test_constants_stay_constant(encoding: str) -> None:
    """Every u8 code, through every filter, wrap mode, level and footprint: exactly its own value."""
    jacobians = np.stack([np.eye(2) * s for s in (0.0, 0.1, 0.5, 3.0)] + [np.diag([0.9, 0.05])])
    uv = np.random.default_rng(0).uniform(-2, 3, (len(jacobians), 2))
    filters = [*MIP_FILTERS, "nearest", "bilinear", "anisotropic", "auto"]
    for code in range(256):
        image = np.full((5, 7, 1), code, np.uint8)
        mode = [*WRAPS[:5], ("repeat", "mirror")][code % 6]
        texture = mt.Texture(image, mode, encoding=encoding)
        want = texture.sample([0.5, 0.5], filter="nearest")
        exact = Brute(image, "clamp", 0.0, encoding).sample(np.array([[0.5, 0.5]]), "nearest")[0]
        np.testing.assert_allclose(want, exact, rtol=2.0**-23)
        for filter in filters:
            got = texture.sample(uv, jacobians, filter=filter)
            np.testing.assert_array_equal(
                got, np.broadcast_to(want, got.shape), err_msg=f"{filter} {mode} {code}"
            )
        for filter in ("bicubic", "mitchell"):
            got = texture.sample(uv, filter=filter)
            np.testing.assert_allclose(got, np.broadcast_to(want, got.shape), rtol=1e-6)
        for level in range(texture.num_levels):
            assert (texture.level(level) == code).all()


@pytest.mark.parametrize(("mode", "tiles"), [("repeat", 1), ("mirror", 2)])
def test_whole_periods_change_nothing(mode: str, tiles: int) -> None:
    rng = np.random.default_rng(7)
    texture = mt.Texture(noise((12, 20)), mode)
    uv = rng.random((300, 2))
    jacobian = rng.normal(0, 0.1, (300, 2, 2))
    for filter in ("bilinear", "bicubic", "mitchell", "trilinear", "anisotropic", "auto"):
        here = texture.sample(uv, jacobian, filter=filter)
        for k in ([1, 0], [0, -1], [-7, 12], [1000, -1000]):
            there = texture.sample(uv + np.multiply(k, tiles), jacobian, filter=filter)
            # u + 1000 keeps 2^-43 of u: 3e-12 texels of slope 3 in 20 texels.
            np.testing.assert_allclose(here, there, rtol=0, atol=2e-11)


def test_turning_the_pixel_frame_changes_nothing() -> None:
    """J and J R are the same piece of texture, seen by a turned pixel."""
    rng = np.random.default_rng(9)
    texture = mt.Texture(noise((40, 24)), "repeat")
    uv = rng.random((100, 2))
    jacobian = rng.normal(0, 0.1, (100, 2, 2))
    for filter in ("trilinear", "anisotropic", "linear_mipmap_nearest"):
        straight = texture.sample(uv, jacobian, filter=filter)
        for turn in (0.1, 0.7, math.pi / 2, 2.5):
            rotation = [[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]]
            turned = texture.sample(uv, jacobian @ rotation, filter=filter)
            np.testing.assert_allclose(straight, turned, rtol=0, atol=2e-6)


@pytest.mark.parametrize("size", [(w, h) for w in (1, 2, 3, 5, 8, 17, 67) for h in (1, 3, 8, 17)])
def test_levels_keep_mean_and_centre_of_mass(size: tuple[int, int]) -> None:
    width, height = size
    texture = mt.Texture(noise((height, width), seed=width * 100 + height))
    for index in range(texture.num_levels):
        level = texture.level(index)
        assert level.shape == (max(1, height >> index), max(1, width >> index))
        if index == 0:
            base = level
        np.testing.assert_allclose(level.mean(), base.mean(), rtol=1e-12)
        for axis in (0, 1):
            # A ramp stays a ramp about the same middle, so that no level is shifted against the others.
            # (At odd sizes it is a little flatter: area means of texels as squares, not of a line.)
            n = base.shape[axis]
            shape = (n, 1) if axis == 0 else (1, n)
            ramp = ((np.arange(n) + 0.5) / n).reshape(shape)
            made = mt.Texture(np.broadcast_to(ramp, base.shape)).level(index)
            flat = made[:, 0] if axis == 0 else made[0]
            np.testing.assert_allclose(flat + flat[::-1], 1, rtol=0, atol=1e-12)
            np.testing.assert_allclose(np.diff(flat, 2), 0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("filter", ["bilinear", "bicubic", "mitchell"])
@pytest.mark.parametrize("mode", [*WRAPS, "extend"])
def test_gradient_against_central_differences(filter: str, mode: str) -> None:
    """In five tiles of every wrap mode, away from the lines where a bilinear slope jumps."""
    rng = np.random.default_rng(10)
    width, height = 7, 5
    extra = 2 * (mode == "extend")
    texture = mt.Texture(noise((height + extra, width + extra, 3)), mode, [0.1, 0.5, 0.9])
    uv = rng.uniform(-2, 3, (400, 2))
    texel = uv * [width, height] - 0.5
    part = texel - np.floor(texel)
    uv = uv[((part > 0.01) & (part < 0.99)).all(-1)]
    got = texture.gradient(uv, filter=filter)
    step = 1e-5
    for axis in (0, 1):
        d = np.eye(2)[axis] * step
        ahead, behind = (texture.sample(uv + s * d, filter=filter) for s in (1, -1))
        # Third derivatives of a cubic: at most 12 a texel cubed by 7^3; step squared over 6 of it.
        np.testing.assert_allclose(got[..., axis], (ahead - behind) / (2 * step), rtol=0, atol=1e-6)


def test_gradient_of_straight_colour_is_the_quotient_rule() -> None:
    texture = mt.Texture(noise((6, 6, 4)) + 0.1, "repeat", alpha="straight")
    uv = np.random.default_rng(11).random((200, 2))
    part = uv * 6 - 0.5 - np.floor(uv * 6 - 0.5)
    uv = uv[((part > 0.01) & (part < 0.99)).all(-1)]
    got = texture.gradient(uv)
    for axis in (0, 1):
        d = np.eye(2)[axis] * 1e-5
        difference = (
            texture.sample(uv + d, filter="bilinear") - texture.sample(uv - d, filter="bilinear")
        ) / 2e-5
        np.testing.assert_allclose(got[..., axis], difference, rtol=1e-6, atol=1e-6)


def test_gradient_where_there_is_none() -> None:
    texture = mt.Texture(noise((4, 4)))
    assert not texture.gradient([[np.nan, 0.5], [np.inf, 0.1], [9.0, 9.0], [1e300, -1e300]]).any()
    with pytest.raises(ValueError, match="filter"):
        texture.gradient([0.5, 0.5], filter="nearest")
