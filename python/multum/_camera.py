"""Cameras."""

import math
from typing import SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import image_size, number


class Camera:
    """Where the eye is and what it sees. It looks along its own -z, with y up in the picture.

    Parameters
    ----------
    eye, target : 3 numbers
        Where it is, and what it looks at.
    up : 3 numbers
        What is upwards in the picture.
    fov : float
        Angle of view from bottom to top, in degrees.
    near, far : float
        Nearest and farthest distance seen; ``far`` may be infinite.

    Raises
    ------
    ValueError, TypeError
        For numbers that make no camera.

    Examples
    --------
    >>> import multum as mt
    >>> camera = mt.Camera((0, 0, 5), (0, 0, 0), fov=90)
    >>> camera.project([0, 5, 0], (64, 64)).round(6).tolist()[:2]
    [0.0, 5.0]
    """

    def __init__(
        self,
        eye: ArrayLike,
        target: ArrayLike = (0.0, 0.0, 0.0),
        up: ArrayLike = (0.0, 1.0, 0.0),
        fov: float = 45.0,
        near: float = 0.01,
        far: float = math.inf,
    ) -> None:
        places = [_place(name, v) for name, v in (("eye", eye), ("target", target), ("up", up))]
        self._native = _multum.Camera(
            places[0],
            places[1],
            places[2],
            math.radians(number("fov", fov)),
            number("near", near),
            number("far", far),
        )

    @classmethod
    def _of(cls, native: _multum.Camera) -> "Camera":
        camera = cls.__new__(cls)
        camera._native = native
        return camera

    @property
    def name(self) -> str:
        """Name in the file."""
        return self._native.name

    @property
    def eye(self) -> NDArray[np.float64]:
        """Where it is, (3,)."""
        return np.array(self._native.eye)

    @property
    def view(self) -> NDArray[np.float64]:
        """World space to the camera's own space, (4, 4), for column vectors."""
        return self._native.view()

    def matrix(self, size: tuple[SupportsIndex, SupportsIndex]) -> NDArray[np.float64]:
        """World space to clip space for a picture of this (width, height), (4, 4), for column vectors."""
        return self._native.matrix(image_size(size))

    def turned(self, degrees: float, center: ArrayLike = (0.0, 0.0, 0.0)) -> "Camera":
        """The camera carried around the vertical (y) axis through ``center``, counter-clockwise from above.

        Examples
        --------
        >>> import multum as mt
        >>> mt.Camera((0, 1, 5)).turned(90).eye.round(6).tolist()
        [5.0, 1.0, 0.0]
        """
        return Camera._of(
            self._native.turned(_place("center", center), math.radians(number("degrees", degrees)))
        )

    def project(self, points: ArrayLike, size: tuple[SupportsIndex, SupportsIndex]) -> NDArray[np.float64]:
        """Clip-space positions (..., 4) of points (..., 3): what :func:`rasterize` takes."""
        return self._native.project(points, image_size(size))


def _place(name: str, value: ArrayLike) -> list[float]:
    try:
        place = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: got {value!r}, expected 3 numbers") from None
    if place.shape != (3,):
        raise ValueError(f"{name}: got shape {place.shape}, expected 3 numbers")
    return [float(x) for x in place]
