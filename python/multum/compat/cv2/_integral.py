"""Integral images."""

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays
from ._arrays import Array, error
from ._constants import CV_32F, CV_32S, CV_64F


def integral(src: ArrayLike, sum: Array | None = None, sdepth: int = -1) -> Array:
    """``cv2.integral``: ``sum[y, x]`` is the sum of all pixels above and left of corner (x, y).

    Shape (H + 1, W + 1) or (H + 1, W + 1, C); ``int32`` for ``uint8``, else ``float64``, unless ``sdepth`` is
    ``CV_32S``, ``CV_32F`` or ``CV_64F``.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> cv2.integral(np.uint8([[1, 2], [3, 4]])).tolist()
    [[0, 0, 0], [0, 1, 3], [0, 4, 10]]
    """
    source = _arrays.image("src", src)
    depths = {-1: np.int32 if source.dtype == np.uint8 else np.float64, CV_32S: np.int32, CV_32F: np.float32}
    depths[CV_64F] = np.float64
    if sdepth not in depths or (depths[sdepth] == np.int32 and source.dtype != np.uint8):
        raise error(
            f"sdepth: got {sdepth} for {source.dtype}, expected -1, CV_32F or CV_64F, or CV_32S for uint8"
        )
    height, width, channels = source.shape
    dtype = np.dtype(depths[sdepth])
    work = _arrays.target(sum, (height + 1, width + 1, channels), dtype, source, False)
    work[0], work[:, 0] = 0, 0
    inner = work[1:, 1:]
    wide = np.cumsum(source, axis=1, dtype=np.float64 if dtype.kind == "f" else dtype)
    inner[...] = np.cumsum(wide, axis=0, out=wide)
    return _arrays.delivered(work, sum)
