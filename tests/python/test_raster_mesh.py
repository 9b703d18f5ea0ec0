"""`rasterize`, `Mesh`, `Scene`: against a solve of the ray's equations, and bad input."""

from __future__ import annotations

import doctest
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt

Array = NDArray[Any]
DATA = Path(os.environ.get("MULTUM_DATA", Path(__file__).parents[2] / ".." / "shared" / "data"))


def random_triangles(n: int, seed: int) -> Array:
    """Clip-space triangles (n, 3, 4), some with corners behind the eye."""
    r = np.random.default_rng(seed)
    centre = r.uniform([-2, -2, 0.5], [2, 2, 4], (n, 1, 3))
    p = centre + r.normal(0, 1, (n, 3, 3))
    w = p[..., 2]
    return np.concatenate([p[..., :2], 0.6 * w[..., None] - 0.4, w[..., None]], -1)


def solve(corners: Array, x: Array, y: Array) -> Array:
    """Weights (..., 3) at places x/w, y/w: the lectures' 2x2 system, with b0 = 1 - b1 - b2."""
    place = np.stack([x, y], -1)[..., None, :]
    moved = corners[:, :2] - place * corners[:, 3:]
    a = np.stack([moved[..., 1, :] - moved[..., 0, :], moved[..., 2, :] - moved[..., 0, :]], -1)
    b = np.linalg.solve(a, -moved[..., 0, :, None])[..., 0]
    return np.concatenate([1 - b.sum(-1, keepdims=True), b], -1)


def test_weights_values_and_derivatives_solve_the_rays_equations() -> None:
    w, h = 40, 24
    x, y = np.meshgrid((np.arange(w) + 0.5) * 2 / w - 1, 1 - (np.arange(h) + 0.5) * 2 / h)
    seen = 0
    for corners in random_triangles(200, 1):
        frag = mt.rasterize(corners, [[0, 1, 2]], (w, h))
        hit = frag.triangle == 0
        if not hit.any():
            continue
        expected = solve(corners, x, y)
        assert np.abs(frag.barycentric - expected)[hit].max() < 2e-2  # centres up to 1/256 pixel outside
        inner = hit & (expected.min(-1) > 0)
        assert np.abs(frag.barycentric - expected)[inner].max(initial=0) < 1e-6
        values = np.random.default_rng(2).normal(size=(3, 2))
        got, jac = frag.interpolate(values, derivatives=True)
        assert got.dtype == np.float64
        np.testing.assert_allclose(got[inner], (expected @ values)[inner], atol=1e-9)
        step = 1e-6
        for axis, (dx, dy) in enumerate([(step * 2 / w, 0.0), (0.0, -step * 2 / h)]):
            slope = (solve(corners, x + dx, y + dy) - solve(corners, x - dx, y - dy)) @ values / (2 * step)
            np.testing.assert_allclose(jac[inner][..., axis], slope[inner], rtol=1e-4, atol=1e-4)
        seen += int(inner.sum())
    assert seen > 10_000


def test_layers_samples_and_culling() -> None:
    corners = random_triangles(30, 5).reshape(-1, 4)
    faces = np.arange(90).reshape(30, 3)
    single: Array = np.sum([mt.rasterize(corners, f[None], (32, 20)).triangle >= 0 for f in faces], axis=0)
    layer, layers = mt.rasterize(corners, faces, (32, 20)), np.zeros((20, 32), int)
    while (layer.triangle >= 0).any():
        layers = layers + (layer.triangle >= 0)
        layer = layer.behind()
    np.testing.assert_array_equal(layers, single)
    back = mt.rasterize(corners, faces, (32, 20), cull="back").triangle
    front = mt.rasterize(corners, faces, (32, 20), cull="front").triangle
    assert not set(back[back >= 0]) & set(front[front >= 0])
    masked = mt.rasterize(corners, faces, (32, 20), cull=np.ones(30, bool)).triangle
    np.testing.assert_array_equal(masked, back)
    smooth = mt.rasterize(corners, faces, (32, 20), samples=16).coverage
    assert ((smooth > 0) & (smooth < 1)).any()
    hard = mt.rasterize(corners, faces, (320, 200)).coverage.reshape(20, 10, 32, 10).mean((1, 3))
    assert np.abs(smooth - hard).max() < 0.2
    assert abs(float(smooth.mean() - hard.mean())) < 0.005


def test_shapes_dtypes_and_threads() -> None:
    corners = random_triangles(500, 6).reshape(-1, 4)
    faces = np.arange(1500).reshape(500, 3)
    one = mt.rasterize(corners.astype(np.float32), faces.astype(np.int16), (61, 33), threads=1)
    two = mt.rasterize(corners.astype(np.float32), np.asfortranarray(faces), (61, 33), threads=2)
    assert one.size == (61, 33)
    for name in ("triangle", "depth", "barycentric", "coverage"):
        a, b = getattr(one, name), getattr(two, name)
        assert a.shape[:2] == (33, 61)
        assert a.tobytes() == b.tobytes()
    assert one.interpolate(np.arange(1500)).shape == (33, 61)
    assert one.interpolate(np.arange(1500)).dtype == np.float32
    assert one.interpolate(np.zeros((500, 3, 4), np.float32), derivatives=True)[1].shape == (33, 61, 4, 2)
    filled = one.interpolate(np.zeros((1500, 2)), fill=np.nan)
    np.testing.assert_array_equal(np.isnan(filled[..., 0]), one.triangle < 0)
    empty = mt.rasterize(np.zeros((0, 4)), np.zeros((0, 3), int), (2, 2))
    assert (empty.triangle == -1).all()
    assert np.isinf(empty.depth).all()


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"clip_positions": np.zeros((3, 3))}, ValueError, "clip_positions"),
        ({"clip_positions": np.zeros(4)}, ValueError, "clip_positions"),
        ({"faces": [[0, 1, 3]]}, ValueError, "faces"),
        ({"faces": [[0, 1, -1]]}, ValueError, "faces: got index -1"),
        ({"faces": [[0, 1]]}, ValueError, "faces"),
        ({"faces": [[0.0, 1, 2]]}, TypeError, "faces"),
        ({"size": (0, 4)}, ValueError, "size"),
        ({"size": (10**6, 10**6)}, ValueError, "size"),
        ({"size": 5}, TypeError, "size"),
        ({"cull": "both"}, ValueError, "cull"),
        ({"cull": [True, False]}, ValueError, "cull"),
        ({"cull": [1]}, TypeError, "cull"),
        ({"samples": 3}, ValueError, "samples"),
    ],
)
def test_bad_arguments_are_named(change: dict[str, Any], error: type[Exception], words: str) -> None:
    arguments: dict[str, Any] = {
        "clip_positions": np.eye(3, 4),
        "faces": [[0, 1, 2]],
        "size": (4, 4),
        **change,
    }
    with pytest.raises(error, match=words):
        mt.rasterize(**arguments)


def test_attributes_that_do_not_fit_are_refused() -> None:
    frag = mt.rasterize(np.eye(3, 4), [[0, 1, 2]], (4, 4))
    for bad in (np.zeros((2, 2)), np.zeros((3, 0)), np.zeros((1, 3, 2, 2)), np.zeros((2, 3, 2))):
        with pytest.raises(ValueError, match="attributes"):
            frag.interpolate(bad)
    with pytest.raises(TypeError, match="attributes"):
        frag.interpolate(["a", "b", "c"])


def test_one_textured_quad_in_both_formats_is_the_same_picture(tmp_path: Path) -> None:
    mt.write_image(tmp_path / "p i.png", (np.random.default_rng(0).random((4, 4, 3)) * 255).astype(np.uint8))
    (tmp_path / "q.mtl").write_text("newmtl m\nmap_Kd p i.png\n")
    (tmp_path / "q.obj").write_text(
        "mtllib q.mtl\nusemtl m\nv -1 1 0\nv 1 1 0\nv 1 -1 0\nv -1 -1 0\n"
        "vt 0 1\nvt 1 1\nvt 1 0\nvt 0 0\nf 1/1 4/4 3/3 2/2\n"
    )
    points = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]], "<f4")
    uv, index = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], "<f4"), np.array([0, 3, 2, 0, 2, 1], "<u2")
    (tmp_path / "q.bin").write_bytes(points.tobytes() + uv.tobytes() + index.tobytes())
    views = [{"buffer": 0, "byteOffset": o, "byteLength": n} for o, n in ((0, 48), (48, 32), (80, 12))]
    accessors = [
        {
            "bufferView": 0,
            "componentType": 5126,
            "count": 4,
            "type": "VEC3",
            "min": [-1, -1, 0],
            "max": [1, 1, 0],
        },
        {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
        {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
    ]
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}
    gltf: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 92, "uri": "q.bin"}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [primitive]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "images": [{"uri": "p%20i.png"}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    }
    (tmp_path / "q.gltf").write_text(json.dumps(gltf))
    pictures = []
    for name in ("q.obj", "q.gltf"):
        scene = mt.Scene.open(tmp_path / name)
        mesh, camera = scene.mesh, mt.Camera((0.5, 0.2, 3))
        frag = mt.rasterize(camera.project(mesh.positions, (48, 32)), mesh.faces, (48, 32), cull="back")
        assert mesh.uv is not None
        uvs, jac = frag.interpolate(mesh.uv, derivatives=True)
        slot = mesh.materials[mesh.face_material[0]].base_color_texture
        assert slot is not None
        assert (slot.wrap, slot.encoding) == (("repeat", "repeat"), "srgb")
        pictures.append(mesh.texture(slot).sample(*slot.uv(uvs, jac)) * (frag.triangle >= 0)[..., None])
    assert pictures[0].any()
    np.testing.assert_allclose(pictures[0], pictures[1], atol=1e-6)
    gltf["buffers"][0]["uri"] = "../q.bin"
    (tmp_path / "q.gltf").write_text(json.dumps(gltf))
    with pytest.raises(OSError, match="folder"):
        mt.Mesh.open(tmp_path / "q.gltf")
    with pytest.raises(FileNotFoundError):
        mt.Mesh.open(tmp_path / "none.glb")
    with pytest.raises(ValueError, match="normals"):
        mt.Mesh.open(tmp_path / "q.obj", normals="soft")
    with pytest.raises(ValueError, match="camera"):
        mt.Scene.open(tmp_path / "q.obj").camera("left")


def test_cameras_refuse_what_makes_none() -> None:
    wrong: list[dict[str, Any]] = [{"fov": 180}, {"near": 0}, {"near": 2, "far": 1}, {"eye": (0, 0, np.nan)}]
    for bad in wrong:
        with pytest.raises(ValueError, match=r"fov|near|eye"):
            mt.Camera(**{"eye": (0, 0, 1), **bad})
    with pytest.raises(ValueError, match="target"):
        mt.Camera((0, 0, 1), (0, 0))


def test_real_models_are_in_view_and_decode() -> None:
    if not DATA.is_dir():
        print("the real models are absent: set MULTUM_DATA to their folder")
        return
    for name in ("gltf/FlightHelmet/FlightHelmet.gltf", "gltf/Fox.glb", "obj/fuze/fuze.obj"):
        scene = mt.Scene.open(DATA / name)
        mesh = scene.mesh
        clip = scene.camera("auto").project(mesh.positions, (96, 64))
        shown = mt.rasterize(clip, mesh.faces, (96, 64)).triangle >= 0
        assert 0.05 < shown.mean() < 0.9, name
        for material in mesh.materials:
            if material.base_color_texture is not None:
                assert mesh.texture(material.base_color_texture).width >= 512


def test_docstrings() -> None:
    finder = doctest.DocTestFinder()
    for item in (mt.Fragments, mt.rasterize, mt.Mesh, mt.Camera, mt.Scene, mt.vertex_normals):
        for case in finder.find(item, globs={}):
            assert not doctest.DocTestRunner().run(case).failed
