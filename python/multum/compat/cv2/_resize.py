"""``resize``."""

from collections.abc import Sequence

from numpy.typing import ArrayLike

from ... import _multum
from . import _arrays
from ._arrays import Array
from ._call import REFUSALS, receivers, refusal, settle
from ._constants import INTER_LINEAR, INTER_NEAREST, INTER_NEAREST_EXACT


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

    With ``antialias``, the other interpolations go over into the mean over what a pixel covers, of the picture
    interpolated linearly, where either side shrinks: by 1.25 or more it is that mean alone, exact to rounding.

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
    """The same for arguments that must be brought into order first."""
    source = _arrays.image("src", src, nearest=interpolation in (INTER_NEAREST, INTER_NEAREST_EXACT))
    size = _arrays.size("dsize", dsize, (0, 0))
    given = None if size == (0, 0) else size
    carrier = source
    if source.dtype not in _arrays.KERNEL_TYPES:
        # Only copied: the bits travel as another type.
        carrier = source.view(_arrays.CARRIERS[source.dtype.itemsize])
    made = _arrays.made(_multum.cv2_resize(carrier, given, None, *factors, interpolation, antialias))
    return settle(made.view(source.dtype), dst)
