"""OpenCV's fisheye lenses: the camera model of Kannala and Brandt."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import Array, image
from ._arrays import size as _size
from ._call import REFUSALS as _REFUSALS
from ._call import refusal as _refusal
from ._constants import CV_16SC2, INTER_LINEAR
from ._remap import remap as _remap
from ._undistort import coefficients as _coefficients
from ._undistort import inverse as _inverse
from ._undistort import maps as _maps
from ._undistort import numbers as _numbers

__all__ = ["initUndistortRectifyMap", "undistortImage"]


def initUndistortRectifyMap(
    K: ArrayLike,
    D: ArrayLike,
    R: ArrayLike | None,
    P: ArrayLike | None,
    size: Sequence[int],
    m1type: int,
    map1: Array | None = None,
    map2: Array | None = None,
) -> tuple[Array, Array | None]:
    """``cv2.fisheye.initUndistortRectifyMap``: where ``remap`` reads an undistorted and rectified picture.

    Parameters
    ----------
    K : array, shape (3, 3)
        Camera matrix of the lens that took the picture.
    D : vector of 4
        ``k1 k2 k3 k4`` of ``theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)``.
    R : array, shape (3, 3), or None
        Rotation into the space of the result.
    P : array, shape (3, 3) or (3, 4), or None
        Camera matrix of the result; None for the identity.
    size, m1type, map1, map2
        As for ``cv2.initUndistortRectifyMap``. Positions behind the camera are infinite.

    Raises
    ------
    error
        For arguments that are not as above.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> camera = np.array([[10.0, 0, 2], [0, 10, 1], [0, 0, 1]])
    >>> none = np.zeros(4)
    >>> x, y = cv2.fisheye.initUndistortRectifyMap(camera, none, None, camera, (5, 3), cv2.CV_32FC1)
    >>> np.round(x[1].astype(float), 3).tolist()
    [0.026, 1.003, 2.0, 2.997, 3.974]
    """
    try:
        camera = _numbers("K", K, ((3, 3),))
        new = np.eye(3) if P is None or np.size(P) == 0 else _numbers("P", P, ((3, 3), (3, 4)))
        lens = _coefficients(D, True)
        return _maps(camera, lens, _inverse(R, new), _size("size", size), m1type, (map1, map2))
    except _REFUSALS as reason:
        raise _refusal(reason) from None


def undistortImage(
    distorted: ArrayLike,
    K: ArrayLike,
    D: ArrayLike,
    undistorted: Array | None = None,
    Knew: ArrayLike | None = None,
    new_size: Sequence[int] | None = None,
    *,
    antialias: bool = True,
) -> Array:
    """``cv2.fisheye.undistortImage``: a fisheye picture as a lens without distortion would have taken it.

    Without ``Knew`` the result is seen through the identity, as in OpenCV: rarely what is wanted. ``new_size`` is
    that of ``distorted`` by default. Other arguments are those of :func:`initUndistortRectifyMap` and ``remap``.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> camera = np.array([[10.0, 0, 2], [0, 10, 1], [0, 0, 1]])
    >>> cv2.fisheye.undistortImage(np.full((3, 5), 9, np.uint8), camera, np.zeros(4), Knew=camera)[1].tolist()
    [9, 9, 9, 9, 9]
    """
    try:
        source = image("distorted", distorted)
        shape = (source.shape[1], source.shape[0])
        chosen = _size("new_size", new_size, shape)
        found = initUndistortRectifyMap(K, D, None, Knew, chosen, CV_16SC2)
        return _remap(source, *found, INTER_LINEAR, undistorted, antialias=antialias)
    except _REFUSALS as reason:
        raise _refusal(reason) from None
