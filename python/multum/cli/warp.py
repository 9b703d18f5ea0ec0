"""``multum warp``: a picture through a matrix, a map or four corners."""

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _warp
from .files import transform
from .options import add_files, add_filtering, filtering, load_array, numbers, size

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]

_DESCRIPTION = """\
Warp a picture. Pixel centres are at whole numbers, x to the right, y down. Where the map makes the picture
smaller, each pixel shows the average of all it covers; where it makes it larger, the interpolation.
"""

_EXAMPLES = """\
examples:
  half a turn about the origin of a 600x400 picture:
    multum warp in.png out.png --matrix -1 0 599  0 -1 399
  a page photographed askew, made straight (corners: top left, top right, bottom right, bottom left):
    multum warp page.jpg flat.png --corners 90,40 610,80 640,900 60,860 --size 600x850 --encoding srgb
  a map made by another program (float array, height x width x 2, holding x and y of IN):
    multum warp in.exr out.exr --map map.npy --wrap repeat clamp
"""


def add(commands: "Commands") -> None:
    """Describe the command."""
    command = commands.add_parser(
        "warp",
        help="warp a picture by a matrix, a map or four corners",
        description=_DESCRIPTION,
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.set_defaults(run=run)
    add_files(command)
    how = command.add_argument_group("the map, one of").add_mutually_exclusive_group(required=True)
    how.add_argument(
        "--matrix",
        nargs="+",
        metavar="M",
        help="6 or 9 numbers, row by row, from pixels of OUT to pixels of IN; or a .npy or text file of them",
    )
    how.add_argument(
        "--map", metavar="FILE", help=".npy array (height, width, 2): x and y of IN for each pixel"
    )
    how.add_argument(
        "--corners",
        nargs="+",
        metavar="X,Y",
        help="where in IN the centres of OUT's corner pixels lie: top left, top right, bottom right, bottom left",
    )
    command.add_argument("--forward", action="store_true", help="the matrix leads from IN to OUT: invert it")
    command.add_argument(
        "--size", type=size, metavar="WxH", help="of OUT (default: that of the map, else IN)"
    )
    command.add_argument(
        "--debug",
        choices=("cost", "lod"),
        help="draw what each pixel costs (1 to 4096 look-ups, dark to light) or on which level it is read (0 to 8)",
    )
    add_filtering(command, wrap="border")


def run(options: argparse.Namespace) -> None:
    """Do it."""
    if options.forward and options.matrix is None:
        raise ValueError("--forward: goes with --matrix only")
    keywords = filtering(options)

    def work(image: NDArray[Any], _: Callable[[float], None]) -> NDArray[Any]:
        height, width = image.shape[:2]
        shape = None if options.size is None else (options.size[1], options.size[0])
        if options.map is not None:
            mapping = load_array("--map", options.map)
        elif options.matrix is not None:
            mapping = _matrix(options.matrix, options.forward)
            shape = shape or (height, width)
        else:
            shape = shape or (height, width)
            mapping = corners_matrix(numbers(options.corners), shape)
        if options.debug is not None:
            drawn: NDArray[Any] = _warp.survey(image, mapping, shape, **keywords).picture(options.debug)
            return drawn
        warped: NDArray[Any] = _warp.warp(image, mapping, shape, **keywords)
        return warped

    transform(options, "warping", work)


def _matrix(words: list[str], forward: bool) -> NDArray[np.float64]:
    """A 2x3 or 3x3 matrix from numbers or a file."""
    try:
        values = np.array(numbers(words))
    except ValueError:
        if len(words) > 1:
            raise ValueError(
                f"--matrix: got {' '.join(words)!r}, expected 6 or 9 numbers, or one file"
            ) from None
        values = load_array("--matrix", words[0]).astype(np.float64)
    if values.size not in (6, 9):
        raise ValueError(f"--matrix: got {values.size} numbers, expected 6 (2x3) or 9 (3x3), row by row")
    matrix = np.vstack([values.reshape(-1, 3), [[0.0, 0.0, 1.0]]])[:3]
    if not forward:
        return matrix
    try:
        return np.asarray(np.linalg.inv(matrix))
    except np.linalg.LinAlgError:
        raise ValueError("--forward: the matrix has no inverse; give one from OUT to IN") from None


def corners_matrix(corners: list[float], shape: tuple[int, int]) -> NDArray[np.float64]:
    """The homography that takes the corner pixels of a picture of this shape to four places."""
    if len(corners) != 8:
        raise ValueError(f"--corners: got {len(corners)} numbers, expected 8: x,y of four corners")
    right, bottom = max(shape[1] - 1, 1), max(shape[0] - 1, 1)
    rows, known = [], []
    for (x, y), (u, v) in zip(
        ((0, 0), (right, 0), (right, bottom), (0, bottom)),
        np.reshape(corners, (4, 2)).tolist(),
        strict=True,
    ):
        rows += [[x, y, 1, 0, 0, 0, -u * x, -u * y], [0, 0, 0, x, y, 1, -v * x, -v * y]]
        known += [u, v]
    try:
        solved = np.linalg.solve(np.array(rows, dtype=np.float64), np.array(known))
    except np.linalg.LinAlgError:
        raise ValueError("--corners: three of the corners lie on a line; expected a quadrilateral") from None
    return np.append(solved, 1.0).reshape(3, 3)
