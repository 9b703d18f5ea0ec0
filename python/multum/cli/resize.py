"""``multum resize``: a picture made larger or smaller."""

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from .. import _warp
from .files import transform
from .options import add_files, add_filtering, filtering, size

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]

_EXAMPLES = """\
examples:
  multum resize photo.jpg small.jpg --scale 0.25 --encoding srgb
  multum resize sprite.png large.png --size 512x512 --filter nearest --alpha straight
  multum resize height16.png half.tif --scale 0.5
"""


def add(commands: "Commands") -> None:
    """Describe the command."""
    command = commands.add_parser(
        "resize",
        help="make a picture larger or smaller",
        description="Resize a picture: averages when smaller, interpolation when larger.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.set_defaults(run=run)
    add_files(command)
    how = command.add_argument_group("the new size, one of").add_mutually_exclusive_group(required=True)
    how.add_argument("--size", type=size, metavar="WxH", help="in pixels")
    how.add_argument("--scale", type=float, metavar="S", help="0.5 halves both sides")
    add_filtering(command, wrap="clamp")


def run(options: argparse.Namespace) -> None:
    """Do it."""
    if options.scale is not None and not 0.0 < options.scale < 1e6:
        raise ValueError(f"--scale: got {options.scale}, expected a number above 0")
    keywords = filtering(options)

    def work(image: NDArray[Any], _: Callable[[float], None]) -> NDArray[Any]:
        height, width = image.shape[:2]
        if options.size is not None:
            width, height = options.size
        else:
            width, height = (max(1, round(side * options.scale)) for side in (width, height))
        return _warp.resize(image, (height, width), **keywords)

    transform(options, "resizing", work)
