"""The pictures that ship with the package, and those that are made of them."""

from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._files import read_image
from .._warp import resize
from .figure import Codes, colour


def photograph(name: str, scale: float = 1.0) -> NDArray[Any]:
    """One of the shipped pictures, (H, W) or (H, W, 3) ``uint8``, at a share of its size."""
    with resources.as_file(resources.files("multum") / "data" / f"{name}.jpg") as path:
        image = read_image(path)
    if scale == 1.0:
        return image
    height, width = (max(8, round(side * scale)) for side in image.shape[:2])
    return resize(image, (height, width), encoding="srgb")


def floor_tiles(side: int) -> Codes:
    """Four tiles with light joints, a texture that repeats without a seam: (2 side, 2 side, 3)."""
    stone = photograph("gravel")[:side, :side].astype(np.float64) / 255.0
    brick = photograph("brick")[120 : 120 + side, 200 : 200 + side].astype(np.float64) / 255.0
    light = np.array([226.0, 212.0, 186.0]) * (0.62 + 0.5 * stone[..., None])
    dark = np.array([150.0, 62.0, 44.0]) * (0.45 + 0.9 * brick[..., None])
    floor = np.concatenate(
        [np.concatenate([light, dark], 1), np.concatenate([dark[:, ::-1], light[::-1]], 1)]
    )
    joint = max(1, side // 32)
    line = (np.arange(2 * side) + joint // 2) % side < joint
    floor[line] = floor[:, line] = 238.0
    return colour(np.clip(floor, 0, 255))
