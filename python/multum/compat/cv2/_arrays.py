"""Arguments of OpenCV's functions, brought into the form that the kernels take."""

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]
Made = TypeVar("Made")

CHANNELS_OF_EXACT_LINEAR = (1, 3, 4)
EXACT_LINEAR = (np.uint8, np.uint16, np.float32)
KERNEL_TYPES = frozenset(
    np.dtype(t) for t in (np.uint8, np.uint16, np.int16, np.float16, np.float32, np.float64)
)
# Types that are only copied, never computed with, travel as others of their size.
CARRIERS = {1: np.uint8, 2: np.uint16, 4: np.float32, 8: np.float64}


class error(ValueError, TypeError):
    """A wrong argument: what ``cv2.error`` is, and a ``ValueError`` and ``TypeError`` at the same time."""


def image(argument: str, value: ArrayLike, nearest: bool = False) -> Array:
    """An image as a native, C-contiguous array of shape (H, W, C)."""
    array = np.asarray(value)
    if array.ndim not in (2, 3) or array.size == 0:
        raise error(f"{argument}: got shape {array.shape}, expected (H, W) or (H, W, C) without empty axes")
    if not array.dtype.isnative:
        array = array.astype(array.dtype.newbyteorder("="))
    if array.dtype not in KERNEL_TYPES and not (nearest and array.dtype.kind in "biu"):
        expected = "uint8, uint16, int16, float16, float32 or float64"
        raise error(f"{argument}: got dtype {array.dtype}, expected {expected}")
    if array.ndim == 2:
        array = array[:, :, np.newaxis]
    return np.ascontiguousarray(array)


def size(
    argument: str, value: Sequence[int] | None, default: tuple[int, int] | None = None
) -> tuple[int, int]:
    """A pair (width, height); zeros and None stand for the default where there is one."""
    try:
        pair = (0, 0) if value is None else tuple(int(v) for v in value)
    except (TypeError, ValueError, OverflowError):
        pair = ()
    if len(pair) != 2 or min(pair) < 0 or max(pair) > 1 << 30:
        raise error(f"{argument}: got {value!r}, expected a pair (width, height) of whole numbers")
    if 0 in pair:
        if default is None or pair != (0, 0):
            raise error(f"{argument}: got {value!r}, expected positive numbers")
        return default
    return pair[0], pair[1]


def matrix(argument: str, value: ArrayLike, rows: int) -> NDArray[np.float64]:
    """A matrix of ``rows`` x 3 doubles."""
    array = np.asarray(value)
    if array.shape != (rows, 3) or array.dtype not in (np.float32, np.float64):
        expected = f"shape ({rows}, 3) and dtype float32 or float64"
        raise error(f"{argument}: got shape {array.shape} and dtype {array.dtype}, expected {expected}")
    return array.astype(np.float64)


def border_colour(value: Any, channels: int) -> list[float]:
    """OpenCV's scalar: up to four numbers, missing ones 0."""
    try:
        numbers = np.zeros(0) if value is None else np.atleast_1d(np.asarray(value, np.float64)).ravel()
    except (TypeError, ValueError):
        raise error(f"borderValue: got {value!r}, expected up to {max(channels, 4)} numbers") from None
    if numbers.size > max(channels, 4):
        raise error(f"borderValue: got {numbers.size} numbers, expected up to {max(channels, 4)}")
    colour = np.zeros(max(channels, 4))
    colour[: numbers.size] = numbers
    return [float(v) for v in colour[:channels]]


def maps(map1: Any, map2: Any) -> tuple[Array, Array | None]:
    """Two arrays (H, W), or one (H, W, 2), of floats; or int16 pairs with uint16 codes or nothing."""
    first = np.asarray(map1)
    second = None if map2 is None else np.asarray(map2)
    if second is not None and second.size == 0:
        second = None
    if second is not None and second.dtype == np.int16 and second.ndim == 3:
        first, second = second, first
    kinds = (np.dtype(np.float32), np.dtype(np.float64))
    pairs = first.ndim == 3 and first.shape[2] == 2
    if second is not None and second.ndim == 3 and second.shape[2] == 1:
        second = second[:, :, 0]
    if first.ndim == 3 and first.shape[2] == 1:
        first = first[:, :, 0]
    fits = second is None or second.shape == first.shape[:2]
    if (
        pairs
        and first.dtype == np.int16
        and fits
        and (second is None or second.dtype in (np.uint16, np.int16))
    ):
        codes = None if second is None else np.ascontiguousarray(second).view(np.uint16)
        return np.ascontiguousarray(first), codes
    if pairs and first.dtype in kinds and second is None:
        return np.ascontiguousarray(first), None
    if first.ndim == 2 and first.dtype in kinds and second is not None and fits and second.dtype in kinds:
        common = np.result_type(first, second)
        return np.ascontiguousarray(first, common), np.ascontiguousarray(second, common)
    got = f"map1 {first.dtype} {first.shape}, map2 " + (
        "none" if second is None else f"{second.dtype} {second.shape}"
    )
    expected = "two float arrays (H, W), one (H, W, 2), or int16 (H, W, 2) with uint16 (H, W) or without"
    raise error(f"map1, map2: got {got}, expected {expected}")


def target(
    dst: Array | None,
    shape: tuple[int, ...],
    dtype: np.dtype[Any],
    inputs: Sequence[Array | None],
    keep: bool,
) -> Array:
    """An array (H, W, C) to work in: ``dst`` itself where that can be, with its content where ``keep``."""
    flat = shape[:2] if shape[2] == 1 else shape
    usable = isinstance(dst, np.ndarray) and dst.shape in (flat, shape) and dst.dtype == dtype
    if usable and dst is not None:
        clean = dst.flags.c_contiguous and dst.flags.writeable and dst.dtype.isnative
        if clean and not any(given is not None and np.may_share_memory(dst, given) for given in inputs):
            return dst.reshape(shape)
        if keep:
            return np.ascontiguousarray(dst, dtype.newbyteorder("=")).reshape(shape).copy()
    return (np.zeros if keep else np.empty)(shape, dtype)


def delivered(work: Array, dst: Array | None) -> Array:
    """The result as OpenCV returns it: in ``dst`` where it fits, and (H, W) for one channel."""
    result = work[:, :, 0] if work.shape[2] == 1 else work
    if isinstance(dst, np.ndarray) and dst.size == work.size and dst.dtype == work.dtype:
        if dst.shape == work.shape:
            result = work
        if dst.shape == result.shape and dst.flags.writeable:
            if not np.may_share_memory(dst, work):
                dst[...] = result
            return dst
    return result


def limits(dtype: np.dtype[Any]) -> tuple[int, int]:
    """The least and the greatest number of a type of integers."""
    if dtype.kind == "b":
        return 0, 1
    limits = np.iinfo(dtype)
    return int(limits.min), int(limits.max)


def made(result: Made | None) -> Made:
    """What a compiled function answers to arguments that it must take."""
    if result is None:
        raise error("src: got memory that cannot be read as it lies, expected an array of numbers")
    return result
