"""What tests of pictures draw: a square, noise, and the folder of real models."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import multum as mt

DATA = Path(os.environ.get("MULTUM_DATA", Path(__file__).parents[3] / "shared" / "data"))
SQUARE = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]], np.float32)
FACES = [[0, 3, 2], [0, 2, 1]]
UV = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
WHITE = mt.Material(unlit=True)


def square(**keywords: Any) -> mt.Mesh:
    """A square of side 2 that faces +z."""
    return mt.Mesh.build(SQUARE, FACES, uv=UV, **keywords)


def close(mesh: mt.Mesh, size: tuple[int, int] = (16, 16), **keywords: Any) -> NDArray[np.float32]:
    """Linear colours of a scene that fills the picture: the square's sides are the picture's."""
    camera = mt.Camera((0, 0, 1), fov=90)
    return mt.render(mt.Scene(mesh), camera, size, output="linear", **keywords)


def noise(shape: tuple[int, ...], seed: int = 0) -> NDArray[np.uint8]:
    return np.random.default_rng(seed).integers(0, 256, shape, np.uint8)
