"""Warps by a matrix, a transform, a function or coordinates."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from . import _filtered
from ._images import (
    NDIMAGE_MODES,
    Array,
    Floats,
    ShapeError,
    as_floats,
    checked_mode,
    checked_order,
    plain,
    scipy_ndimage,
    whole_numbers,
)
from ._matrices import apply, matrix_of
from ._read import Planes, by_matrix, clipped, linear, nearest


def warp(
    image: Array,
    inverse_map: Any,
    map_args: Mapping[str, Any] | None = None,
    output_shape: Any = None,
    order: int | None = None,
    mode: str = "constant",
    cval: float = 0.0,
    clip: bool = True,
    preserve_range: bool = False,
    *,
    antialias: bool = False,
) -> Array:
    """``skimage.transform.warp``: the image seen through a map from output to input.

    Parameters
    ----------
    image : array
        (H, W) or (H, W, C); any number of axes with an array of coordinates.
    inverse_map : 3x3 array, transform object, callable, or array
        From (column, row) of the output to that of the input. A callable gets an array (N, 2) and returns one.
        An array of another shape holds coordinates, row first: ``inverse_map[i]`` is axis i of the input.
    map_args : dict, optional
        Keyword arguments of a callable.
    output_shape : (rows, columns), optional
        Default: the image's.
    order : int, optional
        0 nearest, 1 linear, 2 to 5 splines; default 1, and 0 for bool. With a matrix, 3 is Catmull-Rom.
    mode : str
        What lies outside, as in ``numpy.pad``: ``"constant"`` (``cval``), ``"edge"``, ``"symmetric"``,
        ``"reflect"``, ``"wrap"``.
    clip : bool
        Draw results into the range of the input.
    preserve_range : bool
        Leave integers as they are; else they become [0, 1] or [-1, 1].
    antialias : bool
        Not in scikit-image. Where pixels cover more than a pixel of the input, average it over what they cover
        (orders 1 and above, images of two axes with or without channels).

    Returns
    -------
    array
        ``float64``, or ``float32`` for single and half images; of the image's dtype at order 0.

    Examples
    --------
    >>> import numpy as np
    >>> image = np.arange(6.0).reshape(2, 3)
    >>> warp(image, np.array([[1, 0, 0.5], [0, 1, 0], [0, 0, 1]]), mode="edge").tolist()
    [[0.5, 1.5, 2.0], [3.5, 4.5, 5.0]]
    >>> warp(image, lambda xy: xy[:, ::-1], output_shape=(3, 2)).tolist()
    [[0.0, 3.0], [1.0, 4.0], [2.0, 5.0]]
    """
    image = np.asarray(image)
    if image.size == 0:
        raise ValueError(f"image: got shape {image.shape}, expected a size that is not 0")
    order = checked_order(image.dtype, order)
    shape = np.asarray(image.shape) if output_shape is None else whole_numbers(output_shape)
    checked_mode(mode)
    if order == 2:
        _filtered.warn_of_order_two()
    matrix = matrix_of(inverse_map)
    if matrix is not None and map_args:
        raise TypeError("map_args: got arguments, but the map is a matrix")
    if matrix is None and isinstance(inverse_map, np.ndarray):
        return _at_coordinates(image, inverse_map, order, mode, cval, clip, preserve_range, antialias)
    if image.ndim not in (2, 3):
        raise ValueError(f"image: got {image.ndim} axes, expected 2 or 3 with a map that is no array")
    if len(shape) < 2:
        raise ValueError(f"output_shape: got {output_shape!r}, expected (rows, columns)")
    size = (int(shape[0]), int(shape[1]))
    if min(size) < 0:
        raise ValueError(f"output_shape: got {size}, expected no negative numbers")
    if order == 0 and matrix is not None:
        return nearest(image, size, mode, cval, clip, matrix=matrix)
    source = as_floats(image, preserve_range) if order else Floats(plain(image), 1.0)
    if matrix is not None and order in (1, 3):
        # Positions of single images are computed in singles.
        matrix = matrix.astype(source.dtype)
        out = by_matrix(source, matrix, size, order, mode, cval, clip)
        if antialias:
            _filtered.replace_minified(out, source, matrix.astype(float), mode, cval)
        return out
    if matrix is not None:
        coordinates = _planes(lambda xy: apply(matrix, xy), size)
    else:
        arguments = dict(map_args or {})
        coordinates = _planes(lambda xy: inverse_map(xy, **arguments), size)
    extra = tuple(int(n) for n in shape[2:])
    if extra and extra != image.shape[2:]:
        return _through_channels(source, coordinates, extra, order, mode, cval, clip)
    return _on_planes(image, source, coordinates, order, mode, cval, clip, antialias)


def _on_planes(
    image: Array,
    source: Floats,
    places: Planes,
    order: int,
    mode: str,
    cval: float,
    clip: bool,
    antialias: bool = False,
) -> Array:
    """A picture, with or without channels, at columns and rows of shape (h, w)."""
    shape = places[0].shape
    if order == 0:
        return nearest(image, (shape[0], shape[1]), mode, cval, clip, planes=places)
    if order == 1:
        out = linear(source, shape, mode, cval, clip, planes=places)
    else:
        ndimage = scipy_ndimage(f"order {order}")
        options = {"order": order, "mode": NDIMAGE_MODES[mode], "cval": cval}
        rows_first = np.stack([places[1], places[0]])
        whole = source.whole()
        if whole.ndim == 2:
            out = ndimage.map_coordinates(whole, rows_first, **options)
        else:
            out = np.empty((*shape, whole.shape[2]), whole.dtype)
            for k in range(whole.shape[2]):
                ndimage.map_coordinates(whole[..., k], rows_first, output=out[..., k], **options)
        clipped(out, Floats(whole, 1.0), mode, cval, clip)
    if antialias:
        _filtered.replace_minified(out, source, places, mode, cval)
    return out


def _at_coordinates(
    image: Array,
    coordinates: Array,
    order: int,
    mode: str,
    cval: float,
    clip: bool,
    preserve_range: bool,
    antialias: bool,
) -> Array:
    """An image of any number of axes at an array of coordinates."""
    if coordinates.dtype.kind == "c":
        raise TypeError(f"inverse_map: got dtype {coordinates.dtype}, expected real numbers")
    if coordinates.ndim < 2 or coordinates.shape[0] != image.ndim:
        expected = f"a first axis of {image.ndim}, one for each axis of the image"
        raise ShapeError(f"inverse_map: got shape {coordinates.shape}, expected {expected}")
    source = as_floats(image, preserve_range) if order else Floats(plain(image), 1.0)
    shape = coordinates.shape[1:]
    if image.ndim == 2 and (order < 2 or len(shape) == 2):
        flat = shape if len(shape) == 2 else (1, math.prod(shape))
        rows, columns = (plain(c.astype(np.float64, copy=False)).reshape(flat) for c in coordinates)
        antialias = antialias and len(shape) == 2
        return _on_planes(image, source, (columns, rows), order, mode, cval, clip, antialias).reshape(shape)
    ndimage = scipy_ndimage(f"an image of {image.ndim} axes" if image.ndim != 2 else f"order {order}")
    whole = source.whole() if order else source.array
    options = {"order": order, "mode": NDIMAGE_MODES[mode], "cval": cval, "prefilter": order > 1}
    out: Array = ndimage.map_coordinates(whole, coordinates, **options)
    if order:
        clipped(out, Floats(whole, 1.0), mode, cval, clip)
    return out


def _through_channels(
    source: Floats, places: Planes, extra: tuple[int, ...], order: int, mode: str, cval: float, clip: bool
) -> Array:
    """An output with another number of channels than the image: they are an axis like others."""
    whole = source.whole() if order else source.array
    if whole.ndim != 3 or len(extra) != 1:
        raise ShapeError(f"output_shape: got channels {extra}, but the image has shape {whole.shape}")
    channels = np.broadcast_to(np.arange(extra[0], dtype=float), (*places[0].shape, extra[0]))
    columns, rows = (np.broadcast_to(p[..., np.newaxis], channels.shape) for p in places)
    ndimage = scipy_ndimage("another number of channels")
    options = {"order": order, "mode": NDIMAGE_MODES[mode], "cval": cval, "prefilter": order > 1}
    out: Array = ndimage.map_coordinates(whole, np.stack([rows, columns, channels]), **options)
    if order:
        clipped(out, Floats(whole, 1.0), mode, cval, clip)
    return out


def _planes(mapping: Callable[[Array], Any], size: tuple[int, int]) -> Planes:
    """Columns and rows, from a function of pairs."""
    rows, columns = size
    pairs = np.empty((rows, columns, 2))
    pairs[..., 0] = np.arange(columns)
    pairs[..., 1] = np.arange(rows)[:, np.newaxis]
    moved = np.asarray(mapping(pairs.reshape(-1, 2)))
    if moved.ndim != 2 or moved.shape[0] != rows * columns or moved.shape[1] < 2:
        raise ValueError(f"inverse_map: returned shape {moved.shape}, expected ({rows * columns}, 2)")
    x, y = (plain(moved[:, i].astype(np.float64, copy=False)).reshape(size) for i in (0, 1))
    return x, y


def warp_coords(coord_map: Callable[[Array], Any], shape: Any, dtype: DTypeLike = np.float64) -> Array:
    """Coordinates, row first, at which ``scipy.ndimage.map_coordinates`` reads what :func:`warp` shows.

    Parameters
    ----------
    coord_map : callable
        From (column, row) of the output, an array (N, 2), to those of the input.
    shape : (rows, columns) or (rows, columns, bands)
        Of the output.
    dtype : data type
        Of the coordinates.

    Returns
    -------
    array, shape (len(shape), rows, columns[, bands])

    Examples
    --------
    >>> warp_coords(lambda xy: xy + [10, 0], (1, 3)).tolist()
    [[[0.0, 0.0, 0.0]], [[10.0, 11.0, 12.0]]]
    """
    numbers = tuple(int(n) for n in whole_numbers(shape))
    if len(numbers) not in (2, 3):
        raise ValueError(f"shape: got {shape!r}, expected (rows, columns) or (rows, columns, bands)")
    columns, rows = _planes(coord_map, (numbers[0], numbers[1]))
    coordinates = np.empty((len(numbers), *numbers), dtype)
    if len(numbers) == 3:
        columns, rows = columns[..., np.newaxis], rows[..., np.newaxis]
        coordinates[2] = np.arange(numbers[2])
    coordinates[0], coordinates[1] = rows, columns
    return coordinates
