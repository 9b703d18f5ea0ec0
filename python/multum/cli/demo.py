"""``multum demo``: pictures that show what the library does, and a page to look at them."""

import argparse
from typing import TYPE_CHECKING

from .progress import Progress

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]


def add(commands: "Commands") -> None:
    """Describe the command."""
    command = commands.add_parser(
        "demo",
        help="make pictures that show what this is, and a page to look at them",
        description="Warp, tile, enlarge and reduce real pictures, as OpenCV does it (where it is installed) and "
        "as multum does it, and measure both against a densely supersampled truth.",
    )
    command.set_defaults(run=run)
    command.add_argument(
        "-o", "--out", default="out/demo", metavar="FOLDER", help="made if absent (default: %(default)s)"
    )
    command.add_argument(
        "--scale", type=float, default=1.0, metavar="S", help="size of the pictures, 0.2 to 4 (default: 1)"
    )
    command.add_argument("--only", nargs="+", metavar="NAME", help="some of the pictures, by name")


def run(options: argparse.Namespace) -> None:
    """Do it."""
    from .. import demo

    with Progress(len(options.only or demo.PICTURES)) as progress:
        figures = demo.make(options.out, options.scale, options.only, progress.step)
    print("\n".join(demo.summary(figures, options.out)))
