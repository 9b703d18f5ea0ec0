"""Random calls of ``skimage.transform`` and ``multum.compat.skimage``: results, dtypes, errors and warnings."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import skimage.transform as theirs
from numpy.typing import NDArray

import multum.compat.skimage as ours

from .pictures import laid_out, picture
from .verdicts import Call

Array = NDArray[Any]
Random = np.random.Generator

DTYPES = ("uint8", "uint16", "int16", "int8", "float32", "float64", "float16", "bool", "int32")
MORE = "more is taken"
NAN = "NaN beyond the picture or in it"
ACROSS = "splines across channels"
MODES = ("constant", "edge", "symmetric", "reflect", "wrap")


def pick(rng: Random, values: Any) -> Any:
    items = list(values)
    return items[int(rng.integers(len(items)))]


def image(rng: Random, axes: int | None = None) -> tuple[Array, Array, str]:
    """The same picture twice: plain, and somewhere in memory."""
    count = axes or int(pick(rng, (2, 2, 2, 3, 3)))
    shape = tuple(int(rng.integers(2, 40)) for _ in range(2))
    shape += tuple(int(rng.integers(1, 5)) for _ in range(count - 2))
    plain = picture(rng, shape, pick(rng, DTYPES))
    if plain.dtype.kind == "f" and rng.random() < 0.1:
        plain[tuple(int(rng.integers(n)) for n in shape)] = np.nan
    placed, layout = laid_out(rng, plain)
    return plain, placed, f"{plain.dtype} {shape} {layout}"


def reason(name: str, plain: Array, options: dict[str, Any], by_matrix: bool) -> str | None:
    """The paragraph of docs/peers.md that explains a difference here, if there is one."""
    if name.startswith("pyramid") and options.get("mode") in ("edge", "symmetric"):
        return MORE
    if plain.dtype == np.float16 and options.get("order") == 0:
        return MORE
    if np.isnan(options.get("cval", 0.0)) or (plain.dtype.kind == "f" and np.isnan(plain).any()):
        return NAN
    # Order 3 by a matrix is Catmull and Rom's.
    if plain.ndim == 3 and (options.get("order") or 0) >= 2 and not (by_matrix and options["order"] == 3):
        return ACROSS
    return None


def call(name: str, plain: Array, placed: Array, text: str, *arguments: Any, **options: Any) -> Call:
    shown = {k: v for k, v in options.items() if not callable(v)}
    # Singles are computed in singles by both, in another order of additions.
    single = plain.dtype in (np.float32, np.float16)

    def made(module: Any, picture: Array) -> Any:
        result = getattr(module, name)(picture, *arguments, **options)
        return list(result) if name in ("pyramid_gaussian", "pyramid_laplacian") else result

    return Call(
        name,
        lambda: made(theirs, plain),
        lambda: made(ours, placed),
        f"{text} {arguments if name != 'warp' else ''} {shown}",
        step=0,
        rounding=3e-5 if single else 1e-10,
        warnings=True,
        reason=reason(name, plain, options, name == "rotate" or (name == "warp" and "matrix" in text)),
    )


def common(rng: Random, plain: Array, orders: Any = (0, 1, 1, 1, 3, None, None)) -> dict[str, Any]:
    options: dict[str, Any] = {}
    if rng.random() < 0.7:
        options["order"] = pick(rng, orders)
    if rng.random() < 0.7:
        options["mode"] = pick(rng, MODES)
    if rng.random() < 0.4:
        options["cval"] = float(pick(rng, (0.0, 0.5, 3.0, -1.0, float("nan"))))
    if rng.random() < 0.3:
        options["clip"] = bool(rng.random() < 0.5)
    if rng.random() < 0.4:
        options["preserve_range"] = bool(rng.random() < 0.7)
    return options


def warp(rng: Random) -> Call:
    plain, placed, text = image(rng)
    options = common(rng, plain, (0, 1, 1, 1, 2, 3, 4, 5, None, None))
    h, w = plain.shape[:2]
    angle, scale = rng.uniform(-3, 3), rng.uniform(0.4, 2)
    matrix = theirs.SimilarityTransform(
        scale=scale, rotation=angle, translation=rng.uniform(-9, 30, 2)
    ).params
    if rng.random() < 0.3:
        matrix[2, :2] = rng.uniform(-0.3, 0.3, 2) / (w, h)
    if rng.random() < 0.6:
        options["output_shape"] = tuple(int(n) for n in rng.integers(1, 50, 2))
    form = pick(rng, ("matrix", "object", "inverse", "callable", "coordinates"))
    if form == "matrix":
        inverse: Any = matrix
    elif form == "object":
        inverse = theirs.ProjectiveTransform(matrix)
    elif form == "inverse":
        inverse = theirs.ProjectiveTransform(matrix).inverse
    elif form == "callable":

        def waves(xy: Array) -> Array:
            moved: Array = xy * 0.9 + 3 * np.sin(xy[:, ::-1] / 7)
            return moved

        inverse = waves
    else:
        shape = options.pop("output_shape", (9, 11))
        inverse = rng.uniform(-4, 40, (plain.ndim, *shape, *plain.shape[2:]))
    return call("warp", plain, placed, f"{text} {form}", inverse, **options)


def resize(rng: Random) -> Call:
    plain, placed, text = image(rng, pick(rng, (1, 2, 2, 3, 3, 4)) if rng.random() < 0.2 else None)
    if plain.ndim == 1:
        plain = placed = plain[:, 0] if plain.ndim > 1 else plain
    options = common(rng, plain)
    if rng.random() < 0.4:
        options["anti_aliasing"] = pick(rng, (True, False, None))
    if rng.random() < 0.2:
        options["anti_aliasing_sigma"] = float(pick(rng, (0.0, 0.7, 1.5)))
    shape = tuple(int(n) for n in rng.integers(1, 50, 2))
    if rng.random() < 0.4:
        shape += tuple(plain.shape[2:])
    return call("resize", plain, placed, text, shape, **options)


def rescale(rng: Random) -> Call:
    plain, placed, text = image(rng)
    options = common(rng, plain)
    if rng.random() < 0.4:
        options["anti_aliasing"] = pick(rng, (True, False, None))
    if plain.ndim == 3 and rng.random() < 0.7:
        options["channel_axis"] = pick(rng, (-1, 2))
    scale: Any = float(rng.uniform(0.2, 2.5))
    if rng.random() < 0.2:
        scale = tuple(float(s) for s in rng.uniform(0.3, 2, plain.ndim - ("channel_axis" in options)))
    return call("rescale", plain, placed, text, scale, **options)


def rotate(rng: Random) -> Call:
    plain, placed, text = image(rng)
    options = common(rng, plain)
    if rng.random() < 0.4:
        options["resize"] = True
    if rng.random() < 0.3:
        options["center"] = tuple(float(c) for c in rng.uniform(0, 20, 2))
    return call("rotate", plain, placed, text, float(pick(rng, (0, 90, 180, 33.3, -71, 400))), **options)


def swirl(rng: Random) -> Call:
    plain, placed, text = image(rng)
    options = common(rng, plain)
    options |= {"strength": float(rng.uniform(0, 8)), "radius": float(rng.uniform(3, 60))}
    if rng.random() < 0.3:
        options["rotation"] = float(rng.uniform(-3, 3))
    if rng.random() < 0.3:
        options["center"] = tuple(float(c) for c in rng.uniform(0, 20, 2))
    return call("swirl", plain, placed, text, **options)


def warp_polar(rng: Random) -> Call:
    plain, placed, text = image(rng)
    options = common(rng, plain)
    options["scaling"] = pick(rng, ("linear", "log"))
    if plain.ndim == 3 and rng.random() < 0.9:
        options["channel_axis"] = -1
    if rng.random() < 0.4:
        options["radius"] = float(rng.uniform(2, 40))
    if rng.random() < 0.5:
        options["output_shape"] = tuple(int(n) for n in rng.integers(2, 50, 2))
    return call("warp_polar", plain, placed, text, **options)


def pyramid(rng: Random) -> Call:
    plain, placed, text = image(rng)
    name = pick(rng, ("pyramid_reduce", "pyramid_expand", "pyramid_gaussian", "pyramid_laplacian"))
    options = common(rng, plain, (0, 1, 1, 3))
    options.pop("clip", None)
    if options.get("mode") in ("edge", "symmetric") and rng.random() < 0.9:
        # Documented there, but refused.
        options["mode"] = "reflect"
    if plain.ndim == 3 and rng.random() < 0.8:
        options["channel_axis"] = -1
    factor = "upscale" if name == "pyramid_expand" else "downscale"
    if rng.random() < 0.5:
        options[factor] = float(rng.uniform(1.2, 3))
    if rng.random() < 0.3:
        options["sigma"] = float(rng.uniform(0, 2))
    if name in ("pyramid_gaussian", "pyramid_laplacian") and rng.random() < 0.6:
        options["max_layer"] = int(rng.integers(0, 4))
    return call(name, plain, placed, text, **options)


def means(rng: Random) -> Call:
    plain, placed, text = image(rng)
    if rng.random() < 0.5:
        factors: Any = tuple(int(n) for n in rng.integers(1, 6, plain.ndim))
        if rng.random() < 0.3:
            factors = int(rng.integers(1, 5))
        options = {"cval": float(rng.integers(0, 3))} if rng.random() < 0.3 else {}
        return call("downscale_local_mean", plain, placed, text, factors, **options)
    shape = tuple(int(n) for n in rng.integers(1, 50, 2))
    options = {"grid_mode": bool(rng.random() < 0.7), "preserve_range": bool(rng.random() < 0.3)}
    if plain.ndim == 3:
        options["channel_axis"] = -1
    return call("resize_local_mean", plain, placed, text, shape, **options)


def integral(rng: Random) -> Call:
    plain, placed, text = image(rng)
    if rng.random() < 0.5:
        options = {"dtype": pick(rng, (np.float64, np.float32, None))} if rng.random() < 0.4 else {}
        return call("integral_image", plain, placed, text, **options)
    table = theirs.integral_image(plain[..., 0] if plain.ndim == 3 else plain)
    low = [tuple(int(rng.integers(0, n)) for n in table.shape) for _ in range(3)]
    high = [
        tuple(int(rng.integers(a, n)) for a, n in zip(corner, table.shape, strict=True)) for corner in low
    ]
    return call("integrate", table, table, text, low, high)


DRAWERS: tuple[Callable[[Random], Call], ...] = (
    warp,
    warp,
    warp,
    resize,
    resize,
    rescale,
    rotate,
    swirl,
    warp_polar,
    pyramid,
    pyramid,
    means,
    integral,
)


def calls(seed: int, count: int) -> Iterator[Call]:
    """So many calls; the same for the same seed, each by itself."""
    for index in range(count):
        rng = np.random.default_rng([seed, index])
        yield pick(rng, DRAWERS)(rng)
