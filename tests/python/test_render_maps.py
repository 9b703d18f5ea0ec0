"""Normal and bump maps against the surfaces that they stand for. ``pytest -s`` shows the figures."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from render_scenes import DATA, FACES, SQUARE, UV, close, square


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


@pytest.mark.parametrize("spread", [0.05, 0.12, 0.25])
@pytest.mark.parametrize("shininess", [10.0, 60.0, 250.0])
def test_roughness_is_kept_through_the_pyramid(spread: float, shininess: float) -> None:
    """Toksvig: 16 by 16 normals below a pixel shine like the mean of 256 highlights, at every angle of the light.

    The truth is that mean in float64. A Gaussian spread of normals, which the formula stands for, leaves a few
    hundredths of the error that a renormalised normal makes.
    """
    side, texels = 8, 16
    rng = np.random.default_rng(5)
    n = np.concatenate(
        [
            rng.normal(0, spread, (side * texels, side * texels, 2)),
            np.ones((side * texels, side * texels, 1)),
        ],
        -1,
    )
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    slot = mt.TextureSlot(0, encoding="normal")
    material = mt.Material(
        base_color=(0, 0, 0, 1), specular=(1, 1, 1), shininess=shininess, normal_texture=slot
    )
    scene = mt.Scene(square(material=material, images=[np.float32((n + 1) / 2)]))
    # So far away that the square is seen along -z all over.
    camera = mt.Camera((0, 0, 1e4), fov=2 * np.degrees(np.arctan(1e-4)), near=9e3)
    means = n.reshape(side, texels, side, texels, 3).mean((1, 3))
    means /= np.linalg.norm(means, axis=-1, keepdims=True)
    # y of the map runs up the picture as it does in the scene: the map's axes are the scene's.
    own, truth, lost = [], [], []
    for angle in np.radians(np.arange(0, 61, 6)):
        light = np.array([np.sin(angle), 0, np.cos(angle)])

        def highlight(normal: NDArray[np.float64], light: NDArray[np.float64] = light) -> NDArray[np.float64]:
            facing = normal @ light
            cosine = 2 * facing * normal[..., 2] - light[2]
            return np.asarray(np.where(facing > 0, np.maximum(cosine, 0) ** shininess, 0))

        lamp = [mt.light.Directional(-light)]
        own.append(
            mt.render(scene, camera, (side, side), lights=lamp, output="linear", filter="area")[..., 0]
        )
        truth.append(highlight(n).reshape(side, texels, side, texels).mean((1, 3)))
        lost.append(highlight(means))

    def error(pictures: list[NDArray[Any]]) -> float:
        return float(np.sqrt(np.mean((np.array(pictures) - truth) ** 2)))

    print(f"spread {spread}, p {shininess}: error {error(own):.4f}, without {error(lost):.4f}")
    assert error(own) < 0.1 * error(lost)
    # Light is neither made nor lost: summed over the angles.
    assert abs(np.sum(own) / np.sum(truth) - 1) < 0.1


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


def test_a_normal_map_stands_for_the_real_surface() -> None:
    """The asteroid of 480 faces with its map against that of 48,000, from all round."""
    folder = DATA / "obj" / "asteroid"
    if not folder.exists():
        pytest.skip(f"no {folder}")
    high, low = (mt.Mesh.open(folder / f"asteroid-{n}.obj", normals="smooth") for n in ("high", "low"))
    slot = mt.TextureSlot(0, encoding="normal")

    def low_with(picture: str, **keywords: Any) -> mt.Mesh:
        material = mt.Material(normal_texture=slot, **keywords)
        images = [mt.MeshImage("map", folder / picture)]
        return replace(low, images=images, materials=[material for _ in low.materials])

    meshes = {
        "no map": replace(low, materials=[mt.Material() for _ in low.materials]),
        "tangent space": low_with("asteroid-normal-map-tangent.png"),
        "object space": low_with("asteroid-normal-map.png", normal_space="object"),
    }
    high = replace(high, materials=[mt.Material() for _ in high.materials])
    camera, size = mt.Scene(high).camera("auto"), (256, 256)
    lights = [mt.light.Directional((0.5, -0.6, -1))]
    squares: dict[str, list[float]] = {name: [] for name in meshes}
    for angle in range(0, 360, 60):
        turned = camera.turned(angle)
        real = mt.render(mt.Scene(high, lights=lights), turned, size, output="linear")
        for name, mesh in meshes.items():
            own = mt.render(mt.Scene(mesh, lights=lights), turned, size, output="linear")
            both = (real[..., 3] == 1) & (own[..., 3] == 1)
            squares[name].append(float(np.mean((own - real)[both][:, 0] ** 2)))
    errors = {name: np.sqrt(np.mean(values)) for name, values in squares.items()}
    print(", ".join(f"{name} {error:.4f}" for name, error in errors.items()))
    assert errors["tangent space"] < 0.5 * errors["no map"]
    assert errors["object space"] < 0.5 * errors["no map"]
