"""Panoramas against a function of direction: values, seams, poles, edges, rotations, refusals."""

import doctest
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import multum as mt
from multum import mapping, panorama

#: Form: options of the target, the map between directions and picture, width and height for 128 pixels a turn.
FORMS: dict[str, tuple[dict[str, Any], mapping.Mapping, tuple[int, int]]] = {
    "equirect": ({}, mapping.Equirect(), (128, 64)),
    "cube": ({"layout": "cross"}, mapping.Cube("cross"), (128, 96)),
    "perspective": ({"fov": 100}, mapping.Perspective(100, 1.5), (48, 32)),
    "fisheye": ({"fov": 200, "model": "equisolid"}, mapping.Fisheye("equisolid", 200), (96, 96)),
    "probe": ({}, mapping.LightProbe(), (128, 128)),
    "mirror_ball": ({}, mapping.MirrorBall(), (128, 128)),
    "stereographic": ({"fov": 250}, mapping.Stereographic(250), (96, 96)),
    "dual_paraboloid": ({}, mapping.DualParaboloid(), (128, 64)),
    "octahedral": ({}, mapping.Octahedral(), (64, 64)),
}
TURN = Rotation.from_euler("xyz", [20, -35, 50], degrees=True)


def smooth(d: NDArray[Any]) -> NDArray[Any]:
    """A smooth function of direction without symmetry, in [0, 1]."""
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    waves = np.sin(2 * x + 1) + np.cos(3 * y - 0.5 * z) + np.sin(2.5 * z - x * y + 0.3)
    return np.asarray(0.5 + waves / 6)


def directions(name: str, size: tuple[int, int], parts: int = 1) -> NDArray[np.float64]:
    m: Any = FORMS[name][1]
    w, h = size[0] * parts, size[1] * parts
    x, y = np.meshgrid((np.arange(w) + 0.5) / w, (np.arange(h) + 0.5) / h)
    return np.asarray(m.inverse(np.stack([x, y], -1)))


def picture(name: str, size: tuple[int, int], parts: int = 4) -> NDArray[np.float64]:
    """Pixel means of the smooth function, which goes on around the picture of a form with corners."""
    values = smooth(directions(name, size, parts))
    blocks = values.reshape(size[1], parts, size[0], parts).swapaxes(1, 2)
    return np.asarray(np.nanmean(blocks, (2, 3)))


def turned(d: NDArray[Any]) -> NDArray[np.float64]:
    """Directions of the target as the source sees them; any where there is none."""
    return np.asarray(TURN.apply(np.nan_to_num(d, nan=1.0).reshape(-1, 3)).reshape(d.shape))


def size_of(name: str, size: tuple[int, int]) -> Any:
    return size[0] // 4 if name == "cube" else size


@pytest.mark.filterwarnings("ignore:Mean of empty slice")
@pytest.mark.parametrize("source", ["equirect", "cube", "octahedral", "dual_paraboloid"])
@pytest.mark.parametrize("target", list(FORMS))
def test_every_form_from_every_full_form(source: str, target: str) -> None:
    source_options, _, source_size = FORMS[source]
    options, _, size = FORMS[target]
    given = np.nan_to_num(picture(source, (source_size[0] * 4, source_size[1] * 4), 1), nan=0.5)
    got = panorama.convert(
        given,
        source,
        target,
        size_of(target, size),
        TURN.as_matrix(),
        **{"source_" + k: v for k, v in source_options.items()},
        **options,
    )
    assert got.dtype == np.float64
    d = directions(target, size, 4)
    turned = TURN.apply(np.nan_to_num(d, nan=1.0).reshape(-1, 3)).reshape(d.shape)
    truth = np.where(np.isnan(d[..., 0]), np.nan, smooth(turned))
    blocks = truth.reshape(size[1], 4, size[0], 4).swapaxes(1, 2)
    full = ~np.isnan(blocks).any((2, 3))
    error = np.abs(got - np.nanmean(blocks, (2, 3)))[full]
    # Around the rims of discs, whose outside is no picture, single pixels mix with it.
    limit = 1.0 if source == "dual_paraboloid" else 0.03
    assert error.max() < limit
    assert np.sqrt(np.mean(error**2)) < (0.02 if limit == 1 else 0.004)
    middle = np.isnan(directions(target, size)[..., 0])
    assert np.all(got[middle] == 0)


@pytest.mark.filterwarnings("ignore:Mean of empty slice")
@pytest.mark.parametrize("target", ["cube", "equirect"])
@pytest.mark.parametrize("source", ["equirect", "cube"])
@pytest.mark.parametrize("scale", [1, 4])
def test_no_line_at_seam_pole_or_edge(source: str, target: str, scale: int) -> None:
    options, _, size = FORMS[target]
    _, _, source_size = FORMS[source]
    given = np.nan_to_num(picture(source, (source_size[0] * scale, source_size[1] * scale), 2), nan=0.5)
    extra: dict[str, Any] = {"source_layout": "cross"} if source == "cube" else {}
    got = panorama.convert(given, source, target, size_of(target, size), TURN.as_matrix(), **extra, **options)
    d = directions(target, size, 4)
    turned = TURN.apply(np.nan_to_num(d, nan=1.0).reshape(-1, 3)).reshape(d.shape)
    blocks = np.where(np.isnan(d[..., 0]), np.nan, smooth(turned)).reshape(size[1], 4, size[0], 4)
    there = ~np.isnan(directions(target, size)[..., 0])
    truth = np.nan_to_num(blocks.swapaxes(1, 2).mean((2, 3)))
    error = np.abs(got - truth)
    middle = directions(target, size)
    place = TURN.apply(np.nan_to_num(middle, nan=1.0).reshape(-1, 3)).reshape(middle.shape)
    step = 2 * np.pi / 128
    if source == "equirect":
        seam = (np.abs(place[..., 0]) < step) & (place[..., 2] < 0)
        special = seam | (np.hypot(place[..., 0], place[..., 2]) < 2 * step)
    else:
        order = np.sort(np.abs(place), -1)
        special = (order[..., 2] - order[..., 1]) < step
    assert (special & there).sum() > 20
    rms = [np.sqrt(np.mean(error[mask & there] ** 2)) for mask in (special, ~special)]
    assert rms[0] < 1.5 * rms[1] + 1e-4


def test_forms_are_taken_and_given() -> None:
    rng = np.random.default_rng(1)
    faces = rng.integers(0, 255, (6, 8, 8, 3), dtype=np.uint8)
    same = panorama.convert(faces, "cube", "cube", 8)
    assert np.array_equal(same, faces)
    stacked = panorama.convert(faces.reshape(48, 8, 3), "cube", "cube", 8, source_layout="stacked")
    assert np.array_equal(stacked, faces)
    strip = panorama.convert(faces, "cube", "cube", 8, layout="strip")
    assert np.array_equal(strip, np.concatenate(list(faces), 1))
    cross = panorama.convert(faces, "cube", "cube", 8, layout="cross", border=9)
    assert np.array_equal(cross[8:16, 8:16], faces[4])
    assert np.array_equal(cross[:8, 8:16], faces[2])
    assert (cross[:8, :8] == 9).all()
    back = panorama.convert(cross, "cube", "cube", 8, source_layout="cross")
    assert np.array_equal(back, faces)
    wide = rng.random((16, 32)).astype(np.float32)
    assert np.allclose(panorama.convert(wide, "equirect", "equirect", (32, 16)), wide, atol=0.35)
    assert panorama.convert(wide).shape == (6, 8, 8)
    assert panorama.convert(wide, target="perspective", size=(7, 5), fov=90).shape == (5, 7)
    assert panorama.convert(wide, target="equirect", size=20).shape == (10, 20)


def test_dtypes_alpha_and_threads() -> None:
    rng = np.random.default_rng(2)
    for dtype in (np.uint8, np.uint16, np.float16, np.float32, np.float64):
        flat = np.full((16, 32, 3), 100, dtype)
        got = panorama.convert(flat, target="probe", size=16, border=100)
        assert got.dtype == dtype
        assert (got == 100).all()
    image = rng.random((32, 64, 4)).astype(np.float32)
    image[..., 3] = 1
    one = panorama.convert(image, size=64, alpha="straight", threads=1)
    assert np.array_equal(one, panorama.convert(image, size=64, alpha="straight", threads=3))
    assert np.allclose(one[..., 3], 1)
    # Hidden colour never shows, over the pole too.
    image[:, :32, :3], image[:, :32, 3] = [1, 0, 0], 0
    image[:, 32:, :3] = [0, 1, 0]
    got = panorama.convert(image, size=8, alpha="straight")
    assert got[got[..., 3] > 1e-3][..., 0].max() < 1e-3


def test_orientation() -> None:
    """A dot right of forward and above is found there in every form."""
    d = np.array([0.5, 0.6, 0.8]) / np.linalg.norm([0.5, 0.6, 0.8])
    uv = mapping.Equirect()(d)
    image = np.zeros((128, 256))
    image[int(uv[1] * 128) - 2 : int(uv[1] * 128) + 3, int(uv[0] * 256) - 2 : int(uv[0] * 256) + 3] = 1
    for name, (options, m, size) in FORMS.items():
        got = panorama.convert(image, "equirect", name, size_of(name, size), **options)
        y, x = np.unravel_index(np.argmax(got), got.shape)
        expected = np.array(m(d)) * [got.shape[1], got.shape[0]]
        assert np.abs(expected - [x + 0.5, y + 0.5]).max() < 2.5, name


IMAGE = np.zeros((8, 16), np.uint8)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: panorama.convert(IMAGE, "flat"), "source"),
        (lambda: panorama.convert(IMAGE, target="flat"), "target"),
        (lambda: panorama.convert(IMAGE, size=0), "size"),
        (lambda: panorama.convert(IMAGE, size=(4, 5)), "size"),
        (lambda: panorama.convert(IMAGE, fov=90), "fov"),
        (lambda: panorama.convert(IMAGE, target="perspective", fov=180), "fov"),
        (lambda: panorama.convert(IMAGE, "cube"), "image"),
        (lambda: panorama.convert(IMAGE, "cube", source_layout="cross"), "image"),
        (lambda: panorama.convert(IMAGE, layout="dice"), "layout"),
        (lambda: panorama.convert(IMAGE, target="fisheye", model="wide"), "model"),
        (lambda: panorama.convert(IMAGE, rotation=np.ones((3, 3))), "rotation"),
        (lambda: panorama.convert(IMAGE, rotation=np.eye(2)), "rotation"),
        (lambda: panorama.convert(np.zeros(4)), "image"),
        (lambda: panorama.convert(IMAGE, filter="best"), "filter"),
    ],
)
def test_refusals(call: Callable[[], object], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        call()


def test_docstrings() -> None:
    assert doctest.testmod(panorama).failed == 0
    assert mt.panorama is panorama


@pytest.mark.parametrize("call", ["size=2048", "target='equirect', size=(8192, 4096), rotation=turn"])
def test_rows_in_bands_keep_memory_flat(call: str) -> None:
    """8192 x 4096: beyond source, result and levels, megabytes, as a process of its own sees them."""
    code = """
import resource
import numpy as np
import multum as mt

sky = np.zeros((4096, 8192), np.uint8)
sky += (np.arange(4096) % 256).astype(np.uint8)[:, None]
turn = mt.panorama.rotation(20, 35, 10)
mt.panorama.convert(sky[:64, :128].copy(), size=8)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
made = mt.panorama.convert(sky, CALL, threads=2)
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print((after - before) * 1024 - made.nbytes)
"""
    code = code.replace("CALL", call)
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    extra = int(run.stdout)
    # A third of the source for levels, the rows next to the poles, and what the threads hold.
    assert extra < 40e6


@pytest.mark.parametrize("target", list(FORMS))
def test_means_are_those_of_the_interpolated_picture(target: str) -> None:
    """White noise in floats against many points a pixel: at most a third of what one point a pixel misses."""
    rng = np.random.default_rng(5)
    noise = rng.random((64, 128))
    # Some smoothness, as pictures have: texels share half of their variance with their neighbours.
    for axis in (0, 1):
        noise = (noise + np.roll(noise, 1, axis)) / 2
    options, m, (w, h) = FORMS[target]
    m_: Any = m
    got = panorama.convert(noise, "equirect", target, size_of(target, (w, h)), TURN.as_matrix(), **options)
    k = 8
    x, y = np.meshgrid((np.arange(w * k) + 0.5) / (w * k), (np.arange(h * k) + 0.5) / (h * k))
    d = m_.inverse(np.stack([x, y], -1))
    sky = mt.SphereTexture(noise)
    values = sky.sample(turned(d), filter="bilinear")[..., 0]
    values = np.where(np.isnan(d[..., 0]), np.nan, values).reshape(h, k, w, k)
    truth = values.swapaxes(1, 2).reshape(h, w, k * k)
    inside = ~np.isnan(truth).any(-1)
    truth = truth.mean(-1)
    centre = directions(target, (w, h))
    point = sky.sample(turned(centre), filter="bilinear")[..., 0]
    errors = [float(np.sqrt(np.mean((a - truth)[inside] ** 2))) for a in (got, point)]
    assert errors[0] < errors[1] / 3


def test_bilinear_is_the_value_at_the_centre() -> None:
    noise = np.random.default_rng(6).random((64, 128))
    for target, (options, _, (w, h)) in FORMS.items():
        got = panorama.convert(
            noise, "equirect", target, size_of(target, (w, h)), TURN.as_matrix(), filter="bilinear", **options
        )
        centre = directions(target, (w, h))
        there = ~np.isnan(centre[..., 0])
        d = turned(centre)
        # Over the poles the texture goes on; the conversion of single points ends at the outermost row.
        inner = there & (np.abs(d[..., 1]) < np.cos(np.pi / 64))
        want = mt.Texture(noise, wrap=("repeat", "clamp")).sample(mapping.Equirect()(d), filter="bilinear")
        # Polynomials follow the map to 1/128 texel along each axis, more or less, and texels differ by up to 1.
        assert np.abs(got - want[..., 0])[inner].max() < 0.05, target


def test_progress_is_told_and_ends_the_work() -> None:
    image = np.zeros((512, 1024), np.uint8)
    told: list[float] = []
    panorama.convert(image, target="equirect", size=2048, rotation=TURN.as_matrix(), progress=told.append)
    assert len(told) > 1
    assert all(0 < done <= 1 for done in told)

    def stop(done: float) -> None:
        raise RuntimeError(f"stopped at {done}")

    with pytest.raises(RuntimeError, match="stopped"):
        panorama.convert(image, target="equirect", size=2048, rotation=TURN.as_matrix(), progress=stop)
