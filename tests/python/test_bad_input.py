"""Bad input: the right exception, whose message names the argument. Odd arrays: the right answer."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt

Array = NDArray[Any]
IMAGE = np.arange(8 * 9 * 3, dtype=np.uint8).reshape(8, 9, 3)
TEXTURE = mt.Texture(IMAGE)
bad: Any = None
TRIANGLE = mt.Mesh.build([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])

IMAGES: list[tuple[type[Exception], Any]] = [
    (ValueError, np.zeros((0, 5), np.uint8)),
    (ValueError, np.zeros((5, 0, 3), np.uint8)),
    (ValueError, np.zeros((5, 5, 0), np.uint8)),
    (ValueError, np.zeros(5, np.uint8)),
    (ValueError, np.zeros((2, 2, 2, 2), np.uint8)),
    (TypeError, np.zeros((2, 2), object)),
    (TypeError, np.zeros((2, 2), complex)),
    (TypeError, np.zeros((2, 2), np.int32)),
    (TypeError, np.zeros((2, 2), bool)),
    (TypeError, np.zeros((2, 2), "datetime64[s]")),
    (TypeError, np.zeros((2, 2), "U3")),
    (TypeError, np.zeros((2, 2), [("a", np.uint8)])),
]


@pytest.mark.parametrize(("error", "image"), IMAGES)
@pytest.mark.parametrize(
    "call",
    [
        lambda image: mt.Texture(image),
        lambda image: mt.warp(image, np.eye(3), shape=(3, 3)),
        lambda image: mt.resize(image, (3, 3)),
        lambda image: mt.remap(image, np.zeros((3, 3)), np.zeros((3, 3))),
        lambda image: mt.build_pyramid(image),
    ],
)
def test_images(call: Callable[[Any], object], error: type[Exception], image: Any) -> None:
    with pytest.raises(error, match=r"^image: got "):
        call(image)


@pytest.mark.parametrize("image", [None, "picture.png", 3.0, {}])
def test_things_that_are_no_images(image: Any) -> None:
    with pytest.raises((TypeError, ValueError), match=r"^image: got "):
        mt.Texture(image)


CASES: list[tuple[str, type[Exception], Callable[[], object]]] = [
    ("meshes", TypeError, lambda: mt.Mesh.join(["mesh"])),  # type: ignore[list-item]
    ("meshes", TypeError, lambda: mt.Mesh.join(bad)),
    ("matrix", TypeError, lambda: TRIANGLE.moved("turn")),
    ("matrix", ValueError, lambda: TRIANGLE.moved(np.full((4, 4), np.nan))),
    ("fov", TypeError, lambda: mt.Camera((0, 0, 3), fov="wide")),  # type: ignore[arg-type]
    ("degrees", TypeError, lambda: mt.Camera((0, 0, 3)).turned("half")),  # type: ignore[arg-type]
    ("mesh", TypeError, lambda: mt.unwrap.flatten(bad)),
    ("mesh", TypeError, lambda: mt.unwrap.metrics(bad)),
    ("mesh", TypeError, lambda: mt.unwrap.heat_map(bad)),
    ("mesh", TypeError, lambda: mt.unwrap.checkerboard(bad)),
    ("method", TypeError, lambda: TRIANGLE.unwrap(method=bad)),
    ("rotation", TypeError, lambda: mt.panorama.convert(IMAGE, rotation="turn")),
    ("rotation", ValueError, lambda: mt.panorama.convert(IMAGE, rotation=np.full((3, 3), np.inf))),
    ("fov", TypeError, lambda: mt.panorama.convert(IMAGE, fov="wide")),  # type: ignore[arg-type]
    ("size", ValueError, lambda: mt.panorama.convert(IMAGE, size=2**62)),
    ("size", ValueError, lambda: mt.panorama.convert(IMAGE, size=(2**62, 2**62))),
    ("size", TypeError, lambda: mt.panorama.convert(IMAGE, size=np.inf)),  # type: ignore[arg-type]
    ("size", TypeError, lambda: mt.panorama.convert(IMAGE, size=(np.inf, 4))),  # type: ignore[arg-type]
    ("rotation", TypeError, lambda: mt.panorama.convert(IMAGE, rotation=10**400)),
    ("border", TypeError, lambda: mt.panorama.convert(IMAGE, border=10**400)),
    ("border", TypeError, lambda: mt.SphereTexture(IMAGE, border=10**400)),
    ("center", TypeError, lambda: mt.mapping.Spherical(center=(10**400, 0, 0))),
    ("cells", TypeError, lambda: mt.mapping.checkerboard([0.0, 0.0], 10**400)),
    ("values", TypeError, lambda: mt.mapping.distortion_picture([[10**400]])),
    ("lod", TypeError, lambda: mt.SphereTexture(IMAGE).sample([0.0, 0, 1], lod="fine")),
    ("target", TypeError, lambda: mt.panorama.convert(IMAGE, target=np.zeros(2))),  # type: ignore[arg-type]
    ("wrap", ValueError, lambda: mt.Texture(IMAGE, wrap="tile")),
    ("wrap", TypeError, lambda: mt.Texture(IMAGE, wrap=("repeat", "clamp", "clamp"))),
    ("wrap", TypeError, lambda: mt.Texture(IMAGE, wrap=bad)),
    ("border", ValueError, lambda: mt.Texture(IMAGE, border=[1, 2])),
    ("border", ValueError, lambda: mt.Texture(IMAGE, border=np.nan)),
    ("border", TypeError, lambda: mt.Texture(IMAGE, border="x")),  # type: ignore[arg-type]
    ("encoding", ValueError, lambda: mt.Texture(IMAGE, encoding="gamma")),
    ("encoding", TypeError, lambda: mt.Texture(IMAGE, encoding=bad)),
    ("encoding", ValueError, lambda: mt.Texture(IMAGE[..., 0], encoding="normal")),
    ("alpha", ValueError, lambda: mt.Texture(IMAGE, alpha="straight")),
    ("alpha", ValueError, lambda: mt.Texture(IMAGE, alpha="yes")),
    ("pyramid", ValueError, lambda: mt.Texture(IMAGE, pyramid="gauss")),
    ("coverage", ValueError, lambda: mt.Texture(IMAGE, coverage=0.5)),
    ("coverage", TypeError, lambda: mt.Texture(IMAGE, coverage="x")),  # type: ignore[arg-type]
    ("image", ValueError, lambda: mt.Texture(IMAGE[:2], wrap="extend")),
    ("level", ValueError, lambda: TEXTURE.level(4)),
    ("level", ValueError, lambda: TEXTURE.level(-1)),
    ("level", ValueError, lambda: TEXTURE.level(2**80)),
    ("level", TypeError, lambda: TEXTURE.level(1.0)),  # type: ignore[arg-type]
    ("uv", ValueError, lambda: TEXTURE.sample(np.zeros(3))),
    ("uv", ValueError, lambda: TEXTURE.sample(5)),
    ("uv", TypeError, lambda: TEXTURE.sample(np.zeros((3, 2), complex))),
    ("uv", TypeError, lambda: TEXTURE.sample(np.zeros((3, 2), object))),
    ("uv", ValueError, lambda: TEXTURE.sample("xy")),
    ("uv", ValueError, lambda: TEXTURE.gradient(np.zeros((2, 3)))),
    ("jacobian", ValueError, lambda: TEXTURE.sample([[0, 0]], np.eye(3))),
    ("jacobian", ValueError, lambda: TEXTURE.sample(np.zeros((3, 2)), np.zeros((4, 2, 2)))),
    ("jacobian", TypeError, lambda: TEXTURE.sample([0, 0], np.eye(2) * 1j)),
    ("lod", ValueError, lambda: TEXTURE.sample([[0, 0]], lod=[1, 2, 3])),
    ("lod", TypeError, lambda: TEXTURE.sample([[0, 0]], lod="x")),
    ("lod", ValueError, lambda: TEXTURE.sample([0, 0], np.eye(2), lod=1.0)),
    ("lod_bias", ValueError, lambda: TEXTURE.sample([0, 0], lod_bias=np.nan)),
    ("lod_bias", TypeError, lambda: TEXTURE.sample([0, 0], lod_bias="x")),  # type: ignore[arg-type]
    ("lod_rule", ValueError, lambda: TEXTURE.sample([0, 0], lod_rule="minor")),
    ("filter", ValueError, lambda: TEXTURE.sample([0, 0], filter="cubic")),
    ("filter", TypeError, lambda: TEXTURE.sample([0, 0], filter=3)),  # type: ignore[arg-type]
    ("filter", ValueError, lambda: TEXTURE.gradient([0, 0], filter="nearest")),
    ("max_anisotropy", ValueError, lambda: TEXTURE.sample([0, 0], max_anisotropy=0.5)),
    ("max_anisotropy", ValueError, lambda: TEXTURE.sample([0, 0], max_anisotropy=np.nan)),
    ("max_anisotropy", TypeError, lambda: TEXTURE.sample([0, 0], max_anisotropy="x")),  # type: ignore[arg-type]
    ("tolerance", ValueError, lambda: TEXTURE.sample([0, 0], tolerance=-1)),
    ("tolerance", ValueError, lambda: TEXTURE.sample([0, 0], tolerance=np.nan)),
    ("seed", ValueError, lambda: TEXTURE.sample([0, 0], seed=-1)),
    ("seed", TypeError, lambda: TEXTURE.sample([0, 0], seed=0.5)),  # type: ignore[arg-type]
    ("threads", ValueError, lambda: TEXTURE.sample([0, 0], threads=0)),
    ("threads", ValueError, lambda: TEXTURE.sample([0, 0], threads=2**80)),
    ("threads", ValueError, lambda: mt.set_num_threads(-1)),
    ("out", TypeError, lambda: TEXTURE.sample([0, 0], out=np.zeros(3))),
    ("out", ValueError, lambda: TEXTURE.sample([0, 0], out=np.zeros(4, np.float32))),
    ("out", TypeError, lambda: TEXTURE.sample([0, 0], out=[0.0] * 3)),  # type: ignore[arg-type]
    ("out", ValueError, lambda: TEXTURE.sample(np.zeros((2, 2)), out=np.zeros((2, 6), np.float32)[:, ::2])),
    ("out", ValueError, lambda: mt.resize(IMAGE, (8, 9), out=IMAGE)),
    ("shape", TypeError, lambda: mt.resize(IMAGE, bad)),
    ("shape", TypeError, lambda: mt.resize(IMAGE, (2.5, 3))),  # type: ignore[arg-type]
    ("shape", ValueError, lambda: mt.resize(IMAGE, (0, 3))),
    ("shape", ValueError, lambda: mt.resize(IMAGE, (-1, 3))),
    ("shape", ValueError, lambda: mt.resize(IMAGE, (2**31, 1))),
    ("shape", ValueError, lambda: mt.resize(IMAGE, (2**80, 1))),
    ("shape", ValueError, lambda: mt.resize(IMAGE, (2**20, 2**20))),
    ("shape", ValueError, lambda: mt.warp(IMAGE, np.zeros((4, 4, 2)), shape=(3, 3))),
    ("mapping", ValueError, lambda: mt.warp(IMAGE, bad)),
    ("mapping", ValueError, lambda: mt.warp(IMAGE, np.eye(2))),
    ("mapping", ValueError, lambda: mt.warp(IMAGE, np.array([[1, 0, np.nan], [0, 1, 0]]))),
    ("mapping", TypeError, lambda: mt.warp(IMAGE, np.eye(3, dtype=object))),
    ("mapping", TypeError, lambda: mt.warp(IMAGE, np.eye(3) * 1j)),
    ("mapping", TypeError, lambda: mt.warp(IMAGE, np.zeros((3, 3, 2), object))),
    ("mapping", ValueError, lambda: mt.warp(IMAGE, np.zeros((3, 3, 3)))),
    ("mapping", ValueError, lambda: mt.warp(IMAGE, lambda p: p[:3])),
    ("mapping", TypeError, lambda: mt.warp(IMAGE, lambda p: p.astype(complex))),
    ("map_y", ValueError, lambda: mt.remap(IMAGE, np.zeros((2, 2)), np.zeros((3, 2)))),
    ("map_x", TypeError, lambda: mt.remap(IMAGE, np.zeros((2, 2), complex), np.zeros((2, 2), complex))),
    ("wrap", ValueError, lambda: mt.warp(IMAGE, np.eye(3), wrap="extend")),
]


@pytest.mark.parametrize(
    ("argument", "error", "call"), CASES, ids=[f"{i}-{c[0]}" for i, c in enumerate(CASES)]
)
def test_the_message_names_the_argument(
    argument: str, error: type[Exception], call: Callable[[], object]
) -> None:
    with pytest.raises(error, match=rf"^{re.escape(argument)}: got .*expected "):
        call()


def test_an_output_that_may_not_be_written() -> None:
    locked = np.zeros((2, 3), np.float32)
    locked.flags.writeable = False
    with pytest.raises(ValueError, match=r"^out: "):
        TEXTURE.sample(np.zeros((2, 2)), out=locked)


def test_results_beyond_memory_are_refused() -> None:
    """In a process of its own: a failed allocation would end it."""
    code = (
        "import multum as mt, numpy as np\n"
        "for call in (lambda: mt.resize(np.zeros((8, 8), np.float64), (2**20, 2**19)),\n"
        "             lambda: mt.warp(np.zeros((8, 8), np.uint8), np.eye(3), (2**20, 2**20))):\n"
        "    try:\n        call()\n    except (ValueError, MemoryError) as e:\n        print(type(e).__name__, e)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.count("shape: got") == 2


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16", "float32", "float64"])
def test_any_memory_order_is_read_right(dtype: str) -> None:
    rng = np.random.default_rng(0)
    base = rng.integers(0, 200, (10, 14, 3)).astype(dtype)
    locked = base.copy()
    locked.flags.writeable = False
    views = [
        (np.asfortranarray(base), base),
        (base[::-1, ::-2, ::-1], base[::-1, ::-2, ::-1].copy()),
        (base[::3, 1::2], base[::3, 1::2].copy()),
        (base.transpose(1, 0, 2), base.transpose(1, 0, 2).copy()),
        (np.broadcast_to(base[:1], base.shape), np.broadcast_to(base[:1], base.shape).copy()),
        (base.astype(np.dtype(dtype).newbyteorder(">")), base),
        (locked, base),
    ]
    offset = np.zeros(base.nbytes + 1, np.uint8)[1:].view(np.uint8)
    unaligned = np.frombuffer(b"x" + base.tobytes(), np.uint8)[1:]
    assert offset.nbytes == unaligned.nbytes == base.nbytes
    views.append((np.ndarray(base.shape, dtype, b"x" + base.tobytes(), offset=1), base))
    uv = rng.uniform(-1, 2, (30, 2))
    for odd, plain in views:
        np.testing.assert_array_equal(mt.Texture(odd).sample(uv), mt.Texture(plain).sample(uv))
        np.testing.assert_array_equal(mt.resize(odd, (7, 5)), mt.resize(plain, (7, 5)))


def test_any_order_of_coordinates_is_read_right() -> None:
    rng = np.random.default_rng(1)
    uv, jacobian = rng.random((6, 8, 2)), rng.normal(0, 0.2, (6, 8, 2, 2))
    want = TEXTURE.sample(uv, jacobian)
    for order in (
        lambda a: np.asfortranarray(a),
        lambda a: a.astype(">f8"),
        lambda a: a[::-1][::-1],
        lambda a: np.repeat(a, 2, axis=1)[:, ::2],
    ):
        np.testing.assert_array_equal(TEXTURE.sample(order(uv), order(jacobian)), want)
    np.testing.assert_array_equal(TEXTURE.sample(uv[::-1, ::-1], jacobian[::-1, ::-1]), want[::-1, ::-1])
    # Whole numbers are numbers; mixed precisions are both read.
    np.testing.assert_array_equal(TEXTURE.sample([0, 1]), TEXTURE.sample([0.0, 1.0]))
    single = TEXTURE.sample(uv.astype(np.float32), jacobian)
    np.testing.assert_array_equal(single, TEXTURE.sample(uv.astype(np.float32).astype(np.float64), jacobian))


def test_shapes_of_batches() -> None:
    for shape in ((), (0,), (1,), (3, 0, 2), (2, 3, 4, 5)):
        assert TEXTURE.sample(np.zeros((*shape, 2))).shape == (*shape, 3)
        assert TEXTURE.gradient(np.zeros((*shape, 2))).shape == (*shape, 3, 2)
    out = np.empty((4, 3), np.float32)
    assert TEXTURE.sample(np.zeros((4, 2)), out=out) is out


def test_rows_and_columns_are_not_mixed_up() -> None:
    """Every call on a 3 x 5 image."""
    image = np.arange(15, dtype=np.float64).reshape(3, 5)
    texture = mt.Texture(image)
    assert (texture.width, texture.height, texture.num_levels) == (5, 3, 3)
    assert texture.level(1).shape == (1, 2)
    assert texture.sample([4.5 / 5, 0.5 / 3], filter="nearest") == 4
    assert texture.sample([0.5 / 5, 2.5 / 3], filter="nearest") == 10
    np.testing.assert_allclose(texture.gradient([0.5, 0.5]), [[5, 15]])
    assert mt.resize(image, (6, 2)).shape == (6, 2)
    assert mt.warp(image, np.eye(3)).shape == (3, 5)
    np.testing.assert_array_equal(
        mt.warp(image, [[1, 0, 1], [0, 1, 0]], filter="nearest")[:, :4], image[:, 1:]
    )
    x, y = np.meshgrid(np.arange(5.0), np.arange(3.0))
    np.testing.assert_array_equal(mt.remap(image, x, y), image)
    assert [level.shape for level in mt.build_pyramid(image)] == [(3, 5), (1, 2), (1, 1)]


def test_an_overlapping_output_is_refused_and_a_copied_input_is_not() -> None:
    image = IMAGE.copy()
    for view in (image, image[:, :, :]):
        with pytest.raises(ValueError, match=r"^out: "):
            mt.resize(image, (8, 9), out=view)
    # A reversed input is copied first, so that the result may replace it.
    want = mt.warp(IMAGE[::-1], np.eye(3))
    np.testing.assert_array_equal(want, IMAGE[::-1])
