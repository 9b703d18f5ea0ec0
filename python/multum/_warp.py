"""Image warps: remapping, matrices and resizing, anti-aliased by the map's own footprint."""

from collections.abc import Callable, Sequence
from typing import Any, Literal, SupportsFloat, SupportsIndex, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import name, numbers, size_pair, wrap_pair
from ._sampling import sampling
from ._survey import Survey

Border = float | Sequence[float] | NDArray[Any]


@overload
def warp(
    image: ArrayLike,
    mapping: ArrayLike | Callable[[NDArray[np.float64]], ArrayLike],
    shape: Sequence[SupportsIndex] | None = None,
    *,
    filter: str = "auto",
    wrap: str | Sequence[str] = "border",
    border: Border = 0,
    tolerance: float | None = None,
    coverage: Literal[False] = False,
    out: NDArray[Any] | None = None,
    encoding: str = "linear",
    alpha: str = "none",
    max_anisotropy: SupportsFloat | None = 16,
    threads: int | None = None,
) -> NDArray[Any]: ...
@overload
def warp(
    image: ArrayLike,
    mapping: ArrayLike | Callable[[NDArray[np.float64]], ArrayLike],
    shape: Sequence[SupportsIndex] | None = None,
    *,
    filter: str = "auto",
    wrap: str | Sequence[str] = "border",
    border: Border = 0,
    tolerance: float | None = None,
    coverage: Literal[True],
    out: NDArray[Any] | None = None,
    encoding: str = "linear",
    alpha: str = "none",
    max_anisotropy: SupportsFloat | None = 16,
    threads: int | None = None,
) -> tuple[NDArray[Any], NDArray[np.float32]]: ...
def warp(
    image: ArrayLike,
    mapping: ArrayLike | Callable[[NDArray[np.float64]], ArrayLike],
    shape: Sequence[SupportsIndex] | None = None,
    *,
    filter: str = "auto",
    wrap: str | Sequence[str] = "border",
    border: Border = 0,
    tolerance: float | None = None,
    coverage: bool = False,
    out: NDArray[Any] | None = None,
    encoding: str = "linear",
    alpha: str = "none",
    max_anisotropy: SupportsFloat | None = 16,
    threads: int | None = None,
) -> NDArray[Any] | tuple[NDArray[Any], NDArray[np.float32]]:
    """Warp an image by a matrix, a map or a function.

    Each output pixel (X, Y) shows the input around ``mapping(X, Y)``. Pixel centres are at whole numbers, x to
    the right, y down, as in OpenCV (with ``WARP_INVERSE_MAP``) and in scikit-image (``inverse_map``). Where the
    map minifies, the result is the filtered footprint of each pixel; where it magnifies, the interpolation.

    Parameters
    ----------
    image : array, shape (H, W) or (H, W, C)
        ``uint8``, ``uint16``, ``float16``, ``float32`` or ``float64``; any size, any number of channels.
    mapping : array of shape (2, 3) or (3, 3), array of shape (H', W', 2), or callable
        From output pixels to input pixels. A matrix acts on (X, Y, 1) and its footprint is known in closed
        form. A map holds x and y for each output pixel. A callable gets an array (N, 2) of output pixels and
        returns theirs. The footprint of the last two is the difference to the neighbours; cuts in the map and
        whole periods (under ``wrap="repeat"``) are left out. Places that are not finite show the border.
    shape : (height, width), optional
        Of the result. Default: the map's own, else the image's.
    filter : str
        ``"auto"`` (default) or another filter of :meth:`multum.Texture.sample`.
    wrap : str or pair of str
        What lies outside, along x and y: ``"border"`` (default), ``"clamp"``, ``"repeat"``, ``"mirror"``,
        ``"mirror_once"``, ``"mirror_101"``.
    border : number or sequence of numbers
        Colour outside, in the image's own units.
    tolerance : float, optional
        Largest error that ``"auto"`` may make, as a share of full scale.
    coverage : bool
        Also return, for each pixel, the share of it that lies inside the image.
    out : array, optional
        Receives the result.
    encoding, alpha : str
        What the codes mean, as for :class:`multum.Texture`. ``encoding="srgb"`` filters in linear light,
        ``alpha="straight"`` with premultiplied colour; the result is in the image's encoding again.
    max_anisotropy : float, optional
        Longest footprint, in widths, that is followed; None, and all above, for 1024.
    threads : int, optional
        Threads to use; the result does not depend on it.

    Returns
    -------
    array, shape (height, width) or (height, width, C)
        Of the image's dtype, rounded to nearest. With ``coverage=True`` a pair: the image and an array
        (height, width) ``float32``.

    Raises
    ------
    ValueError, TypeError
        For a shape, dtype, name or number that is not as above.

    Examples
    --------
    >>> import numpy as np, multum as mt
    >>> stripes = np.tile(np.uint8([0, 200]), (4, 8))
    >>> mt.warp(stripes, [[1, 0, 0.5], [0, 1, 0]], shape=(1, 3)).tolist()
    [[100, 100, 100]]
    >>> mt.warp(stripes, lambda xy: xy * 4, shape=(1, 2), wrap="repeat").tolist()
    [[100, 100]]
    """
    pixels = np.asarray(image)
    places, size = _placed(pixels, mapping, shape, wrap)
    options = _options(pixels, filter, wrap, border, tolerance, encoding, alpha, max_anisotropy, threads)
    made = _multum.warp_image(pixels, places, size, options, out)
    if not coverage:
        return made
    return made, _multum.warp_coverage((pixels.shape[0], pixels.shape[1]), places, size, options)


def _placed(
    pixels: NDArray[Any],
    mapping: ArrayLike | Callable[[NDArray[np.float64]], ArrayLike],
    shape: Sequence[SupportsIndex] | None,
    wrap: str | Sequence[str],
) -> tuple[_multum.Places, tuple[int, int]]:
    """The places of all output pixels and the output's shape."""
    if callable(mapping):
        height, width = size_pair("shape", pixels.shape[:2] if shape is None else shape)
        grid = np.empty((height, width, 2))
        grid[..., 0], grid[..., 1] = np.arange(width), np.arange(height)[:, None]
        array = np.asarray(mapping(grid.reshape(-1, 2)))
        if array.shape != (height * width, 2):
            raise ValueError(
                f"mapping: got shape {array.shape} from the callable, expected {(height * width, 2)}"
            )
        array = array.reshape(height, width, 2)
    else:
        array = np.asarray(mapping)
    if array.ndim == 2 and array.shape[0] in (2, 3) and array.shape[1] == 3:
        if not np.issubdtype(array.dtype, np.number) or np.iscomplexobj(array):
            raise TypeError(f"mapping: got dtype {array.dtype}, expected a matrix of real numbers")
        matrix: _multum.Matrix = np.vstack([array, [[0, 0, 1]]])[:3].astype(np.float64).tolist()
        places = _multum.Places(matrix, None, None, _period(pixels, wrap))
        size = size_pair("shape", pixels.shape[:2] if shape is None else shape)
    elif array.ndim == 3 and array.shape[2] == 2:
        places = _multum.Places(None, array, None, _period(pixels, wrap))
        size = size_pair("shape", array.shape[:2] if shape is None else shape)
        if size != array.shape[:2]:
            raise ValueError(f"shape: got {size}, expected that of the map, {array.shape[:2]}")
    else:
        expected = "a matrix (2, 3) or (3, 3), a map (H, W, 2) or a callable"
        raise ValueError(f"mapping: got shape {array.shape}, expected {expected}")
    return places, size


def survey(
    image: ArrayLike,
    mapping: ArrayLike | Callable[[NDArray[np.float64]], ArrayLike],
    shape: Sequence[SupportsIndex] | None = None,
    *,
    filter: str = "auto",
    wrap: str | Sequence[str] = "border",
    border: Border = 0,
    tolerance: float | None = None,
    encoding: str = "linear",
    alpha: str = "none",
    max_anisotropy: SupportsFloat | None = 16,
    threads: int | None = None,
) -> Survey:
    """What :func:`multum.warp` with the same arguments spends on each output pixel, and on which level it reads.

    Parameters
    ----------
    image, mapping, shape, filter, wrap, border, tolerance, encoding, alpha, max_anisotropy, threads
        As for :func:`multum.warp`.

    Returns
    -------
    Survey
        ``cost`` and ``lod``, each of shape (height, width), ``float32``; ``picture("cost")`` draws them.

    Raises
    ------
    ValueError, TypeError
        As :func:`multum.warp`.

    Examples
    --------
    A grey picture takes one trilinear look-up a pixel, however much it shrinks:

    >>> import numpy as np, multum as mt
    >>> grey = np.full((64, 64), 90, np.uint8)
    >>> mt.survey(grey, [[7, 0, 0], [0, 7, 0]], (9, 9), wrap="repeat").cost.max()
    np.float32(8.0)
    """
    pixels = np.asarray(image)
    places, size = _placed(pixels, mapping, shape, wrap)
    options = _options(pixels, filter, wrap, border, tolerance, encoding, alpha, max_anisotropy, threads)
    return Survey(*_multum.warp_survey(pixels, places, size, options))


def remap(
    image: ArrayLike,
    map_x: ArrayLike,
    map_y: ArrayLike,
    *,
    filter: str = "auto",
    wrap: str | Sequence[str] = "border",
    border: Border = 0,
    tolerance: float | None = None,
    out: NDArray[Any] | None = None,
    encoding: str = "linear",
    alpha: str = "none",
    max_anisotropy: SupportsFloat | None = 16,
    threads: int | None = None,
) -> NDArray[Any]:
    """Warp an image by two maps: output pixel (X, Y) shows the input around (map_x[Y, X], map_y[Y, X]).

    Parameters
    ----------
    image : array, shape (H, W) or (H, W, C)
        The input.
    map_x, map_y : arrays, shape (H', W')
        Input columns and rows, ``float32`` or ``float64``, pixel centres at whole numbers.
    filter, wrap, border, tolerance, out, encoding, alpha, max_anisotropy, threads
        As for :func:`multum.warp`.

    Returns
    -------
    array, shape (H', W') or (H', W', C)
        Of the image's dtype.

    Raises
    ------
    ValueError, TypeError
        As :func:`multum.warp`.

    Examples
    --------
    >>> import numpy as np, multum as mt
    >>> x, y = np.meshgrid(np.float32([0, 0.5, 1]), np.float32([0]))
    >>> mt.remap(np.uint8([[10, 20]]), x, y).tolist()
    [[10, 15, 20]]
    """
    pixels = np.asarray(image)
    xs, ys = np.asarray(map_x), np.asarray(map_y)
    if xs.ndim != 2 or xs.shape != ys.shape:
        raise ValueError(f"map_y: got shapes {xs.shape} and {ys.shape}, expected two equal shapes (H, W)")
    if xs.dtype != ys.dtype:
        xs, ys = xs.astype(np.float64), ys.astype(np.float64)
    options = _options(pixels, filter, wrap, border, tolerance, encoding, alpha, max_anisotropy, threads)
    places = _multum.Places(None, xs, ys, _period(pixels, wrap))
    return _multum.warp_image(pixels, places, (xs.shape[0], xs.shape[1]), options, out)


def resize(
    image: ArrayLike,
    shape: Sequence[SupportsIndex],
    filter: str = "auto",
    *,
    wrap: str | Sequence[str] = "clamp",
    border: Border = 0,
    tolerance: float | None = None,
    out: NDArray[Any] | None = None,
    encoding: str = "linear",
    alpha: str = "none",
    max_anisotropy: SupportsFloat | None = 16,
    threads: int | None = None,
) -> NDArray[Any]:
    """Resize an image, edges on edges: output pixel X shows the input around (X + 1/2) W/W' - 1/2.

    Parameters
    ----------
    image : array, shape (H, W) or (H, W, C)
        The input.
    shape : (height, width)
        Of the result.
    filter, wrap, border, tolerance, out, encoding, alpha, max_anisotropy, threads
        As for :func:`multum.warp`.

    Returns
    -------
    array, shape (height, width) or (height, width, C)
        Of the image's dtype.

    Raises
    ------
    ValueError, TypeError
        As :func:`multum.warp`.

    Examples
    --------
    >>> import numpy as np, multum as mt
    >>> mt.resize(np.full((5, 7), 9, np.uint16), (2, 3)).tolist()
    [[9, 9, 9], [9, 9, 9]]
    """
    pixels = np.asarray(image)
    height, width = size_pair("shape", shape)
    options = _options(pixels, filter, wrap, border, tolerance, encoding, alpha, max_anisotropy, threads)
    sy, sx = (n / m for n, m in zip(pixels.shape[:2], (height, width), strict=True))
    matrix = ([sx, 0.0, 0.5 * sx - 0.5], [0.0, sy, 0.5 * sy - 0.5], [0.0, 0.0, 1.0])
    return _multum.warp_image(
        pixels, _multum.Places(matrix, None, None, (None, None)), (height, width), options, out
    )


def _options(
    pixels: NDArray[Any],
    filter: str,
    wrap: str | Sequence[str],
    border: Border,
    tolerance: float | None,
    encoding: str,
    alpha: str,
    max_anisotropy: SupportsFloat | None,
    threads: int | None,
) -> _multum.Warping:
    """All options of a warp, checked."""
    if pixels.ndim not in (2, 3):
        raise ValueError(f"image: got shape {pixels.shape}, expected (H, W) or (H, W, C)")
    channels = pixels.shape[2] if pixels.ndim == 3 else 1
    outside = numbers("border", border, channels)
    chosen = sampling(filter, max_anisotropy, tolerance=tolerance, threads=threads)
    return _multum.Warping(chosen, wrap_pair(wrap), outside, name("encoding", encoding), name("alpha", alpha))


def _period(pixels: NDArray[Any], wrap: str | Sequence[str]) -> tuple[float | None, float | None]:
    """Along a repeating axis a step of nearly a whole period is a small step."""
    u, v = wrap_pair(wrap)
    return (
        float(pixels.shape[1]) if u == "repeat" else None,
        float(pixels.shape[0]) if v == "repeat" else None,
    )
