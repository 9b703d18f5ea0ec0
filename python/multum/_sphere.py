"""Textures of directions: environment maps, filtered across seam, poles and edges."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, SupportsFloat

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import broadcast, name, numbers
from ._files import read_image
from ._sampling import sampling, stacked_faces


class SphereTexture:
    """A picture of all directions, sampled by direction.

    Directions are seen in the frame x right, y up, z forward, and may have any length. A latitude-longitude
    picture has forward at its centre and up at its upper side; cubes are OpenGL's. The image is copied: a
    latitude-longitude picture twice, the second time as it looks from beyond a pole; the faces of a cube with
    the texels of their neighbours around every level.

    Parameters
    ----------
    image : (H, W) or (H, W, C), or (6, n, n) or (6, n, n, C) for a cube with ``layout="faces"``
        Of the dtypes of :class:`multum.Texture`.
    form : str
        ``"equirect"`` or ``"cube"``.
    layout : str
        Of a cube: ``"faces"`` (six arrays, +X -X +Y -Y +Z -Z), ``"cross"``, ``"strip"`` or ``"stacked"``.
    border : number or sequence of numbers, optional
        Colour of directions that are zero or not finite. Default 0.
    encoding, alpha, pyramid : str
        As for :class:`multum.Texture`.

    Raises
    ------
    ValueError, TypeError
        For a shape, dtype, name or number that is not as above.

    Examples
    --------
    >>> import numpy as np, multum as mt
    >>> sky = np.zeros((4, 8), np.float32)
    >>> sky[:2] = 1.0
    >>> texture = mt.SphereTexture(sky)
    >>> texture
    SphereTexture(equirect 8x4, 1 channel)
    >>> texture.sample([[0, 1, 0], [0, 0, 1], [0, -1, 0]]).ravel().tolist()
    [1.0, 0.5, 0.0]
    """

    __slots__ = ("_texture",)

    def __init__(
        self,
        image: ArrayLike,
        form: str = "equirect",
        *,
        layout: str = "faces",
        border: float | Sequence[float] | NDArray[Any] | None = None,
        encoding: str = "linear",
        alpha: str = "none",
        pyramid: str = "box",
    ) -> None:
        pixels = np.asarray(image)
        if name("form", form) == "cube" and name("layout", layout) == "faces":
            pixels = stacked_faces(pixels)
        self._texture = _multum.SphereTexture(
            pixels,
            form,
            "stacked" if layout == "faces" else name("layout", layout),
            numbers("border", border, pixels.shape[2] if pixels.ndim == 3 else 1),
            name("encoding", encoding),
            name("alpha", alpha),
            name("pyramid", pyramid),
        )

    @classmethod
    def open(
        cls,
        path: str | os.PathLike[str],
        form: str = "equirect",
        *,
        layout: str = "cross",
        border: float | Sequence[float] | NDArray[Any] | None = None,
        encoding: str = "linear",
        alpha: str = "none",
        pyramid: str = "box",
    ) -> SphereTexture:
        """Read one from an image file; keywords as for the class.

        Raises
        ------
        OSError
            When the file is missing, damaged, or no image.
        ValueError, TypeError
            As the class does.
        """
        image = read_image(path)
        return cls(image, form, layout=layout, border=border, encoding=encoding, alpha=alpha, pyramid=pyramid)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture, or of a face."""
        return self._texture.size

    @property
    def form(self) -> str:
        """``"equirect"`` or ``"cube"``."""
        return "cube" if self._texture.is_cube else "equirect"

    @property
    def channels(self) -> int:
        """Numbers in a texel."""
        return self._texture.channels

    @property
    def num_levels(self) -> int:
        """Levels of the picture or of a face."""
        return self._texture.num_levels

    @property
    def nbytes(self) -> int:
        """Bytes held now."""
        return self._texture.nbytes

    def __repr__(self) -> str:
        """Form and size."""
        width, height = self.size
        channels = f"{self.channels} channel" + ("s" if self.channels > 1 else "")
        return f"SphereTexture({self.form} {width}x{height}, {channels})"

    def sample(
        self,
        directions: ArrayLike,
        ddx: ArrayLike | None = None,
        ddy: ArrayLike | None = None,
        *,
        lod: ArrayLike | None = None,
        filter: str = "auto",
        max_anisotropy: SupportsFloat | None = 16,
        lod_bias: float = 0.0,
        lod_rule: str = "major",
        tolerance: float | None = None,
        seed: int | None = None,
        out: NDArray[Any] | None = None,
        threads: int | None = None,
    ) -> NDArray[Any]:
        """Sample at a batch of directions, each with the piece of the sphere that its pixel covers.

        Parameters
        ----------
        directions : array, shape (..., 3)
            A direction that is zero or not finite gives the border colour.
        ddx, ddy : array, shape (..., 3), optional
            What one pixel right and one pixel down add to the direction; both or neither. Broadcast against
            ``directions``. One that is not finite gives the coarsest level. Without them every sample is a
            point.
        lod : array, shape (...), optional
            Instead: the footprint is a square on the sphere as wide as ``2**lod`` texels on the equator, or in
            the middle of a face.
        filter, max_anisotropy, lod_bias, lod_rule, tolerance, seed, out, threads
            As for :meth:`multum.Texture.sample`. Next to the edges of a cube the means over the footprint are
            grids of bilinear probes, and ``tolerance`` is not promised there.

        Returns
        -------
        array, shape (..., C)
            ``float32``; ``float64`` for ``float64`` pictures.

        Raises
        ------
        ValueError, TypeError
            For a shape, dtype, name or number that is not as above.

        Examples
        --------
        A pixel that looks straight up and covers 60 degrees sees the average of the sky around:

        >>> import numpy as np, multum as mt
        >>> sky = np.zeros((64, 128), np.float32)
        >>> sky[:, :64] = 1.0
        >>> texture = mt.SphereTexture(sky)
        >>> texture.sample([0, 1, 0], ddx=[1, 0, 0], ddy=[0, 0, 1]).round(4).tolist()
        [0.5]
        """
        places = np.asarray(directions)
        if (ddx is None) != (ddy is None):
            raise ValueError("ddx, ddy: got one of them, expected both or neither")
        if ddx is not None and lod is not None:
            raise ValueError("lod: got both lod and ddx, expected one of them")
        chosen = sampling(filter, max_anisotropy, lod_bias, lod_rule, tolerance, seed, threads)
        return self._texture.sample(
            places,
            broadcast("ddx", ddx, places.shape),
            broadcast("ddy", ddy, places.shape),
            broadcast("lod", lod, places.shape[:-1]),
            chosen,
            out,
        )
