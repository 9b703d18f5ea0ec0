"""Careless and hostile callers of the drop-ins: a result or the documented error, never anything else."""

import inspect
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
import multum.compat.skimage as ski
import multum.compat.torch as th

ours = mt.compat.cv2
Array = NDArray[Any]

IMAGE = (np.arange(5 * 6 * 3).reshape(5, 6, 3) % 251).astype(np.uint8)
X, Y = (
    np.ascontiguousarray(m)
    for m in np.meshgrid(np.arange(4, dtype=np.float32), np.arange(3, dtype=np.float32))
)
CAMERA = np.array([[5.0, 0, 3], [0, 5, 2.5], [0, 0, 1]])

CALLS: dict[str, tuple[Callable[..., Any], tuple[Any, ...]]] = {
    "remap": (ours.remap, (IMAGE, X, Y, 1, None, 0, (1.0, 2.0, 3.0, 4.0))),
    "warpAffine": (ours.warpAffine, (IMAGE, np.eye(2, 3), (4, 3), None, 1, 0, None)),
    "warpPerspective": (ours.warpPerspective, (IMAGE, np.eye(3), (4, 3), None, 1, 0, None)),
    "resize": (ours.resize, (IMAGE, (4, 3), None, 0.0, 0.0, 1)),
    "warpPolar": (ours.warpPolar, (IMAGE, (4, 3), (2.0, 2.0), 3.0, 1, None)),
    "getRectSubPix": (ours.getRectSubPix, (IMAGE, (3, 2), (2.0, 2.0), None, -1)),
    "integral": (ours.integral, (IMAGE, None, -1)),
    "integral2": (ours.integral2, (IMAGE, None, None, -1, -1)),
    "integral3": (ours.integral3, (IMAGE, None, None, None, -1, -1)),
    "pyrDown": (ours.pyrDown, (IMAGE, None, None, 4)),
    "pyrUp": (ours.pyrUp, (IMAGE, None, None, 4)),
    "buildPyramid": (ours.buildPyramid, (IMAGE, 2, None, 4)),
    "convertMaps": (ours.convertMaps, (X, Y, ours.CV_16SC2, None, None, False)),
    "undistort": (ours.undistort, (IMAGE, CAMERA, np.zeros(4), None, None)),
    "initUndistortRectifyMap": (
        ours.initUndistortRectifyMap,
        (CAMERA, np.zeros(5), np.eye(3), CAMERA, (4, 3), ours.CV_32FC1, None, None),
    ),
    "fisheye.undistortImage": (
        ours.fisheye.undistortImage,
        (IMAGE, CAMERA, np.zeros(4), None, CAMERA, (4, 3)),
    ),
}

frozen = np.zeros((3, 4, 3), np.uint8)
frozen.flags.writeable = False

JUNK: dict[str, Any] = {
    "nothing": None,
    "text": "image",
    "object": object(),
    "negative": -1,
    "huge": 1 << 62,
    "beyond 64 bits": 1 << 80,
    "NaN": float("nan"),
    "infinity": float("inf"),
    "empty list": [],
    "pair": (2, 3),
    "pair of NaN": (float("nan"), float("inf")),
    "huge pair": (1 << 30, 1 << 30),
    "negative pair": (-3, 4),
    "ragged": [[1, 2], [3]],
    "empty image": np.zeros((0, 4, 3), np.uint8),
    "line": np.zeros(7, np.float32),
    "four axes": np.zeros((2, 2, 2, 2), np.uint8),
    "complex": np.zeros((3, 4), complex),
    "text array": np.array([["a", "b"]]),
    "objects": np.array([[None, 1.5]]),
    "records": np.zeros((3, 4), [("a", "u1"), ("b", "f4")]),
    "dates": np.zeros((3, 4), "M8[s]"),
    "long doubles": np.zeros((3, 4), np.longdouble),
    "NaN image": np.full((3, 4), np.nan, np.float32),
    "NaN matrix": np.full((2, 3), np.nan),
    "infinite matrix": np.full((3, 3), np.inf),
    "masked": np.ma.masked_array(np.zeros((3, 4), np.uint8), True),
    "foreign": np.zeros((3, 4), ">f4"),
    "one pixel a terabyte of times": np.broadcast_to(np.zeros((1, 1), np.uint8), (1 << 20, 1 << 20)),
    "read-only": frozen,
    "unaligned": np.frombuffer(bytes(4 * 12 + 1), np.uint8)[1:].view(np.float32).reshape(3, 4),
}


@pytest.mark.parametrize("name", CALLS)
def test_junk_in_any_place_gives_a_result_or_opencvs_error(name: str) -> None:
    function, arguments = CALLS[name]
    function(*arguments)
    for place in range(len(arguments)):
        for kind, junk in JUNK.items():
            given = (*arguments[:place], junk, *arguments[place + 1 :])
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    function(*given)
            except ours.error:
                continue
            except Exception as other:
                parameter = list(inspect.signature(function).parameters)[place]
                raise AssertionError(f"{parameter} = {kind}: {type(other).__name__}: {other}") from other


def test_results_do_not_depend_on_where_arrays_lie() -> None:
    wide = np.zeros((5, 12, 3), np.uint8)
    wide[:, ::2] = IMAGE
    layouts = {
        "reversed": IMAGE[::-1].copy()[::-1],
        "mirrored": IMAGE[:, ::-1].copy()[:, ::-1],
        "channels reversed": IMAGE[..., ::-1].copy()[..., ::-1],
        "columns": wide[:, ::2],
        "fortran": np.asfortranarray(IMAGE),
    }
    for name, (function, arguments) in CALLS.items():
        if arguments[0] is not IMAGE:
            continue
        want = function(*arguments)
        for layout, image in layouts.items():
            got = function(image, *arguments[1:])
            for w, g in zip(
                want if isinstance(want, tuple | list) else [want],
                got if isinstance(got, tuple | list) else [got],
                strict=True,
            ):
                assert np.array_equal(w, g), (name, layout)


def test_outputs_that_share_memory_with_inputs() -> None:
    random = np.random.default_rng(3)
    base = random.integers(0, 256, (40, 30, 3), np.uint8)
    x, y = (random.random((20, 30)).astype(np.float32) * 18 for _ in range(2))
    turn = np.array([[0.9, -0.2, 3.0], [0.2, 0.9, 1.0]])
    calls: list[Callable[[Array, Array | None], Array]] = [
        lambda s, d: ours.remap(s, x, y, 1, d),
        lambda s, d: ours.warpAffine(s, turn, (30, 20), d),
        lambda s, d: ours.resize(s, (30, 20), d, interpolation=2),
        lambda s, d: ours.resize(s, (30, 20), d, interpolation=0),
    ]
    for call in calls:
        want = call(base[:20].copy(), None)
        for overlap in (base[:20], base[5:25], base[19:39]):
            memory = base.copy()
            start = (overlap.__array_interface__["data"][0] - base.__array_interface__["data"][0]) // 90
            into = memory[start : start + 20]
            got = call(memory[:20], into)
            assert got is into
            assert np.array_equal(got, want), start
    # A map that is the output.
    own = (np.random.default_rng(0).random((9, 8)) * 5).astype(np.float32)
    single = random.random((9, 8)).astype(np.float32)
    want = ours.remap(single, own.copy(), own.copy(), 1)
    assert np.array_equal(ours.remap(single, own, own.copy(), 1, own), want)


LARGEST = 1 << 30


@pytest.mark.parametrize(
    "call",
    [
        lambda: ours.resize(IMAGE, (10**9, 10**9)),
        lambda: ours.resize(IMAGE, (10**9, 10**9), interpolation=ours.INTER_CUBIC),
        lambda: ours.resize(IMAGE[::-1], (10**9, 10**9), interpolation=ours.INTER_AREA),
        lambda: ours.resize(IMAGE, None, fx=1e8, fy=1e8),
        lambda: ours.warpAffine(IMAGE, np.eye(2, 3), (LARGEST, LARGEST)),
        lambda: ours.warpPerspective(
            IMAGE, np.eye(3), (LARGEST, LARGEST), borderMode=ours.BORDER_TRANSPARENT
        ),
        lambda: ours.warpPolar(IMAGE, (10**9, 10**9), (2, 2), 3, 1),
        lambda: ours.warpPolar(IMAGE, (10**9, 10**9), (2, 2), 3, 1 | ours.WARP_INVERSE_MAP),
        lambda: ours.getRectSubPix(IMAGE, (LARGEST, LARGEST), (2, 2)),
        lambda: ours.initUndistortRectifyMap(CAMERA, None, None, None, (LARGEST, LARGEST), ours.CV_32FC1),
        lambda: ours.fisheye.undistortImage(IMAGE, CAMERA, np.zeros(4), new_size=(LARGEST, LARGEST)),
    ],
)
def test_sizes_beyond_all_memory_are_refused_at_once(call: Callable[[], object]) -> None:
    start = time.process_time()
    with pytest.raises(ours.error):
        call()
    # Nothing was made, cleared or computed: that would take minutes.
    assert time.process_time() - start < 1


def test_more_than_two_billion_elements() -> None:
    # Zeros that nobody writes take no memory: only the pages that are read exist.
    try:
        big = np.zeros((1 << 16, (1 << 15) + 8), np.uint8)
    except MemoryError:
        pytest.skip("the system does not lend this much address space")
    height, width = big.shape
    assert big.size > 1 << 31
    big[-2:, -2:] = [[10, 20], [30, 40]]
    x, y = (np.full((1, 2), n - 1.5, np.float64) for n in (width, height))
    crop = big[-9:, -9:].copy()
    near_x, near_y = (np.full((1, 2), 7.5) for _ in range(2))
    for kind in (ours.INTER_LINEAR, ours.INTER_CUBIC, ours.INTER_LANCZOS4):
        got = ours.remap(big, x, y, kind, borderMode=ours.BORDER_REFLECT_101, antialias=False)
        want = ours.remap(crop, near_x, near_y, kind, borderMode=ours.BORDER_REFLECT_101, antialias=False)
        assert np.array_equal(got, want)
    shift = np.array([[1.0, 0, width - 2], [0, 1, height - 2]])
    corner = ours.warpAffine(big, shift, (2, 2), flags=ours.WARP_INVERSE_MAP | ours.INTER_NEAREST)
    assert corner.tolist() == [[10, 20], [30, 40]]
    assert ours.getRectSubPix(big, (1, 1), (width - 1.5, height - 1.5)).tolist() == [[25]]
    assert ours.resize(big, (4, 4), interpolation=ours.INTER_NEAREST).tolist() == [[0] * 4] * 4
    with pytest.raises(ours.error):
        ours.resize(big, (1 << 30, 1 << 30), interpolation=ours.INTER_NEAREST)
    with pytest.raises(ours.error):
        ours.warpAffine(big, shift, (1 << 30, 1 << 30))
    plain = ski.warp(
        big, ski.AffineTransform(translation=(width - 2, height - 2)), output_shape=(2, 2), order=0
    )
    assert plain.tolist() == [[10, 20], [30, 40]]


@pytest.mark.parametrize("name", [n for n in ski.__all__ if n[0].islower()])
def test_junk_for_scikit_images_functions(name: str) -> None:
    image = np.random.default_rng(0).random((8, 9))
    usual: dict[str, tuple[Any, ...]] = {
        "warp": (image, np.eye(3)),
        "resize": (image, (4, 5)),
        "rescale": (image, 0.5),
        "rotate": (image, 30.0),
        "resize_local_mean": (image, (4, 5)),
        "downscale_local_mean": (image, (2, 3)),
        "integrate": (image, (0, 0), (3, 4)),
        "matrix_transform": ([[1.0, 2.0]], np.eye(3)),
        "warp_coords": (lambda xy: xy, (3, 4)),
        "swirl": (image, (3.0, 4.0), 1.0, 5.0, 0.0, (5, 6), 1, "reflect", 0.0),
        "warp_polar": (image, (3.0, 4.0)),
        "pyramid_reduce": (image, 2.0, 1.0, 1),
        "pyramid_expand": (image, 2.0, 1.0, 1),
        "pyramid_gaussian": (image, 3, 2.0, 1.0),
        "pyramid_laplacian": (image, 3, 2.0, 1.0),
    }
    function = getattr(ski, name)
    arguments = usual.get(name, (image,))
    if not inspect.isgeneratorfunction(function):
        function(*arguments)
    for place in range(len(arguments)):
        for kind, junk in JUNK.items():
            if name == "pyramid_laplacian" and place == 1 and kind in ("huge", "beyond 64 bits"):
                # As many layers as are asked for, one by one.
                continue
            if place == 0 and "terabyte" in kind:
                # A picture of this size is what is given.
                continue
            given = (*arguments[:place], junk, *arguments[place + 1 :])
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    result = function(*given)
                    if inspect.isgenerator(result):
                        list(result)
            except (ValueError, TypeError, MemoryError):
                continue


def test_junk_for_pytorchs_functions() -> None:
    image, grid = np.zeros((1, 1, 3, 4)), np.zeros((1, 2, 2, 2))
    calls: list[tuple[Callable[..., Any], tuple[Any, ...]]] = [
        (th.grid_sample, (image, grid, "bilinear", "zeros", False)),
        (th.grid_sample_backward, (np.zeros((1, 1, 2, 2)), image, grid, "bilinear", "zeros", False)),
        (th.affine_grid, (np.zeros((1, 2, 3)), (1, 1, 3, 4), False)),
        (th.affine_grid, (np.zeros((1, 2, 3)), [1, 1, 3, 4])),
        (th.interpolate, (image, (2, 3), None, "bilinear", False)),
        (th.interpolate, (image, None, (2.0, 0.5), "bicubic")),
    ]
    for function, arguments in calls:
        function(*arguments)
        for place in range(len(arguments)):
            for kind, junk in JUNK.items():
                given = (*arguments[:place], junk, *arguments[place + 1 :])
                try:
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")
                        function(*given)
                except (th.error, ValueError, TypeError, MemoryError):
                    pass
                except Exception as other:
                    raise AssertionError(f"{function.__name__} {place} {kind}: {other!r}") from other
