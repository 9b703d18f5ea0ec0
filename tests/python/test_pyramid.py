"""`build_pyramid` against OpenCV, closed forms, and bad input."""

from __future__ import annotations

import doctest
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt

Array = NDArray[Any]


def noise(shape: tuple[int, ...], dtype: str) -> Array:
    numbers = np.random.default_rng(3).random(shape)
    full = {"uint8": 255, "uint16": 65535}.get(dtype)
    return numbers.astype(dtype) if full is None else np.round(numbers * full).astype(dtype)


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float32"])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_even_sizes_are_area_resizes(dtype: str, channels: int) -> None:
    image = noise((96, 160, channels), dtype)
    exact: Array = image.astype(np.float64)
    for level in mt.build_pyramid(image)[1:6]:
        height, width, _ = level.shape
        exact = cv2.resize(exact, (width, height), interpolation=cv2.INTER_AREA).reshape(level.shape)
        assert level.dtype == image.dtype
        if dtype == "float32":
            np.testing.assert_allclose(level, exact, rtol=0, atol=6e-7)
        else:
            # Exact means of codes are multiples of 4^-l: halves go up.
            np.testing.assert_array_equal(level, np.floor(exact + 0.5))


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (67, 5), (13, 17, 3), (5, 40, 4), (6, 6, 9)])
@pytest.mark.parametrize("kind", ["box", "kaiser", "lanczos3"])
def test_shapes(shape: tuple[int, ...], kind: str) -> None:
    levels = mt.build_pyramid(noise(shape, "float64"), kind=kind, wrap=("repeat", "mirror"))
    assert len(levels) == int(np.log2(max(shape[:2]))) + 1
    for number, level in enumerate(levels):
        assert level.shape == tuple(max(1, n >> number) for n in shape[:2]) + shape[2:]


def test_any_memory_order() -> None:
    image = noise((20, 30, 3), "uint8")
    want = mt.build_pyramid(image)
    for other in (np.asfortranarray(image), image[::-1, ::-1][::-1, ::-1], image.astype(">u1")):
        for a, b in zip(want, mt.build_pyramid(other), strict=True):
            np.testing.assert_array_equal(a, b)
    big = noise((20, 30), "uint16")
    for a, b in zip(mt.build_pyramid(big), mt.build_pyramid(big.astype(">u2")), strict=True):
        np.testing.assert_array_equal(a, b)


def test_level_0_is_the_image() -> None:
    image = noise((8, 8), "uint8")
    levels = mt.build_pyramid(image, levels=1)
    assert len(levels) == 1
    assert levels[0] is image


def test_a_photograph_with_alpha_keeps_its_coverage() -> None:
    image = noise((64, 64, 4), "uint8")
    image[..., 3] = cv2.GaussianBlur(image[..., 3], (0, 0), 3)
    threshold = float(np.median(image[..., 3])) / 255
    base = (image[..., 3] / 255 >= threshold).mean()
    for level in mt.build_pyramid(image, encoding="srgb", alpha="straight", coverage=threshold):
        assert abs((level[..., 3] / 255 >= threshold).mean() - base) <= 0.5 / level[..., 3].size + 1e-12


@pytest.mark.parametrize(
    ("error", "arguments"),
    [
        (ValueError, {"image": np.zeros((0, 4), np.uint8)}),
        (ValueError, {"image": np.zeros(4, np.uint8)}),
        (ValueError, {"image": np.zeros((2, 2, 2, 2), np.uint8)}),
        (TypeError, {"image": np.zeros((2, 2), np.int32)}),
        (TypeError, {"image": np.zeros((2, 2), complex)}),
        (TypeError, {"image": np.zeros((2, 2), object)}),
        (ValueError, {"kind": "mean"}),
        (ValueError, {"encoding": "gamma"}),
        (ValueError, {"alpha": "straight"}),
        (ValueError, {"encoding": "normal", "image": np.zeros((2, 2), np.uint8)}),
        (ValueError, {"wrap": "tile"}),
        (TypeError, {"wrap": ("repeat",)}),
        (TypeError, {"wrap": 3}),
        (ValueError, {"coverage": 0.5}),
        (ValueError, {"coverage": float("nan"), "image": np.zeros((2, 2, 4), np.uint8), "alpha": "straight"}),
        (ValueError, {"levels": 0}),
        (ValueError, {"levels": -3}),
        (ValueError, {"levels": 5}),
        (TypeError, {"levels": 1.5}),
    ],
)
def test_bad_input(error: type[Exception], arguments: dict[str, Any]) -> None:
    image = np.zeros((4, 4, 3), np.uint8)
    with pytest.raises(error):
        mt.build_pyramid(**{"image": image, **arguments})


def test_docstring() -> None:
    finder = doctest.DocTestFinder()
    for case in finder.find(mt.build_pyramid, globs={}):
        assert not doctest.DocTestRunner().run(case).failed
