"""Threads beside those of others: small calls make none, workers of dask and joblib do not add up to more."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt

TASKS = Path("/proc/self/task")

CODE = """
import sys
from pathlib import Path
import numpy as np
import multum as mt
from multum.compat import cv2, skimage, torch

def threads():
    return sum((task / "comm").read_text().startswith("multum") for task in Path("/proc/self/task").iterdir())

side = int(sys.argv[1])
image = np.zeros((side, side, 3), np.uint8)
y, x = np.mgrid[:side, :side].astype(np.float32)
uv = np.stack([x, y], -1) / side
jacobian = np.broadcast_to(np.eye(2) * 3 / side, (side, side, 2, 2))
turn = np.array([[0.9, 0.4, 1.0], [-0.4, 0.9, 9.0], [0.0, 0.0, 1.0]])
calls = {
    "texture": lambda: mt.Texture(image, "repeat").sample(uv, jacobian, filter="trilinear"),
    "area": lambda: mt.Texture(image, "repeat").sample(uv, jacobian, filter="area"),
    "auto": lambda: mt.Texture(image, "repeat").sample(uv, jacobian),
    "within": lambda: mt.Texture(image, "repeat").sample(uv, jacobian, tolerance=0.01),
    "gradient": lambda: mt.Texture(image).gradient(uv),
    "pyramid": lambda: mt.build_pyramid(image, encoding="srgb"),
    "table": lambda: mt.SummedAreaTable(image),
    "warp": lambda: mt.warp(image, turn, (side, side)),
    "resize": lambda: mt.resize(image, (side, side // 2)),
    "remap": lambda: mt.remap(image, x, y),
    "panorama": lambda: mt.panorama.convert(image, source="equirect", target="fisheye", size=side),
    "cv2.remap": lambda: cv2.remap(image, x, y, cv2.INTER_LINEAR),
    "cv2.remap cubic": lambda: cv2.remap(image, x, y, cv2.INTER_CUBIC),
    "cv2.warpAffine": lambda: cv2.warpAffine(image, turn[:2], (side, side)),
    "cv2.resize": lambda: cv2.resize(image, (side // 2, side // 2), interpolation=cv2.INTER_AREA),
    "cv2.pyrDown": lambda: cv2.pyrDown(image),
    "cv2.integral": lambda: cv2.integral(image),
    "skimage.warp": lambda: skimage.warp(image, turn),
    "skimage.rescale": lambda: skimage.rescale(image, 0.37, anti_aliasing=True, channel_axis=-1),
    "torch.grid_sample": lambda: torch.grid_sample(
        np.zeros((1, 3, side, side), np.float32), (2 * uv - 1).astype(np.float32)[None], align_corners=False
    ),
}
made = []
for name, call in calls.items():
    before = threads()
    call()
    if threads() > before:
        made.append(name)
print(",".join(made))
"""


def pools(side: int) -> list[str]:
    """The first calls that make threads, each in the order of the list above."""
    environment = os.environ | {"MULTUM_NUM_THREADS": "2"}
    run = subprocess.run(
        [sys.executable, "-c", CODE, str(side)], env=environment, capture_output=True, text=True, check=True
    )
    return run.stdout.strip().split(",")


@pytest.mark.skipif(not TASKS.exists(), reason="counts threads by /proc")
def test_calls_of_less_than_ten_thousand_pixels_make_no_threads() -> None:
    assert pools(99) == [""]


@pytest.mark.skipif(not TASKS.exists(), reason="counts threads by /proc")
def test_larger_calls_do() -> None:
    assert pools(400) == ["texture"]


def own_threads() -> int:
    """Threads of the module's pool."""
    return sum((task / "comm").read_text().startswith("multum") for task in TASKS.iterdir())


def warped(block: NDArray[Any]) -> NDArray[Any]:
    return mt.warp(block, [[0.9, 0.4, 1.0], [-0.4, 0.9, 9.0]], (500, 500))


@pytest.mark.skipif(not TASKS.exists(), reason="counts threads by /proc")
def test_workers_of_dask_share_one_pool() -> None:
    array = pytest.importorskip("dask.array")
    image = np.random.default_rng(0).integers(0, 256, (4000, 500), np.uint8)
    mt.set_num_threads(2)
    try:
        blocks = array.from_array(image, chunks=(500, 500)).map_blocks(warped)
        got = blocks.compute(scheduler="threads", num_workers=8)
        # A pool is never made smaller: what other tests of this process asked for is still there.
        before = own_threads()
        again = blocks.compute(scheduler="threads", num_workers=8)
        assert own_threads() == before
        mt.set_num_threads(1)
        want = np.concatenate([warped(part) for part in np.split(image, 8)])
    finally:
        mt.set_num_threads(None)
    np.testing.assert_array_equal(got, want)
    np.testing.assert_array_equal(again, want)


def limit_and_picture(image: NDArray[Any]) -> tuple[int, NDArray[Any]]:
    return mt.get_num_threads(), warped(image)


def test_workers_of_joblib_keep_to_what_they_are_told() -> None:
    joblib = pytest.importorskip("joblib")
    image = np.random.default_rng(1).integers(0, 256, (500, 500), np.uint8)
    with joblib.parallel_config(backend="loky", inner_max_num_threads=1):
        results = joblib.Parallel(n_jobs=2)(joblib.delayed(limit_and_picture)(image) for _ in range(2))
    for limit, picture in results:
        assert limit == 1
        np.testing.assert_array_equal(picture, warped(image))
