"""Options that several commands share, and what their words mean."""

import argparse
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

FILTERS = (
    "auto, nearest, bilinear, bicubic, mitchell, trilinear, anisotropic and the other names of the library"
)
WRAPS = "border, clamp, repeat, mirror, mirror_once, mirror_101"
FORMATS = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".hdr", ".exr")


def size(text: str) -> tuple[int, int]:
    """``640x480`` as (width, height)."""
    width, cross, height = text.strip().lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise argparse.ArgumentTypeError(f"got {text!r}, expected WIDTHxHEIGHT in pixels, such as 640x480")
    return int(width), int(height)


def numbers(words: list[str]) -> list[float]:
    """Numbers separated by blanks or commas."""
    parts = [part for word in words for part in word.replace(",", " ").split()]
    try:
        return [float(part) for part in parts]
    except ValueError:
        raise ValueError(f"got {' '.join(words)!r}, expected numbers") from None


def load_array(name: str, path: str) -> NDArray[Any]:
    """An array from a .npy file, or from a text file of rows of numbers."""
    if not os.path.exists(path):
        raise OSError(f"{name}: there is no file {path!r}")
    try:
        if path.endswith(".npy"):
            return np.asarray(np.load(path, allow_pickle=False))
        with open(path, encoding="utf-8") as file:
            rows = [numbers([line]) for line in file if line.strip()]
        return np.array(rows, dtype=np.float64)
    except ValueError as error:
        raise ValueError(f"{name}: {path} holds no plain array ({error})") from None


def add_files(command: argparse.ArgumentParser) -> None:
    """The input and the output file."""
    kinds = "PNG, JPEG, TIFF, HDR or EXR"
    command.add_argument("input", metavar="IN", help=f"{kinds}, 8 or 16 bit or float")
    command.add_argument("output", metavar="OUT", help=f"{kinds}, by its extension; replaced if it exists")
    command.add_argument(
        "--depth",
        choices=("8", "16", "float"),
        help="numbers in OUT: bits, or floats (default: those of IN where the format of OUT holds them)",
    )


def add_filtering(command: argparse.ArgumentParser, wrap: str) -> None:
    """How to filter, what lies outside, what the codes mean."""
    group = command.add_argument_group("filtering")
    group.add_argument("--filter", default="auto", metavar="NAME", help=f"{FILTERS} (default: auto)")
    group.add_argument(
        "--wrap",
        nargs="+",
        default=[wrap],
        metavar="MODE",
        help=f"what lies outside IN, once or for x and y: {WRAPS} (default: {wrap})",
    )
    group.add_argument(
        "--border",
        nargs="+",
        default=["0"],
        metavar="CODE",
        help="colour outside under --wrap border, in the numbers of IN: one, or one a channel (default: 0)",
    )
    group.add_argument(
        "--encoding",
        choices=("linear", "srgb", "normal"),
        help="what the numbers of IN mean; srgb averages light, as is right for photographs; normal is for "
        "normal maps (default: linear, the numbers as they are)",
    )
    group.add_argument(
        "--alpha",
        choices=("none", "straight", "premultiplied"),
        default="none",
        help="what the last of 2 or 4 channels means (default: %(default)s, a channel like others)",
    )
    group.add_argument("--max-anisotropy", type=float, default=16.0, metavar="N", help="default: %(default)g")
    group.add_argument("--threads", type=int, metavar="N", help="default: all cores")


def filtering(options: argparse.Namespace) -> dict[str, Any]:
    """Keyword arguments of :func:`multum.warp` and :func:`multum.resize`."""
    if len(options.wrap) > 2:
        raise ValueError(f"--wrap: got {len(options.wrap)} modes, expected one or two (x and y)")
    border = numbers(options.border)
    return {
        "filter": options.filter,
        "wrap": options.wrap[0] if len(options.wrap) == 1 else tuple(options.wrap),
        "border": border[0] if len(border) == 1 else border,
        "encoding": options.encoding or "linear",
        "alpha": options.alpha,
        "max_anisotropy": options.max_anisotropy,
        "threads": options.threads,
    }
