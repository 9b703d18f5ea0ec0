"""Sampling by PyTorch's rules: against its recorded results, sums written out here, and differences."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import multum.compat.torch as mt

Array = NDArray[Any]
GOLDEN = Path(__file__).with_name("golden") / "torch.npz"
MODES = ("bilinear", "nearest", "bicubic")
PADDINGS = ("zeros", "border", "reflection")
few = settings(max_examples=60, deadline=None, derandomize=True)


class Tensor:
    """A tensor of a library that is this module: DLPack and nothing else."""

    def __init__(self, array: Array) -> None:
        self.array = array

    def __dlpack__(self, **options: Any) -> Any:
        return self.array.__dlpack__(**options)

    def __dlpack_device__(self) -> Any:
        return self.array.__dlpack_device__()


def from_dlpack(array: Array) -> Tensor:
    return Tensor(array)


def weights(at: float, mode: str) -> dict[int, float]:
    """Pixels and weights of one axis, by definition."""
    if mode == "nearest":
        return {round(at): 1.0}
    low = int(np.floor(at))
    if mode == "bilinear":
        return {low: low + 1 - at, low + 1: at - low}
    found = {}
    for i in range(low - 1, low + 3):
        d, a = abs(at - i), -0.75
        near = (a + 2) * d**3 - (a + 3) * d**2 + 1
        found[i] = near if d <= 1 else a * (d**3 - 5 * d**2 + 8 * d - 4)
    return found


def inside(i: int, n: int, padding: str, align: bool) -> int | None:
    """The pixel that stands at i, walking back and forth where the image is reflected."""
    if 0 <= i < n:
        return i
    if padding == "zeros":
        return None
    if padding == "border":
        return min(max(i, 0), n - 1)
    if align and n == 1:
        return 0
    line: list[int] = [*range(n), *(range(n - 2, 0, -1) if align else range(n - 1, -1, -1))]
    return line[i % len(line)]


def by_definition(image: Array, grid: Array, mode: str, padding: str, align: bool) -> Array:
    batch, channels, height, width = image.shape
    out = np.zeros((batch, channels, *grid.shape[1:3]))
    for n, y, x in np.ndindex(*grid.shape[:3]):
        u, v = (float(c) for c in grid[n, y, x])
        at_x = (u + 1) / 2 * (width - 1) if align else ((u + 1) * width - 1) / 2
        at_y = (v + 1) / 2 * (height - 1) if align else ((v + 1) * height - 1) / 2
        for j, wy in weights(at_y, mode).items():
            for i, wx in weights(at_x, mode).items():
                row, column = inside(j, height, padding, align), inside(i, width, padding, align)
                if row is not None and column is not None:
                    out[n, :, y, x] += wy * wx * image[n, :, row, column]
    return out


@st.composite
def calls(draw: st.DrawFn) -> tuple[Array, Array, str, str, bool]:
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    size = [draw(st.integers(1, n)) for n in (2, 4, 7, 7)]
    dtype = draw(st.sampled_from([np.float32, np.float64]))
    image = rng.normal(size=size).astype(dtype)
    grid = rng.uniform(-1.8, 1.8, (size[0], draw(st.integers(1, 5)), draw(st.integers(1, 5)), 2)).astype(
        dtype
    )
    return image, grid, draw(st.sampled_from(MODES)), draw(st.sampled_from(PADDINGS)), draw(st.booleans())


@few
@given(calls())
def test_samples_are_the_sums_that_define_them(call: tuple[Array, Array, str, str, bool]) -> None:
    image, grid, how = call[0], call[1], call[2:]
    got = mt.grid_sample(image, grid, *how)
    want = by_definition(image, grid, *how)
    assert got.dtype == image.dtype
    # Positions in singles are wrong by 10 * 2^-24, and slopes are below 10 here.
    bound = 2e-5 if image.dtype == np.float32 else 1e-12
    np.testing.assert_allclose(got, want, rtol=0, atol=bound)


def golden() -> list[dict[str, Any]]:
    with np.load(GOLDEN) as stored:
        cases: list[dict[str, Any]] = json.loads(str(stored["description"]))
        numbers = stored["numbers"]
    for case in cases:
        for name, value in case.items():
            if isinstance(value, list):
                dtype, *shape = value
                count = int(np.prod(shape))
                case[name] = numbers[:count].astype(dtype).reshape(shape)
                numbers = numbers[count:]
    return cases


def test_results_are_those_that_pytorch_gave() -> None:
    """tests/python/golden/make_torch.py wrote them with PyTorch."""
    seen = set()
    for case in golden():
        kind = case.pop("kind")
        seen.add(kind)
        wanted = {key: case.pop(key) for key in ("output", "grad_input", "grad_grid") if key in case}
        bound = 3e-5 if wanted["output"].dtype == np.float32 else 1e-12
        if kind == "grid_sample":
            above = case.pop("grad_output")
            got = [mt.grid_sample(**case), *mt.grid_sample_backward(above, **case)]
        else:
            case = {k: tuple(v.tolist()) if k in ("size", "scale_factor") else v for k, v in case.items()}
            got = [getattr(mt, kind)(**case)]
        for result, want in zip(got, wanted.values(), strict=True):
            assert (result.shape, result.dtype) == (want.shape, want.dtype)
            np.testing.assert_allclose(result, want, rtol=0, atol=bound * max(1, np.abs(want).max()))
    assert seen == {"grid_sample", "affine_grid", "interpolate"}


@few
@given(calls(), st.integers(0, 10**6))
def test_gradients_are_adjoint_and_differences(call: tuple[Array, Array, str, str, bool], seed: int) -> None:
    image, grid, mode, padding, align = call
    image, grid = image.astype(float), grid.astype(float)
    rng = np.random.default_rng(seed)
    above = rng.normal(size=(*image.shape[:2], *grid.shape[1:3]))
    how = (mode, padding, align)
    to_image, to_grid = mt.grid_sample_backward(above, image, grid, *how)
    # The output is linear in the image: the gradient is the transpose of that map.
    other = rng.normal(size=image.shape)
    left, right = (above * mt.grid_sample(other, grid, *how)).sum(), (to_image * other).sum()
    assert abs(left - right) <= 1e-11 * max(1.0, np.abs(above).sum() * np.abs(other).max())
    step = 1e-6
    for axis in (0, 1):
        n = image.shape[3 - axis]
        at = mt._grid.in_pixels(grid[..., axis], n, align)
        ahead, behind = grid.copy(), grid.copy()
        ahead[..., axis] += step
        behind[..., axis] -= step
        change = (mt.grid_sample(image, ahead, *how) - mt.grid_sample(image, behind, *how)) / (2 * step)
        want = (above * change).sum(axis=1)
        # Corners of the interpolation, where there is no derivative, are at whole and half pixels.
        smooth = np.abs(at * 2 - np.rint(at * 2)) > 1e-3
        np.testing.assert_allclose(to_grid[..., axis][smooth], want[smooth], rtol=0, atol=1e-6)


def test_affine_grids_are_matrices_times_positions() -> None:
    theta = np.array([[[0.5, 0.2, 0.1], [-0.3, 1.5, -0.4]]])
    grid = mt.affine_grid(theta, (1, 3, 4, 6), align_corners=False)
    for y, x in np.ndindex(4, 6):
        place = np.array([(x + 0.5) / 6 * 2 - 1, (y + 0.5) / 4 * 2 - 1, 1])
        np.testing.assert_allclose(grid[0, y, x], theta[0] @ place, rtol=0, atol=1e-15)
    ends = mt.affine_grid(np.eye(2, 3)[None], (1, 1, 2, 3), True)
    assert ends[0, :, :, 0].tolist() == [[-1, 0, 1]] * 2
    assert ends[0, :, 0, 1].tolist() == [-1, 1]
    assert mt.affine_grid(np.eye(3, 4)[None], (1, 1, 2, 2, 2), True)[0, 1, 0, 1].tolist() == [1, -1, 1]


@few
@given(
    st.tuples(*[st.integers(1, 12)] * 4),
    st.sampled_from(["bilinear", "bicubic", "area", "nearest", "nearest-exact"]),
    st.booleans(),
)
def test_resizing_keeps_constants_and_bilinear_keeps_ramps(
    sizes: tuple[int, ...], mode: str, antialias: bool
) -> None:
    height, width, *new = sizes
    antialias &= mode in ("bilinear", "bicubic")
    flat = np.full((1, 2, height, width), 0.3)
    got = mt.interpolate(flat, size=new, mode=mode, antialias=antialias)
    assert got.shape == (1, 2, *new)
    # Up to 12 weights an axis, each with an error of its own.
    np.testing.assert_allclose(got, 0.3, rtol=24 * np.finfo(float).eps)
    if mode == "bilinear" and not antialias:
        ramp = np.broadcast_to(np.arange(width, dtype=float), (1, 1, height, width))
        line = mt.interpolate(ramp, size=new, mode=mode)[0, 0, 0]
        at = (np.arange(new[1]) + 0.5) * width / new[1] - 0.5
        # Away from the ends, which are repeated.
        middle = (at >= 1) & (at <= width - 2)
        np.testing.assert_allclose(line[middle], at[middle], rtol=0, atol=1e-12)


def test_memory_layouts_give_the_same() -> None:
    rng = np.random.default_rng(3)
    image, grid = rng.normal(size=(2, 3, 6, 5)), rng.uniform(-1, 1, (2, 4, 3, 2))
    want = mt.grid_sample(image, grid, align_corners=False)
    wide = np.zeros((2, 3, 12, 10))
    wide[:, :, ::2, ::2] = image
    last = np.ascontiguousarray(image.transpose(0, 2, 3, 1)).transpose(0, 3, 1, 2)
    fixed = image.copy()
    fixed.flags.writeable = False
    swapped = image.astype(">f8")
    reversed_twice = np.ascontiguousarray(image[:, :, ::-1, ::-1])[:, :, ::-1, ::-1]
    for other in (wide[:, :, ::2, ::2], last, fixed, swapped, reversed_twice):
        np.testing.assert_allclose(mt.grid_sample(other, grid, align_corners=False), want, rtol=0, atol=1e-15)
        np.testing.assert_array_equal(
            mt.interpolate(other, size=(3, 3), mode="area"), mt.interpolate(image, size=(3, 3), mode="area")
        )
    half = mt.grid_sample(image.astype(np.float16), grid.astype(np.float16), align_corners=False)
    assert half.dtype == np.float16
    np.testing.assert_allclose(half, want, rtol=0, atol=0.03)


def test_tensors_come_and_go_through_dlpack() -> None:
    rng = np.random.default_rng(4)
    image, grid = rng.normal(size=(1, 2, 4, 4)), rng.uniform(-1, 1, (1, 3, 3, 2))
    want = mt.grid_sample(image, grid, align_corners=False)
    got = mt.grid_sample(Tensor(image), Tensor(grid), align_corners=False)
    assert isinstance(got, Tensor)
    np.testing.assert_array_equal(got.array, want)
    to_image, to_grid = mt.grid_sample_backward(Tensor(want), Tensor(image), grid, align_corners=False)
    assert isinstance(to_image, Tensor)
    assert isinstance(to_grid, np.ndarray)
    # In place: the tensor's own memory is read.
    assert np.shares_memory(mt._tensors.array("input", Tensor(image)), image)


def test_positions_that_are_no_numbers() -> None:
    image = np.arange(1.0, 10.0).reshape(1, 1, 3, 3)
    grid = np.array([[[[np.nan, 0], [0, np.inf], [-np.inf, np.nan], [1e300, 0]]]])
    # What PyTorch 2.15 gives at the first three; the fourth is outside.
    known: dict[tuple[str, str], list[float]] = {
        ("bilinear", "zeros"): [np.nan] * 3 + [0],
        ("bilinear", "border"): [4, 8, 1, 6],
        ("bilinear", "reflection"): [4, 2, 1],
        ("nearest", "zeros"): [0, 0, 0, 0],
        ("nearest", "border"): [4, 8, 1, 6],
        ("nearest", "reflection"): [4, 2, 1],
        ("bicubic", "zeros"): [np.nan] * 3 + [0],
        ("bicubic", "border"): [np.nan] * 3 + [6],
        ("bicubic", "reflection"): [np.nan] * 3,
    }
    for (mode, padding), want in known.items():
        got = mt.grid_sample(image, grid, mode, padding, False).ravel()
        np.testing.assert_array_equal(got[: len(want)], want)
    for mode in MODES:
        to_image, to_grid = mt.grid_sample_backward(np.ones((1, 1, 1, 4)), image, grid, mode, "zeros", False)
        assert not to_image.any()
        assert not to_grid.any()
    assert mt.grid_sample(image[:0], grid[:0], align_corners=False).shape == (0, 1, 1, 4)
    assert mt.grid_sample(image, grid[:, :, :0], align_corners=False).shape == (1, 1, 1, 0)


def test_wrong_arguments_are_named() -> None:
    image, grid = np.zeros((1, 2, 4, 5)), np.zeros((1, 3, 3, 2))
    cases: list[tuple[str, str, tuple[Any, ...], dict[str, Any]]] = [
        ("mode", "grid_sample", (image, grid, "linear"), {}),
        ("padding_mode", "grid_sample", (image, grid, "nearest", "wrap"), {}),
        ("grid", "grid_sample", (image, grid[..., :1]), {}),
        ("grid", "grid_sample", (image, grid.astype(np.float32)), {}),
        ("grid", "grid_sample", (np.zeros((2, 2, 4, 5)), grid), {}),
        ("input", "grid_sample", (np.zeros((1, 2, 4, 5, 6)), grid), {}),
        ("input", "grid_sample", (image.astype(int), grid), {}),
        ("input", "grid_sample", (image[:, :, :0], grid), {}),
        ("grad_output", "grid_sample_backward", (np.zeros((1, 2, 3, 4)), image, grid), {}),
        ("theta", "affine_grid", (np.zeros((2, 2, 3)), (1, 1, 3, 3)), {}),
        ("size", "affine_grid", (np.zeros((1, 2, 3)), (1, 1, 0, 3)), {}),
        ("size", "interpolate", (image,), {}),
        ("size", "interpolate", (image, 3, 2.0), {}),
        ("size", "interpolate", (image, (3, 0)), {}),
        ("size", "interpolate", (image, (3, 4, 5)), {}),
        ("mode", "interpolate", (image, 3), {"mode": "lanczos"}),
        ("align_corners", "interpolate", (image, 3), {"align_corners": True}),
        ("antialias", "interpolate", (image, 3), {"antialias": True}),
        ("input", "interpolate", (image[0], 3), {}),
        ("input", "interpolate", (image.astype(int), 3), {"mode": "area"}),
    ]
    for name, call, arguments, options in cases:
        if call != "interpolate":
            options = {"align_corners": False}
        with pytest.raises(mt.error, match=name):
            getattr(mt, call)(*arguments, **options)
    with pytest.warns(UserWarning, match="align_corners"):
        mt.grid_sample(image, grid)
    assert issubclass(mt.error, RuntimeError)
    assert issubclass(mt.error, ValueError)


def test_the_autograd_function_is_there_where_pytorch_is() -> None:
    try:
        import torch
    except ImportError:
        with pytest.raises(ImportError, match="PyTorch"):
            _ = mt.GridSample
        return
    image = torch.rand(2, 3, 5, 6, dtype=torch.float64, requires_grad=True)
    grid = (torch.rand(2, 4, 4, 2, dtype=torch.float64) * 1.6 - 0.8).requires_grad_()
    for mode in ("bilinear", "bicubic"):
        assert torch.autograd.gradcheck(
            lambda a, b, mode=mode: mt.GridSample.apply(a, b, mode, "zeros", False), (image, grid)
        )
