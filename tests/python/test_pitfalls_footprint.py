"""What goes wrong between a Jacobian and the texels that it asks for."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from weights import turned

Array = NDArray[Any]


def noise(*shape: int, seed: int = 1) -> Array:
    return np.random.default_rng(seed).random(shape)


def test_half_way_between_two_levels_both_weigh_half() -> None:
    texture = mt.Texture(noise(64, 64), "repeat")
    uv = np.random.default_rng(2).random((40, 2))
    for k in range(6):
        fine, coarse = (texture.sample(uv, lod=float(level), filter="trilinear") for level in (k, k + 1))
        between = texture.sample(uv, lod=k + 0.5, filter="trilinear")
        np.testing.assert_allclose(between, (fine + coarse) / 2, rtol=0, atol=1e-15)
        # The same from the footprint: a width of sqrt(2) texels is half a level, not 0.41 of one.
        square = np.eye(2) * 2.0 ** (k + 0.5) / 64
        made = texture.sample(uv, square, filter="trilinear")
        # log2 in singles is good to 1e-6 of a level, and a level apart values differ by at most 1.
        np.testing.assert_allclose(made, between, rtol=0, atol=2e-6)


@pytest.mark.parametrize(
    ("filter", "inside", "blend"),
    [
        ("nearest_mipmap_nearest", "nearest", False),
        ("linear_mipmap_nearest", "bilinear", False),
        ("nearest_mipmap_linear", "nearest", True),
        ("trilinear", "bilinear", True),
    ],
)
def test_first_bias_then_the_limits_then_the_choice_of_level(filter: str, inside: str, blend: bool) -> None:
    texture = mt.Texture(noise(32, 32), "repeat")
    last = texture.num_levels - 1
    levels = [mt.Texture(texture.level(i), "repeat") for i in range(last + 1)]
    uv = np.random.default_rng(3).random((30, 2))
    alone = [level.sample(uv, filter=inside) for level in levels]
    for lod in (-3.0, -0.25, 0.0, 0.25, 1.75, 4.5, 9.0):
        for bias in (-2.0, -0.5, 0.0, 0.75, 3.0, 20.0):
            want = min(max(lod + bias, 0.0), float(last))
            low = int(want)
            if blend:
                part = want - low
                right = (1 - part) * alone[low] + part * alone[min(low + 1, last)]
            else:
                right = alone[max(0, int(np.ceil(want + 0.5)) - 1)]
            for extent in ({"lod": lod}, {"jacobian": np.eye(2) * 2.0**lod / 32}):
                got = texture.sample(uv, filter=filter, lod_bias=bias, **extent)
                np.testing.assert_allclose(got, right, rtol=0, atol=2e-6, err_msg=f"{lod} {bias} {extent}")


_HOSTILE = """
import hashlib, itertools, sys
import numpy as np
import multum as mt
entries = [0.0, np.inf, -np.inf, np.nan, 1e30, -1e30, 1e-30, 0.02]
rows = np.array(list(itertools.product(entries, repeat=4))).reshape(-1, 2, 2)[::7]
uv = np.broadcast_to([0.3, 0.6], (len(rows), 2))
for dtype in (np.uint8, np.float32):
    image = (np.random.default_rng(0).random((16, 24, 3)) * 255).astype(dtype)
    texture = mt.Texture(image, wrap="mirror")
    for name in sys.argv[1:]:
        value = texture.sample(uv, rows, filter=name)
        assert np.isfinite(value).all(), name
        assert value.min() >= image.min() / 255 - 1e-5 or name in ("bicubic", "mitchell"), name
        print(name, dtype.__name__, hashlib.sha256(value.tobytes()).hexdigest())
"""


def test_footprints_that_are_no_numbers_give_the_same_bytes_on_every_instruction_set() -> None:
    filters = [
        "nearest",
        "bilinear",
        "trilinear",
        "anisotropic",
        "ewa",
        "sat",
        "area",
        "exact",
        "stochastic",
        "auto",
    ]
    told = []
    for words in ("scalar", "sse2", "avx2", "avx512"):
        environment = {**os.environ, "MULTUM_SIMD": words}
        command = [sys.executable, "-c", _HOSTILE, *filters]
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
        assert done.returncode == 0, done.stderr
        told.append(done.stdout)
    assert len(told[0].splitlines()) == 2 * len(filters)
    assert len({hashlib.sha256(t.encode()).hexdigest() for t in told}) == 1


@pytest.mark.parametrize("ratio", [2, 3, 5.5, 8, 11, 16])
def test_waves_along_the_major_axis_fade_as_under_the_integral(ratio: float) -> None:
    """Too few probes, or probes too close, leave waves standing; a level too coarse flattens them."""
    n, minor = 256, 2.0
    x = np.arange(n) + 0.5
    for cycles in (2, 4, 8):
        wave = np.broadcast_to(np.cos(2 * np.pi * cycles * x / n), (n, n))
        texture = mt.Texture(wave, "repeat")
        jacobian = np.diag([minor * ratio, minor]) / n
        crest = np.array([0.5 / n + np.arange(8) / 8 / cycles, np.full(8, 0.5)]).T
        got = texture.sample(crest, jacobian, filter="anisotropic")
        right = mt.reference.sample(wave, crest, jacobian, wrap="repeat")
        # Variance of the truth: L^2/12 of the box and 1/6 of the tent between texels. Of the probes: that of the
        # line, (L^2 - w^2)/12, (w^2 - 1)/12 of the level's texels, and w^2 f (1 - f) between those, at most w^2/4
        # where all probes fall alike. A wave feels half the difference times its wave number squared; the rest is
        # of fourth order.
        surplus = minor**2 / 4 - 1 / 12 - 1 / 6
        bound = 0.5 * surplus * (2 * np.pi * cycles / n) ** 2
        assert np.abs(got - right).max() <= 1.05 * bound + 2e-4, (ratio, cycles)


BOUNDS = {
    # Root mean square error on white noise over [0, 1], for ratios of 1, 4, 16 and 64 to a minor axis of 2 texels.
    "trilinear": (0.070, 0.065, 0.036, 0.017),
    "anisotropic": (0.070, 0.034, 0.016, 0.015),
    "ewa": (0.010, 0.016, 0.011, 0.014),
    "area": (0.001, 0.001, 0.001, 0.001),
}


@pytest.mark.parametrize("filter", BOUNDS)
def test_errors_for_every_ratio_and_angle_stay_below_what_they_were(filter: str) -> None:
    n = 256
    image = noise(n, n, seed=9)
    texture = mt.Texture(image, "repeat")
    uv = np.random.default_rng(5).random((32, 4, 2))
    for ratio, bound in zip((1, 4, 16, 64), BOUNDS[filter], strict=True):
        jacobian = np.stack([turned(a, 2.0 * ratio, 2.0) for a in np.arange(32) * 180 / 32])[:, None] / n
        jacobian = np.broadcast_to(jacobian, (32, 4, 2, 2))
        right = mt.reference.sample(image, uv, jacobian, wrap="repeat")
        got = texture.sample(uv, jacobian, filter=filter)
        assert mt.reference.rms(got, right) <= bound, ratio


@pytest.mark.parametrize("filter", ["trilinear", "anisotropic", "ewa", "sat", "area", "exact", "auto"])
def test_footprints_wider_than_the_texture_see_its_mean(filter: str) -> None:
    """Texels under many turns of a repeated picture count alike, and the call ends."""
    image = noise(24, 17)
    for wrap in ("repeat", "clamp", "mirror"):
        texture = mt.Texture(image, wrap)
        uv = np.random.default_rng(1).random((20, 2))
        for jacobian in (np.eye(2) * 10, turned(33, 14.0, 10.0)):
            got = texture.sample(uv, jacobian, filter=filter)
            assert image.min() <= got.min()
            assert got.max() <= image.max()
            if wrap == "repeat":
                np.testing.assert_allclose(got, image.mean(), rtol=0.01)
