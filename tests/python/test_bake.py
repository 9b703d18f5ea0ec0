"""Baking from Python: arrays, reports, warnings, real data, the road from a file to a glTF."""

import doctest
import io
import json
import math
import os
import pathlib
import re
import warnings
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from multum.cli import main
from multum.cli.progress import Progress

QUAD = ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
QUAD_UV = [[0, 1], [1, 1], [1, 0], [0, 0]]


def quad(z: float = 0.0) -> mt.Mesh:
    points = np.array([[x, y, z] for x, y, _ in QUAD[0]], np.float32)
    return mt.Mesh.build(points, QUAD[1], uv=QUAD_UV)


def ball(rings: int, bump: float = 0.0) -> mt.Mesh:
    """A closed sphere, or a bumpy one, of 4 rings^2 faces or so, without uv."""
    v, u = np.meshgrid(
        np.linspace(0, math.pi, rings + 1), np.arange(2 * rings) * math.pi / rings, indexing="ij"
    )
    r = 1 + bump * np.sin(6 * u) * np.sin(v) ** 2 * np.cos(5 * v)
    points = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], -1) * r[..., None]
    i, j = np.meshgrid(np.arange(rings), np.arange(2 * rings), indexing="ij")
    a, b = i * 2 * rings + j, i * 2 * rings + (j + 1) % (2 * rings)
    c, d = a + 2 * rings, b + 2 * rings
    faces = np.concatenate([np.stack([a, c, d], -1).reshape(-1, 3), np.stack([a, d, b], -1).reshape(-1, 3)])
    # One vertex at each pole, and no faces without an area.
    flat = points.reshape(-1, 3).astype(np.float32)
    flat[: 2 * rings], flat[-2 * rings :] = (0, 0, 1), (0, 0, -1)
    _, first, welded = np.unique(flat, axis=0, return_index=True, return_inverse=True)
    faces = welded.reshape(-1)[faces]
    return mt.Mesh.build(flat[first], faces[(faces != np.roll(faces, 1, 1)).all(1)])


def data(name: str) -> pathlib.Path | None:
    root = pathlib.Path(__file__).parents[2]
    folder = pathlib.Path(os.environ.get("MULTUM_DATA", root.parent / "shared" / "data"))
    if not (folder / name).exists():
        print(f"{folder / name} is absent: nothing to compare with")
        return None
    return folder / name


def test_docstrings() -> None:
    assert doctest.testmod(mt.bake).failed == 0


def test_the_line_of_the_contract() -> None:
    high, low = ball(24, 0.02), ball(8).unwrap(64, lowest_level=0)
    found = mt.bake.normal_map(high, low, 64, space="object")
    assert found.shape == (64, 64, 3)
    assert found.dtype == np.uint8
    report = found.report
    assert report is not None
    assert report.missed == 0
    assert report.overlapping == 0
    assert report.texels == 64 * 64
    assert report.covered == ((report.flags & mt.bake.COVERED) > 0).sum()
    part = found[:2]
    assert isinstance(part, mt.bake.Map)
    assert part.report is None
    assert type(found + 1) is np.ndarray


def test_dtypes_hold_the_same_map() -> None:
    high, low = ball(24, 0.05), ball(8).unwrap(64, lowest_level=0)
    floats = np.asarray(mt.bake.normal_map(high, low, (64, 48), space="object", dtype="float32"), np.float64)
    assert floats.shape == (48, 64, 3)
    for dtype, half in (("uint8", 128), ("uint16", 32768)):
        codes = mt.bake.normal_map(high, low, (64, 48), space="object", dtype=dtype)
        decoded = (codes.astype(np.float64) - half) / (half - 1)
        assert abs(decoded - (2 * floats - 1)).max() <= 0.5 / (half - 1) + 2e-7
        # What a texture reads from it.
        texel = mt.Texture(np.asarray(codes), encoding="normal").sample(
            [0.5 / 64, 0.5 / 48], filter="nearest"
        )
        assert abs(texel - decoded[0, 0]).max() < 1e-6


def test_ranges_of_integers() -> None:
    low, high = quad(), quad(0.25)
    assert mt.bake.height(high, low, 2).tolist() == [[0.25, 0.25], [0.25, 0.25]]
    codes = mt.bake.height(high, low, 2, dtype="uint16", range=(0, 1))
    assert codes.tolist() == [[16384, 16384], [16384, 16384]]
    assert codes.report is not None
    assert codes.report.range == (0.0, 1.0)
    own = mt.bake.height(high, low, 2, dtype="uint8")
    assert own.report is not None
    assert own.report.range == (0.25, 1.25)
    assert own.max() == 0
    place = mt.bake.position(high, low, 2)
    assert place[0, 0].tolist() == [0.25, 0.75, 0.25]


def test_what_is_not_right_is_told() -> None:
    low = quad()
    far = mt.Mesh.build([[x + 5, y, z] for x, y, z in QUAD[0]], QUAD[1])
    with pytest.warns(mt.bake.BakeWarning, match="4 texels of the low mesh found nothing"):
        found = mt.bake.normal_map(far, low, 2, distance=0.5)
    assert found.report is not None
    assert (found.report.flags == mt.bake.MISSED).all()
    assert found.report.warnings
    twice = mt.Mesh.build(QUAD[0], QUAD[1] * 2, uv=QUAD_UV)
    with pytest.warns(mt.bake.BakeWarning) as told:
        found = mt.bake.normal_map(low, twice, 4)
    assert "16 texels shared by several faces" in str(told[0].message)
    assert "not manifold: 0 of the high mesh, 5 of the low mesh" in str(told[1].message)
    assert found.report is not None
    assert (found.report.flags & mt.bake.OVERLAPPING).all()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mt.bake.normal_map(low, low, 4)


@pytest.mark.parametrize(
    ("keywords", "error", "match"),
    [
        ({"space": "world"}, ValueError, "space"),
        ({"space": 3}, TypeError, "space"),
        ({"dtype": "int32"}, TypeError, "dtype"),
        ({"dtype": "texels"}, TypeError, "dtype"),
        ({"samples": 0}, ValueError, "samples"),
        ({"samples": 2.5}, TypeError, "samples"),
        ({"method": "furthest"}, ValueError, "method"),
        ({"distance": -1}, ValueError, "distance"),
        ({"distance": "far"}, TypeError, "distance"),
        ({"cage": [[0, 0, 1]]}, ValueError, "cage"),
        ({"padding": -1}, ValueError, "padding"),
        ({"sample": 3}, TypeError, "sample"),
    ],
)
def test_bad_options(keywords: dict[str, Any], error: type[Exception], match: str) -> None:
    with pytest.raises(error, match=match):
        mt.bake.normal_map(quad(), quad(), 4, **keywords)


def test_bad_meshes_and_sizes() -> None:
    plain = mt.Mesh.build(*QUAD)
    with pytest.raises(ValueError, match=r"low: .* uv"):
        mt.bake.normal_map(quad(), plain, 4)
    with pytest.raises(TypeError, match="high"):
        mt.bake.normal_map("mesh", quad(), 4)  # type: ignore[arg-type]
    for size in (0, (4, -1), (4, 20000)):
        with pytest.raises(ValueError, match="size"):
            mt.bake.normal_map(quad(), quad(), size)
    with pytest.raises(ValueError, match="faces"):
        mt.Mesh.build(QUAD[0], [[0, 1, 7]])
    with pytest.raises(ValueError, match="uv"):
        mt.Mesh.build(*QUAD, uv=[[0, 0]])
    with pytest.raises(ValueError, match="positions"):
        mt.Mesh.build(np.full((4, 3), np.nan), QUAD[1])
    with pytest.raises(ValueError, match="rays"):
        mt.bake.ambient_occlusion(quad(), quad(), 4, rays=0)
    with pytest.raises(ValueError, match="directions"):
        mt.bake.intersect(quad(), [[0, 0, 0]], [1, 0, math.inf])


def test_bad_ranges_rays_and_points() -> None:
    for range in ((1,), "ab", 3, (0, None), [[0, 1]]):
        with pytest.raises(TypeError, match="range"):
            mt.bake.height(quad(), quad(), 4, range=range)  # type: ignore[arg-type]
    for ends in ((0, 0), (1, 0), (0, math.nan), (0, math.inf)):
        with pytest.raises(ValueError, match="range"):
            mt.bake.height(quad(), quad(), 4, range=ends)
    with pytest.raises(ValueError, match="directions"):
        mt.bake.intersect(quad(), np.zeros((4, 3)), np.ones((5, 3)))
    with pytest.raises(TypeError, match="origins"):
        mt.bake.intersect(quad(), ["a", "b", "c"], [0, 0, 1])
    with pytest.raises(ValueError, match="points"):
        mt.bake.closest(quad(), [0, math.nan, 0])
    with pytest.raises(TypeError, match="mesh"):
        mt.bake.closest(None, [0, 0, 0])  # type: ignore[arg-type]
    assert mt.bake.height(quad(), quad(), np.array([3, 2])).shape == (2, 3)


def test_threads_and_progress() -> None:
    high, low = ball(40, 0.02), ball(8).unwrap(256)
    shares: list[float] = []
    one = mt.bake.normal_map(high, low, 256, threads=1, progress=shares.append)
    assert shares
    assert all(0 < share < 1 for share in shares)
    assert (mt.bake.normal_map(high, low, 256, threads=5) == one).all()

    def stop(_: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mt.bake.normal_map(high, low, 256, progress=stop)


def test_a_bar_fills_within_a_step() -> None:
    progress = Progress(2, io.StringIO())
    progress.step("baking")
    progress.share(0.5)
    # A new stage of the same step begins at 0, and the bar stays.
    progress.share(0.1)
    assert progress.line().startswith("[######..................] 0/2 baking (")
    progress.step("writing")
    assert progress.line().startswith("[############............] 1/2 writing (")


def test_colour_of_a_file_with_a_texture(tmp_path: pathlib.Path) -> None:
    rng = np.random.default_rng(5)
    picture = rng.integers(0, 256, (16, 16, 3), np.uint8)
    mt.write_image(tmp_path / "p.png", picture)
    (tmp_path / "m.mtl").write_text("newmtl a\nKd 1 1 1\nmap_Kd p.png\n")
    lines = [f"v {x} {y} {z}" for x, y, z in QUAD[0]] + [f"vt {u} {1 - v}" for u, v in QUAD_UV]
    faces = ["f " + " ".join(f"{i + 1}/{i + 1}" for i in face) for face in QUAD[1]]
    (tmp_path / "q.obj").write_text("\n".join(["mtllib m.mtl", *lines, "usemtl a", *faces]))
    high = mt.Mesh.open(tmp_path / "q.obj")
    same = mt.bake.color(high, quad(), 16, samples=1)
    assert (same == picture).all()
    # Half the size: the mean of four texels in linear light, which is what resizing gives.
    half = mt.bake.color(high, quad(), 8, samples=8, dtype="float32", encoding="linear")
    linear = mt.Texture(picture, "repeat", encoding="srgb").sample(
        np.stack(np.meshgrid((np.arange(8) + 0.5) / 8, (np.arange(8) + 0.5) / 8), -1),
        np.eye(2) / 8,
        filter="exact",
    )
    # Samples in the middle of quarters of texels give the integral of the bilinear reconstruction.
    assert abs(np.asarray(half) - linear).max() < 1e-5


def test_asteroid_against_the_maps_that_ship_with_it() -> None:
    folder = data("obj/asteroid/asteroid-low.obj")
    if folder is None:
        return
    folder = folder.parent
    high = mt.Mesh.open(folder / "asteroid-high.obj")
    low = mt.Mesh.open(folder / "asteroid-low.obj")
    islands = mt.read_image(folder / "asteroid-height-map.png")[..., 1] > 127
    # Their codes are 2 x - 1 of eight bits, x right, y up, z out, v up; ours are the same with an exact zero.
    for space, name, least in (("object", "", 0.997), ("tangent", "-tangent", 0.998)):
        theirs = mt.read_image(folder / f"asteroid-normal-map{name}.png")[..., :3] / 127.5 - 1.0
        ours = mt.bake.normal_map(high, low, 1024, space=space, dtype="float32", samples=1)
        report = ours.report
        assert report is not None
        assert report.missed == 0
        assert report.warnings == ()
        both = ((report.flags & mt.bake.COVERED) > 0) & islands
        assert both.sum() > 0.95 * islands.sum()
        theirs /= np.linalg.norm(theirs, axis=-1, keepdims=True)
        cosine = ((2.0 * np.asarray(ours) - 1.0) * theirs).sum(-1)[both]
        assert cosine.mean() > least
        assert np.percentile(cosine, 1) > 0.97


def test_the_page_about_baking_runs(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (pathlib.Path(__file__).parents[2] / "docs" / "bake.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    mesh = ball(100, 0.02)
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.positions.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces.tolist()]
    (tmp_path / "high.obj").write_text("\n".join(lines))
    (block,) = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    exec(compile(block, "bake.md", "exec"), {})
    assert "missed=0" in capsys.readouterr().out
    (command,) = re.findall(r"^multum (bake .*)$", page, re.MULTILINE)
    assert main(command.replace("1024", "256").split()) == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "high.gltf",
        "high.bin",
        "high_normal.png",
    }


def test_one_command_from_a_detailed_mesh_to_a_gltf(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ball(60, 0.03).save(tmp_path / "high.glb")
    out = tmp_path / "out"
    command = ["bake", str(tmp_path / "high.glb"), "--simplify", "0.05", "--size", "256", "--depth", "16"]
    assert main([*command, "--maps", "normal", "occlusion", "height", "--exr", "-o", str(out)]) == 0
    told = capsys.readouterr().out
    assert "normal: 256x256, uint16" in told
    names = {"high.gltf", "high.bin", "high_normal.png", "high_occlusion.png", "high_height.png"}
    exr = {"high_normal.exr", "high_occlusion.exr", "high_height.exr"}
    assert {path.name for path in out.iterdir()} == names | exr
    scene = mt.Scene.open(out / "high.gltf")
    mesh = scene.mesh
    assert 0.03 * 14160 < len(mesh.faces) < 0.06 * 14160
    slot = mesh.materials[0].normal_texture
    assert slot is not None
    assert slot.wrap == ("clamp", "clamp")
    codes = mesh.images[slot.image].read()
    assert codes.dtype == np.uint16
    # Shading the simple mesh with its map gives the normals of the detailed one: the file's own tangents.
    rng = np.random.default_rng(1)
    face = rng.integers(0, len(mesh.faces), 4000)
    weights = rng.dirichlet([1, 1, 1], 4000)
    corners = mesh.faces[face]

    def mix(values: NDArray[np.float32]) -> NDArray[np.float64]:
        mixed: NDArray[np.float64] = np.einsum("nc,nck->nk", weights, values[corners].astype(np.float64))
        return mixed

    assert mesh.uv is not None
    normal, tangent = mix(mesh.normals), mix(mesh.tangents)
    bitangent = tangent[:, 3:] * np.cross(normal, tangent[:, :3])
    read = mesh.texture(slot).sample(mix(mesh.uv), filter="bilinear")
    shaded = read[:, :1] * tangent[:, :3] + read[:, 1:2] * bitangent + read[:, 2:] * normal
    shaded /= np.linalg.norm(shaded, axis=-1, keepdims=True)
    point = mix(mesh.positions)
    direction = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    high = mt.Mesh.open(tmp_path / "high.glb")
    hit, _, high_weights = mt.bake.intersect(high, point + 0.2 * direction, -direction)
    truth = np.einsum("nc,nck->nk", high_weights, high.normals[high.faces[hit]].astype(np.float64))
    truth /= np.linalg.norm(truth, axis=-1, keepdims=True)
    plain = (direction * truth).sum(-1)
    assert (shaded * truth).sum(-1).mean() > 0.995
    assert 1 - (shaded * truth).sum(-1).mean() < 0.1 * (1 - plain.mean())


def test_names_with_signs_and_all_maps(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    ball(12, 0.05).save(tmp_path / "my high #1 %41.gltf")
    names = ("normal", "occlusion", "color", "height", "position", "curvature")
    command = ["bake", str(tmp_path / "my high #1 %41.gltf"), "--simplify", "0.2", "--size", "128"]
    assert main([*command, "--lowest-level", "0", "--maps", *names, "-o", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.count("full scale") == 3
    made = {path.name for path in (tmp_path / "out").iterdir()}
    assert made == {f"my high #1 %41{end}" for end in (".gltf", ".bin", *(f"_{name}.png" for name in names))}
    document = json.loads((tmp_path / "out" / "my high #1 %41.gltf").read_text())
    assert document["buffers"][0]["uri"] == "my%20high%20%231%20%2541.bin"
    mesh = mt.Mesh.open(tmp_path / "out" / "my high #1 %41.gltf")
    assert [image.read().shape[:2] for image in mesh.images] == [(128, 128)] * 3


def test_simplifying_for_a_bake_is_not_held_by_old_cuts(tmp_path: pathlib.Path) -> None:
    ball(24).unwrap(256).save(tmp_path / "high.glb")
    assert main(["bake", str(tmp_path / "high.glb"), "--simplify", "0.02", "--size", "64", "--lowest-level", "0",
                 "-o", str(tmp_path)]) == 0  # fmt: skip
    low = mt.Mesh.open(tmp_path / "high.gltf")
    assert len(low.faces) <= 0.02 * len(ball(24).faces) + 2


def test_gltf_keeps_materials_and_pictures(tmp_path: pathlib.Path) -> None:
    import dataclasses

    mesh = quad()
    mt.write_image(tmp_path / "a.png", np.full((2, 2, 3), 7, np.uint8))
    turn = math.radians(30)
    transform = np.array(
        [[2 * math.cos(turn), 3 * math.sin(turn), 0.1], [-2 * math.sin(turn), 3 * math.cos(turn), 0.2]],
        np.float32,
    )
    slot = mt.TextureSlot(0, 0, transform, ("mirror", "clamp"), "nearest", "trilinear", "srgb")
    material = mt.Material(
        name="tin", base_color=(0.5, 0.25, 1.0, 0.5), metallic=1.0, roughness=0.25, base_color_texture=slot,
        alpha_mode="mask", alpha_cutoff=0.25, double_sided=True, emissive=(0.5, 0.0, 1.0),
    )  # fmt: skip
    plain = mt.Material(name="plain")
    mesh = dataclasses.replace(
        mesh,
        materials=[material, plain],
        images=[mt.MeshImage("a.png", tmp_path / "a.png", None)],
        face_material=np.array([1, 0], np.uint32),
        colors=np.random.default_rng(0).random((4, 4)).astype(np.float32),
    )
    for name in ("m.gltf", "m.glb"):
        mesh.save(tmp_path / name)
        again = mt.Mesh.open(tmp_path / name)
        first = next(m for m in again.materials if m.name == "tin")
        for key in (
            "base_color",
            "metallic",
            "roughness",
            "alpha_mode",
            "alpha_cutoff",
            "double_sided",
            "emissive",
        ):
            assert getattr(first, key) == getattr(material, key), key
        read = first.base_color_texture
        assert read is not None
        assert read.wrap == slot.wrap
        assert (read.mag_filter, read.min_filter) == (slot.mag_filter, slot.min_filter)
        assert abs(read.transform - transform).max() < 1e-6
        assert (again.images[read.image].read() == 7).all()
        assert [again.materials[m].name for m in again.face_material] == ["tin", "plain"]
        assert again.uv is not None
        corners = {tuple(np.round(row, 5)) for row in np.concatenate([again.positions, again.uv], 1).tolist()}
        assert corners == {(*p, *t) for p, t in zip(QUAD[0], QUAD_UV, strict=True)}
    document = json.loads((tmp_path / "m.gltf").read_text())
    assert document["extensionsUsed"] == ["KHR_texture_transform"]
    with pytest.raises(ValueError, match="path"):
        mesh.save(tmp_path / "m.obj")
    shear = dataclasses.replace(slot, transform=np.array([[1, 1, 0], [0, 1, 0]], np.float32))
    sheared = dataclasses.replace(mesh, materials=[mt.Material(base_color_texture=shear), plain])
    with pytest.raises(ValueError, match="shear"):
        sheared.save(tmp_path / "m.gltf")
