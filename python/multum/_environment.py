"""Light from all sides."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import name, number

_LAYOUTS = ("cross", "strip", "stacked", "faces")


class Environment:
    """Light from all sides, as far away as the sky; what :func:`render` mirrors and averages.

    Parameters
    ----------
    image : array, shape (H, W) or (H, W, C), or (6, n, n, C) for the faces of a cube
        One, three or four channels, the fourth not read. The middle of a panorama is what a camera sees that looks
        along -z, with y up.
    form : str
        ``"equirect"`` (latitude and longitude), ``"cube"``, ``"probe"`` (the angular map of a light probe),
        ``"mirror_ball"`` (the photograph of one), or ``"sphere_map"``: OpenGL's, a mirror ball that turns with
        the eye.
    layout : str
        Of a cube in one picture: ``"cross"``, ``"strip"`` or ``"stacked"``. Six faces in one array, (6, n, n, C),
        are known by their shape (``"faces"``).
    encoding : str
        ``"linear"`` or ``"srgb"``.
    rotation : float
        The environment is turned so many degrees about the y axis, counter-clockwise seen from above.
    intensity : float
        Multiplies the light.

    Raises
    ------
    ValueError, TypeError
        For a picture or number that is not as above.

    Examples
    --------
    >>> import numpy as np, multum as mt
    >>> sky = mt.Environment(np.full((16, 32, 3), 0.5, np.float32))
    >>> sky.diffuse([[0, 1, 0]]).round(3).tolist(), sky.radiance([[0, 0, -1]]).round(3).tolist()
    ([[0.5, 0.5, 0.5]], [[0.5, 0.5, 0.5]])
    """

    def __init__(
        self,
        image: ArrayLike,
        form: str = "equirect",
        *,
        layout: str = "cross",
        encoding: str = "linear",
        rotation: float = 0.0,
        intensity: float = 1.0,
    ) -> None:
        pixels = np.asarray(image)
        if name("layout", layout) not in _LAYOUTS:
            raise ValueError(f"layout: got {layout!r}, expected one of {', '.join(map(repr, _LAYOUTS))}")
        if name("form", form) == "cube":
            if pixels.ndim == 4 and pixels.shape[0] == 6:
                pixels, layout = pixels.reshape(-1, *pixels.shape[2:]), "stacked"
            elif layout == "faces":
                raise ValueError(f"image: got shape {pixels.shape}, expected six faces (6, n, n, C)")
        self._native = _multum.Environment(
            pixels,
            name("form", form),
            name("layout", layout),
            name("encoding", encoding),
            math.radians(number("rotation", rotation)),
            number("intensity", intensity),
        )

    def diffuse(self, normals: ArrayLike) -> NDArray[np.float32]:
        """What a white matt surface with each of the unit normals (N, 3) shows, (N, 3).

        By spherical harmonics of bands 0 to 2 (Ramamoorthi and Hanrahan, SIGGRAPH 2001).
        """
        return self._native.diffuse(np.asarray(normals, np.float32))

    def radiance(
        self,
        directions: ArrayLike,
        moving: ArrayLike | None = None,
        *,
        exponent: float = math.inf,
        filter: str = "auto",
        threads: int | None = None,
    ) -> NDArray[np.float32]:
        """The light along directions (N, 3), (N, 3).

        ``moving`` (N, 2, 3) is how each moves for one pixel right and one down; ``exponent`` that of the
        Phong lobe that averages around it, infinite for a mirror.
        """
        around = None if moving is None else np.asarray(moving, np.float64).reshape(-1, 3)
        sampling = _multum.Sampling(filter, 16.0, 0.0, "major", None, 0, threads)
        return self._native.radiance(
            np.asarray(directions, np.float64), around, number("exponent", exponent), sampling
        )
