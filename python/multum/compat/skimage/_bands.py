"""Separable resampling: every axis has its own banded matrix, and the compiled part multiplies.

A Gaussian followed by linear interpolation is one such matrix, so anti-aliased reductions read the image once and
never hold the smoothed one.
"""

import math
from collections.abc import Callable, Mapping
from functools import lru_cache, wraps
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ... import _multum
from ._images import EVERYTHING, Array, Floats, plain


class Band(NamedTuple):
    """Row j of the matrix: ``weights[j]`` at ``first[j]`` and the pixels after it."""

    first: NDArray[np.int64]
    weights: NDArray[np.float64]


def remembered(make: Callable[..., Band]) -> Callable[..., Band]:
    """Keeps the last matrices of short axes, by their arguments: making one takes longer than its use."""
    kept = lru_cache(maxsize=64)(make)

    @wraps(make)
    def band(size: int, count: int, *rest: Any) -> Band:
        return (kept if max(size, count) <= 256 else make)(size, count, *rest)

    return band


def gaussian(sigma: float) -> NDArray[np.float64]:
    """Weights of ``scipy.ndimage.gaussian_filter``: cut at four standard deviations, of sum 1."""
    if not sigma > 1e-15:
        return np.ones(1)
    radius = int(4.0 * sigma + 0.5)
    x = np.arange(-radius, radius + 1)
    weights: NDArray[np.float64] = np.exp(-0.5 / (sigma * sigma) * x**2)
    weights /= weights.sum()
    return weights


def smoothing(size: int, sigma: float) -> Band:
    """The Gaussian alone."""
    weights = gaussian(sigma)
    return Band(np.arange(size) - len(weights) // 2, np.tile(weights, (size, 1)))


@remembered
def resizing(size: int, count: int, step: float, sigma: float, order: int, mode: str) -> Band:
    """The Gaussian, and then ``count`` pixels at ``(j + 1/2) step - 1/2``: nearest or linear (order 0 or 1)."""
    kernel = gaussian(sigma)
    radius = len(kernel) // 2
    at = (np.arange(count) + 0.5) * step - 0.5
    if order == 0:
        nearest = np.clip(np.floor(at + 0.5), 0, size - 1).astype(np.int64)
        return Band(nearest - radius, np.tile(kernel, (count, 1)))
    if mode == "edge":
        # Beyond its ends the smoothed signal is constant, unlike one that was smoothed out there.
        at = np.clip(at, 0, size - 1)
    left = np.floor(at).astype(np.int64)
    share = (at - left)[:, np.newaxis]
    here, there = np.zeros(len(kernel) + 1), np.zeros(len(kernel) + 1)
    here[:-1], there[1:] = kernel, kernel
    weights = (1 - share) * here + share * there
    if mode == "constant":
        # There the smoothed signal is the border's value: one tap beyond everything has all of its weight.
        before, behind = left < 0, left >= size - 1
        weights[before] = share[before] * there
        weights[before, 0] = 1 - share[before, 0]
        weights[behind] = (1 - share[behind]) * here
        weights[behind, -1] = share[behind, 0]
    return Band(left - radius, weights)


def apply(
    image: Floats,
    bands: Mapping[int, Band],
    mode: str,
    cval: float,
    limits: tuple[float, float] = EVERYTHING,
) -> Array:
    """The image with each axis in ``bands`` multiplied by its matrix, in singles or doubles."""
    array, factor = image
    axes = sorted(bands)
    if not axes:
        return np.clip(image.whole(), *limits) if limits != EVERYTHING else image.whole().copy()
    while axes:
        axis = axes.pop(0)
        pair = axes[:1] == [axis + 1]
        if pair:
            axes.pop(0)
        numbers = (factor, float(cval), EVERYTHING if axes else limits)
        array = _along(array, axis, bands[axis], bands[axis + 1] if pair else None, mode, numbers)
        factor = 1.0
    return array


def _along(
    array: Array,
    axis: int,
    down: Band,
    across: Band | None,
    mode: str,
    numbers: tuple[float, float, tuple[float, float]],
) -> Array:
    """One axis, or that one and the next."""
    shape = array.shape
    before, height = math.prod(shape[:axis]), shape[axis]
    last = axis + (1 if across is None else 2)
    width, channels = (
        (math.prod(shape[last:]), 1) if across is None else (shape[axis + 1], math.prod(shape[last:]))
    )
    new = [len(band.first) for band in (down, across) if band is not None]
    dtype = np.float32 if array.dtype == np.float32 else np.float64
    out = np.empty((*shape[:axis], *new, *shape[last:]), dtype)
    if not out.size:
        return out
    pictures = array.reshape(before, height, width, channels)
    targets = out.reshape(before, new[0], -1, channels)
    rows = (plain(down.first), plain(down.weights))
    columns = None if across is None else (plain(across.first), plain(across.weights))
    for picture, target in zip(pictures, targets, strict=True):
        _multum.resample_image(picture, rows, columns, mode, numbers, target)
    return out
