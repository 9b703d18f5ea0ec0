"""``multum chart``: speed against accuracy on this machine."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from .progress import Progress

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]


def add(commands: "Commands") -> None:
    """Describe the command."""
    command = commands.add_parser(
        "chart",
        help="time and error of every filter and of other libraries, drawn",
        description="Measure every filter, and OpenCV, scikit-image, SciPy, reproject, OpenImageIO and llvmpipe "
        "where they are installed, against the exact integral over each pixel; write chart.png, index.html, "
        "chart.json, chart.csv and dominated.csv.",
    )
    command.set_defaults(run=run)
    command.add_argument("image", nargs="?", metavar="IMAGE", help="8 bits; instead of the built-in textures")
    command.add_argument(
        "-o", "--out", default="chart", metavar="FOLDER", help="made if absent (default: %(default)s)"
    )
    command.add_argument("--scene", nargs="+", metavar="NAME", help="some of the scenes")
    command.add_argument("--texture", nargs="+", metavar="NAME", help="some of checker, text, photo, noise")
    command.add_argument("--method", nargs="+", metavar="NAME", help="only methods whose names begin so")
    command.add_argument("--quick", action="store_true", help="small views and textures, few rounds")
    command.add_argument("--no-peers", action="store_true", help="multum alone")
    command.add_argument("--view", type=int, metavar="N", help="pixels a side of each view (default: 384)")
    command.add_argument(
        "--side", type=int, metavar="N", help="texels a side of the textures (default: 1024)"
    )
    command.add_argument("--rounds", type=int, metavar="N", help="calls in turn (default: 7)")


def run(options: argparse.Namespace) -> None:
    """Do it."""
    from .._chart import run as charts
    from .._files import read_image

    image = None if options.image is None else read_image(options.image)
    with Progress(
        charts.steps(image, options.scene, options.texture, options.method, not options.no_peers)
    ) as bar:
        made = charts.run(
            image,
            options.out,
            options.scene,
            options.texture,
            options.method,
            not options.no_peers,
            quick=options.quick,
            view=options.view,
            side=options.side,
            rounds=options.rounds,
            patience=1.0 if options.quick else 4.0,
            tell=bar.step,
        )
    print("; ".join(f"{k}: {v}" for k, v in made.about.items()), end="\n\n")
    for lines in (made.table(), made.domination(), made.economy(), made.missing()):
        print("\n".join(lines), end="\n\n" if lines else "")
    for name in ("chart.png", "index.html", "chart.json", "chart.csv", "dominated.csv"):
        print(Path(options.out) / name)
