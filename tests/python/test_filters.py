"""The area filters through the Python front end."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt


def _texture(seed: int = 1) -> tuple[NDArray[np.uint8], mt.Texture]:
    image = np.random.default_rng(seed).integers(0, 256, (24, 32, 3), dtype=np.uint8)
    return image, mt.Texture(image, wrap="repeat")


def _supersampled(
    image: NDArray[np.uint8], uv: NDArray[Any], jacobian: NDArray[Any], n: int = 400
) -> NDArray[Any]:
    """The mean of the bilinear reconstruction over a fine grid of the pixel, by NumPy alone."""
    height, width = image.shape[:2]
    grid = (np.arange(n) + 0.5) / n - 0.5
    p, q = np.meshgrid(grid, grid)
    offset = np.stack([p, q], axis=-1) @ jacobian.T
    x = (uv[0] + offset[..., 0]) * width - 0.5
    y = (uv[1] + offset[..., 1]) * height - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    a, b = (x - i)[..., None], (y - j)[..., None]
    values = image / 255.0

    def at(di: int, dj: int) -> NDArray[Any]:
        return np.asarray(values[(j + dj) % height, (i + di) % width])

    rows = (1 - b) * ((1 - a) * at(0, 0) + a * at(1, 0)) + b * ((1 - a) * at(0, 1) + a * at(1, 1))
    return np.asarray(rows.mean(axis=(0, 1)))


@pytest.mark.parametrize(
    "jacobian", [[[0.1, 0.03], [-0.05, 0.2]], [[0.3, 0.0], [0.0, 0.01]], [[0.01, 0.0], [0.0, 0.02]]]
)
def test_exact_is_the_mean_over_the_footprint(jacobian: list[list[float]]) -> None:
    image, texture = _texture()
    uv, j = np.array([0.37, 0.81]), np.array(jacobian)
    truth = _supersampled(image, uv, j)
    # The midpoint rule on a grid of 400 x 400 is off by (extent/400)^2 of a kinked integrand.
    np.testing.assert_allclose(texture.sample(uv, j, filter="exact"), truth, atol=2e-5)
    np.testing.assert_allclose(texture.sample(uv, j, filter="auto", tolerance=1e-4), truth, atol=1e-4)


def test_seeds_tell_samples_apart() -> None:
    _, texture = _texture()
    uv = np.full((1000, 2), 0.4)
    jacobian = np.eye(2) * 0.3
    first = texture.sample(uv, jacobian, filter="stochastic", seed=1)
    assert np.array_equal(first, texture.sample(uv, jacobian, filter="stochastic", seed=1, threads=2))
    assert not np.array_equal(first, texture.sample(uv, jacobian, filter="stochastic", seed=2))
    truth = texture.sample(uv[0], jacobian, filter="exact")
    assert np.all(np.abs(first.mean(axis=0) - truth) < 5 * first.std(axis=0) / np.sqrt(1000))


def test_a_table_is_made_once_and_counted() -> None:
    _, texture = _texture()
    before = texture.nbytes
    whole = texture.sample([0.5, 0.5], np.eye(2), filter="sat")
    table = texture.nbytes - before
    assert table == 25 * 33 * 3 * 4
    texture.sample([0.5, 0.5], np.eye(2), filter="sat")
    assert texture.nbytes == before + table
    np.testing.assert_allclose(whole, texture.sample([0.5, 0.5], np.eye(2), filter="exact"), atol=1e-6)
