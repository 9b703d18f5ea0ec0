"""Arguments of maps and surfaces, brought into one form."""

from collections.abc import Sequence
from typing import Any, SupportsFloat

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = Sequence[SupportsFloat] | NDArray[Any]
Bounds = tuple[Vector, Vector] | Sequence[Vector] | NDArray[Any]


def floats(argument: str, value: object, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Numbers of this shape; -1 stands for any count."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{argument}: got {value!r}, expected numbers of shape {shape}") from None
    if array.ndim != len(shape) or any(s not in (-1, n) for s, n in zip(shape, array.shape, strict=True)):
        raise ValueError(f"{argument}: got shape {array.shape}, expected {shape}")
    return array


def triple(argument: str, value: object) -> tuple[float, float, float]:
    x, y, z = floats(argument, value, (3,)).tolist()
    return x, y, z


def pair(argument: str, value: object) -> tuple[float, float]:
    a, b = floats(argument, value, (2,)).tolist()
    return a, b


def single(argument: str, value: object) -> float:
    return float(floats(argument, value, ()))


def box(bounds: Bounds | None) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    if bounds is None:
        return (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    low, high = floats("bounds", bounds, (2, 3))
    return triple("bounds", low), triple("bounds", high)


def like(argument: str, value: ArrayLike | None, points: NDArray[Any], size: int) -> NDArray[Any] | None:
    """An array with one vector a point, repeated where it has fewer axes."""
    if value is None:
        return None
    array = np.asarray(value)
    shape = (*points.shape[:-1], size)
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise ValueError(
            f"{argument}: got shape {array.shape}, expected {shape} or one that broadcasts to it"
        ) from None
