"""Images as scikit-image takes them: dtypes, ranges, modes, axes of channels."""

import math
import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ... import _multum

Array = NDArray[Any]
MODES = ("constant", "edge", "symmetric", "reflect", "wrap")
NDIMAGE_MODES = {
    "constant": "grid-constant",
    "edge": "nearest",
    "symmetric": "reflect",
    "reflect": "mirror",
    "wrap": "grid-wrap",
}
EVERYTHING = (-math.inf, math.inf)


MOST = 1 << 40
"""Elements of a result, at most."""


class IndicesError(IndexError, ValueError):
    """Wrong indices: scikit-image's ``IndexError``, and a ``ValueError`` as elsewhere here."""


class ShapeError(RuntimeError, ValueError):
    """Arrays that do not fit together: SciPy's ``RuntimeError``, and a ``ValueError`` as elsewhere here."""


def sized(argument: str, value: Any) -> tuple[Any, ...]:
    """Sizes as they were given, where their product is no more than fits anywhere."""
    sizes = tuple(np.atleast_1d(np.asarray(value)).tolist()) if np.ndim(value) < 2 else ()
    if not sizes or any(isinstance(n, bool) or not isinstance(n, int | float) for n in sizes):
        raise ValueError(f"{argument}: got {value!r}, expected a tuple of numbers")
    if not all(abs(n) <= MOST for n in sizes) or math.prod(max(abs(n), 1) for n in sizes) > MOST:
        raise ValueError(f"{argument}: got {value!r}, expected at most 2^40 elements")
    return sizes


def finite(argument: str, value: Any) -> float:
    """A number that is neither infinite nor NaN."""
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"{argument}: got {value!r}, expected a finite number")
    return number


def picture(image: Any) -> Array:
    """An array with rows and columns."""
    array = np.asarray(image)
    if array.ndim < 2:
        raise ValueError(f"image: got shape {array.shape}, expected rows and columns")
    return array


class Floats(NamedTuple):
    """An image whose numbers are ``array * factor``: 8 and 16 bit codes are multiplied where they are read."""

    array: Array
    factor: float

    @property
    def dtype(self) -> np.dtype[Any]:
        """Of the image that it stands for."""
        return np.dtype(np.float32 if self.array.dtype == np.float32 else np.float64)

    def whole(self) -> Array:
        """The image itself."""
        if self.array.dtype.kind == "f":
            return self.array
        return np.multiply(self.array, self.factor, dtype=np.float64)


def scipy_ndimage(what: str) -> Any:
    """``scipy.ndimage``, or an error that names the extra."""
    try:
        from scipy import ndimage
    except ImportError as missing:
        raise ImportError(f"{what} needs SciPy: pip install 'multum[skimage]'") from missing
    return ndimage


def plain(image: Array) -> Array:
    """The same elements, C-contiguous, aligned and of native byte order: itself where it is that already."""
    array = np.asarray(image)
    return np.require(array, array.dtype.newbyteorder("="), ["C", "A"])


def as_floats(image: Array, preserve_range: bool) -> Floats:
    """scikit-image's conversion: integers to [0, 1] or [-1, 1] unless the range is preserved; singles stay."""
    image = np.asarray(image)
    kind, size = image.dtype.kind, image.dtype.itemsize
    if kind == "f":
        number = np.float32 if size == 2 else image.dtype if size in (4, 8) else np.float64
        return Floats(plain(image.astype(number, copy=False)), 1.0)
    if preserve_range:
        return Floats(plain(image if kind == "u" and size <= 2 else image.astype(float)), 1.0)
    if kind == "b":
        return Floats(plain(image.astype(float)), 1.0)
    if kind not in "iu":
        raise ValueError(f"image: got dtype {image.dtype}, expected bool, integers or floats")
    factor = 1.0 / np.iinfo(image.dtype).max
    if kind == "u" and size <= 2:
        return Floats(plain(image), factor)
    values = np.multiply(image, factor, dtype=np.float64)
    # The lowest code of a signed type is one below the negative of the highest.
    return Floats(plain(np.maximum(values, -1.0)), 1.0)


def checked_order(dtype: np.dtype[Any], order: int | None) -> int:
    """The order of interpolation; without one, 0 for truth values and else 1."""
    if order is None:
        return 0 if dtype.kind == "b" else 1
    if order < 0 or order > 5:
        raise ValueError(f"order: got {order}, expected 0 to 5")
    if dtype.kind == "b" and order != 0:
        raise ValueError(f"order: got {order} for an image of bool, expected 0")
    return order


def checked_mode(mode: str) -> str:
    """The mode, if there is one of that name."""
    if mode not in MODES:
        raise ValueError(f"mode: got {mode!r}, expected one of {', '.join(map(repr, MODES))}")
    return mode


def whole_numbers(value: Any, tolerance: float = 1e-3) -> NDArray[np.int64]:
    """Numbers that are whole up to a tolerance, as integers."""
    numbers = np.asarray(sized("output_shape", value))
    rounded: NDArray[np.int64] = np.asarray(np.rint(numbers), np.int64)
    if not np.allclose(numbers, rounded, rtol=0, atol=tolerance):
        raise ValueError(f"output_shape: got {value!r}, expected whole numbers")
    return rounded


def limits(image: Floats) -> tuple[float, float]:
    """Least and greatest number of an image, without NaN where there are others."""
    array = image.array
    if array.size == 0:
        raise ValueError(f"image: got shape {array.shape}, expected a size that is not 0")
    if array.dtype.kind == "f":
        low, high, nan = _multum.value_range(array)
        if nan and low > high:
            warnings.warn("All-NaN slice encountered", RuntimeWarning, stacklevel=4)
            return math.nan, math.nan
        return low, high
    return float(array.min() * image.factor), float(array.max() * image.factor)


def joined(bounds: tuple[float, float], mode: str, cval: float) -> tuple[float, float]:
    """Limits that ``cval`` is within, where it is what lies outside."""
    if mode != "constant" or math.isnan(cval):
        return bounds
    return min(bounds[0], cval), max(bounds[1], cval)


def clip_to_input(out: Array, bounds: tuple[float, float], mode: str, cval: float) -> None:
    """Ends what limits passed through :func:`joined` began.

    ``cval`` widens the range of the input only where some result reaches it.
    """
    low, high = bounds
    if math.isnan(low):
        out[...] = math.nan
        return
    if mode != "constant" or low <= cval <= high or not out.size:
        return
    corners = out[tuple(slice(None, None, max(n - 1, 1)) for n in out.shape[:2])]
    if (corners == cval).any():
        return
    least, most, nan = _multum.value_range(plain(out))
    if nan or not least <= cval <= most:
        np.clip(out, low, high, out=out)


def element(number: float, dtype: np.dtype[Any]) -> Any:
    """A number as an element: cut to a bool; rounded to an integer, away from zero at halves, and saturated."""
    if dtype.kind == "b":
        return dtype.type(abs(number) >= 1)
    if dtype.kind not in "iu":
        return np.array(number).astype(dtype)
    if math.isnan(number):
        return dtype.type(0)
    bounds = np.iinfo(dtype)
    # Compared as Python's integers, which have no limits.
    whole = number if math.isinf(number) else math.floor(abs(number) + 0.5) * (1 if number > 0 else -1)
    return dtype.type(int(min(max(whole, bounds.min), bounds.max)))


def channels_last(image: Array, channel_axis: Any) -> tuple[Array, int | None]:
    """The image with its channels on the last axis, and the axis that they came from."""
    if channel_axis is None:
        return image, None
    if not np.isscalar(channel_axis):
        axes: Sequence[int] = tuple(channel_axis)
        if len(axes) > 1:
            raise ValueError(f"channel_axis: got {channel_axis!r}, expected a single axis")
        channel_axis = axes[0]
    return np.moveaxis(image, channel_axis, -1), channel_axis
