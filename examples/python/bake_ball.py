"""From a detailed mesh to a simple one with maps, and the picture of it in docs/bake.md.

python examples/python/bake_ball.py [OUT.png]
"""

import math
import sys
from dataclasses import replace

import numpy as np

import multum as mt


def pebble(rings: int) -> mt.Mesh:
    """A closed bumpy ball of about 4 rings^2 faces."""
    v, u = np.meshgrid(
        np.linspace(0, math.pi, rings + 1), np.arange(2 * rings) * math.pi / rings, indexing="ij"
    )
    soft = np.sin(v) ** 2
    r = 1 + 0.1 * np.cos(2 * u) * soft + 0.02 * np.sin(11 * u) * soft * np.sin(9 * v)
    r += 0.008 * np.sin(31 * u + 5 * np.cos(4 * v)) * soft * np.cos(27 * v)
    points = np.stack([np.sin(v) * np.cos(u), np.cos(v), -np.sin(v) * np.sin(u)], -1) * r[..., None]
    i, j = np.meshgrid(np.arange(rings), np.arange(2 * rings), indexing="ij")
    a, b = i * 2 * rings + j, i * 2 * rings + (j + 1) % (2 * rings)
    c, d = a + 2 * rings, b + 2 * rings
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, c, d), (a, d, b))])
    # The first and the last row are the poles, one vertex each.
    faces = np.where(faces < 2 * rings, 0, np.minimum(faces, 2 * rings * rings))
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    return mt.Mesh.build(points.reshape(-1, 3), faces)


high = pebble(110)
low = high.simplify(0.01).unwrap(512)
normals = mt.bake.normal_map(high, low, 512)

slot = mt.TextureSlot(0, encoding="normal", wrap=("clamp", "clamp"))
dressed = replace(
    low,
    materials=[mt.Material(normal_texture=slot)],
    images=[mt.MeshImage("normal", pixels=np.asarray(normals))],
)

camera = mt.Camera((0.6, 0.9, 3.2), fov=42)
lights = [mt.light.Directional((-0.7, -0.5, -0.6), (0.75, 0.75, 0.75)), mt.light.Ambient(0.05)]


def picture(mesh: mt.Mesh) -> np.ndarray:
    """The mesh on white."""
    scene = mt.Scene(mesh)
    return mt.render(scene, camera, (176, 176), lights=lights, background=1.0, supersample=2)[..., :3]


def row(*pictures: np.ndarray) -> np.ndarray:
    """Pictures side by side."""
    return np.concatenate(pictures, axis=1)


half = mt.resize(np.asarray(normals), (176, 176), encoding="normal")
top = row(picture(high), picture(low), picture(dressed))
bottom = row(half, mt.unwrap.heat_map(low, 176), mt.unwrap.checkerboard(low, 176, cells=40))
sheet = np.concatenate([top, bottom])
mt.write_image(sys.argv[1] if len(sys.argv) > 1 else "bake.png", sheet)
print(f"{len(high.faces)} faces, then {len(low.faces)}; {normals.report.covered} texels covered")
