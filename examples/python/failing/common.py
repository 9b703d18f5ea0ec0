"""What a failure consists of, and what several of them need."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import multum as mt

Array = NDArray[Any]


@dataclass
class Failure:
    """A method that fails, what is wrong with it, and what is right."""

    title: str
    text: str
    quantity: str
    wrong: float
    right: float
    panels: list[tuple[str, Array]]


def checker(n: int, cell: int) -> Array:
    """Black and white squares."""
    return np.uint8(255) * ((np.indices((n, n)) // cell).sum(0) % 2).astype(np.uint8)


def rings(n: int) -> Array:
    """Circles that get finer outwards, up to two texels a wave at the corners."""
    y, x = np.mgrid[:n, :n] - (n - 1) / 2
    return np.rint(127.5 + 127.5 * np.cos(np.pi * (x**2 + y**2) / (1.42 * n))).astype(np.uint8)


def turned(degrees: float, major: float, minor: float) -> Array:
    """A matrix with these singular values."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s], [s, c]]) @ np.diag([major, minor])


def about_centre(linear: Array, view: tuple[int, int], n: int) -> Array:
    """A 3x3 matrix that shows the middle of a picture in the middle of a view."""
    middle = (n - 1) / 2 - linear @ [(view[1] - 1) / 2, (view[0] - 1) / 2]
    return np.vstack([np.column_stack([linear, middle]), [0, 0, 1]])


def ground(rows: int, columns: int, first: float) -> Array:
    """A plane whose horizon is ``first`` pixels above the first row; tiles of 128 texels."""
    near = rows + first
    return np.array([[near, 0, -0.5 * columns * near], [0, 0, 1.4 * near**2], [0, 1, first]])


def warped(
    image: Array, matrix: Array, shape: tuple[int, int], names: list[tuple[str, dict[str, Any]]]
) -> Any:
    """The truth, and what each filter makes."""
    truth = 255 * mt.reference.warp(image, matrix, shape, wrap="repeat", tol=1e-3)
    made = [(name, mt.warp(image, matrix, shape, wrap="repeat", **options)) for name, options in names]
    return truth, made


def codes_of(picture: Array) -> Array:
    """Codes of 8 bits of a picture in units of 255."""
    return np.clip(np.rint(np.asarray(picture, float)), 0, 255).astype(np.uint8)
