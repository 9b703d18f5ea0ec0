"""Textures: what is sampled, and the sampling of it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, SupportsFloat, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import broadcast, count, name, number, numbers, wrap_pair
from ._files import read_image
from ._sampling import sampling
from ._survey import Survey


class Texture:
    """An image to sample: its levels, what lies outside it and what its codes mean.

    The image is copied. Levels beyond the first are made when a filter first needs them, once.

    Texture space is (u, v) in [0, 1]: u to the right, v down, row 0 at v = 0. Texel (i, j) of an image of width
    W and height H has its centre at ((i + 1/2)/W, (j + 1/2)/H).

    Parameters
    ----------
    image : array, shape (H, W) or (H, W, C)
        ``uint8``, ``uint16``, ``float16``, ``float32`` or ``float64``, any strides, any number of channels.
        Integers stand for ``code / max``; floats stand for themselves.
    wrap : str or pair of str
        What lies outside, for u and v: ``"clamp"`` (the edge texel), ``"repeat"``, ``"mirror"``,
        ``"mirror_once"``, ``"mirror_101"`` (mirror about the edge texel's centre), ``"border"`` (the colour
        ``border``), or ``"extend"``: the image has one extra texel on both sides of the axis, which continue
        it; ``width`` and ``height`` do not count them.
    border : number or sequence of numbers, optional
        Colour outside under ``"border"``, in the space of the results (linear, premultiplied); one number
        stands for all channels. Default 0.
    encoding : str
        ``"linear"``, ``"srgb"`` (decoded per texel, so filtering is in linear light; the alpha channel of 2 or
        4 is linear) or ``"normal"`` (unit vectors: integers ``(code - 128)/127``, at least -1, for 8 bits and
        likewise for 16; floats ``2 x - 1``; results are averages, shorter where normals differ).
    alpha : str
        ``"none"``, ``"straight"`` (filtered premultiplied, returned straight, black where alpha is 0) or
        ``"premultiplied"``; the last of 2 or 4 channels.
    pyramid : str
        How levels are made: ``"box"``, ``"kaiser"`` or ``"lanczos3"``; see :func:`multum.build_pyramid`.
    coverage : float, optional
        Keep, on every level, the share of texels whose alpha is at least this.

    Raises
    ------
    ValueError, TypeError
        For a shape, dtype, name or number that is not as above.

    Examples
    --------
    >>> import numpy as np, multum as mt
    >>> texture = mt.Texture(np.uint8([[0, 255], [255, 0]]), wrap="repeat", encoding="srgb")
    >>> texture
    Texture(2x2, 1 channel, uint8, wrap='repeat', encoding='srgb', 2 levels)
    >>> texture.sample([[0.25, 0.25], [0.5, 0.25]], filter="bilinear").ravel().tolist()
    [0.0, 0.5]
    """

    __slots__ = ("_texture",)

    def __init__(
        self,
        image: ArrayLike,
        wrap: str | Sequence[str] = "clamp",
        border: float | Sequence[float] | NDArray[Any] | None = None,
        encoding: str = "linear",
        alpha: str = "none",
        pyramid: str = "box",
        coverage: float | None = None,
    ) -> None:
        pixels = np.asarray(image)
        channels = pixels.shape[2] if pixels.ndim == 3 else 1
        self._texture = _multum.Texture(
            pixels,
            wrap_pair(wrap),
            numbers("border", border, channels),
            name("encoding", encoding),
            name("alpha", alpha),
            name("pyramid", pyramid),
            number("coverage", coverage),
        )

    @classmethod
    def open(
        cls,
        path: str | os.PathLike[str],
        *,
        wrap: str | Sequence[str] = "clamp",
        border: float | Sequence[float] | NDArray[Any] | None = None,
        encoding: str = "linear",
        alpha: str = "none",
        pyramid: str = "box",
        coverage: float | None = None,
    ) -> Texture:
        """Read a texture from a PNG, JPEG, TIFF, HDR or EXR file; keywords as for the class.

        Raises
        ------
        OSError
            When the file is missing, damaged, or no image.
        ValueError, TypeError
            As the class does.
        """
        return cls(read_image(path), wrap, border, encoding, alpha, pyramid, coverage)

    @property
    def width(self) -> int:
        """Texels in a row of level 0, without the extra ones of ``"extend"``."""
        return self._texture.width

    @property
    def height(self) -> int:
        """Rows of level 0, without the extra ones of ``"extend"``."""
        return self._texture.height

    @property
    def channels(self) -> int:
        """Numbers in a texel."""
        return self._texture.channels

    @property
    def dtype(self) -> np.dtype[Any]:
        """Element type of the image."""
        return np.dtype(self._texture.dtype)

    @property
    def num_levels(self) -> int:
        """Levels that there are, made or not: ``floor(log2(max(width, height))) + 1``."""
        return self._texture.num_levels

    @property
    def nbytes(self) -> int:
        """Bytes held now: level 0, and the other levels once a filter has needed them."""
        return self._texture.nbytes

    @property
    def wrap(self) -> str | tuple[str, str]:
        """The wrap mode, or the pair for u and v where they differ."""
        u, v = self._texture.wrap
        return u if u == v else (u, v)

    @property
    def border(self) -> list[float]:
        """The border colour, one number a channel."""
        return self._texture.border

    @property
    def encoding(self) -> str:
        """What the codes mean."""
        return self._texture.encoding

    @property
    def alpha(self) -> str:
        """What the last of two or four channels means."""
        return self._texture.alpha

    @property
    def pyramid(self) -> str:
        """How levels are made."""
        return self._texture.pyramid

    def __repr__(self) -> str:
        """Size, type and modes."""
        channels = f"{self.channels} channel" + ("s" if self.channels > 1 else "")
        levels = f"{self.num_levels} level" + ("s" if self.num_levels > 1 else "")
        return (
            f"Texture({self.width}x{self.height}, {channels}, {self.dtype}, wrap={self.wrap!r}, "
            f"encoding={self.encoding!r}, {levels})"
        )

    def level(self, index: SupportsIndex) -> NDArray[Any]:
        """One level as an image of the texture's own dtype and encoding; level 0 is the image itself.

        Level ``l`` has ``max(1, width >> l)`` by ``max(1, height >> l)`` texels.

        Raises
        ------
        ValueError
            When there is no such level.

        Examples
        --------
        >>> import numpy as np, multum as mt
        >>> mt.Texture(np.uint8([[10, 20], [30, 40]])).level(1).tolist()
        [[25]]
        """
        return self._texture.level(count("level", index, least=0))

    def sample(
        self,
        uv: ArrayLike,
        jacobian: ArrayLike | None = None,
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
        """Sample the texture at a batch of places.

        Parameters
        ----------
        uv : array, shape (..., 2)
            Places in texture space, ``float32`` or ``float64``. A coordinate that is not finite gives the
            border colour.
        jacobian : array, shape (..., 2, 2), optional
            How far (u, v) moves per pixel: ``jacobian[..., i, j]`` is the derivative of coordinate i by pixel
            axis j (0 right, 1 down). Broadcast against ``uv``. Zero is a point; an infinite or NaN Jacobian
            gives the coarsest level. Without it every sample is a point.
        lod : array, shape (...), optional
            Level of detail, given outright instead of a Jacobian.
        filter : str
            ``"auto"`` (default), ``"nearest"``, ``"bilinear"``, ``"bicubic"`` (Catmull-Rom), ``"mitchell"``,
            ``"nearest_mipmap_nearest"``, ``"linear_mipmap_nearest"``, ``"nearest_mipmap_linear"``,
            ``"trilinear"`` (also named ``"linear_mipmap_linear"``), ``"anisotropic"``, ``"ewa"`` (Gaussian weights
            over an ellipse), ``"sat"`` (the mean over the upright rectangle around the footprint, from a
            summed-area table), ``"area"`` (the mean over the footprint, fast and nearly exact), ``"exact"`` (the
            mean of the bilinear reconstruction over the footprint, to rounding), ``"stochastic"`` (one random
            texel a sample, whose expectation is that mean).
        max_anisotropy : float, optional
            Longest footprint, in widths, that ``"anisotropic"`` and ``"ewa"`` follow; None, and all above, for
            1024.
        lod_bias : float
            Added to the level of detail.
        lod_rule : str
            Which extent decides about the level of the isotropic filters: ``"major"`` (the longest axis,
            default) or ``"area"`` (its square root, the rule ``log2(A W H)/2``).
        tolerance : float, optional
            Largest error that ``"auto"`` may make, in units of the result, against the mean of the bilinear
            reconstruction over the footprint: kept on every texture, wrap and footprint. Default: none is
            promised, and about half a step of 8 bits is aimed at.
        seed : int, optional
            Seed of ``"stochastic"``, modulo 2^64; default 0. The same seed gives the same samples.
        out : array, shape (..., C), optional
            Receives the result; C-contiguous, of the result's dtype.
        threads : int, optional
            Threads to use; default :func:`multum.get_num_threads`. The result does not depend on it.

        Returns
        -------
        array, shape (..., C)
            ``float32``; ``float64`` for ``float64`` textures.

        Raises
        ------
        ValueError, TypeError
            For a shape, dtype, name or number that is not as above.

        Examples
        --------
        A pixel that covers the whole texture sees its mean:

        >>> import numpy as np, multum as mt
        >>> texture = mt.Texture(np.float32([[0, 1], [2, 5]]), wrap="repeat")
        >>> texture.sample([0.5, 0.5], np.eye(2) * 2, filter="trilinear").tolist()
        [2.0]
        """
        if jacobian is not None and lod is not None:
            raise ValueError("lod: got both lod and jacobian, expected one of them")
        places = np.asarray(uv)
        leading = places.shape[:-1]
        chosen = sampling(filter, max_anisotropy, lod_bias, lod_rule, tolerance, seed, threads)
        return self._texture.sample(
            places,
            broadcast("jacobian", jacobian, (*leading, 2, 2)),
            broadcast("lod", lod, leading),
            chosen,
            out,
        )

    def survey(
        self,
        uv: ArrayLike,
        jacobian: ArrayLike | None = None,
        *,
        lod: ArrayLike | None = None,
        filter: str = "auto",
        max_anisotropy: SupportsFloat | None = 16,
        lod_bias: float = 0.0,
        lod_rule: str = "major",
        tolerance: float | None = None,
        threads: int | None = None,
    ) -> Survey:
        """What :meth:`sample` with the same arguments spends on each sample, and on which level it reads.

        ``cost`` counts texels and entries of tables. For filters of fixed cost it follows from the footprint; for
        ``"auto"`` it is what was decided, sample by sample: flat and smooth pictures cost a few look-ups at any
        footprint.

        Parameters
        ----------
        uv, jacobian, lod, filter, max_anisotropy, lod_bias, lod_rule, tolerance, threads
            As for :meth:`sample`.

        Returns
        -------
        Survey
            ``cost`` and ``lod``, each of shape (...), ``float32``.

        Raises
        ------
        ValueError, TypeError
            As :meth:`sample`.

        Examples
        --------
        >>> import numpy as np, multum as mt
        >>> grey = mt.Texture(np.full((64, 64), 90, np.uint8), wrap="repeat")
        >>> grey.survey([[0.3, 0.4]], np.eye(2) / 2, tolerance=1 / 255).cost.tolist()
        [4.0]
        >>> grey.survey([[0.3, 0.4]], np.eye(2) / 2, filter="trilinear").lod.tolist()
        [5.0]
        """
        if jacobian is not None and lod is not None:
            raise ValueError("lod: got both lod and jacobian, expected one of them")
        places = np.asarray(uv)
        leading = places.shape[:-1]
        chosen = sampling(filter, max_anisotropy, lod_bias, lod_rule, tolerance, None, threads)
        return Survey(
            *self._texture.survey(
                places,
                broadcast("jacobian", jacobian, (*leading, 2, 2)),
                broadcast("lod", lod, leading),
                chosen,
            )
        )

    def gradient(
        self, uv: ArrayLike, *, filter: str = "bilinear", threads: int | None = None
    ) -> NDArray[Any]:
        """Derivative of the reconstruction by u and v, in closed form.

        Parameters
        ----------
        uv : array, shape (..., 2)
            Places in texture space. A coordinate that is not finite gives 0.
        filter : str
            The reconstruction: ``"bilinear"`` (default), ``"bicubic"`` or ``"mitchell"``. On the lines
            through texel centres, where a bilinear slope jumps, the slope towards larger coordinates is given.
        threads : int, optional
            Threads to use.

        Returns
        -------
        array, shape (..., C, 2)
            ``float32``; ``float64`` for ``float64`` textures.

        Raises
        ------
        ValueError, TypeError
            For a shape, dtype or name that is not as above.

        Examples
        --------
        >>> import numpy as np, multum as mt
        >>> mt.Texture(np.float32([[0, 1], [0, 1]])).gradient([0.5, 0.5]).tolist()
        [[2.0, 0.0]]
        """
        return self._texture.gradient(np.asarray(uv), name("filter", filter), count("threads", threads))
