"""Pictures beside those of Mesa's llvmpipe; both beside a truth in float64. ``pytest -s`` shows the figures."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from render_scenes import DATA
from render_truth import bilinear, cast, rays

try:
    from render_peer import Llvmpipe, Unavailable, context
except ImportError as error:
    pytest.skip(f"without moderngl: {error}", allow_module_level=True)
try:
    context().release()
except Unavailable as error:
    pytest.skip(str(error), allow_module_level=True)

HELMET = DATA / "gltf" / "FlightHelmet" / "FlightHelmet.gltf"


def unlit(mesh: mt.Mesh) -> mt.Mesh:
    """Base colours alone, codes taken for light, no blending."""

    def plain(m: mt.Material) -> mt.Material:
        slot = m.base_color_texture
        slot = None if slot is None else replace(slot, encoding="linear")
        return replace(m, unlit=True, alpha_mode="opaque", base_color_texture=slot, base_color=(1, 1, 1, 1))

    return replace(mesh, materials=[plain(m) for m in mesh.materials])


def clouds(side: int, seed: int) -> NDArray[np.uint8]:
    """Colours with the spectrum of photographs, 1/f."""
    f = np.hypot(np.fft.fftfreq(side)[:, None], np.fft.fftfreq(side)[None]) * side
    f[0, 0] = 1
    noise = np.random.default_rng(seed).normal(size=(side, side, 3))
    image = np.fft.ifft2(np.fft.fft2(noise, axes=(0, 1)) / f[..., None], axes=(0, 1)).real
    image = (image - image.mean()) / image.std()
    return np.asarray(np.clip(128 + 50 * image, 0, 255), np.uint8)


def knot() -> mt.Mesh:
    """A tube along a knot: 40,000 triangles that hide each other, some of them edge-on."""
    n, m = 800, 25
    t = np.linspace(0, 2 * np.pi, n + 1)[:, None]
    s = np.linspace(0, 2 * np.pi, m + 1)[None]
    r = 2 + np.cos(3 * t)
    axis = np.stack([r * np.cos(2 * t), r * np.sin(2 * t), np.sin(3 * t)], -1)
    along = np.gradient(axis[:, 0], axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along, [0, 0, 1])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, along)
    points = axis + 0.4 * (np.cos(s)[..., None] * side[:, None] + np.sin(s)[..., None] * up[:, None])
    uv = np.stack(np.broadcast_arrays(t * 12 / np.pi, s / np.pi), -1)
    first = (np.arange(n)[:, None] * (m + 1) + np.arange(m)).reshape(-1, 1)
    faces = np.concatenate([first + np.array(k) for k in ([0, 1, m + 2], [0, m + 2, m + 1])])
    return mt.Mesh.build(points.reshape(-1, 3), faces, uv=uv.reshape(-1, 2), texture=clouds(512, 1))


def inner(shown: NDArray[np.int32], depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Pixels whose neighbours, two pixels far, show the same piece of surface: no edge of the picture's content."""
    z = np.where(shown >= 0, depth.astype(float), np.inf)
    good = shown >= 0
    with np.errstate(invalid="ignore"):
        for axis in (0, 1):
            for step in (1, 2):
                before, after = np.roll(z, step, axis), np.roll(z, -step, axis)
                # On a smooth surface a depth is near the mean of those on both sides of it.
                good &= np.abs(z - (before + after) / 2) < 2e-5 * step**2
    return good


SCENES = {
    "knot": lambda: unlit(knot()),
    "helmet": lambda: unlit(mt.Mesh.open(HELMET)),
}


@pytest.mark.parametrize("name", SCENES)
def test_coverage_and_colours_are_those_of_llvmpipe(name: str) -> None:
    if name == "helmet" and not HELMET.exists():
        pytest.skip(f"no {HELMET}")
    scene = mt.Scene(SCENES[name]())
    size = (700, 600)
    camera = scene.camera("auto", size)
    peer = Llvmpipe(scene, camera, size, dtype="f4")
    clip = camera.project(scene.mesh.positions, size)
    cull = np.array([not m.double_sided for m in scene.mesh.materials])[scene.mesh.face_material]
    frag = mt.rasterize(clip, scene.mesh.faces, size, cull=cull)
    depth = frag.depth
    there = inner(frag.triangle, depth)
    # Most pixels of a detailed model lie near an edge of something.
    assert there.sum() > 0.25 * (frag.triangle >= 0).sum()
    for filter in ("bilinear", "trilinear"):
        theirs = peer.picture(filter)
        own = mt.render(scene, camera, size, filter, output="linear")
        np.testing.assert_array_equal(own[..., 3] > 0, frag.triangle >= 0)
        apart = ((own[..., 3] > 0) != (theirs[..., 3] > 0)).mean()
        rms = float(np.sqrt(np.mean((own - theirs)[there][:, :3] ** 2)))
        print(
            f"{name}, {filter}: coverage differs on {apart:.3%} of pixels, colours by {rms * 255:.2f} of 255 rms"
        )
        assert apart < 1e-3
        assert rms < 2 / 255


def test_textures_are_twice_as_near_to_the_truth_as_anisotropic_ones() -> None:
    """Floor, wall and ball, 16 by 16 rays a pixel in float64, against 16 times anisotropic filtering."""
    size, eye, target = (96, 72), np.array([0.3, 1.0, 4.0]), np.array([0.0, 0.5, 0.0])
    quad = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]], np.float32)
    floor = np.array([[-6, 0, -8], [6, 0, -8], [6, 0, 3], [-6, 0, 3]], np.float32)
    uv, faces = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]), [[0, 3, 2], [0, 2, 1]]
    n = 12
    theta, phi = np.meshgrid(
        np.linspace(0.3, np.pi - 0.3, n + 1), np.linspace(-1.3, 1.3, n + 1), indexing="ij"
    )
    ball = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], -1)
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).reshape(-1, 1)
    patches = np.concatenate([first + np.array(k) for k in ([0, n + 1, n + 2], [0, n + 2, 1])])
    pictures = [
        clouds(256, 5),
        np.random.default_rng(1).integers(0, 256, (64, 64, 3), np.uint8),
        clouds(128, 6),
    ]
    shapes: list[tuple[Any, Any, Any]] = [
        (floor, faces, uv * [12, 11]),
        (quad + np.array([1.2, 1, -2]), faces, uv * 2),
        ((0.6 * ball + [-0.7, 0.7, 0.3]).reshape(-1, 3), patches, np.stack([phi, theta], -1).reshape(-1, 2)),
    ]
    mesh = unlit(
        mt.Mesh.join(
            [
                mt.Mesh.build(p, f, uv=t, texture=picture)
                for (p, f, t), picture in zip(shapes, pictures, strict=True)
            ]
        )
    )
    assert mesh.uv is not None
    corners, places = mesh.positions[mesh.faces].astype(float), mesh.uv[mesh.faces].astype(float)
    truth, kinds = np.zeros((size[1], size[0], 3)), []
    for i in range(16):
        for j in range(16):
            hits = cast(eye, rays(eye, target, 50, size, ((i + 0.5) / 16, (j + 0.5) / 16)), corners)
            at = hits.blend(places)
            kind = np.where(hits.face < 0, -1, mesh.face_material[hits.face].astype(int))
            for k, picture in enumerate(pictures):
                truth[kind == k] += bilinear(picture / 255.0, at[kind == k])
            kinds.append(kind)
    truth /= 256
    inside = (np.min(kinds, 0) == np.max(kinds, 0)) & (kinds[0] >= 0)
    assert all((inside & (kinds[0] == k)).sum() > 100 for k in range(3))
    scene, camera = mt.Scene(mesh), mt.Camera(eye, target, fov=50)
    peer = Llvmpipe(scene, camera, size, dtype="f4")

    def error(picture: NDArray[Any]) -> float:
        return float(np.sqrt(np.mean((picture[..., :3] - truth)[inside] ** 2)))

    theirs = {filter: error(peer.picture(filter)) for filter in ("trilinear", "anisotropic")}
    own = {
        filter: error(mt.render(scene, camera, size, filter, output="linear"))
        for filter in ("trilinear", "anisotropic", "ewa", "auto", "area", "exact")
    }
    for who, errors in (("llvmpipe", theirs), ("multum", own)):
        print(who, ", ".join(f"{filter} {value * 255:.2f}" for filter, value in errors.items()))
    for filter in ("auto", "area", "exact"):
        assert own[filter] < 0.5 * theirs["anisotropic"], filter
