"""Pictures of every kind and in every place of memory."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
RANGES = {"uint8": (0, 255), "uint16": (0, 65535), "int16": (-32768, 32767), "int8": (-128, 127)}


def picture(rng: np.random.Generator, shape: tuple[int, ...], dtype: Any) -> Array:
    """Noise, or a smooth pattern, over the range of the type; floats from 0 to 1 or 0 to 255."""
    kind = np.dtype(dtype)
    if rng.random() < 0.5:
        values = rng.random(shape)
    else:
        places = np.indices(shape, dtype=np.float64)
        waves = [
            np.sin(p * w + q)
            for p, w, q in zip(places, rng.uniform(0.05, 0.3, 9), rng.random(9), strict=False)
        ]
        values = 0.5 + 0.5 * sum(waves) / len(waves)
    if kind.kind == "b":
        result: Array = values > 0.5
    elif kind.name in RANGES:
        low, high = RANGES[kind.name]
        result = np.rint(low + values * (high - low)).astype(kind)
    elif kind.kind in "iu":
        result = np.rint(values * 1e6).astype(kind)
    else:
        result = (values * float(rng.choice([1.0, 255.0]))).astype(kind)
    return result


LAYOUTS = ("packed", "read-only", "reversed", "columns", "foreign", "fortran", "window", "mirrored")


def laid_out(rng: np.random.Generator, array: Array) -> tuple[Array, str]:
    """The same elements somewhere else in memory."""
    name = str(rng.choice(LAYOUTS, p=[0.44, *[0.08] * 7]))
    if name == "read-only":
        array = array.copy()
        array.flags.writeable = False
    elif name == "reversed":
        array = array[::-1].copy()[::-1]
    elif name == "columns":
        wide = np.zeros((array.shape[0], 2 * array.shape[1], *array.shape[2:]), array.dtype)
        wide[:, ::2] = array
        array = wide[:, ::2]
    elif name == "foreign":
        array = array.astype(array.dtype.newbyteorder(">"))
    elif name == "fortran":
        array = np.asfortranarray(array)
    elif name == "window":
        frame = np.zeros((array.shape[0] + 3, array.shape[1] + 5, *array.shape[2:]), array.dtype)
        frame[1:-2, 2:-3] = array
        array = frame[1:-2, 2:-3]
    elif name == "mirrored":
        array = array[:, ::-1].copy()[:, ::-1]
    return array, name
