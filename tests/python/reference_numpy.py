"""Texture filters by brute force in doubles: written to be read, and sharing nothing with the library.

Positions are exact rationals, wrap modes are written-out sequences, weights are the textbook's formulas.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

WRAPS = ["clamp", "repeat", "mirror", "mirror_once", "mirror_101", "border", "extend"]
FULL_SCALE = {"uint8": 255.0, "uint16": 65535.0}
OUTSIDE = -1


def stored_index(wrap: str, i: int, n: int) -> int:
    """Where texel ``i`` of an axis of ``n`` stands in the stored row, or OUTSIDE; any whole ``i``."""
    forward = list(range(n))
    backward = forward[::-1]
    if wrap == "clamp":
        return min(max(i, 0), n - 1)
    if wrap == "repeat":
        return forward[i % n]
    if wrap == "mirror":
        return (forward + backward)[i % (2 * n)]
    if wrap == "mirror_once":
        return backward[max(i + n, 0)] if i < 0 else min(i, n - 1)
    if wrap == "mirror_101":
        sequence = forward + forward[1:-1][::-1]
        return sequence[i % len(sequence)]
    if wrap == "border":
        return i if 0 <= i < n else OUTSIDE
    if wrap == "extend":
        return min(max(i, -1), n) + 1
    raise AssertionError(wrap)


def place(coordinate: float, n: int) -> tuple[int, float]:
    """Whole and fractional part of ``coordinate * n - 1/2``, the fraction rounded once."""
    exact = Fraction(coordinate) * n - Fraction(1, 2)
    whole = math.floor(exact)
    return whole, float(exact - whole)


def cubic(b: float, c: float, x: float) -> float:
    """The kernel of Mitchell and Netravali at distance ``x``."""
    x = abs(x)
    if x < 1:
        return ((12 - 9 * b - 6 * c) * x**3 + (-18 + 12 * b + 6 * c) * x**2 + 6 - 2 * b) / 6
    if x < 2:
        return ((-b - 6 * c) * x**3 + (6 * b + 30 * c) * x**2 + (-12 * b - 48 * c) * x + 8 * b + 24 * c) / 6
    return 0.0


KERNELS: dict[str, Callable[[float], float]] = {
    "bilinear": lambda x: max(0.0, 1.0 - abs(x)),
    "bicubic": lambda x: cubic(0.0, 0.5, x),
    "mitchell": lambda x: cubic(1 / 3, 1 / 3, x),
}


def axis_taps(kernel: str, wrap: str, coordinates: Floats, n: int) -> tuple[Indices, Floats]:
    """Stored indices and weights, four a coordinate."""
    index = np.zeros((len(coordinates), 4), np.int64)
    weight = np.zeros((len(coordinates), 4))
    for row, coordinate in enumerate(coordinates):
        if not math.isfinite(coordinate):
            index[row], weight[row, 0] = OUTSIDE, 1.0
            continue
        if kernel == "nearest":
            index[row] = stored_index(wrap, math.floor(Fraction(float(coordinate)) * n), n)
            weight[row, 0] = 1.0
            continue
        whole, part = place(float(coordinate), n)
        for k in range(4):
            index[row, k] = stored_index(wrap, whole + k - 1, n)
            weight[row, k] = KERNELS[kernel](part - (k - 1))
    return index, weight


def srgb_to_linear(s: Floats) -> Floats:
    """IEC 61966-2-1."""
    return np.where(s <= 0.04045, s / 12.92, ((np.maximum(s, 0) + 0.055) / 1.055) ** 2.4)


def decoded(image: Array, encoding: str = "linear", alpha: str = "none") -> Floats:
    """What is averaged, as (H, W, C) doubles."""
    codes = image.astype(np.float64)
    codes = codes[:, :, None] if codes.ndim == 2 else codes
    full = FULL_SCALE.get(image.dtype.name)
    value = codes if full is None else codes / full
    channels = codes.shape[2]
    colour = channels - 1 if channels in (2, 4) else channels
    if encoding == "srgb":
        value[..., :colour] = srgb_to_linear(value[..., :colour])
    if encoding == "normal" and full is None:
        value[..., :3] = 2 * value[..., :3] - 1
    if encoding == "normal" and full is not None:
        zero = (full + 1) / 2
        value[..., :3] = np.maximum((codes[..., :3] - zero) / (zero - 1), -1)
    if alpha == "straight":
        value[..., :-1] *= value[..., -1:]
    return value


class Brute:
    """An image to sample by brute force; keywords as for ``multum.Texture``."""

    def __init__(
        self,
        image: Array,
        wrap: str | tuple[str, str] = "clamp",
        border: float | Sequence[float] = 0.0,
        encoding: str = "linear",
        alpha: str = "none",
    ) -> None:
        self.wrap = (wrap, wrap) if isinstance(wrap, str) else wrap
        self.value = decoded(image, encoding, alpha)
        self.straight = alpha == "straight"
        extra = [2 * (mode == "extend") for mode in self.wrap]
        self.width = self.value.shape[1] - extra[0]
        self.height = self.value.shape[0] - extra[1]
        self.border = np.broadcast_to(np.asarray(border, np.float64), self.value.shape[2:])

    def averages(self, uv: Array, kernel: str) -> Floats:
        """Weighted sums of decoded texels at (N, 2) places."""
        uv = np.asarray(uv, np.float64).copy()
        # One coordinate that is not finite is enough for the border colour.
        bad = ~np.isfinite(uv).all(-1)
        uv[bad] = 0.0
        (ix, wx), (iy, wy) = (
            axis_taps(kernel, mode, uv[:, axis], n)
            for axis, (mode, n) in enumerate(zip(self.wrap, (self.width, self.height), strict=True))
        )
        ix, iy = np.broadcast_arrays(ix[:, None, :], iy[:, :, None])
        texel = np.where((ix == OUTSIDE) | (iy == OUTSIDE), OUTSIDE, 0)[..., None]
        texel = np.where(texel == OUTSIDE, self.border, self.value[iy, ix])
        result: Floats = np.einsum("ny,nx,nyxc->nc", wy, wx, texel)
        result[bad] = self.border
        return result

    def finish(self, average: Floats) -> Floats:
        """Averages as results: straight colour is divided by alpha."""
        if self.straight:
            alpha = average[..., -1:]
            colour = np.divide(
                average[..., :-1], alpha, out=np.zeros_like(average[..., :-1]), where=alpha != 0
            )
            average = np.concatenate([colour, alpha], -1)
        return average

    def sample(self, uv: Array, kernel: str = "bilinear") -> Floats:
        """Results at (N, 2) places."""
        return self.finish(self.averages(uv, kernel))


def bilinear_grid(image: Floats, x: Floats, y: Floats, repeat: bool) -> Floats:
    """The bilinear reconstruction of one channel at pixel coordinates; outside: repeated, or 0. Fast."""
    height, width = image.shape
    i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    a, b = x - i, y - j
    total = np.zeros(np.broadcast(x, y).shape)
    for di, wx in ((0, 1 - a), (1, a)):
        for dj, wy in ((0, 1 - b), (1, b)):
            if repeat:
                total += wx * wy * image[(j + dj) % height, (i + di) % width]
            else:
                inside = (i + di >= 0) & (i + di < width) & (j + dj >= 0) & (j + dj < height)
                texel = image[np.clip(j + dj, 0, height - 1), np.clip(i + di, 0, width - 1)]
                total += wx * wy * np.where(inside, texel, 0.0)
    return total


def supersampled(
    image: Floats,
    mapping: Callable[[Floats, Floats], tuple[Floats, Floats]],
    shape: tuple[int, int],
    grid: int,
    repeat: bool = False,
) -> Floats:
    """The mean over each output pixel's square, by ``grid`` x ``grid`` places in it."""
    height, width = shape
    x, y = np.meshgrid(np.arange(width, dtype=np.float64), np.arange(height, dtype=np.float64))
    total = np.zeros(shape)
    steps = (np.arange(grid) + 0.5) / grid - 0.5
    for dy in steps:
        for dx in steps:
            total += bilinear_grid(image, *mapping(x + dx, y + dy), repeat)
    return total / grid**2
