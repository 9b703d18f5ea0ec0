"""Minified pictures against the dense f64 truth: rms error at most a third of plain remapping's.

The truth is the mean of the bilinear reconstruction over each output pixel's square.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from reference_numpy import supersampled

Array = NDArray[Any]
DATA = Path(os.environ.get("MULTUM_DATA", Path(__file__).parents[2] / ".." / "shared" / "data"))
Mapping = Callable[[Array, Array], tuple[Array, Array]]


def rms(a: Array, b: Array) -> float:
    return float(np.sqrt(np.mean((a.astype(np.float64) - b) ** 2)))


def matrix_mapping(matrix: Array) -> Mapping:
    def mapping(x: Array, y: Array) -> tuple[Array, Array]:
        w = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
        return (
            (matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]) / w,
            (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]) / w,
        )

    return mapping


def errors(
    image: Array, matrix: Array, shape: tuple[int, int], grid: int, repeat: bool
) -> tuple[float, float]:
    """Rms error of "auto" and of cv2.remap."""
    mapping = matrix_mapping(matrix)
    truth = supersampled(image.astype(np.float64), mapping, shape, grid, repeat)
    x, y = np.meshgrid(np.arange(shape[1], dtype=np.float64), np.arange(shape[0], dtype=np.float64))
    map_x, map_y = mapping(x, y)
    border = cv2.BORDER_WRAP if repeat else cv2.BORDER_CONSTANT
    theirs = cv2.remap(
        image, map_x.astype(np.float32), map_y.astype(np.float32), cv2.INTER_LINEAR, borderMode=border
    )
    ours = mt.warp(image, matrix, shape, filter="auto", wrap="repeat" if repeat else "border")
    from_map = mt.remap(image, map_x, map_y, wrap="repeat" if repeat else "border")
    assert rms(ours, from_map) < 2
    return rms(ours, truth), rms(theirs, truth)


def checkerboard() -> Array:
    cells: Array = (np.indices((256, 256)) // 4).sum(0).astype(np.uint8)
    return cells % 2 * 255


def photograph() -> Array:
    path = DATA / "images" / "astronaut.png"
    if path.is_file():
        grey: Array = mt.read_image(path)[..., :3].mean(-1)
        return np.round(grey).astype(np.uint8)
    print(f"no photograph in {DATA}: texture of sharp edges at many sizes instead")
    rng = np.random.default_rng(0)
    image = np.full((512, 512), 128, np.uint8)
    for _ in range(3000):
        x, y = (int(v) for v in rng.integers(0, 512, 2))
        r = int(rng.integers(1, 24))
        cv2.circle(image, (x, y), r, int(rng.integers(0, 256)), -1)
    return image


@pytest.mark.parametrize("scale", [2.7, 5.3, 11.0])
def test_minified_checkerboard(scale: float) -> None:
    matrix = np.array([[scale, 0.2, 3.1], [-0.3, scale, 2.2], [0, 0, 1.0]])
    ours, theirs = errors(checkerboard(), matrix, (48, 64), 24, True)
    assert ours <= theirs / 3, (ours, theirs)


def test_a_plane_to_the_horizon() -> None:
    """The camera stands over a tiled floor; rows from just below the horizon to the feet."""
    # (X, Z) = (x/y, 1/y) times a height: footprints from 1 to some 60 texels long.
    width, height = 128, 96
    matrix = np.array([[90.0, 0, -90.0 * width / 2], [0, 0, 5400.0], [0, 1.0, 8.0]])
    ours, theirs = errors(checkerboard(), matrix, (height, width), 32, True)
    assert ours <= theirs / 3, (ours, theirs)


def test_a_zone_plate_reduced_four_times() -> None:
    """Every frequency and direction: what plain remapping folds back is gone."""
    y, x = np.mgrid[-256:256, -256:256]
    image = np.round(127.5 + 127.5 * np.cos((x**2 + y**2) * (math.pi / 1024))).astype(np.uint8)
    matrix = np.array([[4.0, 0, 1.5], [0, 4.0, 1.5], [0, 0, 1.0]])
    ours, theirs = errors(image, matrix, (128, 128), 16, False)
    assert ours <= theirs / 3, (ours, theirs)


def test_more_anisotropy_is_never_worse() -> None:
    image = photograph()
    matrix = np.array([[6.0, 0, 10.0], [0, 0.75, 20.0], [0, 0, 1.0]])
    shape = (120, 76)
    truth = supersampled(image.astype(np.float64), matrix_mapping(matrix), shape, 24)
    found = [
        rms(mt.warp(image, matrix, shape, filter="anisotropic", max_anisotropy=n), truth)
        for n in (1, 2, 4, 8, 16)
    ]
    assert (np.diff(found) <= 0.02).all(), found
    assert found[-1] < found[0] / 2


@pytest.mark.parametrize("scale", [3.0, 4.6])
def test_a_photograph_turned_and_shrunk(scale: float) -> None:
    image = photograph()
    centre = image.shape[0] / 2
    c, s = math.cos(0.5) * scale, math.sin(0.5) * scale
    n = int(image.shape[0] / scale * 0.7)
    matrix = np.array([[c, -s, centre - (c - s) * n / 2], [s, c, centre - (s + c) * n / 2], [0, 0, 1.0]])
    ours, theirs = errors(image, matrix, (n, n), 16, False)
    assert ours <= theirs / 3, (ours, theirs)
