"""The truth that filters are judged by, in double precision: slow, exact, and sharing no code with them.

The colour of a pixel is the integral of the *reconstructed* texture over the pixel's preimage, weighted by
the pixel filter::

    value = ∫∫ reconstruction(map(x + s, y + t)) weight(s, t) ds dt

with a bilinear reconstruction and a box over the pixel's square unless said otherwise. What is exact, what is
estimated, and what it costs is told in ``docs/oracle.md``.

Keywords that all functions share:

``wrap``
    What lies outside: ``"clamp"``, ``"repeat"``, ``"mirror"``, ``"mirror_once"``, ``"mirror_101"``,
    ``"border"``, ``"extend"`` (the outermost texels of ``image`` are no part of the texture), or a pair for
    (u, v).
``border``
    The border colour, a number or one for each channel, in linear light and multiplied by alpha. It is also
    the value where a coordinate is not finite.
``encoding``
    ``"linear"``, ``"srgb"`` or ``"normal"``; values are returned decoded.
``alpha``
    ``"none"``, ``"straight"`` (filtered as a product, returned divided, 0 where alpha is 0) or
    ``"premultiplied"``.
``reconstruction``
    ``"nearest"``, ``"bilinear"`` or ``"bicubic"`` (Catmull-Rom).
``pixel_filter``
    ``"box"`` on the pixel's square; ``"tent"``, (1 - |s|)(1 - |t|) on two pixels a side; ``"gaussian"`` with
    standard deviation ``sigma`` pixels, cut off at four of them; ``"point"``, the value at the centre.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum

__all__ = ["max_error", "quad", "rms", "sample", "warp"]

Wrap = Literal["clamp", "repeat", "mirror", "mirror_once", "mirror_101", "border", "extend"]
Encoding = Literal["linear", "srgb", "normal"]
Alpha = Literal["none", "straight", "premultiplied"]
Reconstruction = Literal["nearest", "bilinear", "bicubic"]
PixelFilter = Literal["point", "box", "tent", "gaussian"]
Mapping = Callable[[NDArray[np.float64]], ArrayLike]
Values = NDArray[np.float64]
_Description = tuple[str, str, list[float], str, str, str]


def _describe(
    wrap: Wrap | tuple[Wrap, Wrap],
    border: float | Sequence[float],
    encoding: Encoding,
    alpha: Alpha,
    reconstruction: Reconstruction,
) -> _Description:
    u, v = (wrap, wrap) if isinstance(wrap, str) else wrap
    colour = [float(x) for x in np.ravel(np.asarray(border, np.float64))]
    return u, v, colour, encoding, alpha, reconstruction


@overload
def sample(
    image: ArrayLike,
    uv: ArrayLike,
    jacobian: ArrayLike | None = ...,
    *,
    wrap: Wrap | tuple[Wrap, Wrap] = ...,
    border: float | Sequence[float] = ...,
    encoding: Encoding = ...,
    alpha: Alpha = ...,
    reconstruction: Reconstruction = ...,
    pixel_filter: PixelFilter = ...,
    sigma: float = ...,
    tol: float = ...,
    return_error: Literal[False] = ...,
) -> Values: ...
@overload
def sample(
    image: ArrayLike,
    uv: ArrayLike,
    jacobian: ArrayLike | None = ...,
    *,
    wrap: Wrap | tuple[Wrap, Wrap] = ...,
    border: float | Sequence[float] = ...,
    encoding: Encoding = ...,
    alpha: Alpha = ...,
    reconstruction: Reconstruction = ...,
    pixel_filter: PixelFilter = ...,
    sigma: float = ...,
    tol: float = ...,
    return_error: Literal[True],
) -> tuple[Values, Values]: ...
def sample(
    image: ArrayLike,
    uv: ArrayLike,
    jacobian: ArrayLike | None = None,
    *,
    wrap: Wrap | tuple[Wrap, Wrap] = "repeat",
    border: float | Sequence[float] = 0.0,
    encoding: Encoding = "linear",
    alpha: Alpha = "none",
    reconstruction: Reconstruction = "bilinear",
    pixel_filter: PixelFilter = "box",
    sigma: float = 0.5,
    tol: float = 1e-9,
    return_error: bool = False,
) -> Values | tuple[Values, Values]:
    """Sample a texture over parallelograms: the true value of ``Texture.sample``.

    ``image`` is (H, W) or (H, W, C). ``uv`` (..., 2) lies in [0, 1] across the texture, u right, v down;
    ``jacobian`` (..., 2, 2) holds ``jacobian[..., i, j]``, the change of coordinate i by one pixel right
    (j = 0) or down (j = 1); both broadcast. Returns (..., C) float64, and with ``return_error`` the estimated
    error (...), which is 0 for box and tent: they are in closed form. ``tol`` is the error that the Gaussian
    may have.

    Without a Jacobian, and where it is zero, the value is the reconstruction at the point; where it is not
    finite, the mean texel; where a coordinate is not finite, the border colour.

    Raises ``ValueError`` for footprints over so many repetitions of the texture that they would take minutes,
    and for every argument that is not among those named.

    >>> import numpy as np
    >>> from multum import reference
    >>> impulse = np.zeros((5, 5))
    >>> impulse[2, 2] = 64
    >>> reference.sample(impulse, (0.5, 0.5), np.eye(2) / 5)   # (1 6 1)/8 on each axis
    array([36.])
    """
    uv = np.asarray(uv)
    if jacobian is not None:
        jacobian = np.asarray(jacobian)
        if uv.ndim and jacobian.ndim > 1:
            leading = np.broadcast_shapes(uv.shape[:-1], jacobian.shape[:-2])
            uv = np.broadcast_to(uv, leading + uv.shape[-1:])
            jacobian = np.broadcast_to(jacobian, leading + jacobian.shape[-2:])
    description = _describe(wrap, border, encoding, alpha, reconstruction)
    values, errors = _multum.reference_sample(image, uv, jacobian, description, (pixel_filter, sigma), tol)
    return (values, errors) if return_error else values


def quad(
    image: ArrayLike,
    corners: ArrayLike,
    *,
    wrap: Wrap | tuple[Wrap, Wrap] = "repeat",
    border: float | Sequence[float] = 0.0,
    encoding: Encoding = "linear",
    alpha: Alpha = "none",
    reconstruction: Reconstruction = "bilinear",
) -> Values:
    """Average a texture over convex quads, weighted by area on the *texture*.

    ``corners`` is (..., 4, 2) in uv, in order around each quad, in either sense. Returns (..., C) float64,
    exact to rounding. For a pixel in perspective the truth weights by area on the screen instead: see `warp`.
    The two agree for parallelograms.

    Raises ``ValueError`` for quads without area, concave or crossing ones, and for too many repetitions.

    >>> import numpy as np
    >>> from multum import reference
    >>> ramp = np.arange(8.0)[None, :]
    >>> reference.quad(ramp, [(0.25, 0), (0.5, 0), (0.75, 1), (0.5, 1)])   # centre u = 1/2
    array([3.5])
    """
    return _multum.reference_quad(image, corners, _describe(wrap, border, encoding, alpha, reconstruction))


@overload
def warp(
    image: ArrayLike,
    mapping: ArrayLike | Mapping,
    shape: tuple[int, int] | None = ...,
    *,
    wrap: Wrap | tuple[Wrap, Wrap] = ...,
    border: float | Sequence[float] = ...,
    encoding: Encoding = ...,
    alpha: Alpha = ...,
    reconstruction: Reconstruction = ...,
    pixel_filter: PixelFilter = ...,
    sigma: float = ...,
    tol: float = ...,
    return_error: Literal[False] = ...,
) -> Values: ...
@overload
def warp(
    image: ArrayLike,
    mapping: ArrayLike | Mapping,
    shape: tuple[int, int] | None = ...,
    *,
    wrap: Wrap | tuple[Wrap, Wrap] = ...,
    border: float | Sequence[float] = ...,
    encoding: Encoding = ...,
    alpha: Alpha = ...,
    reconstruction: Reconstruction = ...,
    pixel_filter: PixelFilter = ...,
    sigma: float = ...,
    tol: float = ...,
    return_error: Literal[True],
) -> tuple[Values, Values]: ...
def warp(
    image: ArrayLike,
    mapping: ArrayLike | Mapping,
    shape: tuple[int, int] | None = None,
    *,
    wrap: Wrap | tuple[Wrap, Wrap] = "border",
    border: float | Sequence[float] = 0.0,
    encoding: Encoding = "linear",
    alpha: Alpha = "none",
    reconstruction: Reconstruction = "bilinear",
    pixel_filter: PixelFilter = "box",
    sigma: float = 0.5,
    tol: float = 1e-6,
    return_error: bool = False,
) -> Values | tuple[Values, Values]:
    """Warp a picture: the integral over each *output* pixel's square, seen through ``mapping``.

    ``mapping`` takes output pixels (x, y) to input pixels (x, y), centres at integers on both: a 2x3 or 3x3
    matrix, or a callable from (N, 2) float64 to (N, 2). ``shape`` is (height, width) of the output, that of
    ``image`` by default. Returns (height, width, C) float64, or (height, width) for an image without
    channels; with ``return_error`` also the estimated error (height, width).

    Affine matrices are exact for box and tent. Perspectives are cut exactly and integrated until two rules
    agree to ``tol``. Callables are integrated on ever smaller triangles on which the map is taken as linear,
    at most 4096 squares a pixel; the error tells where that was not enough for ``tol``.

    Raises ``ValueError`` for matrices of another shape or with entries that are not finite, and for affine
    footprints that would take minutes; what the callable raises passes through.

    >>> import numpy as np
    >>> from multum import reference
    >>> half = [[2, 0, 0.5], [0, 2, 0.5]]   # 2 by 2 texels a pixel: (1 7 7 1)/16 on each axis
    >>> reference.warp(np.eye(4), half, (2, 2), wrap="clamp") * 256
    array([[114.,  14.],
           [ 14., 114.]])
    """
    description = _describe(wrap, border, encoding, alpha, reconstruction)
    if shape is None:
        height, width = np.shape(image)[:2]
    else:
        height, width = shape
    matrix: list[list[float]] | None = None
    call: Callable[..., Any] | None = None
    if callable(mapping):
        call = mapping
    else:
        rows = np.asarray(mapping, np.float64)
        if rows.shape == (2, 3):
            rows = np.vstack([rows, (0.0, 0.0, 1.0)])
        if rows.shape != (3, 3):
            raise ValueError(
                f"mapping: got an array of shape {rows.shape}, expected a 2x3 or 3x3 matrix or a callable"
            )
        matrix = rows.tolist()
    values, errors = _multum.reference_warp(
        image, matrix, call, (int(height), int(width)), description, (pixel_filter, sigma), tol
    )
    return (values, errors) if return_error else values


def rms(a: ArrayLike, b: ArrayLike) -> float:
    """Root of the mean squared difference of two arrays of one shape.

    >>> rms([0, 0], [3, 4])
    3.5355339059327378
    """
    return float(np.sqrt(np.mean(_difference(a, b) ** 2)))


def max_error(a: ArrayLike, b: ArrayLike) -> float:
    """Largest absolute difference of two arrays of one shape.

    >>> max_error([0, 0], [3, -4])
    4.0
    """
    return float(np.max(np.abs(_difference(a, b))))


def _difference(a: ArrayLike, b: ArrayLike) -> NDArray[np.float64]:
    """Both as doubles, so that unsigned integers do not wrap; refuses shapes that would broadcast."""
    first, second = np.asarray(a, np.float64), np.asarray(b, np.float64)
    if first.shape != second.shape or first.size == 0:
        raise ValueError(
            f"b: got shape {second.shape}, expected that of a, {first.shape}, with some elements"
        )
    return first - second
