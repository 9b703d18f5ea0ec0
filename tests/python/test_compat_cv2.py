"""The drop-in against OpenCV itself."""

from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import multum as mt

ours = mt.compat.cv2
Array = NDArray[Any]

DTYPES = (np.uint8, np.uint16, np.int16, np.float32, np.float64)
BORDERS = (
    ours.BORDER_CONSTANT,
    ours.BORDER_REPLICATE,
    ours.BORDER_REFLECT,
    ours.BORDER_WRAP,
    ours.BORDER_REFLECT_101,
    ours.BORDER_TRANSPARENT,
)
KINDS = (ours.INTER_NEAREST, ours.INTER_LINEAR, ours.INTER_CUBIC, ours.INTER_LANCZOS4)


def picture(seed: int, height: int, width: int, channels: int, dtype: type, smooth: bool = False) -> Array:
    """Values from 0 to 250: noise, or a smooth pattern of slopes below 20 a pixel."""
    random = np.random.default_rng(seed)
    values = random.random((height, width, channels)) * 250
    if smooth:
        x, y = np.meshgrid(np.arange(width), np.arange(height))
        values = np.stack(
            [125 + 60 * np.sin(0.15 * x + c) + 60 * np.cos(0.15 * y + c) for c in range(channels)], -1
        )
    image: Array = values.astype(dtype)
    return image[..., 0] if channels == 1 else image


def matches(got: Array, want: Array, float_bound: float) -> None:
    assert got.shape == want.shape
    assert got.dtype == want.dtype
    bound = 1 if want.dtype.kind in "iu" else float_bound
    difference = np.abs(got.astype(np.float64) - want.astype(np.float64))
    assert difference.max(initial=0) <= bound


@st.composite
def calls(draw: st.DrawFn) -> tuple[Array, int, int, int]:
    dtype = draw(st.sampled_from(DTYPES))
    channels = draw(st.integers(1, 4))
    shape = draw(st.tuples(st.integers(2, 40), st.integers(2, 40)))
    seed = draw(st.integers(0, 1 << 30))
    source = picture(seed, *shape, channels, dtype)
    return source, seed, draw(st.sampled_from(KINDS)), draw(st.sampled_from(BORDERS))


def kept(seed: int, shape: tuple[int, int], source: Array) -> Array:
    """An output to draw into, of one colour: OpenCV's cubic kernel shows the first of each eight pixels in all."""
    return np.full(shape + source.shape[2:], seed % 250, source.dtype)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(calls())
def test_remap_is_opencvs(call: tuple[Array, int, int, int]) -> None:
    source, seed, kind, border = call
    fast = source.dtype.type in (np.uint8, np.uint16, np.float32) and source.shape[2:] != (2,)
    if border == ours.BORDER_TRANSPARENT and kind == ours.INTER_LINEAR and not fast:
        # The last column and row blend in other pixels than OpenCV's there: docs/peers.md.
        border = ours.BORDER_CONSTANT
    random = np.random.default_rng(seed)
    h, w = source.shape[:2]
    shape = (int(random.integers(1, 30)), int(random.integers(1, 30)))
    x = (random.random(shape) * (w + 8) - 4).astype(np.float32)
    y = (random.random(shape) * (h + 8) - 4).astype(np.float32)
    value = tuple(float(v) for v in random.integers(0, 255, 4))
    dst = kept(seed, shape, source)
    want = cv2.remap(source, x, y, kind, dst=dst.copy(), borderMode=border, borderValue=value)
    got = ours.remap(
        source, x, y, kind, dst=dst.copy(), borderMode=border, borderValue=value, antialias=False
    )
    if source.dtype == np.float64 and kind == ours.INTER_CUBIC:
        # At borders OpenCV's doubles stray by about 1 of 250 from its singles, which these equal.
        want = cv2.remap(
            source.astype(np.float32),
            x,
            y,
            kind,
            dst=dst.astype(np.float32),
            borderMode=border,
            borderValue=value,
        ).astype(np.float64)
    # Weights of Lanczos come from a table within 2e-6, eight by eight of them.
    matches(got, want, 0.02)
    pairs = ours.remap(
        source,
        np.dstack([x, y]),
        None,
        kind,
        dst=dst.copy(),
        borderMode=border,
        borderValue=value,
        antialias=False,
    )
    assert np.array_equal(got, pairs)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(calls(), st.booleans(), st.booleans())
def test_warps_by_matrices_are_opencvs(
    call: tuple[Array, int, int, int], affine: bool, inverse: bool
) -> None:
    source, seed, kind, border = call
    if border == ours.BORDER_TRANSPARENT and kind != ours.INTER_NEAREST:
        # Whether a pixel on the very edge is kept hangs on the last bit of a position.
        border = ours.BORDER_CONSTANT
    if kind == ours.INTER_CUBIC and border not in (ours.BORDER_CONSTANT, ours.BORDER_REPLICATE):
        # OpenCV's cubic kernel reads wrong pixels under reflection and wrapping in columns 32 and up.
        border = ours.BORDER_REPLICATE
    random = np.random.default_rng(seed)
    h, w = source.shape[:2]
    channels = 1 if source.ndim == 2 else source.shape[2]
    smooth = picture(seed, h, w, channels, source.dtype.type, smooth=True)
    if smooth.dtype == np.float64 and kind == ours.INTER_CUBIC:
        smooth = smooth.astype(np.float32)
    size = (int(random.integers(1, 40)), int(random.integers(1, 40)))
    angle, scale = random.random() * 6, 0.5 + random.random()
    c, s = scale * np.cos(angle), scale * np.sin(angle)
    matrix = np.array([[c, -s, random.random() * w], [s, c, random.random() * h], [0, 0, 1]])
    flags = kind | (ours.WARP_INVERSE_MAP if inverse else 0)
    value = (120.0, 130.0, 110.0, 140.0)
    arguments: dict[str, Any] = {"flags": flags, "borderMode": border, "borderValue": value}
    dst = kept(seed, (size[1], size[0]), smooth)
    if affine:
        want = cv2.warpAffine(smooth, matrix[:2], size, dst=dst.copy(), **arguments)
        got = ours.warpAffine(smooth, matrix[:2], size, dst=dst.copy(), antialias=False, **arguments)
    else:
        matrix[2, :2] = (random.random(2) - 0.5) * 0.01
        want = cv2.warpPerspective(smooth, matrix, size, dst=dst.copy(), **arguments)
        got = ours.warpPerspective(smooth, matrix, size, dst=dst.copy(), antialias=False, **arguments)
    if kind == ours.INTER_NEAREST:
        # A position half-way between pixels falls to one side or the other.
        assert got.shape == want.shape
        assert (got != want).mean() <= 0.02 or (got != want).sum() <= 2 * channels
        return
    # OpenCV's positions are singles: off by up to 64 ulp of 64, times slopes up to 250 at the border.
    allowed = 0.02 if want.dtype.kind == "f" else 1
    difference = np.abs(got.astype(np.float64) - want.astype(np.float64))
    quantised = kind == ours.INTER_LANCZOS4 or not (
        kind == ours.INTER_CUBIC or (source.dtype.type in (np.uint8, np.uint16, np.float32) and channels != 2)
    )
    # Where positions are rounded to 1/32 pixel, a few fall to the other side: one step of slope 20 / 32.
    assert (difference > allowed).mean() <= (0.02 if quantised else 0.0)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize(
    "kind", [ours.INTER_NEAREST, ours.INTER_LINEAR, ours.INTER_CUBIC, ours.INTER_LANCZOS4]
)
def test_fixed_point_maps(dtype: type, kind: int) -> None:
    source = picture(3, 30, 40, 3, dtype)
    random = np.random.default_rng(4)
    x, y = ((random.random((20, 25)) * 44 - 2).astype(np.float32) for _ in range(2))
    # OpenCV reads maps without fractions right with INTER_NEAREST only, and others right without it only.
    for nearest in [kind == ours.INTER_NEAREST]:
        want_maps = cv2.convertMaps(x, y, cv2.CV_16SC2, nninterpolation=nearest)
        got_maps = ours.convertMaps(x, y, ours.CV_16SC2, nninterpolation=nearest)
        assert np.array_equal(got_maps[0], want_maps[0])
        assert (got_maps[1] is None) == nearest
        if got_maps[1] is not None:
            assert np.array_equal(got_maps[1], want_maps[1])
        if dtype is np.float64 and kind == ours.INTER_CUBIC:
            source = source.astype(np.float32)
        want = cv2.remap(source, *want_maps, kind, borderMode=cv2.BORDER_REFLECT_101)
        got = ours.remap(source, *got_maps, kind, borderMode=cv2.BORDER_REFLECT_101, antialias=False)
        matches(got, want, 0.02)


def test_maps_convert_back() -> None:
    x, y = (np.random.default_rng(s).random((6, 7)).astype(np.float32) * 50 for s in (1, 2))
    whole, codes = cv2.convertMaps(x, y, cv2.CV_16SC2)
    want_x, want_y = cv2.convertMaps(whole, codes, cv2.CV_32FC1)
    got_x, got_y = ours.convertMaps(whole, codes, ours.CV_32FC1)
    assert got_y is not None
    assert np.array_equal(got_x, want_x)
    assert np.array_equal(got_y, want_y)
    assert np.array_equal(ours.convertMaps(whole, codes, ours.CV_32FC2)[0], np.dstack([want_x, want_y]))
    assert np.array_equal(ours.convertMaps(x, y, ours.CV_32FC2)[0], np.dstack([x, y]))
    assert np.array_equal(ours.convertMaps(np.dstack([x, y]), None, ours.CV_32FC1)[0], x)


def test_arguments_of_all_kinds_are_borrowed_or_copied() -> None:
    base = picture(1, 24, 36, 3, np.uint8)
    x, y = np.meshgrid(np.arange(20, dtype=np.float32) * 0.9, np.arange(10, dtype=np.float32) * 0.9)
    for source in (base[::-1], base[:, ::2], base.transpose(1, 0, 2), base[..., ::-1]):
        want = cv2.remap(np.ascontiguousarray(source), x, y, cv2.INTER_LINEAR)
        matches(ours.remap(source, x, y, ours.INTER_LINEAR, antialias=False), want, 0)
    want = cv2.remap(base, x, y, cv2.INTER_LINEAR)
    frozen = base.copy()
    frozen.flags.writeable = False
    assert np.array_equal(ours.remap(frozen, x, y, ours.INTER_LINEAR), want)
    foreign = base.astype(np.uint16).astype(">u2")
    assert np.array_equal(ours.remap(foreign, x, y, ours.INTER_LINEAR), want)
    assert np.array_equal(ours.remap(base, x.astype(np.float64), y, ours.INTER_LINEAR), want)
    assert np.array_equal(ours.remap(base, np.asfortranarray(x), y, ours.INTER_LINEAR), want)
    single = ours.remap(base[..., :1], x, y, ours.INTER_LINEAR)
    assert np.array_equal(single, want[..., 0])


def test_dst_receives_the_result() -> None:
    source = picture(1, 10, 20, 3, np.uint8)
    x, y = np.meshgrid(np.arange(20, dtype=np.float32) * 0.9, np.arange(10, dtype=np.float32) * 0.9)
    want = ours.remap(source, x, y, ours.INTER_LINEAR)
    dst = np.zeros_like(want)
    assert ours.remap(source, x, y, ours.INTER_LINEAR, dst) is dst
    assert np.array_equal(dst, want)
    # Rows apart, the source itself, and a shape that does not fit.
    apart = np.zeros((10, 40, 3), np.uint8)[:, ::2]
    assert ours.remap(source, x, y, ours.INTER_LINEAR, apart) is apart
    assert np.array_equal(apart, want)
    own = source.copy()
    assert ours.remap(own, x, y, ours.INTER_LINEAR, own) is own
    assert np.array_equal(own, want)
    assert np.array_equal(ours.remap(source, x, y, ours.INTER_LINEAR, np.zeros((2, 2), np.uint8)), want)


def test_relative_maps() -> None:
    source = picture(1, 30, 40, 3, np.uint8)
    x, y = (np.random.default_rng(s).random((30, 40)).astype(np.float32) for s in (1, 2))
    want = cv2.remap(source, x, y, cv2.INTER_LINEAR | cv2.WARP_RELATIVE_MAP)
    got = ours.remap(source, x, y, ours.INTER_LINEAR | ours.WARP_RELATIVE_MAP, antialias=False)
    matches(got, want, 0)


@pytest.mark.parametrize("dtype", [np.int8, np.uint32, np.int32, np.bool_, np.int64])
def test_nearest_takes_any_integers(dtype: type) -> None:
    source: Array = (np.arange(12 * 13).reshape(12, 13) % 200 - 50).astype(dtype)
    x, y = np.meshgrid(np.arange(13, dtype=np.float32), np.arange(12, dtype=np.float32))
    got = ours.remap(source, x[:, ::-1].copy(), y, ours.INTER_NEAREST)
    assert got.dtype == source.dtype
    assert np.array_equal(got, source[:, ::-1])
    outside = ours.remap(source, x - 100, y, ours.INTER_NEAREST, borderValue=3)
    assert np.array_equal(outside, np.full_like(source, 3))


def test_many_channels_and_wide_images() -> None:
    source = picture(1, 20, 30, 7, np.float32)
    x, y = (np.random.default_rng(s).random((9, 8)).astype(np.float32) * 15 for s in (1, 2))
    got = ours.remap(source, x, y, ours.INTER_CUBIC, antialias=False)
    for c in range(7):
        matches(got[..., c], cv2.remap(source[..., c].copy(), x, y, cv2.INTER_CUBIC), 1e-3)
    wide = np.zeros((2, 40_000), np.uint8)
    wide[:, 39_990] = 200
    got = ours.remap(wide, np.array([[39_990.0]]), np.array([[0.5]]), ours.INTER_LINEAR)
    assert got.tolist() == [[200]]


def test_reductions_are_filtered() -> None:
    stripes = np.tile(np.array([0, 200], np.uint8), (64, 32))
    quarter = np.array([[0.25, 0, 0], [0, 0.25, 0]])
    plain = ours.warpAffine(stripes, quarter, (14, 14), antialias=False)
    assert np.array_equal(plain, cv2.warpAffine(stripes, quarter, (14, 14)))
    assert plain[4:-1, 4:-1].max() == 0
    for kind in (ours.INTER_LINEAR, ours.INTER_CUBIC, ours.INTER_LANCZOS4):
        filtered = ours.warpAffine(stripes, quarter, (14, 14), flags=kind)
        assert np.abs(filtered[4:-1, 4:-1].astype(int) - 100).max() <= 2
    assert ours.warpAffine(stripes, quarter, (14, 14), flags=ours.INTER_NEAREST)[4:-1, 4:-1].max() == 0
    x, y = np.meshgrid(np.arange(14, dtype=np.float32) * 4, np.arange(14, dtype=np.float32) * 4)
    assert np.abs(ours.remap(stripes, x, y, ours.INTER_LINEAR)[4:-1, 4:-1].astype(int) - 100).max() <= 2


@settings(max_examples=30, deadline=None, derandomize=True)
@given(calls())
def test_magnification_is_untouched_by_antialiasing(call: tuple[Array, int, int, int]) -> None:
    source, seed, kind, border = call
    random = np.random.default_rng(seed)
    angle, scale = random.random() * 6, 1.0 + random.random()
    c, s = scale * np.cos(angle), scale * np.sin(angle)
    matrix = np.array([[c, -s, 5.0], [s, c, 7.0]])
    dst = kept(seed, (20, 20), source)
    results = [
        ours.warpAffine(
            source, matrix, (20, 20), dst.copy(), flags=kind, borderMode=border, antialias=antialias
        )
        for antialias in (False, True)
    ]
    assert np.array_equal(results[0], results[1])


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_integral(dtype: type) -> None:
    for channels in (1, 3):
        source = picture(5, 13, 17, channels, dtype)
        matches(ours.integral(source), cv2.integral(source), 1e-6)
        matches(ours.integral(source, sdepth=ours.CV_64F), cv2.integral(source, sdepth=cv2.CV_64F), 1e-6)


@pytest.mark.parametrize("channels", [1, 3])
def test_rect_sub_pix(channels: int) -> None:
    source = picture(5, 13, 17, channels, np.uint8)
    for center in ((8.0, 6.0), (4.25, 3.5), (-1.0, 14.2), (12.9, 0.1)):
        matches(ours.getRectSubPix(source, (5, 4), center), cv2.getRectSubPix(source, (5, 4), center), 0)
        kind = cv2.CV_32F
        got = ours.getRectSubPix(source, (5, 4), center, patchType=kind)
        matches(got, cv2.getRectSubPix(source, (5, 4), center, patchType=kind), 0.01)


@pytest.mark.parametrize("size", [(7, 9), (34, 26), (40, 50), (17, 9), (51, 39)])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_resize(size: tuple[int, int], dtype: type) -> None:
    source = picture(5, 26, 34, 3, dtype)
    # By 3/2 centres lie on pixel edges, where the rounding of INTER_NEAREST_EXACT's step decides in OpenCV.
    for kind in range(6 if size == (51, 39) else 7):
        want = cv2.resize(source, size, interpolation=kind)
        got = ours.resize(source, size, interpolation=kind, antialias=False)
        matches(got, want, 0.02)


@pytest.mark.parametrize("flags", [0, ours.WARP_POLAR_LOG])
def test_warp_polar(flags: int) -> None:
    source = picture(5, 40, 41, 3, np.uint8, smooth=True)
    flags |= ours.INTER_LINEAR | ours.WARP_FILL_OUTLIERS
    want = cv2.warpPolar(source, (24, 60), (20, 19), 22, flags)
    got = ours.warpPolar(source, (24, 60), (20, 19), 22, flags, antialias=False)
    assert got.shape == want.shape
    assert np.abs(got.astype(int) - want).max() <= 2


def bad_calls() -> list[Any]:
    image, m = np.zeros((5, 6, 3), np.uint8), np.zeros((3, 4), np.float32)
    r, a = ours.remap, ours.warpAffine
    return [
        lambda: r(np.zeros((0, 3), np.uint8), m, m, 1),
        lambda: r(np.zeros(3, np.uint8), m, m, 1),
        lambda: r(image.astype(np.int32), m, m, 1),
        lambda: r(image.astype(complex), m, m, 0),
        lambda: r(image, m, m[:2], 1),
        lambda: r(image, m, None, 1),
        lambda: r(image, m.astype(np.int32), m, 1),
        lambda: r(image, m, m, 6),
        lambda: r(image, m, m, 1, borderMode=9),
        lambda: r(image, m, m, 1, borderValue="red"),
        lambda: r(image, m, m, 1, borderValue=(1, 2, 3, 4, 5)),
        lambda: a(image, np.eye(3), (4, 4)),
        lambda: a(image, np.eye(2, 3, dtype=int), (4, 4)),
        lambda: a(image, np.eye(2, 3), (4, -4)),
        lambda: a(image, np.eye(2, 3), (4,)),
        lambda: ours.warpPerspective(image, np.eye(2, 3), (4, 4)),
        lambda: ours.resize(image, None),
        lambda: ours.resize(image, (4, 4), interpolation=9),
        lambda: ours.convertMaps(m, m, 99),
        lambda: ours.integral(image, sdepth=99),
        lambda: ours.warpPolar(image, (4, 4), (1, 1), 0, 1),
    ]


@pytest.mark.parametrize("index", range(len(bad_calls())))
def test_wrong_arguments_raise_error(index: int) -> None:
    with pytest.raises(ours.error) as raised:
        bad_calls()[index]()
    assert isinstance(raised.value, ValueError)
    assert isinstance(raised.value, TypeError)
    assert ": got " in str(raised.value)


def test_constants_are_opencvs() -> None:
    for name in ours.__all__:
        value = getattr(ours, name)
        if isinstance(value, int):
            assert value == getattr(cv2, name), name
