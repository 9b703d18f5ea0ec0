"""Environments, shadows and displacement against closed forms."""

import doctest
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from multum.cli import main

Array = NDArray[np.float64]
SQUARE = [[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]
FACES = [[0, 3, 2], [0, 2, 1]]
UV = [[0, 0], [1, 0], [1, 1], [0, 1]]
MIRROR = mt.Material(model="metallic_roughness", metallic=1.0, roughness=0.0)


def directions(rows: int) -> Array:
    """Of the texels of a lat-long picture, in the scene's axes."""
    u, v = (np.arange(2 * rows) + 0.5) / (2 * rows), (np.arange(rows) + 0.5) / rows
    phi, theta = (u[None] - 0.5) * 2 * np.pi, v[:, None] * np.pi
    return np.stack([np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi, -np.sin(theta) * np.cos(phi)], -1)


def ball(rows: int = 40, **keywords: Any) -> mt.Mesh:
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, 2 * rows + 1))
    n = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], -1)
    first = (np.arange(2 * rows)[:, None] * (rows + 1) + np.arange(rows)).reshape(-1, 1)
    faces = np.concatenate([first + np.array(k) for k in ([0, 1, rows + 2], [0, rows + 2, rows + 1])])
    points = n.reshape(-1, 3)
    return mt.Mesh.build(points, faces, normals=points, **keywords)


def test_a_mirror_shows_the_reflected_direction() -> None:
    d = directions(64)
    sky = mt.Environment((0.5 + 0.5 * d).astype(np.float32))
    camera = mt.Camera((0, 0, 4), fov=40)
    size = (48, 48)
    scene = mt.Scene(ball(120, material=MIRROR), lights=[])
    picture = mt.render(scene, camera, size, environment=sky, output="linear")
    # The ball's own equation, pixel by pixel, in doubles.
    x = ((np.arange(48) + 0.5) / 24 - 1) * np.tan(np.radians(20))
    ray = np.stack(np.broadcast_arrays(x[None, :], -x[:, None], -1.0), -1)
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    b = 4 * ray[..., 2]
    root = b * b - 15
    seen = root > 0.5  # well inside the rim: 1 in the middle, 0 at the rim
    t = -b - np.sqrt(np.where(seen, root, 0))
    n = np.array([0, 0, 4]) + t[..., None] * ray
    r = ray - 2 * (ray * n).sum(-1, keepdims=True) * n
    # Facets lean by at most half their angle, and their reflection by as much again: pi/120/2 each way;
    # the exponent of a roughness of 0 (0.01 wide) averages what is smooth.
    assert seen.sum() > 150
    np.testing.assert_allclose(picture[seen, :3], 0.5 + 0.5 * r[seen], atol=0.02)


@pytest.mark.parametrize("form", ["equirect", "cube", "probe", "mirror_ball"])
def test_every_form_holds_the_same_light(form: str) -> None:
    d = directions(128)
    light = np.clip(0.5 + 0.3 * d[..., :1] + 0.2 * d[..., 1:2] * d[..., 2:], 0, 1).astype(np.float32)
    picture = light
    if form != "equirect":
        picture = mt.panorama.convert(light, "equirect", form, size=128 if form == "cube" else 256)
    sky = mt.Environment(picture, form)
    way = np.random.default_rng(1).normal(size=(200, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    # Away from the rim of the discs, where a texel covers ever more.
    way = way[np.abs(way[:, 2]) < 0.9]
    exact = 0.5 + 0.3 * way[:, 0] + 0.2 * way[:, 1] * way[:, 2]
    np.testing.assert_allclose(sky.radiance(way)[:, 0], exact, atol=0.01)
    # E/pi of the harmonics: the linear part times 2/3, the quadratic one times 1/4.
    diffuse = 0.5 + 0.2 * way[:, 0] + 0.05 * way[:, 1] * way[:, 2]
    np.testing.assert_allclose(sky.diffuse(way)[:, 0], diffuse, atol=0.01)


def test_a_turned_environment_is_the_turned_direction() -> None:
    picture = (0.5 + 0.5 * directions(64)).astype(np.float32)
    turned = mt.Environment(picture, rotation=90).radiance([[0, 0, -1]])
    # Turned counter-clockwise from above, what was at +x is at -z.
    np.testing.assert_allclose(turned, mt.Environment(picture).radiance([[1, 0, 0]]), atol=1e-3)


def test_shadows_are_where_rays_to_the_light_are_blocked() -> None:
    ground = mt.Mesh.build(np.array(SQUARE) * 2, FACES)
    scene = mt.Scene(ground, lights=[mt.light.Directional((1, 0, -1))])
    blocker = np.array(SQUARE) * 0.25 + [-1.0, 0, 1.0]
    scene.add(mt.Mesh.build(blocker, FACES))
    camera = mt.Camera((0, 0, 4), fov=2 * np.degrees(np.arctan(0.25)))
    size = (64, 64)
    clear = mt.render(scene, camera, size, output="linear")[..., 0]
    dark = mt.render(scene, camera, size, output="linear", shadows=1024)[..., 0]
    # The light goes one down for one to the right: the blocker at x - 1 lands at x.
    x = (np.arange(64) + 0.5) / 32 - 1
    inside = np.maximum(np.abs(x[None, :]), np.abs(x[:, None]))
    # Soft for less than a pixel and two texels of some 1/200 each: 0.05 at the most.
    assert np.all(dark[inside < 0.2] == 0)
    np.testing.assert_array_equal(dark[inside > 0.3], clear[inside > 0.3])
    # What is dark has the blocker's area, to the smoothness of a pixel.
    lost = (1 - dark / clear).sum() / 32**2
    assert abs(lost - 0.25) < 0.01


def test_lamps_cast_shadows_to_all_sides_and_masks_by_their_alpha() -> None:
    holes = np.full((2, 2, 4), 255, np.uint8)
    holes[:, 1, 3] = 0
    slot = mt.TextureSlot(0, mag_filter="nearest")
    mask = mt.Material(alpha_mode="mask", base_color_texture=slot, double_sided=True)
    ground = mt.Mesh.build(np.array(SQUARE) * 4, FACES)
    scene = mt.Scene(ground, lights=[mt.light.Point((0, 0, 2))])
    scene.add(mt.Mesh.build(np.array(SQUARE) * 0.5 + [0, 0, 1], FACES, uv=UV, material=mask, images=[holes]))
    camera = mt.Camera((0, -0.01, 12), fov=40)
    picture = mt.render(scene, camera, (65, 65), "nearest", output="linear", shadows=512)[..., 0]
    # The lamp doubles the mask: the left half, |y| < 1 and -1 < x < 0, is dark; the right half is lit.
    pixel = 12 * np.tan(np.radians(20)) / 32.5
    places = np.array([[-0.75, 0.7], [0.75, 0.7], [-1.4, 0]])
    at = np.round(32 + places * [1, -1] / pixel).astype(int)
    dark, through, beside = picture[at[:, 1], at[:, 0]]
    assert dark == 0
    assert through > 0.5
    assert beside > 0.5


def test_displacement_moves_to_the_surface_that_it_stands_for() -> None:
    n = 64
    x = (np.arange(n) + 0.5) / n
    heights = np.broadcast_to(np.sin(np.pi * x), (n, n)).astype(np.float32).copy()
    material = mt.Material(
        displacement_texture=mt.TextureSlot(0, wrap=("clamp", "clamp"), encoding="linear"),
        displacement_scale=0.5,
    )
    mesh = mt.Mesh.build(SQUARE, FACES, uv=UV, material=material, images=[heights])
    scene = mt.Scene(mesh, lights=[mt.light.Directional((0, 0, -1))])
    camera = mt.Camera((0, 0, 8), fov=20)
    picture = mt.render(scene, camera, (128, 128), output="linear", displacement_edge=2.0)[64, :, 0]
    flat = mt.render(scene, camera, (128, 128), output="linear", displacement_edge=1e6)[64, :, 0]
    # Four corners with means of the map for heights, each right to a step of 8 bits (rms), three at most, times
    # 0.5: over sides of 2 that is a slope of 3/255 / 2 each way, and 1 - cos of both is below 4e-5.
    np.testing.assert_allclose(flat[flat > 0], 1.0, atol=4e-5)
    # z = sin(pi (x + 1)/2)/2: a head-on light shows 1/sqrt(1 + z'^2).
    edge = 8 * np.tan(np.radians(10))
    ray = ((np.arange(128) + 0.5) / 64 - 1) * edge / 8
    place = ray * 8
    for _ in range(30):
        place = ray * (8 - 0.5 * np.sin(np.pi * (place + 1) / 2))
    slope = np.pi / 4 * np.cos(np.pi * (place + 1) / 2)
    inside = np.abs(place) < 0.9
    # Facets two pixels wide of a curve: the second derivative (1.2) times a facet (0.05).
    np.testing.assert_allclose(picture[inside], 1 / np.sqrt(1 + slope[inside] ** 2), atol=0.03)


def test_bumped_normals_are_those_of_the_moved_surface() -> None:
    # A cylinder of radius 2 moved outwards by d = 0.3 sin(3 u): its normal by differences, in doubles.
    u = np.linspace(0, 6, 50)

    def point(u: Array) -> Array:
        r = 2 + 0.3 * np.sin(3 * u)
        return np.stack([r * np.cos(u), r * np.sin(u), 0 * u], -1)

    along = (point(u + 1e-6) - point(u - 1e-6)) / 2e-6
    exact = np.cross(along, [0, 0, 1.0])
    exact /= np.linalg.norm(exact, axis=1, keepdims=True)
    n = np.stack([np.cos(u), np.sin(u), 0 * u], -1)
    n_u = np.stack([-np.sin(u), np.cos(u), 0 * u], -1)
    p_v = np.broadcast_to([0, 0, 1.0], n.shape)
    slopes = np.stack([0.9 * np.cos(3 * u), 0 * u], -1)
    d = 0.3 * np.sin(3 * u)[:, None]
    got = mt.light.bumped_normals(2 * n_u, p_v, n, slopes, (d, n_u, 0 * n_u))
    np.testing.assert_allclose(got, exact, atol=1e-5)
    # Without the terms of the curvature the lean is that of d over the unmoved length.
    dropped = mt.light.bumped_normals(2 * n_u, p_v, n, slopes)
    lean = np.arctan(0.45 * np.cos(3 * u))
    np.testing.assert_allclose((dropped * n).sum(1), np.cos(lean), atol=1e-5)


def test_light_does_not_depend_on_the_number_of_threads() -> None:
    sky = mt.Environment((0.5 + 0.5 * directions(32)).astype(np.float32))
    scene = mt.Scene(ball(material=MIRROR), lights=[mt.light.Point((3, 3, 3))])
    pictures = [
        mt.render(
            scene, size=(90, 70), environment=sky, shadows=64, background="environment", threads=threads
        )
        for threads in (1, 2, 7)
    ]
    assert all(np.array_equal(pictures[0], other) for other in pictures[1:])
    assert (pictures[0][..., 3] == 255).all()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"shadows": 0}, "shadows"),
        ({"shadows": 10**6}, "shadows"),
        ({"shadows": 64, "shadow_softness": np.nan}, "shadow_softness"),
        ({"displacement_edge": 0.0}, "displacement_edge"),
        ({"background": "environment"}, "background"),
        ({"environment": 3}, "environment"),
    ],
)
def test_bad_arguments_are_named(change: dict[str, Any], words: str) -> None:
    with pytest.raises((ValueError, TypeError), match=words):
        mt.render(mt.Scene(mt.Mesh.build(SQUARE, FACES)), size=(8, 8), **change)


def test_bad_environments_are_named() -> None:
    grey = np.zeros((8, 16), np.float32)
    bad: list[tuple[dict[str, Any], str]] = [
        ({"form": "map"}, "form"),
        ({"intensity": -1.0}, "intensity"),
        ({"layout": "ring"}, "layout.*'faces'"),
        ({"form": "cube", "layout": "faces"}, "image.*six faces"),
    ]
    for keywords, words in bad:
        with pytest.raises(ValueError, match=words):
            mt.Environment(grey, **keywords)
    with pytest.raises(ValueError, match="channels"):
        mt.Environment(np.zeros((8, 16, 2), np.float32))


def test_the_command_draws_from_all_round(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, out = tmp_path / "ball.glb", tmp_path / "view.png"
    mt.Mesh.build(SQUARE, FACES, uv=UV, texture=np.zeros((64, 64, 3), np.uint8)).save(model)
    words = ["render", str(model), "-o", str(out), "--size", "64x48", "--turntable", "3", "--right-size"]
    assert main(words) == 0
    told = capsys.readouterr().out
    assert "view_2.png: 64x48" in told
    assert "is enough" in told
    pictures = [mt.read_image(tmp_path / f"view_{k}.png") for k in range(3)]
    assert all(p.shape == (48, 64, 4) for p in pictures)
    assert not np.array_equal(pictures[0], pictures[1])
    assert main(["render", str(model), "-o", str(out), "--debug", "checker", "--size", "64x48"]) == 0
    assert main(["render", str(model), "-o", "x.gif"]) == 2


def test_docstrings() -> None:
    finder = doctest.DocTestFinder()
    for item in (mt.Environment, mt.light.bumped_normals):
        for case in finder.find(item, globs={}):
            assert not doctest.DocTestRunner().run(case).failed
