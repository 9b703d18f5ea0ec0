"""``multum gallery``: every mapping function on every shape, drawn."""

import argparse
from typing import TYPE_CHECKING

from .progress import Progress

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]


def add(commands: "Commands") -> None:
    """Describe the command."""
    command = commands.add_parser(
        "gallery",
        help="draw every mapping function on a sphere, a cylinder, a cube, a torus and a mesh",
        description="Draw every mapping function on five shapes, as a checkerboard and as heat maps of how it "
        "stretches areas and angles, the places where maps fail, and a page to look at them. Needs matplotlib.",
    )
    command.set_defaults(run=run)
    command.add_argument(
        "-o", "--out", default="out/gallery", metavar="FOLDER", help="made if absent (default: %(default)s)"
    )
    command.add_argument(
        "--size", type=int, default=160, metavar="N", help="side of a picture (default: 160)"
    )
    command.add_argument("--only", nargs="+", metavar="NAME", help="some of the sheets, by name")
    command.add_argument("--mesh", metavar="FILE", help="glTF or OBJ for the last column")


def run(options: argparse.Namespace) -> None:
    """Do it."""
    from .. import gallery

    with Progress(len(options.only or [*gallery.MAPS, *gallery.FAILURES])) as progress:
        figures = gallery.make(options.out, options.size, options.only, options.mesh, progress.step)
    print(f"{options.out}: {len(figures)} sheet{'s'[: len(figures) > 1]} and index.html")
