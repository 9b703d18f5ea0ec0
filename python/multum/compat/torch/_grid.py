"""Sampling at grids of positions in [-1, 1]."""

import math
import operator
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import _multum
from ._tensors import Array, array, error, floats, like, one_of

MODES = ("bilinear", "nearest", "bicubic")
PADDINGS = ("zeros", "border", "reflection")


def told(align_corners: bool | None, name: str) -> bool:
    """The rule of corners, with PyTorch's warning where none is given."""
    if align_corners is None:
        warnings.warn(f"{name}: align_corners is False unless it is given", UserWarning, stacklevel=3)
    return bool(align_corners)


def checked(input: Any, grid: Any, mode: str, padding_mode: str) -> tuple[Array, Array]:
    """Arrays of an input (N, C, H, W) and a grid (N, h, w, 2) that fit together."""
    one_of("mode", mode, MODES)
    one_of("padding_mode", padding_mode, PADDINGS)
    images = floats("input", input, 4, "(N, C, H, W); volumes are not supported")
    places = floats("grid", grid, 4, "(N, h, w, 2)")
    if places.shape[3] != 2 or places.shape[0] != images.shape[0]:
        raise error(f"grid: got shape {places.shape}, expected ({images.shape[0]}, h, w, 2)")
    if places.dtype != images.dtype:
        raise error(f"grid: got dtype {places.dtype}, expected {images.dtype}, that of the input")
    if 0 in images.shape[1:]:
        raise error(f"input: got shape {images.shape}, expected no empty axis but that of the batch")
    return images, places


def in_pixels(numbers: Array, size: int, align_corners: bool) -> Array:
    """From [-1, 1] to pixels, whose centres are at whole numbers, in the type of the numbers."""
    kind = numbers.dtype.type
    result: Array = numbers + kind(1)
    if align_corners:
        # The ends are the centres of the outermost pixels.
        result *= kind((size - 1) / 2)
    else:
        # They are the outer edges of those pixels.
        result *= kind(size / 2)
        result -= kind(0.5)
    return result


def grid_sample(
    input: Any,
    grid: Any,
    mode: str = "bilinear",
    padding_mode: str = "zeros",
    align_corners: bool | None = None,
) -> Any:
    """``torch.nn.functional.grid_sample`` for images.

    Parameters
    ----------
    input : array or tensor, shape (N, C, H, W)
        ``float32``, ``float64`` or ``float16``.
    grid : array or tensor, shape (N, h, w, 2)
        Positions (x, y) of the input's dtype: -1 is left or top, 1 right or bottom.
    mode : str
        ``"bilinear"``, ``"nearest"`` (ties to even) or ``"bicubic"`` (slope -0.75).
    padding_mode : str
        What lies outside: ``"zeros"``, ``"border"`` (the outermost pixel) or ``"reflection"``.
    align_corners : bool
        Whether -1 and 1 are the centres of the outermost pixels or, by default, their outer edges.

    Returns
    -------
    array or tensor, shape (N, C, h, w)
        Where the grid is not finite: NaN for ``"bicubic"`` and for ``"bilinear"`` with zeros, 0 for ``"nearest"``
        with zeros, else a pixel of the edge.

    Examples
    --------
    >>> import numpy as np
    >>> image = np.array([[[[0.0, 10.0], [20.0, 30.0]]]])
    >>> middle = np.zeros((1, 1, 1, 2))
    >>> grid_sample(image, middle, align_corners=False).item()
    15.0
    """
    align = told(align_corners, "grid_sample")
    images, places = array("input", input), array("grid", grid)
    made: Array | None = None
    if mode in MODES and padding_mode in PADDINGS:
        made = _multum.torch_grid_sample(images, places, mode, padding_mode, align, False)
    if made is None:
        made = _sampled(*checked(images, places, mode, padding_mode), mode, padding_mode, align)
    return like(made, input)


def _sampled(images: Array, places: Array, mode: str, padding_mode: str, align: bool) -> Array:
    """The same for arrays that are not packed; channels that are last in memory are sampled together."""
    grid = np.ascontiguousarray(places)
    together = images.transpose(0, 2, 3, 1)
    if images.shape[1] > 1 and together.flags.c_contiguous:
        made = _multum.torch_grid_sample(together, grid, mode, padding_mode, align, True)
        if made is not None:
            return made.transpose(0, 3, 1, 2)
    made = _multum.torch_grid_sample(np.ascontiguousarray(images), grid, mode, padding_mode, align, False)
    if made is None:
        raise error("input, grid: got memory that cannot be read as it lies, expected arrays of floats")
    return made


def maps(places: Array, size: tuple[int, int], align: bool) -> tuple[Array, Array]:
    """Columns and rows, in singles or doubles."""
    wide = np.float64 if places.dtype == np.float64 else np.float32
    x, y = (np.ascontiguousarray(places[..., i], wide) for i in (0, 1))
    return in_pixels(x, size[1], align), in_pixels(y, size[0], align)


def affine_grid(theta: Any, size: Any, align_corners: bool | None = None) -> Any:
    """``torch.nn.functional.affine_grid``: the positions that 2x3 matrices give to the pixels of an output.

    Parameters
    ----------
    theta : array or tensor, shape (N, 2, 3), or (N, 3, 4) for volumes
    size : (N, C, H, W), or (N, C, D, H, W)
        Of the output.
    align_corners : bool
        As for :func:`grid_sample`.

    Returns
    -------
    array or tensor, shape (N, H, W, 2) or (N, D, H, W, 3)

    Examples
    --------
    >>> import numpy as np
    >>> affine_grid(np.eye(2, 3)[None], (1, 1, 1, 2), align_corners=True)[0, 0].tolist()
    [[-1.0, 0.0], [1.0, 0.0]]
    """
    align = told(align_corners, "affine_grid")
    matrices = floats("theta", theta, 3, "(N, 2, 3)")
    try:
        numbers = tuple(operator.index(n) for n in size)
    except TypeError:
        raise error(f"size: got {size!r}, expected whole numbers (N, C, H, W)") from None
    axes = len(numbers) - 2
    if axes not in (2, 3) or matrices.shape != (numbers[0], axes, axes + 1):
        expected = "(N, 2, 3) with N, C, H, W, or (N, 3, 4) with N, C, D, H, W"
        raise error(f"theta, size: got shape {matrices.shape} with size {numbers}, expected {expected}")
    if min(numbers) < 1 or math.prod(numbers[2:]) * numbers[0] > 1 << 40:
        raise error(f"size: got {numbers}, expected positive numbers and at most 2^40 positions")
    lines: list[NDArray[Any]] = []
    for n in numbers[2:]:
        line = np.linspace(-1, 1, n) if n > 1 else np.zeros(1)
        lines.append((line if align else line * ((n - 1) / n)).astype(matrices.dtype))
    # x comes first and is the last axis.
    base = np.stack(
        [*np.meshgrid(*lines, indexing="ij")[::-1], np.ones(numbers[2:], matrices.dtype)], axis=-1
    )
    grid = base.reshape(-1, axes + 1) @ matrices.transpose(0, 2, 1)
    return like(grid.reshape(numbers[0], *numbers[2:], axes), theta)
