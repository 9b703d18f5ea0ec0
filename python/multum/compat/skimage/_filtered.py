"""What ``antialias=True`` adds: averages over footprints where a map minifies."""

import warnings

import numpy as np
from numpy.typing import NDArray

from ... import _multum
from ..._warp import warp as filtered_warp
from ._images import Array, Floats

Planes = tuple[NDArray[np.float64], NDArray[np.float64]]
_WRAPS = {
    "constant": "border",
    "edge": "clamp",
    "symmetric": "mirror",
    "reflect": "mirror_101",
    "wrap": "repeat",
}


def warn_of_order_two() -> None:
    """scikit-image warns at order 2; so do we, at the caller of the caller."""
    # Programs look for these words.
    message = (
        "Bi-quadratic interpolation is SciPy's spline here, for a bug in scikit-image; take order 1 or 3"
    )
    warnings.warn(message, UserWarning, stacklevel=3)


def replace_minified(
    out: Array, source: Floats, places: Planes | NDArray[np.float64], mode: str, cval: float
) -> None:
    """Writes filtered values over the pixels of ``out`` that cover more than a pixel of the input."""
    height, width = out.shape[:2]
    if isinstance(places, tuple):
        x, y = places
        minifies = _multum.map_minifies(x, y, None, width, height)
        mapping = np.dstack(places)
    else:
        minifies = _multum.map_minifies(None, None, [float(v) for v in places.flat], width, height)
        mapping = places
    if not out.size or not minifies:
        return
    values = filtered_warp(
        source.whole(), mapping, (height, width), wrap=_WRAPS[mode], border=float(cval), max_anisotropy=None
    )
    minified = _minified(mapping, (height, width))
    out[minified] = values[minified]


def _minified(mapping: NDArray[np.float64], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Where the larger singular value of the difference quotient exceeds 1, by more than rounding."""
    if mapping.shape == (3, 3):
        y, x = np.indices(shape, dtype=np.float64)
        with np.errstate(all="ignore"):
            w = mapping[2, 0] * x + mapping[2, 1] * y + mapping[2, 2]
            mapping = np.dstack([(r[0] * x + r[1] * y + r[2]) / w for r in mapping[:2]])
    with np.errstate(all="ignore"):
        a, b = (_steps(mapping, axis) for axis in (1, 0))
        trace = (a * a + b * b).sum(-1)
        det = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
        bound = 1.001**2
        found: NDArray[np.bool_] = (trace > 2 * bound) | (bound**2 - bound * trace + det**2 < 0)
    return found


def _steps(mapping: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
    """Differences to the next pixel; the last one's is that of the one before."""
    if mapping.shape[axis] == 1:
        return np.zeros_like(mapping)
    steps = np.diff(mapping, axis=axis)
    return np.concatenate([steps, np.take(steps, [-1], axis)], axis)
