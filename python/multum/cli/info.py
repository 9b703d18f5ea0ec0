"""``multum info``: what an image file holds, and what it takes as a texture."""

import argparse
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._files import image_info, read_image
from .._texture import Texture

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]


def add(commands: "Commands") -> None:
    """Describe the command."""
    command = commands.add_parser(
        "info",
        help="what a file holds, and what it takes as a texture",
        description="Show format, size, channels, levels, memory as a texture and the range of values.",
    )
    command.set_defaults(run=run)
    command.add_argument("files", nargs="+", metavar="FILE", help="PNG, JPEG, TIFF, HDR or EXR")


def run(options: argparse.Namespace) -> None:
    """Do it."""
    for number, path in enumerate(options.files):
        if number:
            print()
        print("\n".join(f"{name + ':':<10} {text}" for name, text in describe(path)))


def describe(path: str) -> list[tuple[str, str]]:
    """Name and text of each line."""
    header = image_info(path)
    image = read_image(path)
    texture = Texture(image)
    base = texture.nbytes
    texture.sample(np.array([[0.5, 0.5]]), lod=np.array([1.0]), filter="trilinear")
    last = texture.num_levels - 1
    names = {1: "grey", 2: "grey, alpha", 3: "red, green, blue", 4: "red, green, blue, alpha"}
    return [
        ("file", path),
        ("format", header.format.upper()),
        ("size", f"{header.width} x {header.height} pixels"),
        ("channels", f"{header.channels} ({names.get(header.channels, 'unnamed')})"),
        ("numbers", f"{header.dtype}"),
        ("values", _range(image)),
        (
            "levels",
            f"{texture.num_levels}, from {texture.width}x{texture.height} to {_level_size(texture, last)}",
        ),
        ("memory", f"{_bytes(base)} as a texture, {_bytes(texture.nbytes)} with all levels"),
    ]


def _level_size(texture: Texture, level: int) -> str:
    return f"{max(1, texture.width >> level)}x{max(1, texture.height >> level)}"


def _range(image: NDArray[Any]) -> str:
    """Smallest and largest number, by channel where there are several."""
    planes = image.reshape(-1, image.shape[2] if image.ndim == 3 else 1)
    odd = planes.size - int(np.isfinite(planes).sum())
    if odd:
        planes = np.where(np.isfinite(planes), planes, np.nan)
    with np.errstate(all="ignore"):
        low, high = np.nanmin(planes, axis=0), np.nanmax(planes, axis=0)
    parts = [f"{a:g} to {b:g}" for a, b in zip(low, high, strict=True)]
    return ", ".join(parts) + (f" ({odd} not finite)" if odd else "")


def _bytes(count: int) -> str:
    if count < 1000:
        return f"{count} bytes"
    return f"{count / 1e3:.1f} kB" if count < 1e6 else f"{count / 1e6:.1f} MB"
