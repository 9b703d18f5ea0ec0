"""Calls of the compiled functions: at once where the arguments are in order, else with arguments made so."""

from typing import Any

import numpy as np

from ._arrays import Array, error

REFUSALS = (ValueError, TypeError, OverflowError, MemoryError)


def receivers(*given: tuple[str, Any]) -> None:
    """Refuses outputs that cannot be written."""
    for argument, dst in given:
        if dst is None:
            continue
        if not isinstance(dst, np.ndarray):
            raise error(f"{argument}: got {type(dst).__name__}, expected a numpy.ndarray or None")
        if not dst.flags.writeable:
            raise error(f"{argument}: got a read-only array, expected a writable one")


def settle(result: Array, dst: Any) -> Array:
    """The result, in the array that was given for it where shape and dtype are right."""
    if isinstance(dst, np.ndarray) and dst.dtype == result.dtype:
        fits = dst.shape in (result.shape, (*result.shape, 1))
        if fits:
            dst[...] = result.reshape(dst.shape)
            return dst
    return result


def refusal(reason: Exception) -> error:
    """OpenCV's error for what the compiled functions and NumPy raise."""
    return reason if isinstance(reason, error) else error(str(reason))
