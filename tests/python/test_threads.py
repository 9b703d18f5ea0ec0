"""Threads, interrupts, memory, and the examples in the documentation."""

from __future__ import annotations

import doctest
import importlib
import inspect
import os
import pkgutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import multum as mt
from reference_numpy import Brute

Array = NDArray[Any]
FILTERS = ["nearest", "bilinear", "bicubic", "trilinear", "nearest_mipmap_linear", "anisotropic", "auto"]


def noise(shape: tuple[int, ...], dtype: str = "uint8") -> Array:
    return np.random.default_rng(0).integers(0, 256, shape).astype(dtype)


@pytest.mark.parametrize("filter", FILTERS)
def test_the_same_bytes_for_any_number_of_threads(filter: str) -> None:
    rng = np.random.default_rng(1)
    uv, jacobian = rng.uniform(-1, 2, (30_000, 2)), rng.normal(0, 0.05, (30_000, 2, 2))
    for dtype in ("uint8", "float32", "float64"):
        # Fresh textures: levels, too, are made with so many threads.
        results = []
        for threads in (1, 2, 7):
            mt.set_num_threads(threads)
            texture = mt.Texture(noise((65, 130, 3), dtype), "mirror")
            results.append(texture.sample(uv, jacobian, filter=filter).tobytes())
            mt.set_num_threads(None)
            again = texture.sample(uv, jacobian, filter=filter, threads=threads)
            assert again.tobytes() == results[0]
            # Any cutting of the batch, too.
            parts = [
                texture.sample(uv[i : i + 7001], jacobian[i : i + 7001], filter=filter)
                for i in range(0, 30_000, 7001)
            ]
            assert np.concatenate(parts).tobytes() == results[0]
        assert len(set(results)) == 1


def test_warps_and_gradients_are_the_same_bytes_for_any_number_of_threads() -> None:
    image = noise((200, 300, 3))
    matrix = [[1.9, 0.4, -30.0], [-0.7, 2.2, 14.0], [1e-4, 2e-4, 1.0]]
    y, x = np.mgrid[:211, :307].astype(np.float32)
    jobs: list[Callable[[int], Array]] = [
        lambda n: mt.warp(image, matrix, (211, 307), threads=n),
        lambda n: mt.warp(image, matrix, (211, 307), filter="bilinear", threads=n),
        lambda n: mt.remap(image, x * 1.3 + np.sin(y), y * 0.9, threads=n, wrap="mirror"),
        lambda n: mt.resize(image, (77, 401), threads=n),
        lambda n: mt.Texture(image).gradient(np.stack([x / 300, y / 200], -1), filter="bicubic", threads=n),
    ]
    for job in jobs:
        assert len({job(n).tobytes() for n in (1, 2, 7)}) == 1


def test_eight_threads_share_one_fresh_texture() -> None:
    """Levels are made once, and every thread sees whole ones."""
    uv, jacobian = np.random.default_rng(2).random((20_000, 2)), np.eye(2) * 0.02
    image = noise((512, 512, 4))
    want = mt.Texture(image, "repeat").sample(uv, jacobian)
    for _ in range(3):
        texture = mt.Texture(image, "repeat")
        before = texture.nbytes
        results: list[Array] = []
        start = threading.Barrier(8)

        def work(
            texture: mt.Texture = texture, start: threading.Barrier = start, results: list[Array] = results
        ) -> None:
            start.wait()
            results.append(texture.sample(uv, jacobian))

        workers = [threading.Thread(target=work) for _ in range(8)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        assert len(results) == 8
        for result in results:
            np.testing.assert_array_equal(result, want)
        # A third more, and the apron: not eight thirds.
        # A third more for the levels, and four bytes for 16 of their texels.
    assert before < texture.nbytes < 1.45 * before


def test_the_interpreter_goes_on_during_work() -> None:
    """Another Python thread counts while a long call runs."""
    texture = mt.Texture(noise((64, 64)), "repeat")
    uv = np.random.default_rng(3).random((2_000_000, 2))
    counted, stop = [0], threading.Event()

    def count() -> None:
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    before = counted[0]
    texture.sample(uv, filter="bicubic", threads=1)
    during = counted[0] - before
    stop.set()
    counter.join()
    assert during >= 5


@pytest.mark.parametrize("threads", [1, 2])
def test_control_c_ends_a_long_call(threads: int) -> None:
    texture = mt.Texture(noise((256, 256, 3)), "repeat")
    uv = np.broadcast_to(np.random.default_rng(4).random((1_000_000, 2)), (40, 1_000_000, 2))

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    out = np.zeros((40, 1_000_000, 3), np.float32)
    uv = np.ascontiguousarray(uv)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        start = time.monotonic()
        with pytest.raises(KeyboardInterrupt):
            texture.sample(uv, filter="bicubic", threads=threads, out=out)
        # Undisturbed the call takes many seconds.
        assert time.monotonic() - start < 2
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    # Nothing is left in a state: the same texture goes on.
    assert texture.sample([0.5, 0.5]).shape == (3,)


def test_absurd_thread_counts_do_no_harm() -> None:
    texture = mt.Texture(noise((16, 16)), "repeat")
    uv = np.zeros((4_000_000, 2), np.float32)
    want = texture.sample(uv[:1], filter="nearest")
    before = threading.active_count()
    got = texture.sample(uv, filter="nearest", threads=10**9)
    assert (got == want).all()
    assert threading.active_count() == before
    with open("/proc/self/status") as status:
        held = next(int(line.split()[1]) for line in status if line.startswith("Threads"))
    assert held < 300


def test_memory() -> None:
    """All levels of 4096 x 4096 RGB in at most 1.1 times 4/3 of it as RGBA, and none before they are needed."""
    texture = mt.Texture(np.zeros((4096, 4096, 3), np.uint8))
    base = 4096 * 4096 * 4
    assert texture.nbytes <= 1.1 * base
    texture.sample([0.5, 0.5], filter="bicubic")
    texture.sample([0.5, 0.5], filter="bilinear")
    assert texture.nbytes <= 1.1 * base
    texture.sample([0.5, 0.5], lod=12.0, filter="trilinear")
    assert base * 4 / 3 <= texture.nbytes <= 1.1 * 4 / 3 * base


def test_memory_of_other_types() -> None:
    for dtype, size in (("uint8", 1), ("uint16", 2), ("float16", 2), ("float32", 4), ("float64", 8)):
        for channels, lanes in ((1, 1), (2, 2), (3, 4), (4, 4)):
            texture = mt.Texture(np.zeros((1024, 512, channels), dtype))
            base = 1024 * 512 * lanes * size
            assert base <= texture.nbytes <= 1.1 * base
            texture.sample([0.5, 0.5], lod=3.0, filter="trilinear")
            assert texture.nbytes <= 1.1 * 4 / 3 * base


# What the chart measures beside multum where it is installed, and no test needs.
PEERS = {"moderngl", "OpenImageIO", "reproject"}


def modules() -> list[ModuleType]:
    found = [mt]
    for info in pkgutil.walk_packages(mt.__path__, "multum."):
        if info.name.rsplit(".", 1)[-1] == "__main__":
            continue
        try:
            found.append(importlib.import_module(info.name))
        except ModuleNotFoundError as error:
            if error.name not in PEERS:
                raise
    return found


@pytest.mark.parametrize("module", modules(), ids=lambda m: str(m.__name__))
def test_examples_in_docstrings(module: ModuleType) -> None:
    result = doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert result.failed == 0


def test_everything_public_is_documented() -> None:
    assert sorted(mt.__all__) == list(mt.__all__) or set(mt.__all__) <= set(dir(mt))
    for name in mt.__all__:
        thing = getattr(mt, name)
        if callable(thing):
            assert inspect.getdoc(thing), name


@settings(max_examples=150, deadline=None)
@given(
    st.integers(1, 9),
    st.integers(1, 9),
    st.sampled_from(["clamp", "repeat", "mirror", "mirror_once", "mirror_101", "border"]),
    st.sampled_from(["bilinear", "bicubic", "mitchell"]),
    st.tuples(st.floats(-20, 20), st.floats(-20, 20)),
)
def test_any_place_against_brute_force(
    width: int, height: int, mode: str, filter: str, uv: tuple[float, float]
) -> None:
    image = noise((height, width), "float64") / 255
    got = mt.Texture(image, mode, 0.5).sample(uv, filter=filter)
    want = Brute(image, mode, 0.5).sample(np.array([uv]), filter)[0]
    np.testing.assert_allclose(got, want, rtol=0, atol=1e-12)


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.floats(), min_size=2, max_size=2),
    st.lists(st.floats(), min_size=4, max_size=4),
    st.sampled_from(FILTERS),
    st.sampled_from(["clamp", "repeat", "mirror", "mirror_once", "mirror_101", "border", "extend"]),
    st.floats(allow_nan=False, allow_infinity=False, width=32),
)
def test_no_number_does_harm(
    uv: list[float], jacobian: list[float], filter: str, mode: str, bias: float
) -> None:
    texture = mt.Texture(noise((5, 6, 2), "float32") / 255, mode)
    got = texture.sample(uv, np.reshape(jacobian, (2, 2)), filter=filter, lod_bias=bias)
    assert np.isfinite(got).all()
    assert np.abs(got).max() <= 1.6
    assert np.isfinite(texture.sample(uv, lod=bias, filter=filter)).all()


@pytest.mark.parametrize(
    ("variables", "threads", "warned"),
    [
        ({"MULTUM_NUM_THREADS": "3", "OMP_NUM_THREADS": "1"}, 3, ""),
        ({"OMP_NUM_THREADS": "1"}, 1, ""),
        ({"OMP_NUM_THREADS": "5,2"}, 5, ""),
        ({"MULTUM_NUM_THREADS": "many"}, 0, "MULTUM_NUM_THREADS"),
        ({"MULTUM_SIMD": "scalar"}, 0, ""),
        ({"MULTUM_SIMD": "mmx"}, 0, "MULTUM_SIMD"),
    ],
)
def test_the_environment_sets_limits_or_is_said_to_be_wrong(
    variables: dict[str, str], threads: int, warned: str
) -> None:
    names = ("MULTUM_NUM_THREADS", "OMP_NUM_THREADS", "MULTUM_SIMD")
    environment = {k: v for k, v in os.environ.items() if k not in names}
    code = "import multum as mt; print(mt.get_num_threads())"
    run = subprocess.run(
        [sys.executable, "-c", code], env=environment | variables, capture_output=True, text=True, check=True
    )
    # Without a limit it is what the machine has.
    assert int(run.stdout) == threads if threads else int(run.stdout) >= 1
    assert ("RuntimeWarning" in run.stderr) == bool(warned)
    assert warned in run.stderr
