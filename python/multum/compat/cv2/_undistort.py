"""Undistortion by the standard camera models."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ... import _multum
from . import _arrays
from ._arrays import Array, error
from ._arrays import size as _size
from ._call import REFUSALS, receivers, refusal, settle
from ._constants import BORDER_CONSTANT
from ._resample import output_size, resample

# Places of OpenCV's coefficients: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tauX tauY.
_COUNTS = (4, 5, 8, 12, 14)


def numbers(
    argument: str, value: ArrayLike | None, shapes: tuple[tuple[int, ...], ...]
) -> NDArray[np.float64]:
    """Finite or not, doubles of one of these shapes."""
    array = np.asarray(value)
    if array.dtype.kind not in "fiu" or array.shape not in shapes:
        expected = " or ".join(str(s) for s in shapes)
        raise error(f"{argument}: got shape {array.shape} and dtype {array.dtype}, expected shape {expected}")
    return array.astype(np.float64)


def _new_camera(value: ArrayLike) -> NDArray[np.float64]:
    """The camera of the result, without the column of a stereo pair."""
    return np.ascontiguousarray(numbers("newCameraMatrix", value, ((3, 3), (3, 4)))[:, :3])


def coefficients(value: ArrayLike | None, fisheye: bool) -> list[float]:
    """All numbers of a lens, zeros where none are given."""
    found = np.zeros(0) if value is None else np.asarray(value)
    counts = (4,) if fisheye else (0, *_COUNTS)
    flat = found.ndim == 1 or (found.ndim == 2 and 1 in found.shape)
    if found.dtype.kind not in "fiu" or found.size not in counts or not (flat or found.size == 0):
        raise error(
            f"distCoeffs: got shape {found.shape} and dtype {found.dtype}, expected a vector, {counts[-5:]} numbers"
        )
    lens = np.zeros(4 if fisheye else 14)
    lens[: found.size] = found.ravel()
    return [float(v) for v in lens]


def inverse(r: ArrayLike | None, new: NDArray[np.float64]) -> list[float]:
    """From output pixels to directions, row by row."""
    turn = np.eye(3)
    if r is not None and np.size(r):
        turn = numbers("R", r, ((3, 3),))
    product = new[:, :3] @ turn
    try:
        back = np.linalg.inv(product)
    except np.linalg.LinAlgError:
        # What OpenCV's own inverse gives.
        back = np.zeros((3, 3))
    return [float(v) for v in back.ravel()]


def maps(
    camera: NDArray[np.float64],
    lens: list[float],
    back: list[float],
    dsize: tuple[int, int],
    m1type: int,
    given: tuple[Any, Any],
) -> tuple[Array, Array | None]:
    """The maps of a lens, in the form asked for."""
    receivers(("map1", given[0]), ("map2", given[1]))
    intrinsics = (camera[0, 0], camera[1, 1], camera[0, 2], camera[1, 2])
    made = _multum.cv2_undistortion(intrinsics, lens, back, dsize, m1type, *given)
    if made is not None:
        return made
    one, two = _arrays.made(_multum.cv2_undistortion(intrinsics, lens, back, dsize, m1type, None, None))
    return settle(one, given[0]), None if two is None else settle(two, given[1])


def initUndistortRectifyMap(
    cameraMatrix: ArrayLike,
    distCoeffs: ArrayLike | None,
    R: ArrayLike | None,
    newCameraMatrix: ArrayLike | None,
    size: Sequence[int],
    m1type: int,
    map1: Array | None = None,
    map2: Array | None = None,
) -> tuple[Array, Array | None]:
    """``cv2.initUndistortRectifyMap``: where :func:`remap` reads an undistorted and rectified picture.

    Parameters
    ----------
    cameraMatrix : array, shape (3, 3)
        ``[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]`` of the lens that took the picture.
    distCoeffs : vector or None
        ``k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tauX tauY]]]]``: radial, tangential, rational, thin prism and
        the tilt of the sensor in radians.
    R : array, shape (3, 3), or None
        Rotation into the space of the result.
    newCameraMatrix : array, shape (3, 3) or (3, 4), or None
        Of the result; None for ``cameraMatrix``.
    size : (width, height)
        Of the result.
    m1type : int
        ``CV_16SC2``, ``CV_32FC1`` or ``CV_32FC2``: the form of the maps.
    map1, map2 : arrays, optional
        Receive the maps if their shapes and dtypes are right.

    Returns
    -------
    The two arrays that :func:`remap` takes; the second is None for ``CV_32FC2``.

    Raises
    ------
    error
        For arguments that are not as above.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> camera = np.array([[10.0, 0, 2], [0, 10, 1], [0, 0, 1]])
    >>> x, y = cv2.initUndistortRectifyMap(camera, [1.0, 0, 0, 0], None, None, (5, 3), cv2.CV_32FC1)
    >>> np.round(x[1].astype(float), 3).tolist()
    [-0.08, 0.99, 2.0, 3.01, 4.08]
    """
    try:
        made = _multum.cv2_rectify(cameraMatrix, distCoeffs, R, newCameraMatrix, size, m1type, map1, map2)
        if made is not None:
            return made
        camera = numbers("cameraMatrix", cameraMatrix, ((3, 3),))
        new = camera if newCameraMatrix is None else _new_camera(newCameraMatrix)
        lens = coefficients(distCoeffs, False)
        return maps(camera, lens, inverse(R, new), _size("size", size), m1type, (map1, map2))
    except REFUSALS as reason:
        raise refusal(reason) from None


def undistort(
    src: ArrayLike,
    cameraMatrix: ArrayLike,
    distCoeffs: ArrayLike | None,
    dst: Array | None = None,
    newCameraMatrix: ArrayLike | None = None,
    *,
    antialias: bool = True,
) -> Array:
    """``cv2.undistort``: the picture as a lens without distortion would have taken it.

    :func:`remap`, linear, over the map of :func:`initUndistortRectifyMap`; black where nothing was seen.
    Positions are rounded to 1/32 pixel, as in OpenCV.

    Parameters
    ----------
    src : array
        As for :func:`remap`.
    cameraMatrix, distCoeffs, newCameraMatrix
        As for :func:`initUndistortRectifyMap`.
    dst, antialias
        As for :func:`remap`.

    Raises
    ------
    error
        For arguments that are not as above.

    Examples
    --------
    >>> import numpy as np
    >>> from multum.compat import cv2
    >>> camera = np.array([[10.0, 0, 2], [0, 10, 1], [0, 0, 1]])
    >>> cv2.undistort(np.full((3, 5), 9, np.uint8), camera, None).tolist()[0]
    [9, 9, 9, 9, 9]
    """
    try:
        made: Array | None = _multum.cv2_undistort(
            src, cameraMatrix, distCoeffs, dst, newCameraMatrix, antialias
        )
        if made is not None:
            return made
        receivers(("dst", dst))
        camera = numbers("cameraMatrix", cameraMatrix, ((3, 3),))
        lens = np.array(coefficients(distCoeffs, False))
        new = camera if newCameraMatrix is None else _new_camera(newCameraMatrix)
        return resample(
            src,
            output_size((0, 0), src),
            dst,
            BORDER_CONSTANT,
            None,
            False,
            (),
            lambda source, into, _: _multum.cv2_undistort(source, camera, lens, into, new, antialias),
        )
    except REFUSALS as reason:
        raise refusal(reason) from None
