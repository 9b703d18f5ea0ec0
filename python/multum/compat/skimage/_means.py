"""Reductions by means: of blocks, and of fractions of pixels."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _bands
from ._images import MOST, Array, Floats, as_floats, plain, sized
from ._resize import expanded


def downscale_local_mean(image: Array, factors: Any, cval: float = 0, clip: bool = True) -> Array:
    """``skimage.transform.downscale_local_mean``: the mean of each block; the image is filled up by ``cval``.

    Parameters
    ----------
    image : array
    factors : int or tuple of ints
        Size of a block along each axis.
    cval : float
        Beyond the ends of axes that are no multiples.
    clip : bool
        Without effect, as there.

    Returns
    -------
    array
        Of the dtype of ``numpy.mean``.

    Examples
    --------
    >>> import numpy as np
    >>> downscale_local_mean(np.arange(15).reshape(3, 5), (2, 3)).tolist()
    [[3.5, 4.0], [5.5, 4.5]]
    """
    image = np.asarray(image)
    blocks: tuple[Any, ...] = (factors,) * image.ndim if np.ndim(factors) == 0 else tuple(factors)
    if len(blocks) != image.ndim or not all(1 <= block <= MOST for block in blocks):
        raise ValueError(f"factors: got {factors!r}, expected {image.ndim} numbers from 1 on")
    if any(block != int(block) for block in blocks):
        raise TypeError(f"factors: got {factors!r}, expected whole numbers")
    sizes = tuple(int(block) for block in blocks)
    missing = [(0, -size % block) for size, block in zip(image.shape, sizes, strict=True)]
    if any(behind for _, behind in missing):
        image = np.pad(image, missing, mode="constant", constant_values=cval)
    kind, size = image.dtype.kind, image.dtype.itemsize
    if kind not in "iubf" or (kind == "f" and size not in (4, 8)):
        return _mean_of_blocks(image, sizes)
    as_it_is = kind == "f" or (kind == "u" and size < 4)
    source = Floats(plain(image if as_it_is else image.astype(float)), 1.0)
    bands = {}
    for axis, (size, block) in enumerate(zip(image.shape, sizes, strict=True)):
        if block > 1:
            bands[axis] = _bands.Band(np.arange(0, size, block), np.ones((size // block, block)))
    # Sums first: those of integers are exact.
    sums = _bands.apply(source, bands, "edge", 0)
    sums /= float(np.prod(sizes))
    return sums


def _mean_of_blocks(image: Array, sizes: tuple[int, ...]) -> Array:
    """For dtypes that the compiled part does not know."""
    pairs = [n for size, block in zip(image.shape, sizes, strict=True) for n in (size // block, block)]
    means: Array = image.reshape(pairs).mean(axis=tuple(range(1, 2 * image.ndim, 2)))
    return means


@_bands.remembered
def _overlaps(old: int, new: int, grid_mode: bool) -> _bands.Band:
    """Shares of old pixels in new ones. Ends of pixels are at whole numbers, or half way between centres."""
    if grid_mode:
        ends, cuts = np.arange(old + 1.0), np.linspace(0, old, new + 1)
    else:
        length, count = old - 1, new - 1
        half = np.inf if count == 0 else 0.5 * length / count
        ends = np.concatenate([[0], np.linspace(0.5, length - 0.5, length), [length]])
        cuts = np.concatenate([[0], np.linspace(half, length - half, count), [length]])
    low, high = cuts[:-1, np.newaxis], cuts[1:, np.newaxis]
    first = np.clip(np.searchsorted(ends, cuts[:-1], side="right") - 1, 0, old - 1)
    last = np.clip(np.searchsorted(ends, cuts[1:], side="left"), 1, old)
    pixels = first[:, np.newaxis] + np.arange(max(int((last - first).max()), 1))
    inside = np.minimum(pixels, old - 1)
    shares = np.minimum(high, ends[inside + 1]) - np.maximum(low, ends[inside])
    shares = np.where(pixels < old, np.maximum(shares, 0), 0)
    with np.errstate(invalid="warn"):
        return _bands.Band(first, shares / shares.sum(axis=1, keepdims=True))


def _wanted(image: Array, output_shape: tuple[Any, ...], channel_axis: int) -> tuple[Any, ...]:
    """The shape without its axis of channels."""
    if len(output_shape) == image.ndim - 1:
        return output_shape
    if len(output_shape) != image.ndim:
        expected = f"{image.ndim} numbers, or one less"
        raise ValueError(f"output_shape: got {output_shape!r}, expected {expected}")
    if output_shape[channel_axis] != image.shape[channel_axis]:
        raise ValueError(f"output_shape: got {output_shape!r}, expected the image's number of channels")
    axis = channel_axis % image.ndim
    return output_shape[:axis] + output_shape[axis + 1 :]


def resize_local_mean(
    image: Array,
    output_shape: Any,
    grid_mode: bool = True,
    preserve_range: bool = False,
    *,
    channel_axis: int | None = None,
) -> Array:
    """``skimage.transform.resize_local_mean``: means over the area of each new pixel.

    Parameters
    ----------
    image : array
    output_shape : tuple
        With or without the number of channels.
    grid_mode : bool
        Whether the new pixels together cover the area of the old ones, or only that between their centres.
    preserve_range : bool
        As for :func:`warp`.
    channel_axis : int, optional
        Axis of channels, which stays.

    Examples
    --------
    >>> import numpy as np
    >>> resize_local_mean(np.array([[0.0, 3.0, 6.0]]), (1, 2)).tolist()
    [[1.0, 5.0]]
    """
    image = np.asarray(image)
    shape = sized("output_shape", output_shape)
    if channel_axis is not None:
        if not -image.ndim <= channel_axis < image.ndim:
            raise ValueError(f"channel_axis: got {channel_axis}, expected an axis of {image.ndim}")
        shape = _wanted(image, shape, channel_axis)
        given = np.moveaxis(image, channel_axis, -1)
        axes = given.ndim - 1
    else:
        given, shape = expanded(image, shape)
        axes = image.ndim
    source = as_floats(given, preserve_range)
    sizes: list[tuple[int, int]] = list(zip(given.shape[:axes], map(int, shape[:axes]), strict=True))
    bands = {axis: _overlaps(old, new, grid_mode) for axis, (old, new) in enumerate(sizes) if old != new}
    if not bands:
        resized: NDArray[Any] = source.whole() if source.array.dtype.kind != "f" else np.array(source.array)
    else:
        resized = _bands.apply(source, bands, "edge", 0)
    return resized if channel_axis is None else np.moveaxis(resized, -1, channel_axis)
