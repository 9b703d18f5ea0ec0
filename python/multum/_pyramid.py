"""How the levels of a texture are made."""

from collections.abc import Sequence
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import count, name, number, wrap_pair


def build_pyramid(
    image: ArrayLike,
    kind: str = "box",
    encoding: str = "linear",
    alpha: str = "none",
    wrap: str | Sequence[str] = "clamp",
    coverage: float | None = None,
    levels: SupportsIndex | None = None,
) -> list[NDArray[Any]]:
    """Make all levels of an image, each half the size of the one before.

    Level ``l`` is ``max(1, n >> l)`` texels wide and high. Averages are taken of what the codes mean (linear
    light, vectors, premultiplied colour), in floating point from level to level; each level is rounded once.

    Parameters
    ----------
    image : array, shape (H, W) or (H, W, C)
        ``uint8``, ``uint16``, ``float16``, ``float32`` or ``float64``, of any size.
    kind : str
        ``"box"``, the mean over a texel's area, exact at odd sizes too; ``"kaiser"`` and ``"lanczos3"`` are
        sharper and ring a little.
    encoding : str
        ``"linear"``, ``"srgb"`` or ``"normal"``. Normals are averaged as vectors and not renormalised: their
        length tells how much they differ.
    alpha : str
        ``"none"``, ``"straight"`` or ``"premultiplied"``; the last of 2 or 4 channels. Straight colour is
        weighted by alpha, so hidden colour never shows; where alpha is 0, colour is 0.
    wrap : str or pair of str
        What ``"kaiser"`` and ``"lanczos3"`` read beyond the edges, for u and v; ``"border"`` and ``"extend"``
        count as ``"clamp"`` here.
    coverage : float, optional
        An alpha in (0, 1]. Alpha is scaled on every level so that the share of texels with at least this
        alpha is the base's: foliage under an alpha test does not thin out in the distance.
    levels : int, optional
        How many levels, the image itself included; default all, down to one texel.

    Returns
    -------
    list of arrays
        Level 0 first: the image itself, not a copy. All have its dtype and number of axes.

    Raises
    ------
    ValueError, TypeError
        For a shape, dtype, name or number that is not as above.

    Examples
    --------
    Half black and half white is half the light, which sRGB writes as 188:

    >>> import numpy as np, multum as mt
    >>> checker = np.uint8([[0, 255], [255, 0]])
    >>> [level.tolist() for level in mt.build_pyramid(checker, encoding="srgb")]
    [[[0, 255], [255, 0]], [[188]]]
    """
    base = np.asarray(image)
    above = _multum.build_pyramid(
        base,
        name("kind", kind),
        name("encoding", encoding),
        name("alpha", alpha),
        wrap_pair(wrap),
        number("coverage", coverage),
        count("levels", levels),
    )
    return [base, *above]
