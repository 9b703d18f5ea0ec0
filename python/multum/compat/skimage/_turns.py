"""Rotations, swirls, and polar coordinates."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._images import Array, channels_last, finite, picture, whole_numbers
from ._matrices import apply
from ._warp import warp


def _euclidean(translation: Any = (0.0, 0.0), angle: float = 0.0) -> NDArray[np.float64]:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin, translation[0]], [sin, cos, translation[1]], [0.0, 0.0, 1.0]])


def rotate(
    image: Array,
    angle: float,
    resize: bool = False,
    center: Sequence[float] | NDArray[Any] | None = None,
    order: int | None = None,
    mode: str = "constant",
    cval: float = 0,
    clip: bool = True,
    preserve_range: bool = False,
    *,
    antialias: bool = False,
) -> Array:
    """``skimage.transform.rotate``: the image turned counter-clockwise around a point.

    Parameters
    ----------
    image : array, shape (H, W) or (H, W, C)
    angle : float
        In degrees.
    resize : bool
        Make the result as large as the whole of the turned image needs.
    center : (column, row), optional
        The point that stays; default: the middle of the image.
    order, mode, cval, clip, preserve_range, antialias
        As for :func:`warp`.

    Examples
    --------
    >>> import numpy as np
    >>> rotate(np.arange(6.0).reshape(2, 3), 90, resize=True).round(9).tolist()
    [[2.0, 5.0], [1.0, 4.0], [0.0, 3.0]]
    """
    image = picture(image)
    rows, columns = image.shape[0], image.shape[1]
    angle = finite("angle", angle)
    if image.dtype == np.float16:
        image = image.astype(np.float32)
    middle = np.array((columns, rows)) / 2.0 - 0.5 if center is None else np.asarray(center)
    matrix = _euclidean(middle) @ (_euclidean(angle=float(np.deg2rad(angle))) @ _euclidean(-middle))
    shape = None
    if resize:
        corners = [[0, 0], [0, rows - 1], [columns - 1, rows - 1], [columns - 1, 0]]
        turned = apply(np.linalg.inv(matrix), corners)
        low, high = turned.min(axis=0), turned.max(axis=0)
        shape = np.around((high - low + 1)[::-1])
        matrix = matrix @ _euclidean(low)
    # Products of affine matrices are affine, but for rounding.
    matrix[2] = (0, 0, 1)
    return warp(
        image,
        matrix,
        output_shape=shape,
        order=order,
        mode=mode,
        cval=cval,
        clip=clip,
        preserve_range=preserve_range,
        antialias=antialias,
    )


def _swirled(
    xy: NDArray[np.float64], center: Any, rotation: float, strength: float, radius: float
) -> NDArray[np.float64]:
    x0, y0 = center
    dx, dy = xy[:, 0] - x0, xy[:, 1] - y0
    distance = np.sqrt(dx**2 + dy**2)
    # The strength has fallen to about a thousandth at the radius: ln(2) / 5 is nearly 1 / ln(1000).
    decay = radius / 5 * np.log(2)
    theta = rotation + strength * np.exp(-distance / decay) + np.arctan2(dy, dx)
    return np.column_stack([x0 + distance * np.cos(theta), y0 + distance * np.sin(theta)])


def swirl(
    image: Array,
    center: Sequence[float] | NDArray[Any] | None = None,
    strength: float = 1,
    radius: float = 100,
    rotation: float = 0,
    output_shape: Any = None,
    order: int | None = None,
    mode: str = "reflect",
    cval: float = 0,
    clip: bool = True,
    preserve_range: bool = False,
    *,
    antialias: bool = False,
) -> Array:
    """``skimage.transform.swirl``: a whirl around a point.

    Parameters
    ----------
    image : array, shape (H, W) or (H, W, C)
    center : (column, row), optional
        Default: half the image's width and height.
    strength : float
        Angle at the center, in radians; it falls as exp(-distance / (radius ln(2) / 5)).
    radius : float
        In pixels.
    rotation : float
        Of the whole image, in radians.
    output_shape, order, mode, cval, clip, preserve_range, antialias
        As for :func:`warp`.

    Examples
    --------
    >>> import numpy as np
    >>> swirl(np.eye(9), strength=3, radius=9).shape
    (9, 9)
    """
    image = picture(image)
    arguments = {
        "center": np.array(image.shape)[:2][::-1] / 2 if center is None else center,
        "rotation": rotation,
        "strength": strength,
        "radius": radius,
    }
    return warp(
        image,
        _swirled,
        map_args=arguments,
        output_shape=output_shape,
        order=order,
        mode=mode,
        cval=cval,
        clip=clip,
        preserve_range=preserve_range,
        antialias=antialias,
    )


def warp_polar(
    image: Array,
    center: Sequence[float] | NDArray[Any] | None = None,
    *,
    radius: float | None = None,
    output_shape: Any = None,
    scaling: str = "linear",
    channel_axis: Any = None,
    **kwargs: Any,
) -> Array:
    """``skimage.transform.warp_polar``: rows are angles, columns are radii or their logarithms.

    Parameters
    ----------
    image : array, shape (H, W), or of three axes with ``channel_axis``
    center : (row, column), optional
        Default: the middle of the image.
    radius : float, optional
        Of the circle that is shown; default: that around the whole image.
    output_shape : (rows, columns), optional
        Default: 360 and the radius.
    scaling : str
        ``"linear"`` or ``"log"``.
    channel_axis : int, optional
        Axis of channels.
    **kwargs
        As for :func:`warp`.

    Examples
    --------
    >>> import numpy as np
    >>> rings = warp_polar(np.hypot(*np.ogrid[-8:9, -8:9]), radius=8)
    >>> rings.shape, bool(abs(rings - np.arange(8)).max() < 0.2)
    ((360, 8), True)
    """
    image, axis = channels_last(np.asarray(image), channel_axis)
    wanted = 2 if axis is None else 3
    if image.ndim != wanted:
        raise ValueError(f"image: got {image.ndim} axes, expected {wanted}")
    half = np.array(image.shape)[:2] / 2
    if center is None:
        center = half - 0.5
    elif np.shape(center) != (2,):
        raise ValueError(f"center: got {center!r}, expected (row, column)")
    if radius is None:
        radius = float(np.sqrt(half[0] ** 2 + half[1] ** 2))
    radius = finite("radius", radius)
    shape = (360, math.ceil(radius)) if output_shape is None else whole_numbers(output_shape)
    if scaling not in ("linear", "log"):
        raise ValueError(f"scaling: got {scaling!r}, expected 'linear' or 'log'")
    if len(shape) < 2:
        raise ValueError(f"output_shape: got {output_shape!r}, expected (rows, columns)")
    height, width = int(shape[0]), int(shape[1])
    step = width / radius if scaling == "linear" else width / np.log(radius)
    turn = height / (2 * np.pi)

    def places(xy: NDArray[np.float64]) -> NDArray[np.float64]:
        angle = xy[:, 1] / turn
        distance = xy[:, 0] / step
        if scaling == "log":
            distance = np.exp(distance)
        return np.column_stack([distance * np.cos(angle) + center[1], distance * np.sin(angle) + center[0]])

    warped = warp(image, places, output_shape=shape, **kwargs)
    return warped if axis is None else np.moveaxis(warped, -1, axis)
