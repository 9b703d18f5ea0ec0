"""``resize``."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ... import _multum
from . import _arrays
from ._arrays import Array
from ._call import REFUSALS, receivers, refusal, settle
from ._constants import (
    BORDER_REPLICATE,
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
    try:
        made: Array | None = _multum.cv2_resize(src, dsize, dst, fx, fy, interpolation, antialias)
        if made is not None:
            return made
        receivers(("dst", dst))
        return _resized(src, dsize, dst, (fx, fy), interpolation, antialias)
    except REFUSALS as reason:
        raise refusal(reason) from None


def _resized(
    src: ArrayLike,
    dsize: Sequence[int] | None,
    dst: Array | None,
    factors: tuple[float, float],
    interpolation: int,
    antialias: bool,
) -> Array:
    """The same for arguments that must be brought into order first, and for filtered cubic and Lanczos."""
    source = _arrays.image("src", src, nearest=interpolation in (INTER_NEAREST, INTER_NEAREST_EXACT))
    size = _arrays.size("dsize", dsize, (0, 0))
    given = None if size == (0, 0) else size
    carrier = source
    if source.dtype not in _arrays.KERNEL_TYPES:
        # Only copied: the bits travel as another type.
        carrier = source.view(_arrays.CARRIERS[source.dtype.itemsize])
    made: Array | None = _multum.cv2_resize(carrier, given, None, *factors, interpolation, antialias)
    if made is not None:
        return settle(made.view(source.dtype), dst)
    plain = _arrays.made(_multum.cv2_resize(carrier, given, None, *factors, interpolation, False))
    h, w = plain.shape[:2]
    scale = (
        [1 / f for f in factors]
        if given is None
        else [n / m for n, m in zip(source.shape[1::-1], (w, h), strict=True)]
    )
    sx, sy = scale
    places = Places(
        (w, h), matrix=np.array([[sx, 0.0, 0.5 * sx - 0.5], [0.0, sy, 0.5 * sy - 0.5], [0.0, 0.0, 1.0]])
    )
    kind = INTER_LINEAR if interpolation == INTER_LINEAR_EXACT else interpolation
    return resample(source, places, kind, dst, BORDER_REPLICATE, None, antialias, exact=True)
