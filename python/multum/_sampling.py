"""Arguments of sampling, brought into their compiled form."""

from typing import Any, SupportsFloat

import numpy as np
from numpy.typing import NDArray

from . import _multum
from ._arguments import count, name, number


def sampling(
    filter: str,
    max_anisotropy: SupportsFloat | None,
    lod_bias: float = 0.0,
    lod_rule: str = "major",
    tolerance: float | None = None,
    seed: int | None = None,
    threads: int | None = None,
) -> _multum.Sampling:
    """A filter and its options, checked; None stands for no limit and for defaults."""
    return _multum.Sampling(
        name("filter", filter),
        np.inf if max_anisotropy is None else number("max_anisotropy", max_anisotropy),
        number("lod_bias", lod_bias),
        name("lod_rule", lod_rule),
        number("tolerance", tolerance),
        count("seed", seed, least=0, most=2**64 - 1) or 0,
        count("threads", threads),
    )


def stacked_faces(pixels: NDArray[Any]) -> NDArray[Any]:
    """Six faces, (6, n, n) or (6, n, n, C), as one picture with one below the other."""
    if pixels.ndim not in (3, 4) or pixels.shape[0] != 6 or pixels.shape[1] != pixels.shape[2]:
        raise ValueError(f"image: got shape {pixels.shape}, expected six faces (6, n, n) or (6, n, n, C)")
    return pixels.reshape(6 * pixels.shape[1], *pixels.shape[2:])
