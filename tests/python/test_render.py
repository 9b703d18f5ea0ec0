"""Pictures of scenes against a ray caster in float64, closed forms and the order of layers."""

import doctest
import threading
import time
from dataclasses import replace

import numpy as np
import pytest

import multum as mt
from render_scenes import FACES, SQUARE, UV, WHITE, close, noise, square
from render_truth import Array, bilinear, cast, rays, srgb_to_linear


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


def test_the_camera_that_frames_fills_the_picture() -> None:
    """Tall, wide and flat things reach over 19 of 20 parts of a side, in the middle, and never leave it."""
    rng = np.random.default_rng(2)
    for stretch in ([1, 1, 1], [0.1, 3, 0.1], [5, 0.2, 1], [1, 0, 1], [0.01, 0.01, 4]):
        points = rng.normal(size=(60, 3)) * stretch + rng.normal(size=3) * 10
        scene = mt.Scene(mt.Mesh.build(points, np.arange(60).reshape(20, 3)))
        for size in ((100, 100), (300, 100), (80, 320)):
            clip = scene.camera("auto", size).project(scene.mesh.positions, size)
            assert (np.abs(clip[:, 2]) < clip[:, 3]).all()
            seen = clip[:, :2] / clip[:, 3:]
            np.testing.assert_allclose(seen.max(0) + seen.min(0), 0, atol=1e-3)
            near, far = clip[:, 3].min(), clip[:, 3].max()
            # A stick towards the eye stays off it by a twentieth of its length.
            assert abs(float(np.abs(seen).max()) - 0.95) < 1e-3 or near < 0.0501 * (far - near)
            # From all round, with the one camera that turns.
            camera = scene.camera("auto", size, turning=True)
            for angle in range(0, 360, 23):
                clip = camera.turned(angle, scene.center).project(scene.mesh.positions, size)
                assert (np.abs(clip[:, :3]) < clip[:, 3:]).all()


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


def test_docstrings() -> None:
    finder = doctest.DocTestFinder()
    for item in (mt.render, mt.right_size, mt.Mesh.build, mt.Scene, mt.Camera, mt.light):
        for case in finder.find(item, globs={}):
            assert not doctest.DocTestRunner().run(case).failed
