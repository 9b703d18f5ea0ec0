"""The gallery behind ``multum gallery``: every map on every shape, and where maps fail."""

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from .. import __version__
from .._files import write_image
from .._mesh import Mesh
from ..demo.draw import sheet
from ..demo.figure import Figure, Panel
from ..demo.page import page
from .failures import FAILURES
from .maps import MAPS, Shown
from .paint import FINER, paint, stretch
from .shapes import Shape, of_mesh, shapes

__all__ = ["FAILURES", "MAPS", "make"]


def make(
    out: str | os.PathLike[str],
    size: int = 160,
    only: Sequence[str] | None = None,
    mesh: str | os.PathLike[str] | None = None,
    tell: Callable[[str], None] = lambda name: None,
) -> list[Figure]:
    """Draw every map on a sphere, a cylinder, a cube, a torus and a mesh, where maps fail, and ``index.html``.

    Parameters
    ----------
    out : path
        The folder; made if absent.
    size : int
        Side of a picture in pixels, 32 to 1024.
    only : sequence of str, optional
        Names of :data:`MAPS` and :data:`FAILURES`; default all.
    mesh : path, optional
        A glTF or OBJ file for the last column; default a rock made by a formula.
    tell : callable
        Gets the name of each sheet before it is drawn.

    Raises
    ------
    ValueError, OSError
        For a size or name that is not as above, and a mesh that cannot be read.
    """
    if not 32 <= size <= 1024:
        raise ValueError(f"size: got {size}, expected 32 to 1024")
    known = [*MAPS, *FAILURES]
    names = known if only is None else list(only)
    for name in names:
        if name not in known:
            raise ValueError(f"only: got {name!r}, expected names of {', '.join(known)}")
    columns = dict(shapes())
    if mesh is not None:
        del columns["rock"]
        columns[Path(mesh).stem] = of_mesh(Mesh.open(mesh))
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    figures = []
    for name in names:
        tell(name)
        figure = FAILURES[name](size) if name in FAILURES else _figure(name, MAPS[name], columns, size)
        write_image(folder / f"{name}.png", sheet(figure))
        figures.append(figure)
    about = (
        f"Made by multum {__version__}. Checkerboards are filtered exactly with each map's analytic Jacobian; red "
        "grows with u, blue with v; grey is where a map has no answer. Heat maps: area (stretch against its "
        "median) and angle (longest against shortest), blue 1/4 and less, white 1, red 4 and more."
    )
    (folder / "index.html").write_text(page(figures, about, "multum gallery"), encoding="utf-8")
    return figures


def _figure(name: str, shown: Shown, columns: dict[str, Shape], size: int) -> Figure:
    rows = list(_rows(shown, columns, size))
    return Figure(name, shown.title, shown.text, rows)


def _rows(shown: Shown, columns: dict[str, Shape], size: int) -> Iterator[list[Panel]]:
    views = {name: shape.seen(FINER * size) for name, shape in columns.items()}
    for label, mapping in shown.maps.items():
        yield [
            Panel(paint(mapping, view), name, label if i == 0 else "")
            for i, (name, view) in enumerate(views.items())
        ]
        if len(shown.maps) == 1:
            for kind in ("area", "angle"):
                yield [Panel(stretch(mapping, view, kind), kind) for view in views.values()]
