"""Gaussian and Laplacian pyramids."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from ._images import Array, Floats, as_floats, checked_mode, checked_order, finite
from ._resize import resampled, resize, smoothed

# The smoothing of these functions follows SciPy's names, whose "reflect" repeats the edge.
_SMOOTHING_MODES = {
    "reflect": "symmetric",
    "symmetric": "symmetric",
    "constant": "constant",
    "edge": "edge",
    "wrap": "wrap",
}


def _check(name: str, factor: float, sigma: float | None) -> float:
    """The standard deviation: a third of the factor, unless it is given."""
    if finite(name, factor) <= 1:
        raise ValueError(f"{name}: got {factor}, expected more than 1")
    if sigma is not None and finite("sigma", sigma) < 0:
        raise ValueError(f"sigma: got {sigma}, expected no negative number")
    return 2 * factor / 6.0 if sigma is None else sigma


def _sigmas(image: Array, sigma: float, channel_axis: int | None) -> list[float]:
    spared = None if channel_axis is None else channel_axis % image.ndim
    return [0.0 if axis == spared else sigma for axis in range(image.ndim)]


def _scaled(image: Array, factor: float, channel_axis: int | None) -> tuple[int, ...]:
    spared = None if channel_axis is None else channel_axis % image.ndim
    return tuple(n if axis == spared else math.ceil(n * factor) for axis, n in enumerate(image.shape))


def _reduced(image: Array, downscale: float, channel_axis: int | None) -> tuple[int, ...]:
    spared = None if channel_axis is None else channel_axis % image.ndim
    return tuple(n if axis == spared else math.ceil(n / downscale) for axis, n in enumerate(image.shape))


def pyramid_reduce(
    image: Array,
    downscale: float = 2,
    sigma: float | None = None,
    order: int = 1,
    mode: str = "reflect",
    cval: float = 0,
    preserve_range: bool = False,
    *,
    channel_axis: int | None = None,
) -> Array:
    """``skimage.transform.pyramid_reduce``: smoothed, then smaller.

    Parameters
    ----------
    image : array
    downscale : float
        Above 1.
    sigma : float, optional
        Of the Gaussian; default ``downscale / 3``.
    order, mode, cval, preserve_range
        As for :func:`resize`.
    channel_axis : int, optional
        Axis of channels, which stays.

    Examples
    --------
    >>> import numpy as np
    >>> pyramid_reduce(np.ones((5, 8))).shape
    (3, 4)
    """
    sigma = _check("downscale", downscale, sigma)
    checked_mode(mode)
    source = as_floats(np.asarray(image), preserve_range)
    shape = _reduced(source.array, float(downscale), channel_axis)
    sigmas = _sigmas(source.array, sigma, channel_axis)
    order = checked_order(source.dtype, order)
    if order < 2 and mode not in ("edge", "constant"):
        # No place between pixels of the smaller image lies beyond those of the larger: one pass does both.
        return resampled(source, shape, sigmas, order, _SMOOTHING_MODES[mode], cval)
    smooth = smoothed(source, sigmas, _SMOOTHING_MODES[mode], cval)
    return resize(smooth, shape, order=order, mode=mode, cval=cval, anti_aliasing=False)


def pyramid_expand(
    image: Array,
    upscale: float = 2,
    sigma: float | None = None,
    order: int = 1,
    mode: str = "reflect",
    cval: float = 0,
    preserve_range: bool = False,
    *,
    channel_axis: int | None = None,
) -> Array:
    """``skimage.transform.pyramid_expand``: larger, then smoothed.

    Parameters
    ----------
    image : array
    upscale : float
        Above 1.
    sigma : float, optional
        Of the Gaussian; default ``upscale / 3``.
    order, mode, cval, preserve_range
        As for :func:`resize`.
    channel_axis : int, optional
        Axis of channels, which stays.

    Examples
    --------
    >>> import numpy as np
    >>> pyramid_expand(np.ones((3, 4))).shape
    (6, 8)
    """
    sigma = _check("upscale", upscale, sigma)
    checked_mode(mode)
    source = as_floats(np.asarray(image), preserve_range)
    shape = _scaled(source.array, upscale, channel_axis)
    larger = resize(source.whole(), shape, order=order, mode=mode, cval=cval, anti_aliasing=False)
    return smoothed(Floats(larger, 1.0), _sigmas(larger, sigma, channel_axis), _SMOOTHING_MODES[mode], cval)


def pyramid_gaussian(
    image: Array,
    max_layer: int = -1,
    downscale: float = 2,
    sigma: float | None = None,
    order: int = 1,
    mode: str = "reflect",
    cval: float = 0,
    preserve_range: bool = False,
    *,
    channel_axis: int | None = None,
) -> Iterator[Array]:
    """``skimage.transform.pyramid_gaussian``: the image, then each :func:`pyramid_reduce` of the one before.

    Parameters
    ----------
    image : array
    max_layer : int
        Last layer, from 0; -1 for all, until the size stays.
    downscale, sigma, order, mode, cval, preserve_range, channel_axis
        As for :func:`pyramid_reduce`.

    Yields
    ------
    array of floats

    Examples
    --------
    >>> import numpy as np
    >>> [layer.shape for layer in pyramid_gaussian(np.ones((5, 8)))]
    [(5, 8), (3, 4), (2, 2), (1, 1)]
    """
    _check("downscale", downscale, sigma)
    layer = as_floats(np.asarray(image), preserve_range).whole()
    yield layer
    count = 0
    while count != max_layer:
        count += 1
        smaller = pyramid_reduce(layer, downscale, sigma, order, mode, cval, channel_axis=channel_axis)
        if smaller.shape == layer.shape:
            return
        layer = smaller
        yield layer


def pyramid_laplacian(
    image: Array,
    max_layer: int = -1,
    downscale: float = 2,
    sigma: float | None = None,
    order: int = 1,
    mode: str = "reflect",
    cval: float = 0,
    preserve_range: bool = False,
    *,
    channel_axis: int | None = None,
) -> Iterator[Array]:
    """``skimage.transform.pyramid_laplacian``: what smoothing takes from the image, layer by layer.

    Parameters
    ----------
    image : array
    max_layer : int
        Last layer, from 0; -1 for all, down to a single pixel.
    downscale, sigma, order, mode, cval, preserve_range, channel_axis
        As for :func:`pyramid_reduce`.

    Yields
    ------
    array of floats

    Examples
    --------
    >>> import numpy as np
    >>> [layer.shape for layer in pyramid_laplacian(np.ones((5, 8)))]
    [(5, 8), (3, 4), (2, 2), (1, 1)]
    """
    sigma = _check("downscale", downscale, sigma)
    layer = as_floats(np.asarray(image), preserve_range).whole()

    def smooth(picture: Array) -> Array:
        sigmas = _sigmas(picture, sigma, channel_axis)
        return smoothed(Floats(picture, 1.0), sigmas, _SMOOTHING_MODES[checked_mode(mode)], cval)

    soft = smooth(layer)
    yield layer - soft
    if max_layer == -1:
        spared = None if channel_axis is None else channel_axis % layer.ndim
        longest = max(n for axis, n in enumerate(layer.shape) if axis != spared)
        max_layer = math.ceil(math.log(longest, downscale))
    for _ in range(max_layer):
        shape = _reduced(soft, float(downscale), channel_axis)
        options: dict[str, Any] = {"order": order, "mode": mode, "cval": cval, "anti_aliasing": False}
        layer = resize(soft, shape, **options)
        soft = smooth(layer)
        yield layer - soft
