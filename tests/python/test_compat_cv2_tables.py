"""Pyramids, integrals and undistortion of the drop-in against OpenCV itself."""

import doctest
import importlib
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt

ours = mt.compat.cv2
Array = NDArray[Any]

DTYPES = (np.uint8, np.uint16, np.int16, np.float32, np.float64)
BORDERS = (ours.BORDER_REPLICATE, ours.BORDER_REFLECT, ours.BORDER_WRAP, ours.BORDER_REFLECT_101)
SIZES = ((1, 1), (1, 2), (2, 1), (1, 9), (3, 3), (2, 5), (4, 4), (7, 6), (17, 33), (70, 64))


def noise(seed: int, shape: tuple[int, ...], dtype: Any) -> Array:
    random = np.random.default_rng(seed)
    limits = {"u": (0, 2 ** (8 * np.dtype(dtype).itemsize)), "i": (-(2**15), 2**15), "f": (-1000, 1000)}
    low, high = limits[np.dtype(dtype).kind]
    values: Array = np.floor(random.random(shape) * (high - low) + low).astype(dtype)
    return values


def same(got: Array, want: Array, relative: float = 3e-6) -> None:
    """Integers are equal, floats to the rounding of sums."""
    assert got.shape == want.shape
    assert got.dtype == want.dtype
    if want.dtype.kind in "iu":
        assert np.array_equal(got, want)
    else:
        scale = max(1.0, float(np.abs(want).max(initial=0)))
        assert np.abs(got.astype(np.float64) - want).max(initial=0) <= relative * scale


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("channels", [1, 2, 3, 4, 6])
def test_pyr_down(dtype: type, channels: int) -> None:
    for seed, (h, w) in enumerate(SIZES):
        source = noise(seed, (h, w, channels), dtype)
        for border in BORDERS:
            same(ours.pyrDown(source, borderType=border), cv2.pyrDown(source, borderType=border))
        for dw in (-1, 0, 1):
            for dh in (-1, 0, 1):
                size = (w // 2 + dw, h // 2 + dh)
                if min(size) > 0 and abs(2 * size[0] - w) <= 2 and abs(2 * size[1] - h) <= 2:
                    same(ours.pyrDown(source, dstsize=size), cv2.pyrDown(source, dstsize=size))


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("channels", [1, 2, 3, 4, 6])
def test_pyr_up(dtype: type, channels: int) -> None:
    for seed, (h, w) in enumerate(SIZES):
        source = noise(seed, (h, w, channels), dtype)
        same(ours.pyrUp(source), cv2.pyrUp(source))
        for dw in (-1, 0, 1):
            for dh in (-1, 0, 1):
                size = (2 * w + dw, 2 * h + dh)
                if size[0] == 3 and w == 1:
                    # OpenCV leaves the third column as it finds it.
                    assert ours.pyrUp(source, dstsize=size).shape[:2] == size[::-1]
                    continue
                same(ours.pyrUp(source, dstsize=size), cv2.pyrUp(source, dstsize=size))


def test_a_pyramid_is_a_chain() -> None:
    source = noise(3, (45, 70, 3), np.uint8)
    levels = ours.buildPyramid(source, 4)
    assert levels[0] is source
    want = source
    for level in levels[1:]:
        want = cv2.pyrDown(want)
        same(level, want)
    into = [np.zeros_like(level) for level in levels[1:]]
    filled = ours.buildPyramid(source, 4, into)
    assert all(a is b for a, b in zip(filled[1:], into, strict=True))
    assert all(np.array_equal(a, b) for a, b in zip(filled, levels, strict=True))


def test_half_floats_are_those_of_singles() -> None:
    source = noise(4, (12, 15, 3), np.float16)
    for function in (ours.pyrDown, ours.pyrUp):
        single = function(source.astype(np.float32))
        assert np.array_equal(function(source), single.astype(np.float16))
    assert ours.integral(source).dtype == np.float64
    assert np.array_equal(ours.integral(source), ours.integral(source.astype(np.float32)))


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("channels", [1, 2, 3, 4, 6])
def test_integrals(dtype: type, channels: int) -> None:
    depths: dict[Any, list[tuple[int, int]]] = {
        np.uint8: [(4, 4), (4, 5), (4, 6), (5, 5), (5, 6), (6, 6)],
        np.float32: [(5, 5), (5, 6), (6, 6)],
    }
    for seed, (h, w) in enumerate(SIZES):
        source = noise(seed, (h, w, channels), dtype)
        # OpenCV sums in singles what it stores in singles: each of its additions is rounded.
        rounding = 3e-6 * (w + h)
        same(ours.integral(source), cv2.integral(source))
        for sdepth, sqdepth in [(-1, -1), (0, 0), *depths.get(dtype, [(6, 6)])]:
            got = ours.integral3(source, sdepth=sdepth, sqdepth=sqdepth)
            want = cv2.integral3(source, sdepth=sdepth, sqdepth=sqdepth)
            pair = ours.integral2(source, sdepth=sdepth, sqdepth=sqdepth)
            for table, expected in zip(got, want, strict=True):
                same(table, expected, rounding)
            assert all(np.array_equal(a, b) for a, b in zip(pair, got[:2], strict=True))
            alone = ours.integral(source, sdepth=sdepth)
            assert np.array_equal(alone, got[0])


CAMERA = np.array([[70.0, 0, 41.5], [0, 72.0, 30.25], [0, 0, 1]])
LENS = [-0.3, 0.12, 0.002, -0.003, -0.02, 0.1, -0.05, 0.01, 0.003, -0.002, 0.001, 0.002, 0.05, -0.04]


def turned() -> Array:
    rotation, _ = cv2.Rodrigues(np.array([0.02, -0.05, 0.1]))
    found: Array = rotation
    return found


@pytest.mark.parametrize("count", [0, 4, 5, 8, 12, 14])
def test_undistortion_maps(count: int) -> None:
    lens = np.array(LENS[:count]) if count else None
    new = np.array([[60.0, 0, 45], [0, 61, 28], [0, 0, 1]])
    for rotation in (None, turned()):
        for target in (CAMERA, new, np.hstack([new, np.ones((3, 1))])):
            for kind in (ours.CV_32FC1, ours.CV_32FC2, ours.CV_16SC2, -1):
                want = cv2.initUndistortRectifyMap(CAMERA, lens, rotation, target, (83, 61), kind)
                got = ours.initUndistortRectifyMap(CAMERA, lens, rotation, target, (83, 61), kind)
                if want[0].dtype == np.int16:
                    assert got[1] is not None
                    assert (np.asarray(got[0]) != want[0]).mean() < 1e-3
                    assert (got[1] != want[1]).mean() < 1e-3
                    continue
                assert np.abs(got[0] - want[0]).max() < 1e-4
                if want[1] is not None and want[1].size:
                    assert got[1] is not None
                    assert np.abs(got[1] - want[1]).max() < 1e-4


@pytest.mark.parametrize("count", [0, 4, 5, 8, 12, 14])
def test_undistort(count: int) -> None:
    source = noise(5, (61, 83, 3), np.uint8)
    smooth = cv2.GaussianBlur(source, (0, 0), 4)
    lens = np.array(LENS[:count]) if count else None
    want = cv2.undistort(smooth, CAMERA, lens)
    got = ours.undistort(smooth, CAMERA, lens, antialias=False)
    assert np.abs(got.astype(int) - want).max() <= 1
    dst = np.zeros_like(smooth)
    assert ours.undistort(smooth, CAMERA, lens, dst, antialias=False) is dst
    assert np.array_equal(dst, got)


def test_fisheye() -> None:
    lens = np.array([0.1, -0.03, 0.01, -0.002])
    for rotation, new in ((None, CAMERA), (turned(), CAMERA), (None, np.diag([20.0, 20, 1]))):
        want = cv2.fisheye.initUndistortRectifyMap(
            CAMERA, lens, np.eye(3) if rotation is None else rotation, new, (83, 61), cv2.CV_32FC1
        )
        got = ours.fisheye.initUndistortRectifyMap(CAMERA, lens, rotation, new, (83, 61), ours.CV_32FC1)
        for a, b in zip(got, want, strict=True):
            assert a is not None
            assert np.abs(a - b).max() < 1e-4
    smooth = cv2.GaussianBlur(noise(5, (61, 83, 3), np.uint8), (0, 0), 4)
    want = cv2.fisheye.undistortImage(smooth, CAMERA, lens, Knew=CAMERA)
    seen = ours.fisheye.undistortImage(smooth, CAMERA, lens, Knew=CAMERA, antialias=False)
    assert np.abs(seen.astype(int) - want).max() <= 1


MODULES = ("_integral", "_pyramids", "_remap", "_resize", "_undistort", "_warps", "fisheye")


@pytest.mark.parametrize("module", MODULES)
def test_examples_in_docstrings(module: str) -> None:
    result = doctest.testmod(importlib.import_module(f"multum.compat.cv2.{module}"))
    assert result.attempted > 0
    assert result.failed == 0
