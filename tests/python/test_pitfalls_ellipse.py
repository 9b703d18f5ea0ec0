"""What goes wrong with elliptical averages: thin ellipses, hard rims, eccentricity without limit."""

from __future__ import annotations

import numpy as np
import pytest

import multum as mt
from weights import impulses, turned, weights

SMALL = 24


@pytest.fixture(scope="module")
def small() -> mt.Texture:
    return mt.Texture(impulses(SMALL), "repeat")


@pytest.mark.parametrize("minor", [1e-4, 0.01, 0.5, 2.0])
def test_thin_ellipses_always_hold_a_texel(small: mt.Texture, minor: float) -> None:
    shift = (np.arange(8) + 0.5) / 8
    centres = 11.0 + np.stack(np.meshgrid(shift, shift), axis=-1)
    jacobian = np.broadcast_to(turned(27, 4.0, minor), (8, 8, 2, 2)) / SMALL
    got = weights(small, centres / SMALL, jacobian, filter="ewa", max_anisotropy=None)
    assert np.isfinite(got).all()
    assert got.min() >= 0
    np.testing.assert_allclose(got.sum(axis=(-2, -1)), 1, rtol=0, atol=1e-12)
    constant = mt.Texture(np.full((5, 7), 201, np.uint8), "repeat")
    values = constant.sample(centres / SMALL, jacobian, filter="ewa", max_anisotropy=None)
    assert (values == np.float32(201 / 255)).all()


def test_texels_come_in_at_the_rim_without_a_pop() -> None:
    """Cut off without being lowered to zero, the Gaussian's rim weighs exp(-2): a jump of 0.04 at this size."""
    image = np.random.default_rng(3).random((64, 64))
    texture = mt.Texture(image, "repeat")
    step = 1e-3
    place = np.stack([31.2 + np.arange(0, 2, step), np.full(2000, 30.7)], axis=-1) / 64
    for jacobian in (turned(0, 2.5, 2.5), turned(20, 8.0, 2.5)):
        got = texture.sample(place, np.broadcast_to(jacobian / 64, (2000, 2, 2)), filter="ewa")[:, 0]
        # Slope: sum |dw| / sum w <= 4 max(r exp(-2 r^2)) / semi-axis / mean weight < 4 / semi-axis.
        assert np.abs(np.diff(got)).max() <= 4 * step / 1.95
        # At the rim a weight has a kink of slope 4 exp(-2) / semi-axis, of a sum of 0.3 pi times both.
        assert np.abs(np.diff(got, 2)).max() <= 1e-4


def test_shears_are_limited_in_the_axes_of_the_ellipse() -> None:
    """Both columns nearly alike: equal lengths, yet a ratio of hundreds."""
    n = 40
    texture = mt.Texture(impulses(n), "repeat")
    jacobian = np.array([[8.0, 8.0], [5.0, 5.2]])
    major, minor = np.linalg.svd(jacobian, compute_uv=False)
    assert major / minor > 100
    got = weights(texture, np.array([0.5, 0.5]), jacobian / n, filter="ewa", max_anisotropy=8)
    y, x = np.mgrid[:n, :n] + 0.5 - n / 2
    covariance = np.array([[(got * a * b).sum() for a in (x, y)] for b in (x, y)])
    small, large = np.linalg.eigvalsh(covariance)
    # The weight's own variance on a unit disc stands for the reconstruction; the rest is that of the footprint.
    unit = 0.13608
    assert large - unit == pytest.approx(major**2 / 12, rel=0.03)
    assert small - unit == pytest.approx((major / 8) ** 2 / 12, rel=0.1)


def test_the_number_of_texels_is_bounded_for_any_footprint(small: mt.Texture) -> None:
    limit = 4
    random = np.random.default_rng(7)
    for _ in range(60):
        jacobian = turned(random.uniform(0, 180), random.uniform(0, 12), random.uniform(0, 1.9)) @ turned(
            random.uniform(0, 180), 1, 1
        )
        widest = np.linalg.svd(jacobian, compute_uv=False)
        if max(widest[1], widest[0] / limit) > 2:
            continue
        got = weights(small, random.random(2), jacobian / SMALL, filter="ewa", max_anisotropy=limit)
        assert np.count_nonzero(got) <= 8 * (4 * limit + 2)
