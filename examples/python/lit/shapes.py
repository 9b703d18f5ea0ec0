"""Shapes and pictures of the examples."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

import multum as mt
from multum.demo.pictures import photograph

Array = NDArray[Any]
FACES = [[0, 3, 2], [0, 2, 1]]
CORNERS = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]], np.float32)
UV = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
LAMP = mt.light.Directional((0.6, -0.7, -1.0), 0.9)
LIGHTS = [LAMP, mt.light.Ambient(0.12)]


def ball(rows: int = 48, tiles: tuple[float, float] = (2, 1), **keywords: Any) -> mt.Mesh:
    """A sphere of radius 1 around the origin, its seam at the back."""
    v, u = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, 2 * rows + 1))
    theta, phi = np.pi * v, 2 * np.pi * (u - 0.5)
    n = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], -1).reshape(-1, 3)
    first = (np.arange(2 * rows)[:, None] * (rows + 1) + np.arange(rows)).reshape(-1, 1)
    faces = np.concatenate([first + np.array(k) for k in ([0, 1, rows + 2], [0, rows + 2, rows + 1])])
    uv = np.stack([u, v], -1).reshape(-1, 2) * tiles
    return mt.Mesh.build(n, faces, normals=n, uv=uv, **keywords)


def square(place: Any = (0, 0, 0), scale: float = 1.0, tiles: float = 1.0, **keywords: Any) -> mt.Mesh:
    """An upright square of side 2 ``scale`` that faces +z."""
    return mt.Mesh.build(CORNERS * scale + np.float32(place), FACES, uv=UV * tiles, **keywords)


def floor(scale: float = 4.0, tiles: float = 4.0, **keywords: Any) -> mt.Mesh:
    """A level square at y = -1."""
    points = CORNERS[:, [0, 2, 1]] * np.float32([scale, 1, -scale]) - np.float32([0, 1, 0])
    return mt.Mesh.build(points, FACES, uv=UV * tiles, **keywords)


def grey(name: str) -> Array:
    """A photograph's brightness, one channel, from dark to light."""
    image = photograph(name).astype(np.float64)
    image = image if image.ndim == 2 else image.mean(-1)
    low, high = np.percentile(image, [1, 99])
    return (np.clip((image - low) / (high - low), 0, 1) * 255).astype(np.uint8)


def fields(dark: int, light: int, count: int = 12) -> NDArray[np.uint8]:
    """Squares of two codes, (128, 128)."""
    x = np.arange(128) * count // 128
    return np.where((x[:, None] + x) % 2 == 0, dark, light).astype(np.uint8)


def bumps(side: int = 256, count: int = 8) -> NDArray[np.float32]:
    """Rounded studs in a square grid: a height map from 0 to 1 that repeats."""
    x = (np.arange(side) + 0.5) / side * count % 1 - 0.5
    r = np.hypot(x[:, None], x[None])
    return np.sqrt(np.clip(1 - (r / 0.36) ** 2, 0, 1)).astype(np.float32)


def normals_of(height: NDArray[np.float32], scale: float) -> NDArray[np.uint8]:
    """The tangent-space normal map of a height map that repeats; ``scale`` is in sides of the map."""
    du = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) * 0.5 * height.shape[1]
    dv = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) * 0.5 * height.shape[0]
    # y of the map runs up, v runs down.
    n = np.stack([-scale * du, scale * dv, np.ones_like(du)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return np.floor((n * 0.5 + 0.5) * 255 + 0.5).astype(np.uint8)


def puff(seed: int, side: int = 128) -> NDArray[np.uint8]:
    """A cloud's alpha, one channel."""
    y, x = np.mgrid[-1 : 1 : side * 1j, -1 : 1 : side * 1j]  # type: ignore[misc]
    rng = np.random.default_rng(seed)
    alpha = np.zeros((side, side))
    for _ in range(26):
        cx, cy = rng.normal(0, [0.32, 0.16])
        alpha += 0.5 * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / 0.03)
    return (np.clip(alpha * (1 - np.hypot(x, y)).clip(0, 0.3) / 0.3, 0, 1) * 255).astype(np.uint8)


def tree(side: int = 256) -> NDArray[np.uint8]:
    """A tree before nothing, RGBA."""
    y, x = np.mgrid[0 : 1 : side * 1j, -0.5 : 0.5 : side * 1j]  # type: ignore[misc]
    rng = np.random.default_rng(4)
    picture = np.zeros((side, side, 4))
    trunk = (np.abs(x) < 0.03 + 0.03 * y) & (y > 0.5)
    picture[trunk] = [0.35, 0.22, 0.12, 1]
    for _ in range(700):
        angle, r = rng.uniform(0, 2 * np.pi), np.sqrt(rng.uniform())
        cx, cy = 0.4 * r * np.cos(angle), 0.37 + 0.33 * r * np.sin(angle)
        leaf = (x - cx) ** 2 / 0.0004 + (y - cy) ** 2 / 0.0002 < 1
        picture[leaf] = [0.15 + 0.2 * rng.uniform(), 0.35 + 0.35 * rng.uniform(), 0.1, 1]
    # Colour runs on under the alpha, as in any cut-out that is to be filtered straight.
    return (picture * 255).astype(np.uint8)


def label(side: int = 256) -> NDArray[np.uint8]:
    """A round label with a star, clear around it, RGBA."""
    y, x = np.mgrid[-1 : 1 : side * 1j, -1 : 1 : side * 1j]  # type: ignore[misc]
    r, angle = np.hypot(x, y), np.arctan2(x, -y)
    star = r < 0.62 * np.cos(np.pi / 5) / np.cos((angle * 5 % (2 * np.pi) - np.pi) / 5 * 1.9)
    picture = np.zeros((side, side, 4))
    picture[r < 0.95] = [0.85, 0.1, 0.1, 1]
    picture[r < 0.8] = [0.96, 0.9, 0.75, 1]
    picture[star & (r < 0.8)] = [0.1, 0.2, 0.5, 1]
    return (picture * 255).astype(np.uint8)


def sky(rows: int = 128) -> NDArray[np.float32]:
    """A panorama in linear light: ground, horizon, and a low sun."""
    v, u = (np.arange(rows) + 0.5) / rows, (np.arange(2 * rows) + 0.5) / (2 * rows)
    theta, phi = np.pi * v[:, None], 2 * np.pi * (u[None] - 0.5)
    up = np.cos(theta) + 0 * phi
    blue = np.stack([0.25 + 0.6 * (1 - up), 0.45 + 0.45 * (1 - up), 0.9 + 0.05 * (1 - up)], -1)
    tiles = (np.floor(phi * 6 / np.pi) + np.floor(1 / np.clip(-up, 0.05, 1))) % 2
    ground = (0.08 + 0.25 * tiles)[..., None] * np.array([1.0, 0.9, 0.75])
    light = np.where(up[..., None] > 0, blue, ground)
    sun = np.stack([np.sin(theta) * np.sin(phi), up, -np.sin(theta) * np.cos(phi)], -1) @ (
        np.array([-0.6, 0.5, 0.62]) / np.linalg.norm([0.6, 0.5, 0.62])
    )
    return (light + 30 * (sun > 0.985)[..., None]).astype(np.float32)
