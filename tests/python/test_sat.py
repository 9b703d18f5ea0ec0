"""`SummedAreaTable` against OpenCV, scikit-image, direct sums, and bad input."""

from __future__ import annotations

import doctest
from typing import Any

import cv2
import numpy as np
import pytest
import skimage.transform
from numpy.typing import NDArray

import multum as mt

Array = NDArray[Any]


def noise(shape: tuple[int, ...], dtype: str) -> Array:
    numbers = np.random.default_rng(3).random(shape)
    full = {"uint8": 255, "uint16": 65535}.get(dtype)
    return numbers.astype(dtype) if full is None else np.round(numbers * full).astype(dtype)


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_tables_are_opencvs(channels: int) -> None:
    image = noise((37, 53, channels), "uint8")
    table = mt.SummedAreaTable(image).table
    assert table.dtype == np.uint32
    np.testing.assert_array_equal(table, cv2.integral(image).reshape(38, 54, channels))
    floats = noise((37, 53, channels), "float32")
    sat = mt.SummedAreaTable(floats)
    areas = np.arange(38)[:, None, None] * np.arange(54)[None, :, None]
    whole = cv2.integral(floats, sdepth=cv2.CV_64F).reshape(38, 54, channels)
    np.testing.assert_allclose(sat.table + areas * sat.offset, whole, rtol=1e-13, atol=1e-10)


def test_tables_are_scikit_images() -> None:
    image = noise((40, 30), "uint16")
    sat = mt.SummedAreaTable(image)
    assert sat.table.dtype == np.uint64
    whole = skimage.transform.integral_image(image.astype(np.float64))
    np.testing.assert_array_equal(sat.table[1:, 1:, 0], whole)


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16", "float32", "float64"])
def test_whole_boxes_are_slices(dtype: str) -> None:
    image = noise((24, 31, 3), dtype)
    values = image.astype(np.float64) / {"uint8": 255, "uint16": 65535}.get(dtype, 1)
    sat = mt.SummedAreaTable(image)
    random = np.random.default_rng(1)
    x = np.sort(random.integers(0, 32, (50, 2)), axis=1)
    y = np.sort(random.integers(0, 25, (50, 2)), axis=1)
    boxes = np.stack([x[:, 0] / 31, y[:, 0] / 24, x[:, 1] / 31, y[:, 1] / 24], axis=1)
    want = [values[b:d, a:c].sum(axis=(0, 1)) for (a, c), (b, d) in zip(x, y, strict=True)]
    np.testing.assert_allclose(sat.sum(boxes), want, rtol=0, atol=1e-11)
    assert sat.sum(boxes.reshape(5, 10, 4)).shape == (5, 10, 3)


@pytest.mark.parametrize(("wrap", "pad"), [("repeat", "wrap"), ("mirror", "symmetric"), ("clamp", "edge")])
def test_boxes_outside_are_boxes_of_the_padded_image(wrap: str, pad: Any) -> None:
    image = noise((7, 9), "float64")
    padded = np.pad(image, ((14, 14), (18, 18)), mode=pad)
    boxes = np.random.default_rng(2).uniform(-2, 3, (200, 4))
    got = mt.SummedAreaTable(image, wrap=wrap).mean(boxes)
    want = mt.SummedAreaTable(padded).mean((boxes + 2) / 5)
    np.testing.assert_allclose(got, want, rtol=0, atol=1e-12)


def test_border_colour() -> None:
    image = np.full((4, 4, 3), 255, np.uint8)
    sat = mt.SummedAreaTable(image, wrap=("border", "repeat"), border=[0, 0.5, 2])
    assert sat.wrap == ("border", "repeat")
    np.testing.assert_allclose(sat.mean([-1, 0, 1, 7]), [0.5, 0.75, 1.5])
    np.testing.assert_array_equal(sat.mean([np.nan, 0, 1, 1]), [0, 0.5, 2])
    one = mt.SummedAreaTable(image, wrap="border", border=0.25)
    np.testing.assert_array_equal(one.mean([5, 5, 6, 6]), [0.25] * 3)


@pytest.mark.parametrize(
    ("error", "arguments"),
    [
        (ValueError, {"image": np.zeros((0, 4), np.uint8)}),
        (ValueError, {"image": np.zeros((2, 2, 2, 2), np.uint8)}),
        (TypeError, {"image": np.zeros((2, 2), np.int64)}),
        (ValueError, {"wrap": "tile"}),
        (TypeError, {"wrap": ("clamp", 3)}),
        (ValueError, {"border": [1, 2]}),
        (ValueError, {"border": np.inf}),
        (ValueError, {"wrap": "extend", "image": np.zeros((2, 9), np.uint8)}),
    ],
)
def test_bad_input(error: type[Exception], arguments: dict[str, Any]) -> None:
    image = np.zeros((4, 4, 3), np.uint8)
    with pytest.raises(error):
        mt.SummedAreaTable(**{"image": image, **arguments})


@pytest.mark.parametrize(
    ("error", "boxes"),
    [
        (ValueError, np.zeros(3)),
        (ValueError, 1.0),
        (ValueError, "box"),
        (TypeError, ["a", "b", "c", "d"]),
        (TypeError, np.zeros(4, complex)),
    ],
)
def test_bad_boxes(error: type[Exception], boxes: Any) -> None:
    with pytest.raises(error):
        mt.SummedAreaTable(np.zeros((4, 4), np.uint8)).sum(boxes)


def test_docstrings() -> None:
    for case in doctest.DocTestFinder().find(mt.SummedAreaTable, globs={}):
        assert not doctest.DocTestRunner().run(case).failed
