"""Tensors of any library as NumPy arrays, and back."""

import importlib
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
FLOATS = (np.dtype(np.float16), np.dtype(np.float32), np.dtype(np.float64))


class error(RuntimeError, ValueError, TypeError):
    """A wrong argument: PyTorch's ``RuntimeError``, and a ``ValueError`` and ``TypeError`` as elsewhere here."""


def array(argument: str, value: Any) -> Array:
    """The numbers of a tensor, in place where DLPack or NumPy allow it."""
    if isinstance(value, np.ndarray):
        result = value
    elif hasattr(value, "__dlpack__"):
        plain = value.detach() if hasattr(value, "detach") else value
        try:
            # PyTorch's own way to share memory with NumPy takes a third of the time of the general one.
            result = plain.numpy() if _library(value) == "torch" else np.from_dlpack(plain)
        except (BufferError, RuntimeError, TypeError) as cause:
            got = f"a {type(value).__name__} whose memory cannot be shared ({cause})"
            raise error(f"{argument}: got {got}, expected one on the CPU") from cause
    else:
        result = np.asarray(value)
    return result if result.dtype.isnative else result.astype(result.dtype.newbyteorder("="))


def floats(argument: str, value: Any, axes: int, shape: str) -> Array:
    """The numbers of a tensor of floats with so many axes."""
    result = array(argument, value)
    if result.dtype not in FLOATS:
        raise error(f"{argument}: got dtype {result.dtype}, expected float32, float64 or float16")
    if result.ndim != axes:
        raise error(f"{argument}: got shape {result.shape}, expected {shape}")
    return result


def like(result: Array, value: Any) -> Any:
    """The result as a tensor of the library that ``value`` came from, sharing memory."""
    if isinstance(value, np.ndarray) or not hasattr(value, "__dlpack__"):
        return result
    library = _library(value)
    if library == "torch":
        return sys.modules["torch"].from_numpy(result)
    home = importlib.import_module({"jaxlib": "jax.numpy", "jax": "jax.numpy"}.get(library, library))
    return home.from_dlpack(result)


def _library(value: Any) -> str:
    """The package that a tensor's type is of."""
    return type(value).__module__.partition(".")[0]


def one_of(argument: str, value: str, names: Sequence[str]) -> str:
    """A name out of a list."""
    if value not in names:
        raise error(f"{argument}: got {value!r}, expected one of {', '.join(map(repr, names))}")
    return value
