"""``multum bake``: a detailed mesh to a simple one with maps."""

import argparse
import dataclasses
import os
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import bake
from .._files import write_image
from .._material import MeshImage, TextureSlot
from .._mesh import Mesh
from .progress import Progress

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]

_DESCRIPTION = """\
Bake a detailed mesh into a simple one: simplify it (or take one that is given), unwrap it where it has no uv,
and write a glTF file with normals and tangents, a normal map, and the maps asked for.
"""

_EXAMPLES = """\
examples:
  the whole road; out/ then holds high.gltf, high.bin and high_normal.png:
    multum bake high.obj --simplify 0.01 --size 1024 -o out/
  onto a mesh made elsewhere, with occlusion and colour, 16 bits, and a copy of the normals as EXR:
    multum bake high.obj --low low.obj --maps normal occlusion color --depth 16 --exr -o out/
"""

_MAPS = ("normal", "occlusion", "color", "height", "position", "curvature")
# Maps that are lengths, not shares: what their codes stand for is printed, and glTF has no place for them.
_LENGTHS = ("height", "position", "curvature")


def add(commands: "Commands") -> None:
    """Describe the command."""
    command = commands.add_parser(
        "bake",
        help="maps from a detailed mesh onto a simple one, as glTF",
        description=_DESCRIPTION,
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.set_defaults(run=run)
    command.add_argument("high", metavar="HIGH", help="the detailed mesh: OBJ, glTF or GLB")
    command.add_argument("-o", "--output", metavar="DIR", required=True, help="folder for the results")
    low = command.add_argument_group("the simple mesh").add_mutually_exclusive_group()
    low.add_argument(
        "--simplify", type=float, metavar="SHARE", help="share of the faces to keep, such as 0.01"
    )
    low.add_argument("--low", metavar="LOW", help="a mesh to bake onto; unwrapped if it has no uv")
    command.add_argument(
        "--size", type=int, default=1024, metavar="N", help="side of the maps (default: 1024)"
    )
    command.add_argument(
        "--maps", nargs="+", choices=_MAPS, default=["normal"], help="what to bake (default: normal)"
    )
    command.add_argument("--depth", choices=("8", "16"), default="8", help="bits of PNG files (default: 8)")
    command.add_argument("--exr", action="store_true", help="write each map as floats too")
    command.add_argument("--samples", type=int, default=3, metavar="N", help="N x N a texel (default: 3)")
    command.add_argument("--method", choices=("outermost", "nearest", "closest"), default="outermost")
    command.add_argument("--distance", type=float, help="how far to look (default: measured)")
    command.add_argument(
        "--lowest-level",
        type=int,
        default=2,
        metavar="L",
        help="coarsest level on which charts stay apart (default: 2)",
    )
    command.add_argument("--glb", action="store_true", help="one .glb file instead of .gltf and its parts")
    command.add_argument("--threads", type=int, metavar="N", help="default: all cores")


def run(options: argparse.Namespace) -> None:
    """Do it."""
    folder = Path(options.output)
    stem = Path(options.high).stem
    lines: list[str] = []
    with Progress(4 + len(options.maps)) as progress, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", bake.BakeWarning)
        progress.step(f"reading {os.path.basename(options.high)}")
        high = Mesh.open(options.high)
        progress.step("simplifying")
        low = high
        if options.low is not None:
            low = Mesh.open(options.low)
        elif options.simplify is not None:
            # Old uv and materials are no edges that have to stay.
            one = np.zeros(len(high.faces), np.uint32)
            low = dataclasses.replace(high, uv_sets=[], face_material=one).simplify(options.simplify)
        progress.step("unwrapping")
        if low.uv is None or options.simplify is not None:
            low = low.unwrap(options.size, lowest_level=options.lowest_level)
        folder.mkdir(parents=True, exist_ok=True)
        maps: dict[str, bake.Map] = {}
        for kind in options.maps:
            progress.step(f"baking {kind}")
            depth = "uint16" if options.depth == "16" else "uint8"
            maps[kind] = _bake(kind, high, low, options, depth, progress)
            if options.exr:
                floats = _bake(kind, high, low, options, "float32", progress)
                path = folder / f"{stem}_{kind}.exr"
                # EXR files hold three channels here.
                three = floats if floats.ndim == 3 else np.repeat(floats[..., None], 3, axis=2)
                write_image(path, np.asarray(three, np.float32))
                lines.append(f"{path}: {floats.shape[1]}x{floats.shape[0]}, float32")
        progress.step("writing")
        path = folder / f"{stem}.{'glb' if options.glb else 'gltf'}"
        finished(low, maps).save(path)
        for kind in set(maps) & set(_LENGTHS):
            write_image(folder / f"{stem}_{kind}.png", np.asarray(maps[kind]))
    lines.insert(0, f"{path}: {len(low.faces)} faces of {len(high.faces)}, {', '.join(maps)}")
    for kind, baked in maps.items():
        report = baked.report
        if report is not None:
            low_end, high_end = report.range or (0.0, 0.0)
            scale = f", 0 is {low_end:.6g}, full scale {high_end:.6g}" if kind in _LENGTHS else ""
            lines.append(
                f"{kind}: {baked.shape[1]}x{baked.shape[0]}, {baked.dtype}, {report.covered} texels covered, "
                f"{report.missed} missed{scale}"
            )
    print("\n".join(lines))
    for text in dict.fromkeys(str(warning.message) for warning in caught):
        print(f"warning: {text}")


def _bake(
    kind: str, high: Mesh, low: Mesh, options: argparse.Namespace, dtype: str, progress: Progress
) -> bake.Map:
    keywords: dict[str, Any] = {
        "samples": options.samples,
        "method": options.method,
        "distance": options.distance,
        "threads": options.threads,
        "dtype": dtype,
        "progress": progress.share,
    }
    if kind == "normal":
        return bake.normal_map(high, low, options.size, **keywords)
    if kind == "occlusion":
        return bake.ambient_occlusion(high, low, options.size, **keywords)
    if kind == "color":
        # Floats are linear light, as EXR files are read.
        encoding = "linear" if dtype == "float32" else "srgb"
        return bake.color(high, low, options.size, encoding=encoding, **keywords)
    length = {"height": bake.height, "position": bake.position, "curvature": bake.curvature}[kind]
    return length(high, low, options.size, **keywords)


def finished(low: Mesh, maps: dict[str, bake.Map]) -> Mesh:
    """The mesh with one material that shows its maps; lengths have no place in it."""
    slots: dict[str, TextureSlot] = {}
    images: list[MeshImage] = []
    names = {"normal": "normal_texture", "occlusion": "occlusion_texture", "color": "base_color_texture"}
    encodings = {"normal": "normal", "occlusion": "linear", "color": "srgb"}
    for kind, baked in maps.items():
        if kind not in names:
            continue
        slots[names[kind]] = TextureSlot(
            image=len(images),
            uv_set=0,
            transform=np.eye(2, 3, dtype=np.float32),
            wrap=("clamp", "clamp"),
            mag_filter="bilinear",
            min_filter="trilinear",
            encoding=encodings[kind],
        )
        images.append(MeshImage(kind, pixels=np.asarray(baked)))
    first = low.materials[0]
    base = (1.0, 1.0, 1.0, 1.0) if "color" in maps else first.base_color
    # Without a map the old material's numbers stay, but none of its pictures: they belong to other uv.
    textures: dict[str, Any] = {
        slot.name: slots.get(slot.name)
        for slot in dataclasses.fields(first)
        if slot.name.endswith("_texture")
    }
    material = dataclasses.replace(
        first,
        base_color=base,
        layers=(),
        normal_scale=1.0,
        normal_space="tangent",
        occlusion_strength=1.0,
        **textures,
    )
    return dataclasses.replace(
        low,
        uv_sets=low.uv_sets[:1],
        colors=None if "color" in maps else low.colors,
        materials=[material],
        images=images,
        face_material=np.zeros(len(low.faces), np.uint32),
    )
