"""Gradients of :func:`grid_sample`."""

from typing import Any, NamedTuple

import numpy as np

from ._grid import checked, maps, told
from ._tensors import Array, error, floats, like

_SLOPE = -0.75


class Taps(NamedTuple):
    """One axis of the samples: for each of a few taps a pixel, a weight, and the weight's derivative.

    Arrays (taps, h, w); the derivative is by the grid's own coordinate. Taps that do not count have weight 0.
    """

    pixel: Array
    weight: Array
    slope: Array


def _cubic(t: Array) -> tuple[Array, Array]:
    """Weights of the pixels at -1, 0, 1, 2 for a position t in [0, 1), and their derivatives."""
    a = _SLOPE
    distances = [t + 1, t, 1 - t, 2 - t]
    signs = [1.0, 1.0, -1.0, -1.0]
    weights, slopes = [], []
    for d, sign, is_far in zip(distances, signs, (True, False, False, True), strict=True):
        if is_far:
            weights.append(((a * d - 5 * a) * d + 8 * a) * d - 4 * a)
            slopes.append(sign * ((3 * a * d - 10 * a) * d + 8 * a))
        else:
            weights.append(((a + 2) * d - (a + 3)) * d * d + 1)
            slopes.append(sign * (3 * (a + 2) * d - 2 * (a + 3)) * d)
    return np.stack(weights), np.stack(slopes)


def _padded(index: Array, size: int, padding_mode: str, align: bool) -> tuple[Array, Array]:
    """Indices inside the image, and whether those that were given count."""
    counts = (index >= 0) & (index < size)
    if padding_mode == "reflection":
        counts[...] = True
        if align and size > 1:
            period = 2 * size - 2
            index = index % period
            index = np.minimum(index, period - index)
        elif not align:
            index = index % (2 * size)
            index = np.minimum(index, 2 * size - 1 - index)
    elif padding_mode == "border":
        counts[...] = True
    return np.clip(index, 0, size - 1), counts


def _axis(at: Array, size: int, mode: str, padding_mode: str, align: bool) -> Taps:
    scale = (size - 1) / 2 if align else size / 2
    finite = np.isfinite(at)
    at = np.where(finite, at, 0.0).clip(-(2.0**40), 2.0**40)
    if mode == "nearest":
        index, counts = _padded(np.rint(at).astype(np.int64)[np.newaxis], size, padding_mode, align)
        weight = (counts & finite).astype(np.float64)
        return Taps(index, weight, np.zeros_like(weight))
    whole = np.floor(at)
    t = at - whole
    if mode == "bilinear":
        offsets = np.arange(2)
        weight, slope = np.stack([1 - t, t]), np.stack([-np.ones_like(t), np.ones_like(t)])
    else:
        offsets = np.arange(-1, 3)
        weight, slope = _cubic(t)
    index = whole.astype(np.int64) + offsets[:, np.newaxis, np.newaxis]
    index, counts = _padded(index, size, padding_mode, align)
    counts &= finite
    return Taps(index, weight * counts, slope * (counts * scale))


def grid_sample_backward(
    grad_output: Any,
    input: Any,
    grid: Any,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool | None = None,
) -> tuple[Any, Any]:
    """Gradients of a number L by the input and the grid of :func:`grid_sample`, from that by its output.

    The sample is a sum of pixels times weights; the gradient by a pixel collects the weights of all samples that
    read it, and that by a position takes the weights' derivatives. Where the interpolation has a corner, at
    pixels' centres, the derivative is that to the right and below.

    Parameters
    ----------
    grad_output : array or tensor, shape (N, C, h, w)
        dL / d output.
    input, grid, mode, padding_mode, align_corners
        As for :func:`grid_sample`.

    Returns
    -------
    (grad_input, grad_grid)
        Of the shapes and dtypes of input and grid. That of the grid is 0 for ``"nearest"``.

    Examples
    --------
    >>> import numpy as np
    >>> image = np.array([[[[0.0, 10.0], [20.0, 30.0]]]])
    >>> middle = np.zeros((1, 1, 1, 2))
    >>> to_image, to_grid = grid_sample_backward(np.ones((1, 1, 1, 1)), image, middle, align_corners=False)
    >>> to_image.tolist(), to_grid.ravel().tolist()
    ([[[[0.25, 0.25], [0.25, 0.25]]]], [10.0, 20.0])
    """
    align = told(align_corners, "grid_sample_backward")
    images, places = checked(input, grid, mode, padding_mode)
    above = floats("grad_output", grad_output, 4, "(N, C, h, w)")
    batch, channels, height, width = images.shape
    if above.shape != (batch, channels, *places.shape[1:3]):
        expected = (batch, channels, *places.shape[1:3])
        raise error(f"grad_output: got shape {above.shape}, expected {expected}")
    to_input = np.zeros(images.shape, images.dtype)
    to_grid = np.zeros(places.shape, places.dtype)
    for n in range(batch if above.size else 0):
        x, y = (m.astype(np.float64) for m in maps(places[n], (height, width), align))
        columns = _axis(x, width, mode, padding_mode, align)
        rows = _axis(y, height, mode, padding_mode, align)
        index = (rows.pixel[:, np.newaxis] * width + columns.pixel).reshape(-1)
        weight = rows.weight[:, np.newaxis] * columns.weight
        along_x = rows.weight[:, np.newaxis] * columns.slope
        along_y = rows.slope[:, np.newaxis] * columns.weight
        dx, dy = np.zeros(places.shape[1:3]), np.zeros(places.shape[1:3])
        for c in range(channels):
            g = above[n, c].astype(np.float64)
            sums = np.bincount(index, (weight * g).reshape(-1), height * width)
            to_input[n, c] = sums.reshape(height, width)
            if mode != "nearest":
                pixels = images[n, c].reshape(-1)[index].reshape(weight.shape)
                dx += g * (along_x * pixels).sum(axis=(0, 1))
                dy += g * (along_y * pixels).sum(axis=(0, 1))
        to_grid[n, ..., 0], to_grid[n, ..., 1] = dx, dy
    return like(to_input, input), like(to_grid, grid)
