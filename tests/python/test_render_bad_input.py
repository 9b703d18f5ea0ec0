"""Bad input of `render` is refused by name; odd numbers do no harm."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

import multum as mt
from render_scenes import UV, noise, square


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


def any_floats(rows: int, columns: int) -> st.SearchStrategy[NDArray[np.float32]]:
    odd = st.sampled_from([0.0, -0.0, 1.0, -1.0, 1e38, -1e38, 1e-38, 1e-45, 0.5])
    return arrays(np.float32, (rows, columns), elements=odd | st.floats(-2, 2, width=32), fill=st.nothing())


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    positions=any_floats(7, 3),
    normals=any_floats(7, 3),
    tangents=any_floats(7, 4),
    uv=any_floats(7, 2),
    faces=arrays(np.uint32, (6, 3), elements=st.integers(0, 6)),
    numbers=any_floats(1, 6),
    mode=st.sampled_from(["opaque", "mask", "blend"]),
    shiny=st.booleans(),
)
def test_any_mesh_gives_a_picture(
    positions: NDArray[np.float32],
    normals: NDArray[np.float32],
    tangents: NDArray[np.float32],
    uv: NDArray[np.float32],
    faces: NDArray[np.uint32],
    numbers: NDArray[np.float32],
    mode: str,
    shiny: bool,
) -> None:
    """Degenerate faces, huge and tiny numbers in every place: a picture, the same for any number of threads."""
    a, b, c, d, e, f = numbers[0].tolist()
    bumpy = mt.TextureSlot(0, transform=np.array([[a, b, c], [d, 1, e]], np.float32))
    material = mt.Material(
        alpha_mode=mode, double_sided=shiny, base_color=(a, b, 1, c), roughness=d, metallic=e, shininess=f,
        model="metallic_roughness" if shiny else "phong", specular=(d, e, f), base_color_texture=bumpy,
        normal_texture=replace(bumpy, encoding="normal"), bump_texture=bumpy, bump_scale=f,
        layers=(mt.Layer(bumpy, "decal", after_light=shiny),),
    )  # fmt: skip
    mesh = mt.Mesh.build(positions, faces, uv=uv, material=material, images=[noise((5, 3, 4))])
    wild = replace(mesh, normals=_fit(normals, mesh), tangents=_fit(tangents, mesh))
    scene = mt.Scene(wild, lights=[mt.light.Point((a, b, c)), mt.light.Directional((0, 0.1, -1))])
    for camera in (scene.camera("auto", (11, 7)), mt.Camera((0, 0, 3))):
        keywords: dict[str, Any] = {"shadows": 8, "bump_curvature": shiny, "supersample": 2}
        pictures = [mt.render(scene, camera, (11, 7), threads=n, **keywords) for n in (1, 2)]
        assert pictures[0].shape == (7, 11, 4)
        np.testing.assert_array_equal(pictures[0], pictures[1])


def _fit(rows: NDArray[np.float32], mesh: mt.Mesh) -> NDArray[np.float32]:
    """As many rows as the mesh has vertices: building splits some."""
    return np.resize(rows, (len(mesh.positions), rows.shape[1]))
