"""Random calls of ``cv2`` and ``multum.compat.cv2`` with ``antialias=False``."""

from collections.abc import Callable, Iterator
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import multum as mt

from .pictures import laid_out, picture
from .verdicts import Call

Array = NDArray[Any]
Random = np.random.Generator
ours = mt.compat.cv2
theirs: Any = cv2

DTYPES = ("uint8", "uint16", "int16", "float32", "float64")
OFTEN = ("uint8",) * 16 + ("uint16",) * 6 + ("int16",) * 4 + ("float32",) * 13 + ("float64",)
"""As often as they are met."""
KINDS = {"NEAREST": 0, "LINEAR": 1, "CUBIC": 2, "LANCZOS4": 4}
OFTEN_KINDS = ("NEAREST", "LINEAR", "LINEAR", "CUBIC", "LANCZOS4")
RESIZES = {**KINDS, "AREA": 3, "LINEAR_EXACT": 5, "NEAREST_EXACT": 6}
BORDERS = {"CONSTANT": 0, "REPLICATE": 1, "REFLECT": 2, "WRAP": 3, "REFLECT_101": 4, "TRANSPARENT": 5}
CORNER = "getRectSubPix over a right corner"
FAR = "cubic, reflected or repeated, far outside"
HALVES = "positions half-way between two that exist"
WHOLE = "cubic, float64, with pixels from outside"
MORE = "more is taken"


def pick(rng: Random, values: Any) -> Any:
    items = list(values)
    return items[int(rng.integers(len(items)))]


class Source:
    """A picture, plain for OpenCV and in any place of memory for us."""

    def __init__(self, rng: Random, dtypes: Any = OFTEN, channels: int = 4, longest: int = 64) -> None:
        self.dtype = pick(rng, dtypes)
        self.channels = int(rng.integers(1, channels + 1))
        least = 1 if rng.random() < 0.05 else longest // 4
        self.size = int(rng.integers(least, longest)), int(rng.integers(least, longest))
        flat = self.channels == 1 and rng.random() < 0.8
        shape = self.size if flat else (*self.size, self.channels)
        self.plain = picture(rng, shape, self.dtype)
        self.placed, self.layout = laid_out(rng, self.plain)
        self.flat = shape[2:]
        self.slope = float(np.ptp(self.plain.astype(np.float64))) or 1.0
        """The most that neighbours can differ by."""

    def receiver(self, rng: Random, size: tuple[int, int], always: bool) -> Array | None:
        """An output for (width, height), of one colour, or none."""
        if not always and rng.random() < 0.7:
            return None
        shape = (size[1], size[0]) if self.channels == 1 else (size[1], size[0], self.channels)
        return np.full(shape, float(self.plain.flat[0]), self.plain.dtype)

    def __str__(self) -> str:
        return f"{self.dtype} {self.plain.shape} {self.layout}"


def both(
    name: str,
    source: Source,
    arguments: tuple[Any, ...],
    options: dict[str, Any],
    dst: Array | None,
    text: str,
    **bounds: Any,
) -> Call:
    """A call with an output of its own for each."""

    def call(function: Callable[..., Any], image: Array, **more: Any) -> Any:
        into = None if dst is None else dst.copy()
        return function(image, *arguments, dst=into, **options, **more)

    return Call(
        name,
        lambda: call(getattr(theirs, name), source.plain),
        lambda: call(getattr(ours, name), source.placed, antialias=False),
        f"{source} {text}" + ("" if dst is None else " dst"),
        **bounds,
    )


def how(rng: Random, source: Source) -> tuple[str, str, tuple[float, ...]]:
    kind, border = pick(rng, OFTEN_KINDS), pick(rng, BORDERS)
    if kind == "CUBIC" and border == "REFLECT_101" and 1 in source.size:
        # OpenCV looks for the reflected pixel for ever.
        border = "REFLECT"
    value = tuple(float(v) for v in rng.integers(0, 255, 4))
    return kind, border, value if rng.random() < 0.8 else (0.0,) * 4


def positions(rng: Random, source: Source) -> tuple[Array, Array, str]:
    """A map of any shape: scattered, or a turn about the middle."""
    h, w = source.size
    shape = int(rng.integers(1, 70)), int(rng.integers(1, 70))
    if rng.random() < 0.5:
        x = rng.uniform(-6, w + 6, shape)
        y = rng.uniform(-6, h + 6, shape)
        text = f"scattered {shape}"
    else:
        m = matrix(rng, source, (shape[1], shape[0]), False)
        x, y = placed(m, (shape[1], shape[0]))
        text = f"turned {shape}"
    return x.astype(np.float32), y.astype(np.float32), text


def remap(rng: Random) -> Call:
    source = Source(rng)
    kind, border, value = how(rng, source)
    x, y, text = positions(rng, source)
    form = pick(rng, ("planes", "pairs", "fixed", "relative"))
    flags = KINDS[kind]
    maps: tuple[Any, Any] = (x, y)
    if form == "pairs":
        maps = (np.dstack([x, y]), None)
    elif form == "fixed":
        maps = cv2.convertMaps(x, y, cv2.CV_16SC2, nninterpolation=kind == "NEAREST")
    elif form == "relative":
        flags |= cv2.WARP_RELATIVE_MAP
        maps = (
            x - np.arange(x.shape[1], dtype=np.float32),
            y - np.arange(x.shape[0], dtype=np.float32)[:, None],
        )
    dst = source.receiver(rng, x.shape[::-1], border == "TRANSPARENT")
    options = {"interpolation": flags, "borderMode": BORDERS[border], "borderValue": value}
    return both(
        "remap",
        source,
        maps,
        options,
        dst,
        f"{text} {form} {kind} {border}",
        reason=reason(source, kind, border, x, y, rounded=form == "relative"),
        **bounds(source, kind),
    )


def placed(m: Array, size: tuple[int, int]) -> tuple[Array, Array]:
    """Where the pixels of an output lie."""
    i, j = np.indices(size[::-1], dtype=np.float64)
    w = m[2, 0] * j + m[2, 1] * i + m[2, 2]
    return (m[0, 0] * j + m[0, 1] * i + m[0, 2]) / w, (m[1, 0] * j + m[1, 1] * i + m[1, 2]) / w


def reason(source: Source, kind: str, border: str, x: Array, y: Array, rounded: bool = False) -> str | None:
    """The paragraph of docs/peers.md that explains a difference here, if there is one."""
    beyond = [(at < 1).any() or (at >= n - 2).any() for at, n in zip((x, y), source.size[::-1], strict=True)]
    if kind == "CUBIC" and border in ("REFLECT", "WRAP", "REFLECT_101"):
        for at, n in zip((x, y), source.size[::-1], strict=True):
            if (at < -max(16, n) + 3).any() or (at > max(32, 2 * n) - 3).any():
                return FAR
    if kind == "CUBIC" and source.dtype == "float64" and any(beyond):
        return WHOLE
    return HALVES if rounded and kind == "NEAREST" else None


def bounds(source: Source, kind: str, reach: float = 100.0) -> dict[str, float]:
    """Positions up to ``reach`` are singles in OpenCV."""
    ulp = 2.0**-23 * reach
    # 64 weights of Lanczos come from a table of singles, each within 2e-6.
    rounding = 1e-5 + 4 * ulp + (64 * 2e-6 if kind == "LANCZOS4" else 0)
    return {"step": 1 + 4 * ulp * source.slope * (source.dtype != "uint8"), "rounding": rounding}


def matrix(rng: Random, source: Source, size: tuple[int, int], perspective: bool) -> Array:
    """From output to input."""
    angle = rng.uniform(0, 6.3)
    scale = rng.uniform(0.4, 1.2) * max(source.size) / max(size)
    c, s = scale * np.cos(angle), scale * np.sin(angle)
    m = np.array([[c, -s, 0.0], [s, c, 0.0], [0, 0, 1]]) @ np.array(
        [[1, rng.uniform(-0.3, 0.3), 0], [0, 1, 0], [0, 0, 1]]
    )
    middle = m @ (size[0] / 2, size[1] / 2, 1)
    # The output shows about the whole of the source.
    m[0, 2] = source.size[1] / 2 - middle[0]
    m[1, 2] = source.size[0] / 2 - middle[1]
    if perspective:
        m[2, :2] = rng.uniform(-0.3, 0.3, 2) / size
    found: Array = m
    return found


def warp(rng: Random, perspective: bool) -> Call:
    source = Source(rng)
    kind, border, value = how(rng, source)
    size = int(rng.integers(1, 70)), int(rng.integers(1, 70))
    m = matrix(rng, source, size, perspective)
    why = reason(source, kind, border, *placed(m, size), rounded=True)
    flags = KINDS[kind]
    if rng.random() < 0.5:
        flags |= cv2.WARP_INVERSE_MAP
    else:
        m = np.linalg.inv(m)
        m /= m[2, 2]
    m = m if perspective else m[:2]
    if rng.random() < 0.3:
        m = m.astype(np.float32)
    dst = source.receiver(rng, size, border == "TRANSPARENT")
    options = {"flags": flags, "borderMode": BORDERS[border], "borderValue": value}
    name = "warpPerspective" if perspective else "warpAffine"
    text = f"to {size} {kind} {border} flags {flags}"
    # A division by numbers from 0.4 on doubles the rounding.
    reach = 250.0 if perspective else 100.0
    return both(name, source, (m, size), options, dst, text, reason=why, **bounds(source, kind, reach))


def resize(rng: Random) -> Call:
    kind = pick(rng, ("LINEAR", "LINEAR", "AREA", "AREA", "CUBIC", "NEAREST", *RESIZES))
    dtypes = DTYPES if not kind.startswith("NEAREST") else (*DTYPES, "int8", "int32", "bool")
    source = Source(rng, dtypes)
    if source.dtype == "bool":
        source.dtype = "uint8"
        source.plain, source.placed = source.plain.astype(np.uint8), source.placed.astype(np.uint8)
    options: dict[str, Any] = {"interpolation": RESIZES[kind]}
    if rng.random() < 0.5:
        if rng.random() < 0.3:
            size: Any = tuple(
                max(1, round(n * f))
                for n, f in zip(
                    source.size[::-1],
                    pick(rng, ((0.5, 0.5), (2, 2), (0.25, 0.5), (1, 3), (1, 1))),
                    strict=True,
                )
            )
        else:
            size = int(rng.integers(1, 80)), int(rng.integers(1, 80))
    else:
        size = None
        options["fx"], options["fy"] = (float(v) for v in rng.uniform(0.2, 3, 2))
        if rng.random() < 0.3:
            options["fx"], options["fy"] = pick(rng, ((0.5, 0.5), (2.0, 2.0), (0.25, 0.5), (1.0, 3.0)))
    scaled = size or tuple(
        max(1, round(n * f)) for n, f in zip(source.size[::-1], (options["fx"], options["fy"]), strict=True)
    )
    dst = source.receiver(rng, scaled, False)
    text = f"to {size} {options} {kind}"
    why = HALVES if kind == "NEAREST_EXACT" else None
    return both("resize", source, (size,), options, dst, text, reason=why, **bounds(source, kind))


def warp_polar(rng: Random) -> Call:
    source = Source(rng, longest=60)
    kind = pick(rng, KINDS)
    flags = (
        KINDS[kind]
        | pick(rng, (0, cv2.WARP_POLAR_LOG))
        | pick(rng, (0, cv2.WARP_FILL_OUTLIERS))
        | pick(rng, (0, cv2.WARP_INVERSE_MAP))
    )
    if flags & cv2.WARP_INVERSE_MAP:
        # Else OpenCV loses what the output held.
        flags |= cv2.WARP_FILL_OUTLIERS
    size = int(rng.integers(1, 60)), int(rng.integers(1, 60))
    if rng.random() < 0.2 and not flags & cv2.WARP_INVERSE_MAP:
        size = (0, 0)
    center = float(rng.uniform(0, source.size[1])), float(rng.uniform(0, source.size[0]))
    radius = float(rng.uniform(2, 50))
    dst = None
    if not flags & cv2.WARP_FILL_OUTLIERS:
        real = size if size != (0, 0) else (max(1, round(radius)), max(1, round(radius * np.pi)))
        dst = source.receiver(rng, real, True)
    text = f"to {size} around {center} {radius} flags {flags}"
    # Sines and logarithms differ by a last bit, which is a step where positions are rounded.
    why = WHOLE if kind == "CUBIC" and source.dtype == "float64" else HALVES
    return both(
        "warpPolar", source, (size, center, radius, flags), {}, dst, text, reason=why, **bounds(source, kind)
    )


def tables(rng: Random) -> Call:
    name = pick(rng, ("integral", "integral2", "integral3", "pyrDown", "pyrUp"))
    source = Source(rng, channels=6)
    options: dict[str, Any] = {}
    if name.startswith("integral"):
        if rng.random() < 0.5:
            options["sdepth"] = pick(rng, (-1, cv2.CV_32S, cv2.CV_32F, cv2.CV_64F))
            if name != "integral":
                options["sqdepth"] = pick(rng, (-1, cv2.CV_32F, cv2.CV_64F))
    else:
        options["borderType"] = pick(rng, (1, 2, 3, 4)) if name == "pyrDown" else 4
    return Call(
        name,
        lambda: getattr(theirs, name)(source.plain, **options),
        lambda: getattr(ours, name)(source.placed, **options),
        f"{source} {options}",
        step=0,
        rounding=1e-6 if options.get("sdepth") != cv2.CV_32F else 1e-5,
    )


def rect_sub_pix(rng: Random) -> Call:
    source = Source(rng, ("uint8", "float32"), channels=1)
    if rng.random() < 0.5:
        source.plain = np.dstack([source.plain] * 3)
        source.placed, source.layout = laid_out(rng, source.plain)
    size = int(rng.integers(1, 30)), int(rng.integers(1, 30))
    center = float(rng.uniform(-4, source.size[1] + 4)), float(rng.uniform(-4, source.size[0] + 4))
    kind = pick(rng, (-1, cv2.CV_32F))
    return Call(
        "getRectSubPix",
        lambda: cv2.getRectSubPix(source.plain, size, center, patchType=kind),
        lambda: ours.getRectSubPix(source.placed, size, center, patchType=kind),
        f"{source} {size} {center} {kind}",
        rounding=1e-5,
        reason=CORNER if source.plain.size == np.prod(source.size) else None,
    )


def undistort(rng: Random) -> Call:
    source = Source(rng)
    h, w = source.size
    camera = np.array(
        [[rng.uniform(10, 90), 0, rng.uniform(0, w)], [0, rng.uniform(10, 90), rng.uniform(0, h)], [0, 0, 1]]
    )
    lens = rng.uniform(-0.2, 0.2, pick(rng, (4, 5, 8, 12, 14))) * 0.3
    if rng.random() < 0.3:
        kind = pick(rng, (cv2.CV_16SC2, cv2.CV_32FC1, cv2.CV_32FC2))
        size = int(rng.integers(1, 60)), int(rng.integers(1, 60))
        return Call(
            "initUndistortRectifyMap",
            lambda: cv2.initUndistortRectifyMap(camera, lens, None, camera, size, kind),
            lambda: ours.initUndistortRectifyMap(camera, lens, None, camera, size, kind),
            f"{size} {kind} {len(lens)} coefficients",
        )
    return Call(
        "undistort",
        lambda: cv2.undistort(source.plain, camera, lens),
        lambda: ours.undistort(source.placed, camera, lens, antialias=False),
        f"{source} {len(lens)} coefficients",
        step=bounds(source, "LINEAR")["step"],
        rounding=bounds(source, "LINEAR")["rounding"],
    )


def convert_maps(rng: Random) -> Call:
    x, y, text = positions(rng, Source(rng))
    nearest = bool(rng.random() < 0.3)
    first: tuple[Any, Any] = (x, y) if rng.random() < 0.5 else (np.dstack([x, y]), None)
    # With nearest pixels OpenCV makes no second float map.
    kind = cv2.CV_16SC2 if nearest else pick(rng, (cv2.CV_16SC2, cv2.CV_32FC1, cv2.CV_32FC2))
    if rng.random() < 0.4:
        # Without fractions OpenCV reads the second map where there is none.
        first, nearest = cv2.convertMaps(x, y, cv2.CV_16SC2), False
        kind = pick(rng, (cv2.CV_32FC1, cv2.CV_32FC2))
    return Call(
        "convertMaps",
        lambda: cv2.convertMaps(*first, kind, nninterpolation=nearest),
        lambda: ours.convertMaps(*first, kind, nninterpolation=nearest),
        f"{text} to {kind} nearest {nearest}",
        step=0,
    )


DRAWERS: tuple[tuple[float, Callable[[Random], Call]], ...] = (
    (0.25, remap),
    (0.2, lambda rng: warp(rng, False)),
    (0.2, lambda rng: warp(rng, True)),
    (0.15, resize),
    (0.06, warp_polar),
    (0.05, tables),
    (0.03, rect_sub_pix),
    (0.04, undistort),
    (0.02, convert_maps),
)


def calls(seed: int, count: int) -> Iterator[Call]:
    """So many calls; the same for the same seed, each by itself."""
    shares = np.cumsum([share for share, _ in DRAWERS])
    for index in range(count):
        rng = np.random.default_rng([seed, index])
        which = int(np.searchsorted(shares, rng.random() * shares[-1]))
        yield DRAWERS[which][1](rng)
