"""Speed against accuracy, measured here and now, judged by the f64 integral."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from .report import Chart

__all__ = ["chart"]


def chart(
    image: ArrayLike | None = None,
    out: str | os.PathLike[str] | None = None,
    *,
    scenes: Sequence[str] | None = None,
    textures: Sequence[str] | None = None,
    methods: Sequence[str] | None = None,
    peers: bool = True,
    quick: bool = False,
    view: int | None = None,
    side: int | None = None,
    rounds: int | None = None,
    patience: float = 10.0,
    tell: Callable[[str], None] = lambda text: None,
) -> Chart:
    """Measure time and error of every filter and of other libraries, and draw them.

    Each scene shows a texture that repeats. ``"warp"`` methods go from an 8-bit picture and a matrix or map to an
    8-bit picture, all of their work included (peers get maps made beforehand); ``"sample"`` methods read a texture
    made ready at given places with given Jacobians. The truth is :func:`multum.reference.warp` at pixels drawn at
    random, the same for all; rounding to 8 bits alone is an error of 0.29. One thread, one process, methods in
    turn; times are the least and the median of all calls.

    Parameters
    ----------
    image : array, shape (H, W) or (H, W, 3), optional
        ``uint8``; takes the place of the textures.
    out : path, optional
        A folder for chart.png, index.html, chart.json, chart.csv and dominated.csv; made if absent. Needs
        matplotlib.
    scenes : sequence of str, optional
        Some of ``"magnify"``, ``"rotate"``, ``"homography"``, ``"barrel"``, ``"cylinder"``, ``"sphere"``,
        ``"planet"``, ``"plane"``; default all.
    textures : sequence of str, optional
        Some of ``"checker"``, ``"text"``, ``"photo"``, ``"noise"``; default all.
    methods : sequence of str, optional
        Only methods whose name begins with one of these.
    peers : bool
        Whether other libraries take part: OpenCV, scikit-image, SciPy, reproject, OpenImageIO and Mesa's llvmpipe
        (through moderngl), as far as they are installed.
    quick : bool
        Smaller views and textures, fewer rounds and pixels: half a minute.
    view, side, rounds : int, optional
        Side of the view (384; quick 192), of the textures (1024; quick 512), and calls in turn (7; quick 4).
    patience : float
        Seconds that one call may take.
    tell : callable
        Gets the name of each step before it is made.

    Returns
    -------
    Chart
        ``points``, ``verdicts()`` and ready-made text.

    Raises
    ------
    ValueError, TypeError
        For unknown names, an image that is not as above, and sizes out of range.

    Examples
    --------
    >>> import multum as mt
    >>> made = mt.chart(scenes=["rotate"], textures=["noise"], methods=["bilinear", "area"], peers=False,
    ...                 view=32, side=64, rounds=1)
    >>> error = {p.method: p.rms for p in made.points if p.kind == "warp"}
    >>> error["area"] < error["bilinear"]
    True
    """
    # Other libraries are imported only when they are asked for.
    from .run import run

    return run(
        image,
        out,
        scenes,
        textures,
        methods,
        peers,
        quick=quick,
        view=view,
        side=side,
        rounds=rounds,
        patience=patience,
        tell=tell,
    )
