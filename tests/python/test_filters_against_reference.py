"""Every filter against the f64 integral, with the bound that theory gives each."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from multum import reference
from weights import impulses, turned, weights

Array = NDArray[Any]
WRAPS: list[reference.Wrap] = ["clamp", "repeat", "mirror", "mirror_once", "mirror_101", "border"]
SIDE = 20
FOOTPRINTS = {
    "identity": np.eye(2),
    "upright": np.diag([3.0, 5.0]),
    "turned square": turned(40, 4.0, 4.0),
    "turned": turned(65, 7.0, 2.5),
    "sheared": np.array([[4.0, 3.0], [0.5, 3.0]]),
    "mirrored": np.array([[0.0, 4.0], [6.0, 1.0]]),
}


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("filter", ["nearest", "bilinear", "bicubic"])
def test_interpolation_is_the_reconstruction_at_the_point(filter: Any, wrap: reference.Wrap) -> None:
    image = np.random.default_rng(1).random((7, 11, 2))
    uv = np.random.default_rng(2).uniform(-2, 3, (300, 2))
    right = reference.sample(image, uv, wrap=wrap, border=0.4, reconstruction=filter, pixel_filter="point")
    got = mt.Texture(image, wrap, 0.4).sample(uv, np.eye(2), filter=filter)
    # Doubles throughout; a bicubic slope is at most 2 a texel.
    assert reference.max_error(got, right) <= 1e-12


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("shape", FOOTPRINTS)
def test_exact_is_the_integral(shape: str, wrap: reference.Wrap) -> None:
    image = np.random.default_rng(3).random((9, 13, 3))
    uv = np.random.default_rng(4).uniform(-0.5, 1.5, (60, 2))
    jacobian = FOOTPRINTS[shape] / [[13], [9]]
    right = reference.sample(image, uv, jacobian, wrap=wrap, border=0.4)
    got = mt.Texture(image, wrap, 0.4).sample(uv, np.broadcast_to(jacobian, (60, 2, 2)), filter="exact")
    assert reference.max_error(got, right) <= 1e-10


@pytest.fixture(scope="module")
def impulse() -> tuple[Array, mt.Texture]:
    image = impulses(SIDE)
    return image, mt.Texture(image, "repeat")


# "auto" is not among them: what it does depends on the texture.
LINEAR = ["trilinear", "anisotropic", "ewa", "sat", "area", "exact"]


@pytest.mark.parametrize("filter", LINEAR)
@pytest.mark.parametrize("shape", FOOTPRINTS)
def test_no_picture_is_worse_than_the_weights_allow(
    impulse: tuple[Array, mt.Texture], shape: str, filter: str
) -> None:
    """Weights are shares; half the sum of what they are off, times the range, bounds the error of any picture."""
    image, texture = impulse
    jacobian = FOOTPRINTS[shape] / SIDE
    for uv in (np.array([0.5, 0.5]), np.array([0.512, 0.537]), np.array([0.02, 0.97])):
        got = weights(texture, uv, jacobian, filter=filter)
        right = reference.sample(image, uv, jacobian, wrap="repeat").reshape(SIDE, SIDE)
        assert got.min() >= -1e-12
        assert got.sum() == pytest.approx(1, abs=1e-12)
        bound = 0.5 * np.abs(got - right).sum()
        assert bound <= 1
        for seed in range(3):
            picture = np.random.default_rng(seed).random((SIDE, SIDE))
            value = mt.Texture(picture, "repeat").sample(uv, jacobian, filter=filter)[0]
            truth = reference.sample(picture, uv, jacobian, wrap="repeat")[0]
            assert abs(value - truth) <= bound * np.ptp(picture) + 1e-12
            assert value == pytest.approx((got * picture).sum(), abs=1e-12)


@pytest.mark.parametrize("shape", [name for name in FOOTPRINTS if name != "identity"])
def test_area_weights_are_off_at_the_rim_only(impulse: tuple[Array, mt.Texture], shape: str) -> None:
    """A soft parallelogram errs along its perimeter P: E <= P / 4 A of all weight, in texels of area A."""
    _, texture = impulse
    footprint = FOOTPRINTS[shape]
    image = impulses(SIDE)
    perimeter = 2 * np.linalg.norm(footprint, axis=0).sum()
    area = abs(np.linalg.det(footprint))
    for uv in (np.array([0.5, 0.5]), np.array([0.512, 0.537])):
        got = weights(texture, uv, footprint / SIDE, filter="area")
        right = reference.sample(image, uv, footprint / SIDE, wrap="repeat").reshape(SIDE, SIDE)
        assert 0.5 * np.abs(got - right).sum() <= 0.25 * perimeter / area


@pytest.mark.parametrize("filter", LINEAR)
def test_averages_lie_around_the_centre(impulse: tuple[Array, mt.Texture], filter: str) -> None:
    """In the middle of four texels, or of sixteen, nothing but the footprint tells left from right."""
    _, texture = impulse
    y, x = np.mgrid[:SIDE, :SIDE] + 0.5 - SIDE / 2
    for footprint in FOOTPRINTS.values():
        got = weights(texture, np.array([0.5, 0.5]), footprint / SIDE, filter=filter)
        assert abs((got * x).sum()) <= 1e-9
        assert abs((got * y).sum()) <= 1e-9


@pytest.mark.parametrize("shape", FOOTPRINTS)
def test_many_random_texels_are_the_integral(shape: str) -> None:
    image = np.random.default_rng(5).random((SIDE, SIDE))
    jacobian = FOOTPRINTS[shape] / SIDE
    uv = np.array([0.41, 0.63])
    n = 20000
    texture = mt.Texture(image, "repeat")
    values = texture.sample(
        np.broadcast_to(uv, (n, 2)), np.broadcast_to(jacobian, (n, 2, 2)), filter="stochastic", seed=11
    )[:, 0]
    truth = reference.sample(image, uv, jacobian, wrap="repeat")[0]
    # Five standard errors: one seed in two million is further off.
    assert abs(values.mean() - truth) <= 5 * values.std() / np.sqrt(n)


@pytest.mark.parametrize("tolerance", [0.1, 1 / 64, 1 / 1024, 1 / 65535])
@pytest.mark.parametrize("wrap", ["repeat", "clamp", "mirror", "border"])
def test_a_tolerance_is_kept_on_every_footprint(tolerance: float, wrap: reference.Wrap) -> None:
    random = np.random.default_rng(6)
    for dtype, image in (
        ("float32", random.random((33, 29), np.float32)),
        ("uint8", (random.integers(0, 2, (33, 29)) * 255).astype(np.uint8)),
    ):
        uv = random.uniform(-0.5, 1.5, (150, 2))
        jacobian = np.stack(
            [
                turned(random.uniform(0, 180), 2 ** random.uniform(-1, 4.5), 2 ** random.uniform(-2, 3))
                @ turned(random.uniform(0, 180), 1, 1)
                for _ in range(150)
            ]
        ) / np.array([[29], [33]])
        got = mt.Texture(image, wrap, 0.5).sample(uv, jacobian, tolerance=tolerance)
        right = reference.sample(image, uv, jacobian, wrap=wrap, border=0.5)
        worst = np.abs(got - right).max()
        assert worst <= tolerance, (dtype, worst)
