"""``resize``."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays
from ._arrays import Array, error, limits
from ._constants import (
    BORDER_REPLICATE,
    INTER_AREA,
    INTER_CUBIC,
    INTER_LANCZOS4,
    INTER_LINEAR,
    INTER_LINEAR_EXACT,
    INTER_NEAREST,
    INTER_NEAREST_EXACT,
)
from ._resample import Places, resample


def resize(
    src: ArrayLike,
    dsize: Sequence[int] | None,
    dst: Array | None = None,
    fx: float = 0,
    fy: float = 0,
    interpolation: int = INTER_LINEAR,
    *,
    antialias: bool = True,
) -> Array:
    """``cv2.resize``: to ``dsize`` (width, height), or by the factors ``fx`` and ``fy`` where that is None.

    Pixel edges lie on pixel edges. ``INTER_NEAREST`` takes pixel ``floor(x W / w)``, ``INTER_NEAREST_EXACT``
    the one nearest to the centre. ``INTER_AREA`` is the mean over the pixel's area where both sides shrink.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> cv2.resize(np.uint8([[0, 10, 20, 30]]), (2, 1), interpolation=cv2.INTER_AREA).tolist()
    [[5, 25]]
    """
    source = _arrays.image("src", src, nearest=interpolation in (INTER_NEAREST, INTER_NEAREST_EXACT))
    height, width = source.shape[:2]
    scaled = None
    if fx > 0 and fy > 0:
        scaled = (max(1, round(width * fx)), max(1, round(height * fy)))
    w, h = _arrays.size("dsize", dsize, scaled)
    given = dsize is not None and tuple(dsize) != (0, 0)
    sx, sy = (width / w, height / h) if given else (1 / fx, 1 / fy)
    shrinks = sx >= 1 and sy >= 1 and sx * sy > 1
    if interpolation == INTER_AREA and shrinks:
        return _arrays.delivered(_area(source, w, h, sx, sy), dst)
    if interpolation == INTER_LINEAR and sx == 2 and sy == 2:
        return _arrays.delivered(_area(source, w, h, sx, sy), dst)
    if interpolation in (INTER_NEAREST, INTER_NEAREST_EXACT):
        if interpolation == INTER_NEAREST:
            # The factor is rounded before its inverse is taken, as OpenCV does.
            xs = np.floor(np.arange(w) * (1 / (w / width))).astype(np.int64).clip(0, width - 1)
            ys = np.floor(np.arange(h) * (1 / (h / height))).astype(np.int64).clip(0, height - 1)
        else:
            xs, ys = _nearest_exact(width, w), _nearest_exact(height, h)
        return _arrays.delivered(source[ys[:, np.newaxis], xs], dst)
    kinds = {
        INTER_LINEAR: INTER_LINEAR,
        INTER_LINEAR_EXACT: INTER_LINEAR,
        INTER_CUBIC: INTER_CUBIC,
        INTER_LANCZOS4: INTER_LANCZOS4,
    }
    if interpolation == INTER_AREA:
        matrix = None
        first, second = _area_enlarged(width, w, sx), _area_enlarged(height, h, sy)
        x, y = (np.ascontiguousarray(v) for v in np.broadcast_arrays(first, second[:, np.newaxis]))
        places = Places((w, h), x, y)
        return resample(source, places, INTER_LINEAR, dst, BORDER_REPLICATE, None, False, exact=True)
    if interpolation not in kinds:
        raise error(
            f"interpolation: got {interpolation}, expected one of INTER_NEAREST to INTER_NEAREST_EXACT"
        )
    matrix = np.array([[sx, 0.0, 0.5 * sx - 0.5], [0.0, sy, 0.5 * sy - 0.5], [0.0, 0.0, 1.0]])
    places = Places((w, h), matrix=matrix)
    kind = kinds[interpolation]
    return resample(source, places, kind, dst, BORDER_REPLICATE, None, antialias, exact=True)


def _nearest_exact(n: int, m: int) -> NDArray[np.int64]:
    """For each of ``m`` output pixels the one of ``n`` that holds its centre."""
    found: NDArray[np.int64] = (2 * np.arange(m, dtype=np.int64) + 1) * n // (2 * m)
    return found.clip(0, n - 1)


def _area_enlarged(n: int, m: int, scale: float) -> NDArray[np.float64]:
    """Positions along an axis where ``INTER_AREA`` enlarges: each pixel keeps its colour but near its edges."""
    at = np.arange(m, dtype=np.float64)
    whole = np.floor(at * scale)
    rest = (at + 1) - (whole + 1) / scale
    rest = np.where(rest <= 0, 0.0, rest - np.floor(rest))
    positions: NDArray[np.float64] = (whole + rest).clip(0, n - 1)
    return positions


def _shares(n: int, m: int, scale: float) -> NDArray[np.float64]:
    """Row ``i`` holds the shares of ``n`` pixels in output pixel ``i``, which covers ``scale`` of them."""
    edges = np.arange(n + 1, dtype=np.float64)
    low, high = np.arange(m)[:, np.newaxis] * scale, (np.arange(m)[:, np.newaxis] + 1) * scale
    inside = np.clip(edges, low, np.minimum(high, n))
    lengths = np.diff(inside, axis=1)
    shares: NDArray[np.float64] = lengths / lengths.sum(axis=1, keepdims=True)
    return shares


def _area(source: Array, w: int, h: int, sx: float, sy: float) -> Array:
    """The mean over the area of each output pixel."""
    height, width, channels = source.shape
    across = _shares(width, w, sx)
    rows = np.empty((height, w, channels))
    for c in range(channels):
        rows[..., c] = source[..., c].astype(np.float64) @ across.T
    mean = np.tensordot(_shares(height, h, sy), rows, axes=1)
    if source.dtype.kind in "iu":
        mean = np.rint(mean).clip(*limits(source.dtype))
    return mean.astype(source.dtype)
