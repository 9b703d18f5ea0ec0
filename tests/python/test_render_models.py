"""Scenes of files and of parts, and what textures see in them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import multum as mt
from render_scenes import DATA, FACES, SQUARE, UV, WHITE, noise, square
from render_truth import srgb_to_linear


def test_debug_views() -> None:
    mesh = square(texture=noise((64, 64, 3)))
    views = {d: mt.render(mt.Scene(mesh), mt.Camera((0, 0, 1), fov=90), (16, 16), debug=d) for d in
             ("uv", "footprint", "lod", "normals", "checker")}  # fmt: skip
    np.testing.assert_allclose(views["uv"][0, :, 0], (np.arange(16) + 0.5) / 16 * 255, atol=0.51)
    np.testing.assert_allclose(views["uv"][:, 0, 1], (np.arange(16) + 0.5) / 16 * 255, atol=0.51)
    assert (views["footprint"][..., :3] == [0, 0, 255]).all()  # square footprints
    assert (views["normals"][..., :3] == [128, 128, 255]).all()
    # Four texels a pixel: level 2 of 6, between cyan and green.
    np.testing.assert_allclose(views["lod"][8, 8, :3], [0, 255, 2 / 3 * 255], atol=1)
    # Two by two fields a pixel: the mean of light.
    assert abs(srgb_to_linear(np.array(views["checker"][8, 8, 0] / 255.0)) - 0.5) < 0.01
    with pytest.raises(ValueError, match="debug"):
        mt.render(mt.Scene(mesh), debug="heat")


def test_right_size() -> None:
    mesh = square(texture=noise((256, 128, 3)))
    half = replace(mesh, uv_sets=[UV * np.array([0.5, 1], np.float32)])
    use = mt.right_size(mt.Scene(half), mt.Camera((0, 0, 1), fov=90), (64, 64))[0]
    # du/dx = 0.5/64: one texel of 128; dv/dy = 1/64: four texels of 256.
    assert (use.size, use.reads) == ((128, 256), 64 * 64)
    assert use.histogram == [0, 0, 0, 64 * 64]
    assert use.recommended == (32, 64)
    assert abs(use.touched - 0.5) < 0.02
    assert mt.right_size(mt.Scene(mesh), mt.Camera((0, 0, -5), (0, 0, -9)), (64, 64)) == []


def test_unseen_textures_are_not_read() -> None:
    mesh = square(
        material=mt.Material(base_color_texture=mt.TextureSlot(0)),
        images=[mt.MeshImage("gone", Path("/nowhere/x.png"))],
    )
    away = mt.Camera((0, 0, -5), (0, 0, -9))
    assert not mt.render(mt.Scene(mesh), away, (8, 8)).any()
    with pytest.raises(OSError, match=r"x\.png"):
        mt.render(mt.Scene(mesh), size=(8, 8))
    # Other pictures are other textures.
    scene = mt.Scene(square(material=WHITE, texture=np.zeros((1, 1, 3), np.uint8)))
    assert mt.render(scene, size=(8, 8))[4, 4, 0] == 0
    scene.mesh = square(material=WHITE, texture=np.full((1, 1, 3), 255, np.uint8))
    assert mt.render(scene, size=(8, 8))[4, 4, 0] == 255


def test_meshes_join_and_move() -> None:
    one = square(texture=noise((2, 2, 3)))
    two = mt.Mesh.build(SQUARE, FACES, colors=np.full((4, 4), 0.5))
    mirror = np.diag([-1.0, 1, 1, 1])
    mirror[2, 3] = 0.5
    scene = mt.Scene(one)
    scene.add(two, mirror)
    mesh = scene.mesh
    assert (len(mesh.positions), len(mesh.faces), len(mesh.materials), len(mesh.images)) == (8, 4, 2, 1)
    assert mesh.colors is not None
    np.testing.assert_array_equal(mesh.colors[:4], 1)
    np.testing.assert_allclose(mesh.positions[4:, 2], 0.5)
    np.testing.assert_allclose(mesh.normals[4:], [[0, 0, 1]] * 4, atol=1e-6)
    # The mirrored square still shows its front.
    lit = mt.render(
        scene, mt.Camera((0, 0, 3)), (8, 8), lights=[mt.light.Directional((0, 0, -1))], output="linear"
    )
    np.testing.assert_allclose(lit[4, 4], [0.5, 0.5, 0.5, 1], atol=1e-6)
    np.testing.assert_allclose(scene.center, [0, 0, 0.25])
    with pytest.raises(ValueError, match="meshes"):
        mt.Mesh.join([])
    with pytest.raises(ValueError, match="matrix"):
        one.moved(np.eye(2))
    for bad in (
        {"faces": [[0, 1, 9]]},
        {"uv": np.zeros((3, 2))},
        {"normals": np.zeros((3, 3))},
        {"colors": np.zeros((2, 4))},
    ):
        with pytest.raises(ValueError, match=next(iter(bad))):
            mt.Mesh.build(**{"positions": SQUARE, "faces": FACES, **bad})  # type: ignore[arg-type]


def test_lights_of_a_file(tmp_path: Path) -> None:
    """Blender's lamps: watts as lumen at 683 to the watt."""
    light = {"type": "directional", "intensity": 683 * np.pi * 0.5, "color": [1, 0.5, 0.25]}
    spot = {"type": "spot", "intensity": 683 * np.pi, "spot": {"outerConeAngle": 0.5}}
    gltf = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [light, spot]}},
        "nodes": [
            {"extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"translation": [1, 2, 3], "extensions": {"KHR_lights_punctual": {"light": 1}}},
        ],
        "scenes": [{"nodes": [0, 1]}],
    }
    path = tmp_path / "lamps.gltf"
    path.write_text(json.dumps(gltf))
    lights = mt.Scene.open(path).lights
    assert lights is not None
    sun, lamp = lights
    assert isinstance(sun, mt.light.Directional)
    assert isinstance(lamp, mt.light.Point)
    np.testing.assert_allclose(np.asarray(sun.direction), [0, 0, -1])
    np.testing.assert_allclose(np.asarray(sun.color), [0.5, 0.25, 0.125], rtol=1e-5)
    np.testing.assert_allclose(np.asarray(lamp.position), [1, 2, 3])
    assert lamp.falloff == 1
    assert lamp.cone is not None
    np.testing.assert_allclose(lamp.cone[2], np.degrees(0.5), rtol=1e-5)


def test_real_models_are_drawn() -> None:
    if not DATA.is_dir():
        print("the real models are absent: set MULTUM_DATA to their folder")
        return
    scene = mt.Scene.open(DATA / "gltf/BoxTextured/BoxTextured.gltf")
    picture = mt.render(scene, camera="auto", size=(64, 48), filter="trilinear")
    assert picture.shape == (48, 64, 4)
    assert picture[24, 24, 3] == 255
    for path in ("gltf/FlightHelmet/FlightHelmet.gltf", "gltf/Fox.glb", "obj/fuze/fuze.obj",
                 "gltf/SheenChair/MixedLightingExample.gltf", "gltf/AlphaBlendModeTest.glb"):  # fmt: skip
        picture = mt.render(mt.Scene.open(DATA / path), size=(96, 64))
        shown = picture[picture[..., 3] == 255]
        assert 0.03 < len(shown) / (96 * 64) < 0.9, path
        assert shown[:, :3].std() > 10, path
