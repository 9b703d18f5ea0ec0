"""Resizing by interpolation, after a Gaussian where the image shrinks."""

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _bands
from ._images import (
    EVERYTHING,
    NDIMAGE_MODES,
    Array,
    Floats,
    as_floats,
    channels_last,
    checked_mode,
    checked_order,
    clip_to_input,
    finite,
    joined,
    limits,
    plain,
    scipy_ndimage,
    sized,
)


def expanded(image: Array, output_shape: Any) -> tuple[Array, tuple[Any, ...]]:
    """Image and shape with the same number of axes: missing ones are of size 1, or channels that stay."""
    wanted = sized("output_shape", output_shape)
    if len(wanted) > image.ndim:
        image = image.reshape(image.shape + (1,) * (len(wanted) - image.ndim))
    elif len(wanted) == image.ndim - 1:
        wanted = (*wanted, image.shape[-1])
    elif len(wanted) < image.ndim:
        raise ValueError(f"output_shape: got {wanted!r}, expected {image.ndim} numbers, or one less")
    return image, wanted


def _deviations(given: Any, factors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Standard deviations of the Gaussian along the axes."""
    if given is None:
        return np.maximum(0, (factors - 1) / 2)
    sigmas: NDArray[np.float64] = np.atleast_1d(given) * np.ones_like(factors)
    if (sigmas < 0).any():
        raise ValueError(f"anti_aliasing_sigma: got {given!r}, expected no negative numbers")
    if ((sigmas > 0) & (factors <= 1)).any():
        # Programs look for these words.
        message = "Anti-aliasing standard deviation greater than zero along an axis that does not shrink"
        warnings.warn(message, UserWarning, stacklevel=4)
    return sigmas


def resize(
    image: Array,
    output_shape: Any,
    order: int | None = None,
    mode: str = "reflect",
    cval: float = 0,
    clip: bool = True,
    preserve_range: bool = False,
    anti_aliasing: bool | None = None,
    anti_aliasing_sigma: Any = None,
) -> Array:
    """``skimage.transform.resize``: an image of any number of axes in another size.

    Parameters
    ----------
    image : array
    output_shape : tuple
        (rows, columns[, ...][, channels]); without a last number, the last axis stays.
    order : int, optional
        0 nearest, 1 linear, 2 to 5 splines (which need SciPy); default 1, and 0 for bool.
    mode, cval, clip, preserve_range
        As for :func:`warp`.
    anti_aliasing : bool, optional
        Smooth by a Gaussian before; default: where any axis shrinks, unless the image is bool or of integers at
        order 0.
    anti_aliasing_sigma : float or tuple of floats, optional
        Standard deviations; default (s - 1) / 2 for an axis that shrinks by the factor s.

    Returns
    -------
    array
        ``float64``, ``float32`` for single and half images, and of the image's dtype at order 0.

    Examples
    --------
    >>> import numpy as np
    >>> resize(np.arange(8.0).reshape(2, 4), (2, 2), anti_aliasing=False).tolist()
    [[0.5, 2.5], [4.5, 6.5]]
    """
    image = np.asarray(image)
    image, wanted = expanded(image, output_shape)
    dtype = image.dtype
    if dtype == np.float16:
        image = image.astype(np.float32)
    if anti_aliasing is None:
        shrinks = any(new < old for new, old in zip(wanted, image.shape, strict=True))
        anti_aliasing = dtype.kind != "b" and not (dtype.kind in "iu" and order == 0) and shrinks
    if dtype.kind == "b" and anti_aliasing:
        raise ValueError("anti_aliasing: got True for an image of bool, expected False")
    with np.errstate(divide="warn", invalid="warn"):
        factors = np.divide(image.shape, wanted)
    if anti_aliasing and not np.isfinite(factors).all():
        raise ValueError(f"output_shape: got {output_shape!r}, expected positive numbers to smooth for")
    order = checked_order(dtype, order)
    whole = order == 0 and dtype.kind not in "f"
    source = Floats(plain(image), 1.0) if whole else as_floats(image, preserve_range)
    checked_mode(mode)
    sigmas = _deviations(anti_aliasing_sigma, factors) if anti_aliasing else np.zeros_like(factors)
    clip = clip and not whole
    bounds = limits(source) if clip else EVERYTHING
    counts = tuple(round(old * (1 / factor)) for old, factor in zip(image.shape, factors, strict=True))
    if order > 1:
        out = _spline(source, counts, factors, sigmas, order, mode, cval)
        if clip:
            np.clip(out, *joined(bounds, mode, cval), out=out)
    elif whole:
        out = _picked(source.array, counts, sigmas, mode, cval)
    else:
        out = resampled(source, counts, sigmas, order, mode, cval, joined(bounds, mode, cval))
    if clip:
        clip_to_input(out, bounds, mode, cval)
    return out


def resampled(
    source: Floats,
    counts: tuple[int, ...],
    sigmas: Any,
    order: int,
    mode: str,
    cval: float,
    bounds: tuple[float, float] = EVERYTHING,
) -> Array:
    """Smoothing and interpolation of order 0 or 1 at once."""
    bands = {}
    for axis, (size, count, sigma) in enumerate(zip(source.array.shape, counts, sigmas, strict=True)):
        if count != size:
            bands[axis] = _bands.resizing(size, count, size / max(count, 1), sigma, order, mode)
        elif sigma > 0:
            bands[axis] = _bands.smoothing(size, sigma)
    return _bands.apply(source, bands, mode, cval, bounds)


def smoothed(source: Floats, sigmas: Any, mode: str, cval: float) -> Array:
    """The Gaussian alone."""
    bands = {
        axis: _bands.smoothing(source.array.shape[axis], s) for axis, s in enumerate(sigmas) if s > 1e-15
    }
    return _bands.apply(source, bands, mode, cval)


def _spline(
    source: Floats,
    counts: tuple[int, ...],
    factors: NDArray[np.float64],
    sigmas: NDArray[np.float64],
    order: int,
    mode: str,
    cval: float,
) -> Array:
    ndimage = scipy_ndimage(f"order {order}")
    whole = smoothed(source, sigmas, mode, cval)
    options = {"order": order, "mode": NDIMAGE_MODES[mode], "cval": cval, "grid_mode": True}
    out: Array = ndimage.zoom(whole, [1 / f for f in factors], **options)
    return out


def _picked(
    array: Array, counts: tuple[int, ...], sigmas: NDArray[np.float64], mode: str, cval: float
) -> Array:
    """Nearest elements of any type; a Gaussian of integers is rounded after every axis, as SciPy's is."""
    if (sigmas > 0).any():
        ndimage = scipy_ndimage("a Gaussian of integers")
        array = ndimage.gaussian_filter(array, sigmas, mode=NDIMAGE_MODES[mode], cval=cval)
    picked = array
    for axis, (size, count) in enumerate(zip(array.shape, counts, strict=True)):
        if count != size:
            at = np.floor((np.arange(count) + 0.5) * (size / max(count, 1)))
            picked = np.take(picked, np.clip(at, 0, size - 1).astype(np.int64), axis=axis)
    return picked.copy() if picked is array else picked


def rescale(
    image: Array,
    scale: Any,
    order: int | None = None,
    mode: str = "reflect",
    cval: float = 0,
    clip: bool = True,
    preserve_range: bool = False,
    anti_aliasing: bool | None = None,
    anti_aliasing_sigma: Any = None,
    *,
    channel_axis: Any = None,
) -> Array:
    """``skimage.transform.rescale``: an image of any number of axes, larger or smaller by a factor.

    Parameters
    ----------
    image : array
    scale : float or tuple of floats
        One for all axes that are no channels, or one each.
    order, mode, cval, clip, preserve_range, anti_aliasing, anti_aliasing_sigma
        As for :func:`resize`.
    channel_axis : int, optional
        Axis of channels, which stays.

    Examples
    --------
    >>> import numpy as np
    >>> rescale(np.ones((10, 20, 3)), 0.5, channel_axis=-1).shape
    (5, 10, 3)
    """
    image, axis = channels_last(np.asarray(image), channel_axis)
    spatial = image.ndim - (axis is not None)
    scales = np.array([finite("scale", s) for s in np.atleast_1d(scale)])
    if len(scales) > 1 and len(scales) != spatial:
        raise ValueError(f"scale: got {scale!r}, expected one number or {spatial}")
    wanted = np.maximum(np.round(scales * np.array(image.shape[:spatial])), 1)
    shape = (*wanted, *image.shape[spatial:])
    out = resize(
        image,
        shape,
        order=order,
        mode=mode,
        cval=cval,
        clip=clip,
        preserve_range=preserve_range,
        anti_aliasing=anti_aliasing,
        anti_aliasing_sigma=anti_aliasing_sigma,
    )
    return out if axis is None else np.moveaxis(out, -1, axis)
