"""The value that a pixel should have: the mean of the bilinear picture over the pixel's square, by brute force.

Written with numpy alone and sharing no code with the filters that it judges.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

_MOST_SAMPLES = (24, 512)
_AT_ONCE = 1 << 15


def truth(
    image: NDArray[Any], matrix: NDArray[np.float64], shape: tuple[int, int], repeat: bool
) -> NDArray[np.float64]:
    """The exact warp of a picture by a 3x3 matrix, in codes; black outside unless it repeats.

    Each row takes as many samples a pixel as its footprint needs: two a texel, 6 to 24 across and 6 to 512 down.
    """
    texels = image.reshape(*image.shape[:2], -1).astype(np.float32)
    height, width = shape
    out = np.empty((height, width, texels.shape[2]))
    for row in range(height):
        across, down = _samples(matrix, row, width)
        dx = (np.arange(across) + 0.5) / across - 0.5
        dy = (np.arange(down) + 0.5) / down - 0.5
        x = (np.arange(width)[:, None] + dx).ravel()
        total = np.zeros((width, texels.shape[2]))
        for offsets in np.array_split(dy, max(1, x.size * down // _AT_ONCE)):
            place = _apply(matrix, np.tile(x, offsets.size), row + np.repeat(offsets, x.size))
            values = _bilinear(texels, place, repeat)
            total += values.reshape(offsets.size, width, across, -1).sum(axis=(0, 2))
        out[row] = total / (across * down)
    return out.reshape(*shape, *image.shape[2:])


def footprint(matrix: NDArray[np.float64], x: NDArray[np.float64], y: Any) -> NDArray[np.float64]:
    """Derivatives (..., 2, 2) of the mapped place by x and y, in closed form."""
    w = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
    place = _apply(matrix, x, y)
    rows = [[(matrix[i, j] - place[i] * matrix[2, j]) / w for j in (0, 1)] for i in (0, 1)]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def _samples(matrix: NDArray[np.float64], row: int, width: int) -> tuple[int, int]:
    x = np.linspace(0, width - 1, 9)
    lengths = np.linalg.norm(footprint(matrix, x, np.float64(row)), axis=-2).max(axis=0)
    across, down = (
        int(np.clip(np.ceil(2 * n), 6, most)) for n, most in zip(lengths, _MOST_SAMPLES, strict=True)
    )
    return across, down


def _apply(matrix: NDArray[np.float64], x: NDArray[np.float64], y: Any) -> NDArray[np.float64]:
    w = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
    return np.stack([(matrix[i, 0] * x + matrix[i, 1] * y + matrix[i, 2]) / w for i in (0, 1)])


def _bilinear(texels: NDArray[np.float32], place: NDArray[np.float64], repeat: bool) -> NDArray[np.float32]:
    height, width, channels = texels.shape
    whole = np.floor(place)
    fx, fy = (place - whole).astype(np.float32)[..., None]
    if repeat:
        x0, y0 = (whole % np.array([[width], [height]])).astype(np.intp)
        x1, y1 = (x0 + 1) % width, (y0 + 1) % height
    else:
        # One row and column of black around, and everything beyond folded onto it.
        padded = np.zeros((height + 2, width + 2, channels), np.float32)
        padded[1:-1, 1:-1] = texels
        texels = padded
        limits = np.array([[width + 1], [height + 1]])
        x0, y0 = np.clip(whole + 1, 0, limits).astype(np.intp)
        x1, y1 = np.clip(whole + 2, 0, limits).astype(np.intp)
    top = texels[y0, x0] * (1 - fx) + texels[y0, x1] * fx
    bottom = texels[y1, x0] * (1 - fx) + texels[y1, x1] * fx
    return np.asarray(top * (1 - fy) + bottom * fy)
