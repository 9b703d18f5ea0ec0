"""Calls of the compiled functions with arguments that have been brought into order."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays
from ._arrays import Array, limits
from ._constants import BORDER_ISOLATED, BORDER_TRANSPARENT

Ordered = Callable[[Array, Array, tuple[float, ...]], Array | None]
"""A compiled function, called with a source, an output and a border colour."""


def resample(
    src: ArrayLike,
    size: tuple[int, int],
    dst: Array | None,
    border_mode: int,
    border_value: Any,
    nearest: bool,
    inputs: Sequence[Array | None],
    call: Ordered,
) -> Array:
    """A result of ``size`` (width, height) of ``src``, whatever its form.

    ``nearest`` takes elements of any kind, which are only copied; ``inputs`` are what else ``call`` reads.
    """
    source = _arrays.image("src", src, nearest=nearest)
    channels = source.shape[2]
    colour = _arrays.border_colour(border_value, channels)
    transparent = border_mode & ~BORDER_ISOLATED == BORDER_TRANSPARENT
    shape = (size[1], size[0], channels)
    work = _arrays.target(dst, shape, source.dtype, (source, *inputs), transparent)
    into = work
    if source.dtype not in _arrays.KERNEL_TYPES:
        # Only copied: the bits travel as another type.
        carrier = _arrays.CARRIERS[source.dtype.itemsize]
        bits = np.array(np.clip(colour, *limits(source.dtype))).round().astype(source.dtype)
        colour = [float(v) for v in bits.view(carrier)]
        source, into = source.view(carrier), work.view(carrier)
    _arrays.made(call(source, into, tuple(colour)))
    return _arrays.delivered(work, dst)


def output_size(dsize: Sequence[int], src: ArrayLike) -> tuple[int, int]:
    """The size asked for; zeros stand for that of the source."""
    shape = np.shape(src)
    return _arrays.size("dsize", dsize, (shape[1], shape[0]) if len(shape) > 1 else None)
