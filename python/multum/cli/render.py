"""``multum render``: a picture of a model."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from .._environment import Environment
from .._files import read_image, write_image
from .._render import TextureUse, render, right_size
from .._scene import Scene
from .progress import Progress

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]

_DESCRIPTION = """\
Draw a glTF, GLB or OBJ model with every texture filtered over what each pixel covers of it.
"""

_EXAMPLES = """\
examples:
  eight pictures from all round, view_0.png to view_7.png:
    multum render model.glb -o view.png --size 1920x1080 --turntable 8
  lit by a panorama that is seen behind it, with shadows of the model's lights:
    multum render model.glb -o view.png --environment sky.hdr --show-environment --shadows 2048
  what the textures see, and which sizes of them this view can use:
    multum render model.glb -o lod.png --debug lod
    multum render model.glb -o view.png --right-size
"""


def _size(text: str) -> tuple[int, int]:
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.isdecimal() for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r}, expected a size such as 1920x1080")
    return int(parts[0]), int(parts[1])


def add(commands: "Commands") -> None:
    """Describe the command."""
    command = commands.add_parser(
        "render",
        help="a picture of a glTF or OBJ model",
        description=_DESCRIPTION,
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.set_defaults(run=run)
    command.add_argument("model", metavar="MODEL", help="glTF, GLB or OBJ")
    command.add_argument("-o", "--output", metavar="OUT", required=True, help="a PNG file")
    command.add_argument("--size", type=_size, default=(1024, 768), metavar="WxH", help="default: 1024x768")
    command.add_argument("--camera", default="auto", help="name of one of the model's (default: its first)")
    command.add_argument(
        "--turntable", type=int, default=1, metavar="N", help="N pictures from all round: OUT_0, OUT_1, ..."
    )
    command.add_argument("--filter", default="auto", help="as for textures, or file (default: auto)")
    command.add_argument(
        "--supersample", type=int, default=2, metavar="N", help="N x N for smooth edges (default: 2)"
    )
    command.add_argument("--background", type=float, metavar="GREY", help="0 to 1 (default: transparent)")
    command.add_argument("--environment", metavar="PANORAMA", help="light from an equirectangular picture")
    command.add_argument("--show-environment", action="store_true", help="and see it behind the model")
    command.add_argument("--shadows", type=int, metavar="N", help="with depth textures of N x N")
    command.add_argument(
        "--debug", choices=("uv", "footprint", "lod", "normals", "checker"), help="what textures see"
    )
    command.add_argument("--right-size", action="store_true", help="tell what size of each texture is used")
    command.add_argument("--threads", type=int, metavar="N", help="default: all cores")


def run(options: argparse.Namespace) -> None:
    """Do it."""
    if options.turntable < 1:
        raise ValueError(f"--turntable: got {options.turntable}, expected 1 or more")
    if options.show_environment and options.environment is None:
        raise ValueError("--show-environment: got no --environment, expected a panorama")
    out = Path(options.output)
    if out.suffix.lower() != ".png":
        raise ValueError(f"-o: got {options.output!r}, expected a PNG file")
    lines: list[str] = []
    uses: list[TextureUse] = []
    with Progress(1 + options.turntable) as progress:
        progress.step(f"reading {os.path.basename(options.model)}")
        scene = Scene.open(options.model)
        camera = scene.camera(options.camera, options.size, turning=options.turntable > 1)
        sky = None
        if options.environment is not None:
            picture = read_image(options.environment)
            encoding = "srgb" if picture.dtype.kind == "u" else "linear"
            sky = Environment(picture, encoding=encoding)
        for k in range(options.turntable):
            path = out if options.turntable == 1 else out.with_name(f"{out.stem}_{k}{out.suffix}")
            progress.step(f"drawing {path.name}")
            image = render(
                scene,
                camera.turned(360 * k / options.turntable, scene.center),
                options.size,
                options.filter,
                background="environment" if options.show_environment else options.background,
                environment=sky,
                shadows=options.shadows,
                supersample=options.supersample,
                debug=options.debug,
                threads=options.threads,
                progress=progress.share,
            )
            write_image(path, image)
            lines.append(f"{path}: {image.shape[1]}x{image.shape[0]}")
        if options.right_size:
            uses = right_size(scene, camera, options.size, threads=options.threads)
    print("\n".join(lines))
    for use in uses:
        reads = max(use.reads, 1)
        shares = " ".join(f"{100 * n / reads:.0f}" for n in use.histogram)
        print(
            f"{use.name}: {use.size[0]}x{use.size[1]}, {100 * use.touched:.0f} % touched, "
            f"{use.recommended[0]}x{use.recommended[1]} is enough; "
            f"% of reads enlarged, on level 0, 1, ...: {shares}"
        )
