"""What ``antialias`` adds to OpenCV's functions: means where the map minifies, and nothing anywhere else."""

from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt

Array = NDArray[Any]
ours = mt.compat.cv2
DTYPES = (np.uint8, np.uint16, np.int16, np.float16, np.float32, np.float64)
KINDS = (ours.INTER_LINEAR, ours.INTER_CUBIC, ours.INTER_LANCZOS4)


def noise(height: int, width: int, channels: int, dtype: type) -> Array:
    shape = (height, width, channels) if channels > 1 else (height, width)
    scale = 200 * 257 if dtype == np.uint16 else 200
    return (np.random.default_rng(7).random(shape) * scale).astype(dtype)


def bent(height: int = 40, width: int = 300) -> tuple[Array, ...]:
    """Columns half a pixel apart on the left and three pixels apart on the right; rows half a pixel."""
    i = np.arange(width)
    x = 0.5 * i + 1.25 / width * i * i
    return tuple(np.meshgrid(x.astype(np.float32), 0.5 * np.arange(height, dtype=np.float32)))


SLOPE = 0.5 + 2.5 / 300 * np.arange(300)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("border", [ours.BORDER_CONSTANT, ours.BORDER_REFLECT_101, ours.BORDER_TRANSPARENT])
@pytest.mark.parametrize("dtype", DTYPES)
def test_magnified_pixels_of_a_map_that_also_minifies_are_opencvs(
    dtype: type, border: int, kind: int
) -> None:
    source = noise(30, 540, 3, dtype)
    x, y = bent()
    held: Array = np.full((40, 300, 3), 9, dtype)
    forms: list[tuple[Array, Array | None]] = [
        (x, y),
        (np.dstack([x, y]), None),
        (x.astype(np.float64), y.astype(np.float64)),
    ]
    for first, second in forms:
        plain, mean = (
            ours.remap(source, first, second, kind, held.copy(), border, antialias=antialias)
            for antialias in (False, True)
        )
        # A footprint is made of the differences on both sides.
        assert np.array_equal(plain[:, SLOPE < 0.98], mean[:, SLOPE < 0.98])
        assert (plain[2:, SLOPE > 1.3] != mean[2:, SLOPE > 1.3]).mean() > 0.9


def test_fixed_point_maps_of_unit_scale_are_not_filtered_for_their_rounding() -> None:
    source = noise(60, 80, 3, np.uint8)
    c, s = np.cos(0.4), np.sin(0.4)
    x, y = np.meshgrid(np.arange(50.0), np.arange(40.0))
    turned = [m.astype(np.float32) for m in (c * x - s * y + 20, s * x + c * y)]
    first, second = ours.convertMaps(turned[0], turned[1], ours.CV_16SC2)
    plain, mean = (ours.remap(source, first, second, ours.INTER_LINEAR, antialias=a) for a in (False, True))
    assert np.array_equal(plain, mean)
    # But where they do minify: the mean of black and white stripes is grey.
    stripes = np.tile(np.array([0, 200], np.uint8), (60, 100))
    first, second = ours.convertMaps((3 * x).astype(np.float32), y.astype(np.float32), ours.CV_16SC2)
    grey = ours.remap(stripes, first, second, ours.INTER_LINEAR, borderMode=ours.BORDER_WRAP)
    # A box of three pixels over stripes of one: a third of the contrast, smoothed by the interpolation, remains.
    assert np.abs(grey.astype(int) - 100).max() <= 100 / 3 + 1


def test_undistortion_filters_where_the_lens_shrinks_the_picture() -> None:
    source = noise(60, 80, 3, np.uint8)
    camera = np.array([[80.0, 0, 40], [0, 80, 30], [0, 0, 1]])
    lens = np.array([-0.3, 0.1, 0.0, 0.0])
    plain, mean = (ours.undistort(source, camera, lens, antialias=a) for a in (False, True))
    # A barrel lens is magnified everywhere.
    assert np.array_equal(plain, mean)
    small = np.array([[25.0, 0, 40], [0, 25, 30], [0, 0, 1]])
    plain, mean = (
        ours.undistort(source, camera, lens, newCameraMatrix=small, antialias=a) for a in (False, True)
    )
    inside = (slice(25, 35), slice(33, 47))
    # The mean of some ten pixels of noise varies less.
    assert mean[inside].std() < 0.6 * plain[inside].std()


@pytest.mark.parametrize("size", [(11, 7), (30, 3), (5, 26), (24, 20)])
def test_antialiased_resizes_are_the_integral(size: tuple[int, int]) -> None:
    source = noise(26, 34, 1, np.float64)
    sx, sy = 34 / size[0], 26 / size[1]
    matrix = np.array([[sx, 0, 0.5 * sx - 0.5], [0, sy, 0.5 * sy - 0.5], [0, 0, 1]])
    truth = mt.reference.warp(source, matrix, (size[1], size[0]), wrap="clamp")
    for kind in (*KINDS, ours.INTER_LINEAR_EXACT):
        got = ours.resize(source, size, interpolation=kind)
        assert np.abs(got - np.asarray(truth).reshape(got.shape)).max() < 1e-9 * 200
    single = ours.resize(source.astype(np.float32), size)
    # Sums of singles: some dozen roundings.
    assert np.abs(single - np.asarray(truth).reshape(single.shape)).max() < 40 * 2.0**-24 * 200


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("channels", [1, 2, 3, 4, 5])
def test_resizes_are_the_warps_by_their_matrix(channels: int, dtype: type) -> None:
    source = noise(26, 34, channels, dtype)
    for size in ((21, 17), (50, 9), (80, 61)):
        sx, sy = 34 / size[0], 26 / size[1]
        matrix = np.array([[sx, 0, 0.5 * sx - 0.5], [0, sy, 0.5 * sy - 0.5]])
        for kind in (ours.INTER_LINEAR, ours.INTER_CUBIC):
            got = ours.resize(source, size, interpolation=kind)
            warped = ours.warpAffine(
                source, matrix, size, flags=kind | ours.WARP_INVERSE_MAP, borderMode=ours.BORDER_REPLICATE
            )
            off = np.abs(got.astype(np.float64) - warped)
            # Warps round positions to 1/32 pixel for some formats, and `auto` may be wrong by half a code of 8 bits
            # where it reduces by far; see docs/filters.md.
            exact = dtype in (np.uint8, np.uint16, np.float32) and channels in (1, 3, 4)
            codes = 2 if exact or kind == ours.INTER_CUBIC else 2 + 200 / 32
            assert off.max() <= codes * (257 if dtype == np.uint16 else 1)


def test_reductions_approach_the_interpolation_without_a_jump() -> None:
    source = noise(9, 120, 1, np.float64)
    x = np.arange(40.0)
    for kind in KINDS:
        before: Array | None = None
        for scale in np.arange(0.95, 1.4, 0.0025):
            # Column 20 is always read at 50.3.
            row = (50.3 + scale * (x - 20)).astype(np.float64)
            maps = np.broadcast_to(row, (5, 40)).copy(), np.full((5, 40), 4.0) + np.arange(5)[:, None]
            now = ours.remap(source, *maps, kind)[:, 20]
            if before is not None:
                # The mean's share rises by 6 times the step at most, and so does the contrast it takes away.
                assert np.abs(now - before).max() < 200 * 0.0025 * 7
            before = now


def test_images_over_32767_pixels_and_many_channels_are_filtered() -> None:
    wide = np.zeros((4, 40_000, 6), np.uint8)
    wide[:, 1::2] = 200
    third = ours.resize(wide, (10_000, 4))
    assert third.shape == (4, 10_000, 6)
    # Four pixels of stripes: half of each but for the ends of the integral.
    assert np.abs(third[:, 1:-1].astype(int) - 100).max() <= 1
    with pytest.raises(cv2.error):
        cv2.remap(wide[..., 0], np.zeros((2, 40_000), np.float32), np.zeros((2, 40_000), np.float32), 1)
