"""What a texture can be: a scene for each row of the table, with and without it where that tells more."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import multum as mt
from multum.demo.figure import colour
from multum.demo.pictures import photograph

from .shapes import LIGHTS, ball, bumps, fields, floor, grey, label, normals_of, puff, sky, square, tree

Codes = NDArray[np.uint8]
SLOT = mt.TextureSlot(0)
DATA = mt.TextureSlot(0, encoding="linear")
GLOSS = {"specular": (0.5, 0.5, 0.5), "shininess": 40.0}
CAMERA = mt.Camera((1.2, 0.9, 3.4), fov=38)


@dataclass(frozen=True)
class Row:
    """One row of the table."""

    title: str
    text: str
    draw: Callable[[int], Codes]


def seen(scene: mt.Scene, side: int, camera: mt.Camera = CAMERA, **keywords: Any) -> Codes:
    """A picture on white paper."""
    keywords = {"supersample": 2, "background": 1.0, **keywords}
    return mt.render(scene, camera, (side, side), **keywords)[..., :3]


def lit(mesh: mt.Mesh, side: int, **keywords: Any) -> Codes:
    """A mesh under the lamp."""
    return seen(mt.Scene(mesh, lights=LIGHTS), side, **keywords)


def bricks() -> Codes:
    """Bricks in colour."""
    return (colour(photograph("brick")) * np.array([1.0, 0.62, 0.5])).astype(np.uint8)


def on_ball(material: mt.Material, image: Any, side: int, **keywords: Any) -> Codes:
    """A ball with one texture."""
    return lit(ball(material=material, images=[image], **keywords), side)


def shadows(side: int) -> Codes:
    """A ball and a cut-out above tiles."""
    pale = (200 + 0.2 * grey("gravel")).astype(np.uint8)
    lamps = [mt.light.Directional((0.45, -0.7, -0.6), 0.8), mt.light.Ambient(0.25)]
    scene = mt.Scene(floor(texture=colour(pale)), lights=lamps)
    scene.add(
        ball(24).moved(np.diag([0.6, 0.6, 0.6, 1])),
        np.array([[1.0, 0, 0, 0.7], [0, 1, 0, 0], [0, 0, 1, -0.4], [0, 0, 0, 1]]),
    )
    cut = mt.Material(base_color_texture=SLOT, alpha_mode="mask", double_sided=True)
    scene.add(square((-0.7, -0.2, 0.6), 0.8, material=cut, images=[tree()]))
    return seen(scene, side, mt.Camera((2.4, 2.4, 4.6), (0.1, -0.5, 0), fov=38), shadows=1024)


def clouds(side: int) -> Codes:
    """Billboards in no order, one behind the other."""
    material = mt.Material(unlit=True, alpha_texture=DATA, alpha_mode="blend")
    parts = [
        square((x, y, z), s, material=material, images=[puff(k)])
        for k, (x, y, z, s) in enumerate([(-0.5, 0.3, 0, 1.1), (0.6, 0.0, -1, 1.5), (0.1, -0.35, 0.6, 0.9)])
    ]
    blue = mt.Material(unlit=True, base_color=(0.1, 0.3, 0.7, 1))
    return seen(mt.Scene(mt.Mesh.join([*parts, square((0, 0, -2), 5, material=blue)])), side)


def trees(side: int) -> Codes:
    """Cut-outs with colour and alpha on a meadow."""
    green = mt.Material(unlit=True, base_color=(0.25, 0.45, 0.12, 1))
    material = mt.Material(unlit=True, base_color_texture=SLOT, alpha_mode="blend", double_sided=True)
    scene = mt.Scene(floor(8, material=green))
    for x, z in [(-0.9, 0), (0.8, -0.8), (0.1, -2), (-2.2, -3), (1.9, 0.6)]:
        scene.add(square((x, 0, z), material=material, images=[tree()]))
    return seen(scene, side, mt.Camera((1.2, 1.2, 5.4), (0, -0.2, 0), fov=42), background=(0.6, 0.8, 1))


def sticker(side: int) -> Codes:
    """A label on bricks: its alpha decides, the surface stays opaque."""
    # Three times smaller than a tile, around a place on the side that is seen; nothing beyond its border.
    times, u, v = 3.0, 1.12, 0.42
    window = np.array([[times, 0, 0.5 - times * u], [0, times, 0.5 - times * v]], np.float32)
    slot = mt.TextureSlot(1, transform=window, wrap=("border", "border"))
    material = mt.Material(base_color_texture=SLOT, layers=(mt.Layer(slot, "decal"),))
    return lit(ball(material=material, images=[bricks(), label()]), side)


def light_map(side: int) -> Codes:
    """Bricks times the light of two lamps, kept in a small texture of its own uv set."""
    x = (np.arange(32) + 0.5) / 32
    pools = sum(
        np.exp(-((x[None] - a) ** 2 + (x[:, None] - b) ** 2) / 0.03) for a, b in [(0.3, 0.3), (0.7, 0.65)]
    )
    lamps = (np.clip(0.12 + 0.88 * np.asarray(pools), 0, 1)[..., None] * [255, 235, 190]).astype(np.uint8)
    material = mt.Material(
        unlit=True, base_color_texture=SLOT, layers=(mt.Layer(mt.TextureSlot(1, 1, encoding="linear")),)
    )
    wall = square(tiles=2, material=material, images=[bricks(), lamps])
    wall = replace(wall, uv_sets=[*wall.uv_sets, wall.uv_sets[0] / 2])
    return seen(mt.Scene(wall), side, mt.Camera((0.9, 0.3, 2.6), fov=42))


def metals(side: int) -> Codes:
    """Gold under a sky that it mirrors."""
    gold = mt.Material(model="metallic_roughness", base_color=(1, 0.76, 0.34, 1), metallic=1, roughness=0.1)
    environment = mt.Environment(sky(), rotation=30)
    scene = mt.Scene(ball(96, material=gold), lights=[])
    return seen(scene, side, environment=environment, background="environment")


def displaced(side: int) -> Codes:
    """Vertices moved by the studs: the outline shows them."""
    material = mt.Material(
        base_color=(0.75, 0.6, 0.45, 1), displacement_texture=DATA, displacement_scale=0.12, **GLOSS
    )
    return on_ball(material, bumps(), side, rows=64)


CLAY: dict[str, Any] = {"base_color": (0.75, 0.6, 0.45, 1), **GLOSS}
ROWS = {
    "replace": Row("RGB to the screen", "replace: no light", lambda n: on_ball(
        mt.Material(unlit=True, base_color_texture=SLOT), bricks(), n)),
    "modulate": Row("RGB times the lit colour", "modulate", lambda n: on_ball(
        mt.Material(base_color=(0.9, 0.9, 0.9, 1), **GLOSS, layers=(mt.Layer(SLOT, after_light=True),)),
        bricks(), n)),
    "kd": Row("RGB as kd", "highlights stay white", lambda n: on_ball(
        mt.Material(base_color_texture=SLOT, **GLOSS), bricks(), n)),
    "intensity": Row("intensity scales kd", "one channel", lambda n: on_ball(
        mt.Material(base_color=(0.2, 0.55, 0.9, 1), base_color_texture=DATA, **GLOSS), grey("gravel"), n)),
    "alpha": Row("alpha of the surface", "billboards", clouds),
    "rgba": Row("RGBA: kd and alpha", "trees", trees),
    "decal": Row("decal", "by the texture's alpha", sticker),
    "light_map": Row("several, multiplied", "light map", light_map),
    "shininess": Row("intensity as shininess", "p = 5 and p = 120", lambda n: on_ball(
        mt.Material(base_color=(0.15, 0.2, 0.3, 1), specular=(0.8, 0.8, 0.8), shininess=120,
                    shininess_texture=DATA), fields(10, 255), n)),
    "bump": Row("height: bump map", "normals lean, outline stays", lambda n: on_ball(
        mt.Material(bump_texture=DATA, bump_scale=0.12, **CLAY), bumps(), n)),
    "normal": Row("vectors: normal map", "the same studs", lambda n: on_ball(
        mt.Material(normal_texture=mt.TextureSlot(0, encoding="normal"), **CLAY), normals_of(bumps(), 0.04), n)),
    "displacement": Row("height: displacement", "the outline too", displaced),
    "environment": Row("environment", "mirrored by gold", metals),
    "shadow": Row("depth: shadows", "alpha counts", shadows),
}  # fmt: skip
