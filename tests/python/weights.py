"""The weights that filters give to texels, seen from outside: each texel is 1 in a channel of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import multum as mt

Array = NDArray[Any]


def impulses(n: int) -> Array:
    """(n, n, n * n): channel k is 1 at texel k."""
    return np.eye(n * n).reshape(n, n, n * n)


def weights(texture: mt.Texture, uv: Array, jacobian: Array, **options: Any) -> Array:
    """Weights (..., n, n) of the texels of a texture made of `impulses`."""
    values = texture.sample(uv, jacobian, **options)
    return values.reshape(*values.shape[:-1], texture.height, texture.width)


def turned(degrees: float, major: float, minor: float) -> Array:
    """A footprint in texels with its major axis at an angle."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s], [s, c]]) @ np.diag([major, minor])
