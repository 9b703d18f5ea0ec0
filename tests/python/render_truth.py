"""A ray caster in float64 for tests: every face against every ray, bilinear texels, no footprints.

It shares nothing with the renderer but the conventions: pixel centres at one half, v down, linear light.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def srgb_to_linear(x: Array) -> Array:
    return np.asarray(np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4))


def bilinear(texels: Array, uv: Array) -> Array:
    """Texels (H, W, C) of a repeating texture at uv (..., 2)."""
    h, w = texels.shape[:2]
    s, t = uv[..., 0] * w - 0.5, uv[..., 1] * h - 0.5
    i, j = np.floor(s).astype(int), np.floor(t).astype(int)
    a, b = (s - i)[..., None], (t - j)[..., None]
    rows = [(1 - a) * texels[k % h, i % w] + a * texels[k % h, (i + 1) % w] for k in (j, j + 1)]
    return np.asarray((1 - b) * rows[0] + b * rows[1])


@dataclass
class Hits:
    """Where rays meet the nearest face: its index or -1, and the weights of its corners."""

    face: NDArray[np.int64]
    weights: Array

    def blend(self, corners: Array) -> Array:
        """Attributes (F, 3, C) at the hits."""
        return np.asarray(np.einsum("...k,...kc->...c", self.weights, corners[self.face]))


def rays(eye: Array, target: Array, fov: float, size: tuple[int, int], offset: tuple[float, float]) -> Array:
    """Directions (H, W, 3) through one place of every pixel; y is up."""
    w, h = size
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross([0, 1, 0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    high = np.tan(np.radians(fov) / 2)
    x = ((np.arange(w) + offset[0]) * 2 / w - 1) * high * w / h
    y = (1 - (np.arange(h) + offset[1]) * 2 / h) * high
    return np.asarray(x[None, :, None] * right + y[:, None, None] * up - back)


def cast(eye: Array, directions: Array, corners: Array) -> Hits:
    """The nearest of the faces (F, 3, 3) along each ray: Moeller and Trumbore's equations."""
    face = np.full(directions.shape[:-1], -1)
    nearest = np.full(directions.shape[:-1], np.inf)
    weights = np.zeros((*directions.shape[:-1], 3))
    for k, (a, b, c) in enumerate(corners):
        e1, e2 = b - a, c - a
        p = np.cross(directions, e2)
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1 / (p @ e1)
            u = (p @ (eye - a)) * inverse
            q = np.cross(eye - a, e1)
            v = (directions @ q) * inverse
            t = (e2 @ q) * inverse
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < nearest)
        face[hit], nearest[hit] = k, t[hit]
        weights[hit] = np.stack([1 - u - v, u, v], -1)[hit]
    return Hits(face, weights)
