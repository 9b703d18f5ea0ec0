"""Calls drawn at random give what scikit-image gives: values, dtypes, warnings and errors."""

import platform
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import skimage.transform as theirs
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import multum.compat.skimage as ours

Array = NDArray[Any]
MODES = ("constant", "edge", "symmetric", "reflect", "wrap")
DTYPES = ("bool", "u1", "i1", "u2", "i2", "i4", "u4", "f2", "f4", "f8")
few = settings(max_examples=60, deadline=None, derandomize=True)


def outcome(function: Callable[..., Any], *args: Any, **options: Any) -> tuple[Any, set[str]]:
    """The result or the error, and the categories of the warnings."""
    copies = [a.copy() if isinstance(a, np.ndarray) else a for a in args]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            result = function(*copies, **options)
            result = list(result) if hasattr(result, "__next__") else result
        except Exception as error:
            result = error
    return result, {w.category.__name__ for w in caught}


def compare(name: str, *args: Any, **options: Any) -> None:
    theirs_is, their_warnings = outcome(getattr(theirs, name), *args, **options)
    ours_is, our_warnings = outcome(getattr(ours, name), *args, **options)
    if isinstance(theirs_is, Exception) or isinstance(ours_is, Exception):
        assert isinstance(ours_is, type(theirs_is)), (theirs_is, ours_is)
        return
    assert our_warnings == their_warnings
    pairs = (theirs_is, ours_is) if isinstance(theirs_is, list) else ([theirs_is], [ours_is])
    assert len(pairs[0]) == len(pairs[1])
    scale = max([1.0, abs(options.get("cval", 0.0))] + [top(a) for a in args if isinstance(a, np.ndarray)])
    for want, got in zip(*pairs, strict=True):
        assert (got.shape, got.dtype) == (want.shape, want.dtype)
        # Both sum about a hundred terms; singles have positions in singles, up to 20, times slopes.
        bound = scale * (2e-5 if want.dtype == np.float32 else 1e-12 if want.dtype.kind == "f" else 0)
        np.testing.assert_allclose(got.astype(float), want.astype(float), rtol=0, atol=bound)


def top(array: Array) -> float:
    return float(np.abs(array.astype(float)).max(initial=0))


def numbers(shape: tuple[int, ...], dtype: str, seed: int) -> Array:
    """An image that uses its dtype's range."""
    rng = np.random.default_rng(seed)
    kind = np.dtype(dtype).kind
    if kind == "b":
        return rng.random(shape) > 0.5
    if kind in "iu":
        limits = np.iinfo(dtype)
        return rng.integers(limits.min, limits.max, size=shape, dtype=np.dtype(dtype).type, endpoint=True)
    return (rng.uniform(-1, 1, shape) if seed % 2 else rng.uniform(0.3, 1.3, shape)).astype(dtype)


@st.composite
def images(draw: st.DrawFn, dtypes: tuple[str, ...] = DTYPES, axes: tuple[int, ...] = (2, 3)) -> Array:
    shape = tuple(draw(st.integers(1, 13)) for _ in range(2))
    if draw(st.sampled_from(axes)) == 3:
        shape += (draw(st.integers(1, 5)),)
    return numbers(shape, draw(st.sampled_from(dtypes)), draw(st.integers(0, 10**6)))


shapes = st.tuples(st.integers(1, 15), st.integers(1, 15))


@st.composite
def options(
    draw: st.DrawFn, /, orders: tuple[int, ...] = (0, 1, 3), **more: st.SearchStrategy[Any]
) -> dict[str, Any]:
    each: dict[str, st.SearchStrategy[Any]] = {
        "order": st.sampled_from(orders),
        "mode": st.sampled_from(MODES),
        "cval": st.sampled_from([0.0, 0.5, -3.0, 7.0]),
        "clip": st.booleans(),
        "preserve_range": st.booleans(),
        **more,
    }
    return {name: draw(values) for name, values in each.items() if draw(st.booleans())}


@st.composite
def matrices(draw: st.DrawFn) -> Array:
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    matrix = np.eye(3)
    matrix[:2] += rng.normal(size=(2, 3)) * [0.4, 0.4, 3]
    if draw(st.booleans()):
        matrix[2, :2] = rng.normal(size=2) * 0.02
    elif draw(st.booleans()):
        matrix = np.round(matrix * 2) / 2
    return matrix


def settled(how: dict[str, Any]) -> dict[str, Any]:
    """Without the clipping of linear interpolation by SciPy where a last bit decides about it: whether what lies
    outside counts depends there on whether its weighted sum, rounded, still reaches it."""
    return {**how, "clip": False} if how.get("cval") and how.get("order", 1) == 1 else how


def is_unsupported_there(image: Array, order: int | None) -> bool:
    """Half images at order 0, which SciPy refuses."""
    return image.dtype == np.float16 and order == 0


@few
@given(images(), matrices(), options(output_shape=shapes))
def test_warp_by_a_matrix(image: Array, matrix: Array, how: dict[str, Any]) -> None:
    if is_unsupported_there(image, how.get("order")):
        assert ours.warp(image, matrix, **how).dtype == image.dtype
        return
    compare("warp", image, matrix, **how)
    kind = theirs.ProjectiveTransform if matrix[2, :2].any() else theirs.AffineTransform
    compare("warp", image, kind(matrix), **how)
    same, _ = outcome(ours.warp, image, getattr(ours, kind.__name__)(matrix), **how)
    if not isinstance(same, Exception):
        np.testing.assert_array_equal(same, ours.warp(image, matrix, **how))


@few
@given(images(("f8",)), matrices(), options((1,), output_shape=shapes))
def test_linear_warps_have_their_bits(image: Array, matrix: Array, how: dict[str, Any]) -> None:
    got, want = ours.warp(image, matrix, **how), theirs.warp(image, matrix, **how)
    if platform.machine() in ("x86_64", "AMD64"):
        np.testing.assert_array_equal(got, want)
    else:
        # Other compilers may fuse multiplications and additions.
        np.testing.assert_allclose(got, want, rtol=0, atol=1e-12 * max(1, abs(how.get("cval", 0))))


@few
@given(images(tuple(set(DTYPES) - {"f2"}), (2,)), st.integers(0, 10**6), shapes, options())
def test_warp_at_coordinates(image: Array, seed: int, shape: tuple[int, int], how: dict[str, Any]) -> None:
    rng = np.random.default_rng(seed)
    places = rng.uniform(-4, 18, (2, *shape))
    compare("warp", image, np.round(places * 2) / 2 if seed % 3 == 0 else places, **settled(how))


@few
@given(images(tuple(set(DTYPES) - {"f2"})), options((0, 1), output_shape=shapes))
def test_warp_by_a_function(image: Array, how: dict[str, Any]) -> None:
    compare("warp", image, lambda xy, by: xy[:, ::-1] * 0.9 + by, map_args={"by": 1.3}, **settled(how))


@few
@given(images(tuple(set(DTYPES) - {"f2"}), (2,)), st.sampled_from([0.0, 30.0, 45.0, 90.0, -77.3]), options())
def test_turns(image: Array, angle: float, how: dict[str, Any]) -> None:
    if how.get("order", 0 if image.dtype == bool else 1) == 0:
        # Whole turns lead to places half way between pixels, where the last bit of a cosine decides.
        angle += 0.1
    compare("rotate", image, angle, resize=len(how) % 2 == 0, **how)
    compare("swirl", image, strength=2.1, radius=12.3, center=(3.1, 2.7), **settled(how))


@few
@given(images(("u1", "f4", "f8"), (3,)), st.sampled_from(["linear", "log", "cubic"]), options((1,)))
def test_polar(image: Array, scaling: str, how: dict[str, Any]) -> None:
    compare(
        "warp_polar", np.moveaxis(image, -1, 0), scaling=scaling, channel_axis=0, output_shape=(7, 9), **how
    )
    compare("warp_polar", image[..., 0], scaling=scaling, center=(2.2, 3.1), radius=5.5, **settled(how))
    compare("warp_polar", image, scaling=scaling, **settled(how))


smoothing = {
    "anti_aliasing": st.sampled_from([None, False, True]),
    "anti_aliasing_sigma": st.sampled_from([None, 0.0, 0.7, 2.5, -1.0]),
}


@few
@given(images(), shapes, options((0, 1, 2, 3, 5), **smoothing))
def test_resize(image: Array, shape: tuple[int, int], how: dict[str, Any]) -> None:
    compare("resize", image, shape, **how)


@few
@given(st.integers(0, 99), st.tuples(*[st.integers(1, 9)] * 3), options((0, 1, 4), **smoothing))
def test_resize_volumes(seed: int, shape: tuple[int, ...], how: dict[str, Any]) -> None:
    compare("resize", numbers((4, 6, 5), "f8", seed), shape, **how)
    compare("resize", numbers((4, 6), "f4", seed), shape, **how)


@few
@given(
    images(("u1", "i2", "f4", "f8"), (3,)),
    options((0, 1), **smoothing),
    st.sampled_from([0.3, 0.5, 1.0, 1.6]),
)
def test_rescale(image: Array, how: dict[str, Any], scale: float) -> None:
    compare("rescale", image, scale, channel_axis=-1, **how)
    compare("rescale", np.moveaxis(image, -1, 0), (scale, 0.7), channel_axis=0, **how)
    compare("rescale", image[..., 0], (scale, 0.7, 1.0), **how)
    compare("rescale", image, scale, **how)


@few
@given(images(), st.tuples(*[st.integers(0, 4)] * 2), st.sampled_from([0.0, 3.0, -2.0]))
def test_local_means(image: Array, factors: tuple[int, int], cval: float) -> None:
    if image.dtype.kind in "bu" and cval < 0:
        cval = 1.0
    blocks = factors if image.ndim == 2 else (*factors, 1)
    if image.dtype == np.float16:
        # The order of additions in halves is NumPy's own affair.
        got, _ = outcome(ours.downscale_local_mean, image, blocks, cval)
        assert min(factors) == 0 or got.dtype == np.float16
        return
    compare("downscale_local_mean", image, blocks, cval)


@few
@given(images(), shapes, st.booleans(), st.booleans())
def test_resize_local_mean(image: Array, shape: tuple[int, int], grid: bool, preserve: bool) -> None:
    axis = -1 if image.ndim == 3 else None
    if not grid and 1 in image.shape[:2]:
        # A single pixel has no area between centres: 0 / 0 there, a sum that is empty here.
        return
    compare("resize_local_mean", image, shape, grid_mode=grid, preserve_range=preserve, channel_axis=axis)


@few
@given(
    images(),
    st.sampled_from([1.0, 1.5, 2.0, 3.0]),
    st.sampled_from([None, 0.4, 2.0]),
    st.sampled_from([0, 1, 3]),
    st.sampled_from(["reflect", "constant", "wrap"]),
    st.booleans(),
)
def test_pyramids(
    image: Array, factor: float, sigma: float | None, order: int, mode: str, preserve: bool
) -> None:
    how: dict[str, Any] = {"sigma": sigma, "order": order, "mode": mode, "preserve_range": preserve}
    how["channel_axis"] = -1 if image.ndim == 3 else None
    for name in ("pyramid_reduce", "pyramid_expand"):
        compare(name, image, factor, **how)
    for name in ("pyramid_gaussian", "pyramid_laplacian"):
        compare(name, image, 2, factor, **how)
        if order < 2:
            compare(name, image, downscale=factor, **how)


@few
@given(images(), st.integers(0, 10**6))
def test_integrals(image: Array, seed: int) -> None:
    compare("integral_image", image)
    compare("integral_image", image, dtype=np.float32)
    rng = np.random.default_rng(seed)
    table = theirs.integral_image(image.astype(float))
    start = rng.integers(-np.array(image.shape), image.shape, size=(4, image.ndim))
    end = np.minimum(start + rng.integers(-(seed % 2), 4, size=start.shape), np.array(image.shape) - 1)
    compare("integrate", table, [tuple(s) for s in start.tolist()], [tuple(e) for e in end.tolist()])
    compare("integrate", table, tuple(start[0].tolist()), tuple(start[0].tolist()))


def test_warp_coords() -> None:
    for shape in ((3, 4), (3, 4, 2)):
        compare("warp_coords", lambda xy: xy * 2 + 1, shape)
        compare("warp_coords", lambda xy: xy[:, ::-1], shape, np.float32)


def test_transforms_have_their_matrices() -> None:
    parts: dict[str, Any] = {"rotation": 0.7, "translation": (3.0, -2.0)}
    cases: list[tuple[str, dict[str, Any]]] = [
        ("EuclideanTransform", parts),
        ("SimilarityTransform", {**parts, "scale": 1.7}),
        ("AffineTransform", {**parts, "scale": (1.7, 0.4), "shear": 0.3}),
        ("AffineTransform", {**parts, "scale": 2.0, "shear": (0.3, 0.2)}),
        ("ProjectiveTransform", {"matrix": np.array([[1, 0.2, 3], [0.1, 2, 1], [0.01, 0.02, 1]])}),
        ("AffineTransform", {}),
    ]
    points = np.array([[0.0, 0.0], [3.0, -1.0], [10.0, 4.0]])
    for name, how in cases:
        mine, other = getattr(ours, name)(**how), getattr(theirs, name)(**how)
        np.testing.assert_allclose(mine.params, other.params, rtol=0, atol=1e-15)
        np.testing.assert_allclose(mine(points), other(points), rtol=1e-14)
        np.testing.assert_allclose(mine.inverse(points), other.inverse(points), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose((mine + mine).params, (other + other).params, rtol=0, atol=1e-13)
        for attribute in ("rotation", "scale", "shear", "translation"):
            if hasattr(other, attribute):
                assert np.allclose(getattr(mine, attribute), getattr(other, attribute)), attribute
        np.testing.assert_allclose(
            ours.matrix_transform(points, other.params),
            theirs.matrix_transform(points, other.params),
            rtol=1e-14,
        )
        with pytest.raises(ValueError, match="matrix"):
            getattr(ours, name)(np.eye(4))
    with pytest.raises(ValueError, match="parts"):
        ours.AffineTransform(np.eye(3), rotation=1.0)
    with pytest.raises(TypeError):
        ours.ProjectiveTransform() + 3  # type: ignore[operator]


def test_splines_of_colour_images_are_those_of_their_channels() -> None:
    image = numbers((9, 11, 3), "f8", 5)

    def turned(xy: Array) -> Array:
        return np.asarray(xy @ np.array([[0.9, 0.2], [-0.2, 0.9]]))

    for order in (2, 3, 4, 5):
        got, caught = outcome(ours.warp, image, turned, order=order, mode="symmetric", clip=False)
        assert caught == ({"UserWarning"} if order == 2 else set())
        for k in range(3):
            want, _ = outcome(theirs.warp, image[..., k], turned, order=order, mode="symmetric", clip=False)
            np.testing.assert_allclose(got[..., k], want, rtol=0, atol=1e-12)


def test_warnings_begin_with_the_words_that_programs_filter_by() -> None:
    image = np.random.default_rng(0).random((9, 9))
    for words, name, arguments, options in (
        ("Bi-quadratic.*bug", "warp", (image, np.eye(3)), {"order": 2}),
        (
            "Anti-aliasing standard deviation greater",
            "resize",
            (image, (4, 12)),
            {"anti_aliasing": True, "anti_aliasing_sigma": 1.0},
        ),
    ):
        for module in (theirs, ours):
            with pytest.warns(UserWarning, match=words):
                getattr(module, name)(*arguments, **options)
