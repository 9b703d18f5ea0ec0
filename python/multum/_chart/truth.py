"""The truth of a view at some of its pixels, from the f64 integral of `multum.reference`."""

import numpy as np
from numpy.typing import NDArray

from .. import reference
from .scenes import Floats, View

BLOCK = 8


def corners(size: int, across: int, seed: int = 1) -> NDArray[np.int64]:
    """Places (N, 2) of blocks of `BLOCK` squared pixels: one at random in each of ``across`` squared parts."""
    random = np.random.default_rng(seed)
    part = size / across
    room = max(part - BLOCK, 0.0)
    jitter = random.random((across, across, 2)) * room
    grid = np.stack(np.meshgrid(np.arange(across), np.arange(across)), axis=-1) * part
    return np.clip(np.floor(grid + jitter), 0, size - BLOCK).astype(np.int64).reshape(-1, 2)


def block(
    view: View, image: NDArray[np.uint8], left: int, top: int, side: int = BLOCK, tol: float = 1e-5
) -> Floats:
    """The integral (side, side, C) at the pixels from (left, top) on, in codes of 255."""
    if view.matrix is not None:
        moved = view.matrix @ np.array([[1, 0, left], [0, 1, top], [0, 0, 1]])
        values = reference.warp(image, moved, (side, side), wrap="repeat", tol=tol)
    else:
        offset = np.array([left, top], np.float64)
        values = reference.warp(
            image, lambda xy: view.places(xy + offset), (side, side), wrap="repeat", tol=tol
        )
    return 255.0 * values


def blocks(view: View, image: NDArray[np.uint8], places: NDArray[np.int64], tol: float = 1e-5) -> Floats:
    """The integrals (N, BLOCK, BLOCK, C) of all blocks."""
    return np.stack([block(view, image, int(x), int(y), tol=tol) for x, y in places])


def cut(picture: NDArray[np.float64], places: NDArray[np.int64]) -> Floats:
    """The same pixels of a picture of the whole view."""
    return np.stack([picture[y : y + BLOCK, x : x + BLOCK] for x, y in places])
