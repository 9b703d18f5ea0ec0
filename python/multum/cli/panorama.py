"""``multum panorama``: from one form of a picture of all directions to another."""

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import panorama
from .files import transform
from .options import add_files, numbers

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]

_FORMS = (
    "equirect",
    "cube",
    "perspective",
    "fisheye",
    "probe",
    "mirror_ball",
    "stereographic",
    "dual_paraboloid",
    "octahedral",
)
_LAYOUTS = ("cross", "strip", "stacked")
_MODELS = ("equidistant", "equisolid")

_DESCRIPTION = """\
Convert a panorama between forms, at any rotation. Each pixel shows the average of all it covers.
"""

_EXAMPLES = """\
examples:
  a cube map, as a cross, of an equirectangular picture:
    multum panorama sky.hdr cross.hdr --to cube
  what a camera sees that looks 30 degrees to the right and 10 up:
    multum panorama earth.jpg view.png --to perspective --fov 75 --size 800x600 --rotation 30 10
  a little planet:
    multum panorama street.jpg planet.png --to stereographic --fov 280 --rotation 0 -90
  the picture of a mirror ball as an equirectangular one of 2048x1024:
    multum panorama ball.exr sky.exr --from mirror_ball --size 2048
"""


def add(commands: "Commands") -> None:
    """Describe the command."""
    command = commands.add_parser(
        "panorama",
        help="convert a picture of all directions: equirectangular, cube, fisheye and others",
        description=_DESCRIPTION,
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.set_defaults(run=run)
    add_files(command)
    form = command.add_argument_group("the forms")
    form.add_argument(
        "--from",
        dest="source",
        choices=_FORMS,
        default="equirect",
        metavar="FORM",
        help=f"of IN: {', '.join(_FORMS)} (default: equirect)",
    )
    form.add_argument(
        "--to", dest="target", choices=_FORMS, default="equirect", metavar="FORM", help="of OUT, likewise"
    )
    form.add_argument(
        "--size",
        metavar="N|WxH",
        help="of OUT: width, or side of a cube's face, or both sides (default: as many pixels a turn as IN)",
    )
    form.add_argument(
        "--rotation",
        nargs="+",
        metavar="R",
        help="where OUT looks: degrees to the right, up, and of roll clockwise (one to three numbers); "
        "or 9 numbers, a matrix from directions of OUT to those of IN",
    )
    form.add_argument("--fov", type=float, metavar="DEGREES", help="that OUT sees across")
    form.add_argument("--source-fov", type=float, metavar="DEGREES", help="that IN sees across")
    form.add_argument("--layout", choices=_LAYOUTS, default="cross", help="of a cube in OUT (default: cross)")
    form.add_argument("--source-layout", choices=_LAYOUTS, help="of a cube in IN (default: by its shape)")
    form.add_argument("--model", choices=_MODELS, default="equidistant", help="of a fisheye in OUT")
    form.add_argument("--source-model", choices=_MODELS, default="equidistant", help="of a fisheye in IN")
    how = command.add_argument_group("filtering")
    how.add_argument(
        "--filter", default="auto", metavar="NAME", help="default: auto, the mean of what is covered"
    )
    how.add_argument(
        "--border",
        nargs="+",
        default=["0"],
        metavar="CODE",
        help="colour where there is no picture: one number, or one a channel (default: 0)",
    )
    how.add_argument(
        "--encoding", choices=("linear", "srgb"), help="srgb averages light, as is right for photographs"
    )
    how.add_argument("--alpha", choices=("none", "straight", "premultiplied"), default="none")
    how.add_argument("--threads", type=int, metavar="N", help="default: all cores")


def run(options: argparse.Namespace) -> None:
    """Do it."""
    rotation = None if options.rotation is None else _rotation(numbers(options.rotation))
    size = None if options.size is None else _size(options.size)
    border = numbers(options.border)

    def work(image: NDArray[Any], progress: Callable[[float], None]) -> NDArray[Any]:
        layout = options.source_layout
        if options.source == "cube" and layout is None:
            layout = _layout_of(image)
        return panorama.convert(
            image,
            options.source,
            options.target,
            size,
            rotation,
            options.fov,
            source_fov=options.source_fov,
            layout=options.layout,
            source_layout=layout or "cross",
            model=options.model,
            source_model=options.source_model,
            filter=options.filter,
            border=border[0] if len(border) == 1 else border,
            encoding=options.encoding or "linear",
            alpha=options.alpha,
            threads=options.threads,
            progress=progress,
        )

    transform(options, "converting", work)


def _size(text: str) -> int | tuple[int, int]:
    """One number or two."""
    parts = text.lower().split("x")
    if len(parts) > 2 or not all(part.isdecimal() for part in parts):
        raise ValueError(f"--size: got {text!r}, expected a number of pixels, or two such as 800x600")
    return int(parts[0]) if len(parts) == 1 else (int(parts[0]), int(parts[1]))


def _rotation(values: list[float]) -> NDArray[np.float64]:
    """A matrix from degrees or from its nine numbers."""
    if len(values) == 9:
        return np.reshape(values, (3, 3))
    if not 1 <= len(values) <= 3:
        raise ValueError(f"--rotation: got {len(values)} numbers, expected 1 to 3 degrees or 9 of a matrix")
    return panorama.rotation(*values)


def _layout_of(image: NDArray[Any]) -> str:
    """The layout whose cells would be square."""
    height, width = image.shape[:2]
    for layout, (columns, rows) in {"cross": (4, 3), "strip": (6, 1), "stacked": (1, 6)}.items():
        if width * rows == height * columns:
            return layout
    raise ValueError(f"IN: got {width}x{height}, expected a cube of 4x3, 6x1 or 1x6 square faces")
