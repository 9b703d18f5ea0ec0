"""Pictures of scenes against a ray caster in float64, closed forms and the order of layers."""

import doctest
import json
import os
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from render_truth import Array, bilinear, cast, rays, srgb_to_linear

DATA = Path(os.environ.get("MULTUM_DATA", Path(__file__).parents[3] / "shared" / "data"))
SQUARE = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]], np.float32)
FACES = [[0, 3, 2], [0, 2, 1]]
UV = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
WHITE = mt.Material(unlit=True)


def square(**keywords: Any) -> mt.Mesh:
    """A square of side 2 that faces +z."""
    return mt.Mesh.build(SQUARE, FACES, uv=UV, **keywords)


def close(mesh: mt.Mesh, size: tuple[int, int] = (16, 16), **keywords: Any) -> NDArray[np.float32]:
    """Linear colours of a scene that fills the picture: the square's sides are the picture's."""
    camera = mt.Camera((0, 0, 1), fov=90)
    return mt.render(mt.Scene(mesh), camera, size, output="linear", **keywords)


def noise(shape: tuple[int, ...], seed: int = 0) -> NDArray[np.uint8]:
    return np.random.default_rng(seed).integers(0, 256, shape, np.uint8)


def test_textured_scene_is_its_supersampled_truth() -> None:
    """A floor to the distance, a wall and a box, unlit: 16 by 16 rays a pixel."""
    size, eye, target = (64, 48), np.array([0.3, 1.2, 4.0]), np.array([0.0, 0.4, 0.0])
    floor = np.array([[-6, 0, -8], [6, 0, -8], [6, 0, 4], [-6, 0, 4]], np.float32)
    pictures = [noise((32, 32, 3), 1), noise((64, 16, 3), 2)]
    parts = [
        mt.Mesh.build(floor, FACES, uv=UV * [6, 6], material=WHITE, texture=pictures[0]),
        mt.Mesh.build(SQUARE + np.array([0, 1, -2]), FACES, uv=UV * 1.5, material=WHITE, texture=pictures[1]),
    ]
    mesh = mt.Mesh.join(parts)
    corners = mesh.positions[mesh.faces].astype(float)
    assert mesh.uv is not None
    uv = mesh.uv[mesh.faces].astype(float)
    linear = [srgb_to_linear(p / 255.0) for p in pictures]
    truth = np.zeros((size[1], size[0], 4))
    kinds = []
    for i in range(16):
        for j in range(16):
            hits = cast(eye, rays(eye, target, 50, size, ((i + 0.5) / 16, (j + 0.5) / 16)), corners)
            places = hits.blend(uv)
            kind = np.where(hits.face < 0, -1, mesh.face_material[hits.face].astype(int))
            for k, texels in enumerate(linear):
                own = kind == k
                truth[own, :3] += bilinear(texels, places[own])
                truth[own, 3] += 1
            kinds.append(kind)
    truth /= 256
    inner = (np.min(kinds, 0) == np.max(kinds, 0)) & (kinds[0] >= 0)
    assert inner.mean() > 0.5
    scene, camera = mt.Scene(mesh), mt.Camera(eye, target, fov=50)

    def error(filter: str) -> float:
        got = mt.render(scene, camera, size, filter, output="linear")
        np.testing.assert_array_equal(got[inner][:, 3], 1)
        return float(np.sqrt(np.mean((got - truth)[inner] ** 2)))

    # What is left of the exact mean: the footprint is taken for a parallelogram, and 256 rays are not all.
    assert error("exact") < 1 / 255
    # Noise of full contrast is the worst that a texture can be.
    assert error("auto") < 3 / 255
    assert error("auto") < 0.6 * error("anisotropic")
    assert error("auto") < 0.2 * error("trilinear")
    # Edges of faces too, by supersampling: half a sample of 16.
    smooth = mt.render(scene, camera, size, supersample=8, output="linear")
    assert np.abs(smooth - truth).max() < 0.15
    assert np.sqrt(np.mean((smooth - truth) ** 2)) < 0.01


def test_light_is_the_formula() -> None:
    """Point, directional and ambient light on a smooth-shaded tent, in float64 by rays."""
    points = np.array([[-1, 0, 0.5], [0, 1, 0.2], [1, 0, 0.5], [0, -1, 0.2], [0, 0, 1]], np.float32)
    faces = [[4, 1, 0], [4, 2, 1], [4, 3, 2], [4, 0, 3]]
    material = mt.Material(
        base_color=(0.8, 0.5, 0.2, 1), specular=(0.3, 0.2, 0.1), shininess=9, ambient=(0.5, 1, 1)
    )
    mesh = mt.Mesh.build(points, faces, material=material)
    eye, size = np.array([0.4, 0.3, 3.0]), (40, 30)
    lamp, way = np.array([1.0, 1.5, 2.0]), np.array([0.3, -0.2, -1.0])
    scene = mt.Scene(
        mesh,
        lights=[
            mt.light.Point(lamp, (0.5, 0.6, 0.7), falloff=1.5),
            mt.light.Directional(way, 0.3),
            mt.light.Ambient((0.1, 0.2, 0.3)),
        ],
    )
    got = mt.render(scene, mt.Camera(eye), size, output="linear")
    hits = cast(eye, rays(eye, np.zeros(3), 45, size, (0.5, 0.5)), mesh.positions[mesh.faces].astype(float))
    n = hits.blend(mesh.normals[mesh.faces].astype(float))
    n /= np.maximum(np.linalg.norm(n, axis=-1, keepdims=True), 1e-9)
    p = hits.blend(mesh.positions[mesh.faces].astype(float))
    v = (eye - p) / np.linalg.norm(eye - p, axis=-1, keepdims=True)
    kd, ks = np.array([0.8, 0.5, 0.2]), np.array([0.3, 0.2, 0.1])
    expected = kd * [0.5, 1, 1] * [0.1, 0.2, 0.3] + np.zeros_like(p)
    distance = np.linalg.norm(lamp - p, axis=-1, keepdims=True)
    far = -way / np.linalg.norm(way) + np.zeros_like(p)
    for towards, light in (
        ((lamp - p) / distance, np.array([0.5, 0.6, 0.7]) * (1.5 / distance) ** 2),
        (far, np.full(3, 0.3)),
    ):
        facing = np.sum(towards * n, -1, keepdims=True)
        r = 2 * facing * n - towards
        highlight = np.maximum(0, np.sum(v * r, -1, keepdims=True)) ** 9
        expected += light * np.where(facing > 0, kd * facing + ks * highlight, 0)
    shown = (hits.face >= 0) & (got[..., 3] == 1)
    assert shown.sum() > 150
    np.testing.assert_allclose(got[shown][:, :3], expected[shown], atol=2e-5)


def test_layers_are_blended_in_order_of_depth() -> None:
    """Crossing transparent triangles before an opaque wall: sorted by depth at each pixel."""
    rng = np.random.default_rng(3)
    count, size = 60, (24, 16)
    corners = rng.uniform(-2, 2, (count, 3, 3)) * [1, 1, 0.4]
    colors = rng.random((count, 4)).astype(np.float32)
    meshes = [
        mt.Mesh.build(
            c,
            [[0, 1, 2]],
            normals="flat",
            material=replace(WHITE, base_color=tuple(k), alpha_mode="blend", double_sided=True),
        )
        for c, k in zip(corners, colors.tolist(), strict=True)
    ]
    wall = mt.Mesh.build(
        SQUARE * 3 + np.array([0, 0, -0.3]), FACES, material=replace(WHITE, base_color=(0.2, 0.4, 0.6, 0.1))
    )
    camera = mt.Camera((0, 0, 3))
    scene = mt.Scene(mt.Mesh.join([*meshes, wall]))
    got = mt.render(scene, camera, size, output="linear")
    expected = np.zeros((size[1], size[0], 3))
    single = [mt.rasterize(camera.project(m.positions, size), m.faces, size) for m in [*meshes, wall]]
    depth: Array = np.array([f.depth for f in single], float)
    straight = [*(np.array(c, float) for c in colors), np.array([0.2, 0.4, 0.6, 1.0])]
    for y in range(size[1]):
        for x in range(size[0]):
            left = 1.0
            for k in np.argsort(depth[:, y, x], kind="stable"):
                if np.isinf(depth[k, y, x]):
                    break
                expected[y, x] += left * straight[k][3] * straight[k][:3]
                left *= 1 - straight[k][3]
    assert (np.sum(np.isfinite(depth), 0) >= 5).mean() > 0.1
    np.testing.assert_allclose(got[..., :3], expected, atol=1e-5)
    np.testing.assert_allclose(got[..., 3], 1, atol=1e-5)


def test_alpha_modes() -> None:
    texels = np.zeros((1, 4, 4), np.uint8)
    texels[..., :3], texels[0, :, 3] = 255, [0, 100, 200, 255]
    alphas = {}
    for mode in ("opaque", "mask", "blend"):
        material = replace(WHITE, alpha_mode=mode, base_color=(0.5, 0.5, 0.5, 1))
        picture = close(square(material=material, texture=texels), (4, 4), filter="nearest")
        alphas[mode] = picture[1, :, 3]
        np.testing.assert_allclose(picture[1, :, 0], 0.5 * picture[1, :, 3], atol=1e-6)
    np.testing.assert_array_equal(alphas["opaque"], 1)
    np.testing.assert_array_equal(alphas["mask"], [0, 0, 1, 1])
    np.testing.assert_allclose(alphas["blend"], np.array([0, 100, 200, 255]) / 255, atol=1e-6)
    # Alpha of an opaque material does not darken what is filtered.
    texels[0, :, :3] = [[255] * 3, [0] * 3, [255] * 3, [0] * 3]
    flat = close(square(material=WHITE, texture=texels), (1, 1), filter="exact")
    assert abs(float(flat[0, 0, 0]) - 0.5) < 0.01


def test_sides_colours_layers_and_transform() -> None:
    turned = mt.Mesh.build(SQUARE, [f[::-1] for f in FACES], normals=[[0, 0, -1]] * 4)
    lamp = [mt.light.Directional((0, 0, -1))]
    assert not close(turned, lights=lamp).any()
    both = replace(turned, materials=[mt.Material(double_sided=True)])
    np.testing.assert_array_equal(close(both, lights=lamp), 1)
    colors = np.array([[1, 0, 0, 1], [1, 0, 0, 1], [0, 1, 0, 0.5], [0, 1, 0, 0.5]], np.float32)
    painted = close(mt.Mesh.build(SQUARE, FACES, colors=colors, material=replace(WHITE, alpha_mode="blend")))
    # The first row is a 32nd of the way down: colour and alpha, premultiplied.
    np.testing.assert_allclose(painted[0, 0], np.array([31 / 32, 1 / 32, 0, 1]) * (1 - 1 / 64), atol=1e-6)
    # The second texture, over the base colour and over the light.
    texel = np.array([[[255, 0, 0, 51]]], np.uint8)
    grey = mt.light.Directional((0, 0, -1), 0.5)
    expected: dict[tuple[str, bool], list[float]] = {
        ("modulate", False): [0.5, 0, 0], ("modulate", True): [0.5, 0, 0],
        ("decal", False): [0.5, 0.4, 0.4], ("decal", True): [0.6, 0.4, 0.4],
        ("replace", True): [1, 0, 0], ("add", True): [1.5, 0.5, 0.5],
    }  # fmt: skip
    for (blend, after), color in expected.items():
        layer = mt.Layer(mt.TextureSlot(0), blend, after)
        mesh = square(material=mt.Material(layers=(layer,)), images=[texel])
        np.testing.assert_allclose(close(mesh, lights=[grey])[8, 8, :3], color, atol=1e-6)
    # Scale 2 and offset: the slot's matrix, and its footprint.
    slot = mt.TextureSlot(0, transform=np.array([[2, 0, 0.25], [0, 2, 0]], np.float32), encoding="linear")
    ramp = np.arange(64, dtype=np.float32).reshape(8, 8) / 64
    mesh = square(material=replace(WHITE, base_color_texture=slot), images=[ramp])
    uv = (np.stack(np.meshgrid(np.arange(16), np.arange(16)), -1) + 0.5) / 16 * 2 + [0.25, 0]
    np.testing.assert_allclose(
        close(mesh, filter="bilinear")[..., :1], bilinear(ramp[..., None], uv), atol=1e-5
    )
    jacobian = np.eye(2) * 2 / 16
    texture = mt.Texture(ramp, "repeat")
    np.testing.assert_allclose(
        close(mesh, filter="area")[..., :1], texture.sample(uv, jacobian, filter="area"), atol=1e-5
    )


def test_normal_maps() -> None:
    """A plane whose map leans by known angles is lit like the leaning plane; mirrored uv mirror it."""
    lean = np.array([0.6, 0.0, 0.8])
    texel = np.float32((lean + 1) / 2).reshape(1, 1, 3)
    slot = mt.TextureSlot(0, encoding="normal")
    material = mt.Material(normal_texture=slot)
    lamp = np.array([0.48, 0.6, 0.64])
    lights = [mt.light.Directional(-lamp)]
    plain = close(square(material=material, images=[texel]), lights=lights)
    np.testing.assert_allclose(plain[..., 0], lean @ lamp, atol=1e-6)
    mirrored = mt.Mesh.build(SQUARE, FACES, uv=UV * [-1, 1], material=material, images=[texel])
    np.testing.assert_allclose(close(mirrored, lights=lights)[..., 0], lean * [-1, 1, 1] @ lamp, atol=1e-6)
    turned = mt.Mesh.build(SQUARE, FACES, uv=UV[:, ::-1], material=material, images=[texel])
    # u runs down there: x of the map is -y of the scene.
    np.testing.assert_allclose(close(turned, lights=lights)[..., 0], [0, -0.6, 0.8] @ lamp, atol=1e-6)
    up = np.float32((np.array([0, 0.6, 0.8]) + 1) / 2).reshape(1, 1, 3)
    green = close(square(material=material, images=[up]), lights=lights)
    np.testing.assert_allclose(green[..., 0], [0, 0.6, 0.8] @ lamp, atol=1e-6)
    world = close(square(material=replace(material, normal_space="object"), images=[texel]), lights=lights)
    np.testing.assert_allclose(world[..., 0], lean @ lamp, atol=1e-6)
    scaled = np.array([0.3, 0, 0.8]) / np.hypot(0.3, 0.8)
    half = close(square(material=replace(material, normal_scale=0.5), images=[texel]), lights=lights)
    np.testing.assert_allclose(half[..., 0], scaled @ lamp, atol=1e-6)


def test_highlights_keep_their_light_from_afar() -> None:
    """Toksvig: a bumpy mirror seen from afar is as bright, on the whole, as the mean of its close-up."""
    rng = np.random.default_rng(5)
    vectors = np.concatenate([rng.normal(0, 0.12, (128, 128, 2)), np.ones((128, 128, 1))], -1)
    vectors /= np.linalg.norm(vectors, axis=-1, keepdims=True)
    texel = np.float32((vectors + 1) / 2)
    material = mt.Material(
        base_color=(0, 0, 0, 1),
        specular=(1, 1, 1),
        shininess=60,
        normal_texture=mt.TextureSlot(0, encoding="normal"),
    )
    mesh = square(material=material, images=[texel])
    scene = mt.Scene(mesh, lights=[mt.light.Directional((0, 0, -1))])
    camera = mt.Camera((0, 0, 20), fov=2 * np.degrees(np.arctan(1 / 20)))
    fine = mt.render(scene, camera, (256, 256), output="linear", filter="nearest")
    coarse = mt.render(scene, camera, (8, 8), output="linear")
    flat = mt.render(
        mt.Scene(replace(mesh, materials=[replace(material, normal_texture=None)]), lights=scene.lights),
        camera,
        (8, 8),
        output="linear",
    )
    mean, kept, lost = (float(p[..., 0].mean()) for p in (fine, coarse, flat))
    assert abs(kept - mean) < 0.25 * abs(lost - mean)


def test_bump_maps_lean_like_the_surface_they_stand_for() -> None:
    """A height that grows evenly: a leaning plane. A wave: the normals of the wave."""
    u = (np.arange(256) + 0.5) / 256
    lamp = np.array([0.6, 0.0, 0.8])
    lights = [mt.light.Directional(-lamp)]
    slot = mt.TextureSlot(0, encoding="linear")
    scale = 0.05
    wave = np.tile(0.5 + 0.5 * np.sin(2 * np.pi * u), (4, 1)).astype(np.float32)
    mesh = square(material=mt.Material(bump_texture=slot, bump_scale=scale), images=[wave])
    got = close(mesh, (64, 64), lights=lights)[32, :, 0]
    x = (np.arange(64) + 0.5) / 64
    slope = scale * 0.5 * 2 * np.pi * np.cos(2 * np.pi * x) / 2  # u runs over two units of x
    n = np.stack([-slope, np.zeros(64), np.ones(64)], -1) / np.sqrt(1 + slope**2)[:, None]
    np.testing.assert_allclose(got, n @ lamp, atol=2e-3)


def test_emission_occlusion_shininess_and_pbr() -> None:
    one = np.array([[[128, 255, 0]]], np.uint8)
    glow = square(
        material=mt.Material(emissive=(2, 1, 1), emissive_texture=mt.TextureSlot(0, encoding="linear")),
        images=[one],
    )
    np.testing.assert_allclose(close(glow, lights=[])[8, 8, :3], [2 * 128 / 255, 1, 0], atol=1e-6)
    dim = square(
        material=mt.Material(occlusion_texture=mt.TextureSlot(0, encoding="linear"), occlusion_strength=0.5),
        images=[one],
    )
    lights = [mt.light.Ambient(0.4), mt.light.Directional((0, 0, -1), 0.5)]
    expected = 0.4 * (1 + 0.5 * (128 / 255 - 1)) + 0.5
    np.testing.assert_allclose(close(dim, lights=lights)[8, 8, :3], expected, atol=1e-6)
    shiny = mt.Material(specular=(1, 1, 1), shininess=40, base_color=(0, 0, 0, 1))
    textured = replace(shiny, shininess_texture=mt.TextureSlot(0, encoding="linear"))
    lamp = [mt.light.Directional((-0.3, -0.2, -1))]
    half = close(square(material=textured, images=[one]), lights=lamp)
    plain = close(square(material=replace(shiny, shininess=40 * 128 / 255)), lights=lamp)
    np.testing.assert_allclose(half, plain, atol=1e-6)
    rough = mt.Material(model="metallic_roughness", metallic=1, roughness=1)
    metal = close(square(material=rough), lights=[mt.light.Directional((0, 0, -1))])
    assert 0 < float(metal[0, 0, 0]) <= 1.01
    none = close(square(material=mt.Material(shininess=0, specular=(1, 1, 1))), lights=lamp)
    assert none[..., :3].max() < 1


def test_filters_of_the_file_and_their_override() -> None:
    checker = np.indices((8, 8)).sum(0).astype(np.uint8) % 2 * 255
    slot = mt.TextureSlot(0, mag_filter="nearest", min_filter="trilinear", encoding="linear")
    mesh = square(material=replace(WHITE, base_color_texture=slot), images=[checker])
    enlarged, reduced = ((64, 64), (2, 2))
    file = [close(mesh, size, filter="file") for size in (enlarged, reduced)]
    np.testing.assert_array_equal(file[0], close(mesh, enlarged, filter="nearest"))
    np.testing.assert_array_equal(file[1], close(mesh, reduced, filter="trilinear"))
    assert (close(mesh, enlarged, filter="bilinear") != file[0]).any()
    plain = replace(mesh, materials=[replace(WHITE, base_color_texture=mt.TextureSlot(0, encoding="linear"))])
    np.testing.assert_array_equal(close(plain, filter="file"), close(plain, filter="auto"))


def test_same_bytes_for_any_number_of_threads() -> None:
    rng = np.random.default_rng(1)
    count = 200
    points = rng.uniform(-1, 1, (count * 3, 3)).astype(np.float32)
    faces = np.arange(count * 3).reshape(count, 3)
    material = mt.Material(
        double_sided=True,
        alpha_mode="blend",
        base_color=(1, 1, 1, 0.7),
        specular=(0.2, 0.2, 0.2),
        shininess=8,
    )
    mesh = mt.Mesh.build(
        points, faces, uv=rng.uniform(-2, 2, (count * 3, 2)), material=material, texture=noise((32, 32, 4))
    )
    scene = mt.Scene(mt.Mesh.join([mesh, square(texture=noise((64, 64, 3)))]))
    for filter in ("auto", "stochastic"):
        pictures = [
            mt.render(scene, size=(160, 120), filter=filter, threads=n, supersample=2).tobytes()
            for n in (1, 2, 5)
        ]
        assert len(set(pictures)) == 1


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


def test_background_and_outputs() -> None:
    scene, camera = mt.Scene(square(material=WHITE)), mt.Camera((0, 0, 4))
    clear = mt.render(scene, camera, (8, 8), output="linear")
    assert clear.dtype == np.float32
    assert clear.shape == (8, 8, 4)
    assert not clear[0, 0].any()
    codes = mt.render(scene, camera, (8, 8), background=(0.5, 0.2, 0.0, 0.5))
    np.testing.assert_array_equal(codes[0, 0], [188, 124, 0, 128])
    np.testing.assert_array_equal(codes[4, 4], 255)
    assert mt.render(scene, camera, (8, 8), background=0.5)[0, 0].tolist() == [188, 188, 188, 255]


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"size": (0, 4)}, ValueError, "size"),
        ({"size": (10**6, 10**6)}, ValueError, "size: got .*16384"),
        ({"size": (9000, 4), "supersample": 2}, ValueError, "size"),
        ({"size": 5}, TypeError, "size"),
        ({"supersample": 9}, ValueError, "supersample"),
        ({"filter": "best"}, ValueError, "filter"),
        ({"output": "png"}, ValueError, "output"),
        ({"camera": "left"}, ValueError, "camera"),
        ({"camera": 3}, TypeError, "camera"),
        ({"background": "red"}, TypeError, "background"),
        ({"background": (1, 2)}, ValueError, "background"),
        ({"background": np.nan}, ValueError, "background"),
        ({"lights": [mt.light.Ambient(np.nan)]}, ValueError, "lights"),
        ({"lights": [mt.light.Directional((0, 0, 0))]}, ValueError, "lights"),
        ({"lights": [mt.light.Point((0, 0, np.inf))]}, ValueError, "lights"),
        ({"lights": [mt.light.Point((0, 0, 1), falloff=0)]}, ValueError, "lights"),
        ({"lights": [mt.light.Point((0, 0, 1), cone=((0, 0, 1), 40, 20))]}, ValueError, "lights"),
        ({"lights": ["sun"]}, TypeError, "lights"),
        ({"progress": 3}, TypeError, "progress"),
        ({"max_anisotropy": 0.5}, ValueError, "max_anisotropy"),
        ({"scene": 3}, TypeError, "scene"),
    ],
)  # fmt: skip
def test_bad_arguments_are_named(change: dict[str, Any], error: type[Exception], words: str) -> None:
    arguments: dict[str, Any] = {"scene": mt.Scene(square()), "size": (8, 8), **change}
    with pytest.raises(error, match=words):
        mt.render(**arguments)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"base_color": (1, 1, 1)}, "base_color"),
        ({"model": "toon"}, "model"),
        ({"alpha_mode": "add"}, "alpha_mode"),
        ({"normal_space": "world"}, "normal_space"),
        ({"base_color_texture": mt.TextureSlot(7)}, "image 7"),
        ({"base_color_texture": 3}, "TextureSlot"),
        ({"layers": (mt.Layer(mt.TextureSlot(0), "xor"),)}, "blend"),
        ({"base_color_texture": mt.TextureSlot(0, transform=np.zeros((3, 3), np.float32))}, "transform"),
        ({"base_color_texture": mt.TextureSlot(0, wrap=("twist", "clamp"))}, "wrap"),
        ({"base_color_texture": mt.TextureSlot(0, mag_filter="best")}, "mag_filter"),
    ],
)
def test_bad_materials_are_named(change: dict[str, Any], words: str) -> None:
    mesh = square(images=[np.zeros((1, 1), np.uint8)])
    bad = replace(mesh, materials=[replace(mt.Material(), **change)])
    with pytest.raises((ValueError, TypeError), match=words):
        mt.render(mt.Scene(bad), size=(8, 8))


def test_numbers_that_are_not_finite_do_no_harm() -> None:
    """Odd materials, normals and uv give a picture or an error that names them, never a crash."""
    for value in (np.nan, np.inf, 1e38, -1e38):
        mesh = square(texture=noise((4, 4, 3)), material=mt.Material(shininess=value, specular=(value, 1, 1)))
        odd = replace(mesh, uv_sets=[np.full_like(UV, value)], normals=np.full((4, 3), value, np.float32))
        assert mt.render(mt.Scene(odd), size=(8, 8)).shape == (8, 8, 4)
        broken = replace(mesh, positions=np.full((4, 3), value, np.float32))
        if np.isfinite(value):
            mt.render(mt.Scene(broken), mt.Camera((0, 0, 3)), (8, 8))
        else:
            with pytest.raises(ValueError, match="positions"):
                mt.render(mt.Scene(broken), mt.Camera((0, 0, 3)), (8, 8))


def test_progress_and_stopping() -> None:
    shares: list[float] = []
    mt.render(mt.Scene(square()), size=(64, 64), progress=shares.append)
    assert shares[0] == 0
    assert shares[-1] == 1
    assert shares == sorted(shares)

    def stop(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mt.render(mt.Scene(square()), size=(64, 64), progress=stop)


def test_other_threads_run_while_a_picture_is_drawn() -> None:
    ticks = []
    done = threading.Event()

    def count() -> None:
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    start = time.monotonic()
    mt.render(mt.Scene(square(texture=noise((64, 64, 3)))), size=(1024, 1024), threads=1, filter="ewa")
    end = time.monotonic()
    done.set()
    thread.join()
    assert sum(start < t < end for t in ticks) >= 2


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


def test_docstrings() -> None:
    finder = doctest.DocTestFinder()
    for item in (mt.render, mt.right_size, mt.Mesh.build, mt.Scene, mt.Camera, mt.light):
        for case in finder.find(item, globs={}):
            assert not doctest.DocTestRunner().run(case).failed
