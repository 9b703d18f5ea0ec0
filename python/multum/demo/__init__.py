"""The demonstration behind ``multum demo``."""

import os
import platform
from collections.abc import Callable, Sequence
from pathlib import Path

from .. import __version__
from .._files import write_image
from .._threads import get_num_threads
from . import compare, gallery, peers
from .draw import LABELS, sheet
from .figure import Figure
from .page import page

PICTURES: dict[str, Callable[[float], Figure]] = {
    "homography": compare.homography,
    "plane": compare.plane,
    "levels": compare.levels_of_detail,
    "wrap": gallery.wrap_modes,
    "magnification": gallery.magnification,
    "pyramid": gallery.pyramid,
    "linear_light": gallery.linear_light,
}


def make(
    out: str | os.PathLike[str],
    scale: float = 1.0,
    only: Sequence[str] | None = None,
    tell: Callable[[str], None] = lambda name: None,
) -> list[Figure]:
    """Make the pictures and ``index.html`` in a folder.

    Parameters
    ----------
    out : path
        The folder; made if absent.
    scale : float
        Size of the pictures, 0.2 to 4.
    only : sequence of str, optional
        Names of :data:`PICTURES`; default all.
    tell : callable
        Gets the name of each picture before it is made.
    """
    if not 0.2 <= scale <= 4.0:
        raise ValueError(f"scale: got {scale}, expected 0.2 to 4")
    names = list(PICTURES) if only is None else list(only)
    for name in names:
        if name not in PICTURES:
            raise ValueError(f"only: got {name!r}, expected names of {', '.join(PICTURES)}")
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    figures = []
    for name in names:
        tell(name)
        figure = PICTURES[name](scale)
        write_image(folder / f"{name}.png", sheet(figure))
        figures.append(figure)
    threads = get_num_threads()
    about = (
        f"Made by multum {__version__} on {platform.machine()} with {threads} thread{'s'[: threads > 1]}; compared "
        f"with {peers.NAME}. Errors are root mean squares in codes of 255. {peers.NOTE} {_no_labels()}"
    ).strip()
    (folder / "index.html").write_text(page(figures, about), encoding="utf-8")
    return figures


def summary(figures: list[Figure], out: str | os.PathLike[str]) -> list[str]:
    """What was written and what was measured."""
    lines = []
    for figure in figures:
        lines.append(f"{Path(out) / (figure.name + '.png')}: {figure.title}")
        lines += [f"    {line}" for line in figure.measured]
    if peers.NOTE or not LABELS:
        lines.append(f"{peers.NOTE} {_no_labels()}".strip())
    return [*lines, f"{Path(out) / 'index.html'}: open it in a browser"]


def _no_labels() -> str:
    return (
        ""
        if LABELS
        else "Pictures have no labels because matplotlib is not installed (pip install multum[demo])."
    )
