"""Plain interpolation, resizing and tables beside OpenCV, scikit-image, SciPy, Pillow and py360convert."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

import multum as mt

from .clock import Case, codes

ours = mt.compat.cv2
GOALS = {
    ("uint8", 1): 1.3,
    ("uint8", 3): 2.0,
    ("uint8", 4): 1.15,
    ("uint16", 1): 1.3,
    ("uint16", 3): 1.6,
    ("float32", 1): 1.3,
    ("float32", 3): 1.6,
    ("float32", 4): 1.3,
}


def turned(side: int) -> NDArray[np.float64]:
    """A turn by 0.4 about the middle, from output to input."""
    c, s, k = np.cos(0.4), np.sin(0.4), side / 2
    return np.array([[c, -s, k - c * k + s * k], [s, c, k - s * k - c * k]])


def turned_map(side: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    first, second = ((r[0] * x + r[1] * y + r[2]).astype(np.float32) for r in turned(side))
    return first, second


def opencv(side: int) -> Iterator[Case]:
    import cv2

    random = np.random.default_rng(0)
    pixels = side * side
    affine = turned(side)
    projective = np.vstack([affine, [1e-5, 2e-5, 1]])
    line = turned_map(side)
    scattered = tuple((random.random((side, side)) * (side - 2)).astype(np.float32) for _ in range(2))
    inverse = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP

    def case(name: str, dtype: Any, channels: int, function: str, arguments: Any, **more: Any) -> Case:
        image = codes(random, (side, side, channels), dtype)
        image = image[..., 0].copy() if channels == 1 else image
        keywords = more.pop("keywords", {})
        into = [np.empty((side, side, channels)[: image.ndim], dtype) for _ in range(2)]
        itemsize = channels * image.itemsize
        return Case(
            "interpolation",
            name,
            "OpenCV",
            pixels,
            lambda: getattr(cv2, function)(image, *arguments, dst=into[0], **keywords),
            lambda: getattr(ours, function)(image, *arguments, dst=into[1], antialias=False, **keywords),
            moved=2 * itemsize + (8 if function == "remap" else 0),
            most=1 if dtype != np.float32 else 0.05,
            **more,
        )

    for dtype in (np.uint8, np.uint16, np.float32):
        for channels in (1, 3, 4):
            word = np.dtype(dtype).name
            goal = GOALS.get((word, channels))
            yield case(
                f"remap linear, {word} c{channels}",
                dtype,
                channels,
                "remap",
                (*line, cv2.INTER_LINEAR),
                goal=goal,
            )
    yield case(
        "remap linear, random, uint8 c3", np.uint8, 3, "remap", (*scattered, cv2.INTER_LINEAR), goal=3.0
    )
    for channels in (1, 3, 4):
        yield case(
            f"remap nearest, uint8 c{channels}",
            np.uint8,
            channels,
            "remap",
            (*line, cv2.INTER_NEAREST),
            goal=1.0,
        )
    yield case("remap cubic, uint8 c3", np.uint8, 3, "remap", (*line, cv2.INTER_CUBIC), goal=2.0)
    yield case("remap Lanczos4, uint8 c3", np.uint8, 3, "remap", (*line, cv2.INTER_LANCZOS4), goal=2.0)
    flags = {"flags": inverse}
    size = (side, side)
    yield case("warpAffine, uint8 c3", np.uint8, 3, "warpAffine", (affine, size), keywords=flags, goal=2.0)
    yield case(
        "warpPerspective, uint8 c3",
        np.uint8,
        3,
        "warpPerspective",
        (projective, size),
        keywords=flags,
        goal=2.0,
    )


def resizing(side: int) -> Iterator[Case]:
    import cv2
    from PIL import Image

    random = np.random.default_rng(1)
    for factor, goal in ((2.0, 1.1), (2.7, 2.0)):
        to = int(side / factor)
        for dtype in (np.uint8, np.float32):
            image = codes(random, (side, side, 3), dtype)

            def theirs(image: NDArray[Any] = image, to: int = to) -> Any:
                return cv2.resize(image, (to, to), interpolation=cv2.INTER_AREA)

            def own(image: NDArray[Any] = image, to: int = to) -> Any:
                return ours.resize(image, (to, to), interpolation=cv2.INTER_AREA)

            name = f"resize area by {factor:g}, {np.dtype(dtype).name} c3"
            moved = 3 * image.itemsize * (1 + (to / side) ** 2)
            yield Case("building", name, "OpenCV", side * side, theirs, own, goal=goal, moved=moved)
    image = codes(random, (side, side, 3), np.uint8)
    picture, to = Image.fromarray(image), int(side / 2.7)
    yield Case(
        "building",
        "resize by boxes by 2.7, uint8 c3",
        "Pillow",
        side * side,
        lambda: np.asarray(picture.resize((to, to), Image.Resampling.BOX)),
        lambda: mt.resize(image, (to, to)),
        most=np.inf,
    )


def chain(image: NDArray[Any]) -> list[NDArray[Any]]:
    """All levels by area resizes; each from the codes of the one before, not in linear light."""
    import cv2

    levels = [image]
    while max(levels[-1].shape[:2]) > 1:
        height, width = levels[-1].shape[:2]
        size = (max(1, width // 2), max(1, height // 2))
        levels.append(cv2.resize(levels[-1], size, interpolation=cv2.INTER_AREA))
    return levels


def tables(side: int) -> Iterator[Case]:
    import cv2

    random = np.random.default_rng(2)
    rgba = codes(random, (side, side, 4), np.uint8)
    rgb = rgba[..., :3].copy()
    singles = random.random((side, side, 3), np.float32)
    pixels = side * side
    yield Case(
        "building",
        "pyramid in linear light, uint8 c4",
        "OpenCV (not in linear light)",
        pixels,
        lambda: chain(rgba)[-1],
        lambda: mt.build_pyramid(rgba, encoding="srgb")[-1],
        goal=1.0,
        most=np.inf,
    )
    yield Case(
        "building",
        "pyramid, uint8 c3",
        "OpenCV",
        pixels,
        lambda: chain(rgb)[1],
        lambda: mt.build_pyramid(rgb)[1],
    )
    yield Case(
        "building",
        "summed-area table, uint8 c3 to 32 bits",
        "OpenCV",
        pixels,
        lambda: cv2.integral(rgb)[-1],
        lambda: ours.integral(rgb)[-1],
        goal=1.0,
        moved=15,
    )
    yield Case(
        "building",
        "summed-area table, float32 c3 to float64",
        "OpenCV",
        pixels,
        lambda: cv2.integral(singles, sdepth=cv2.CV_64F)[-1],
        lambda: ours.integral(singles, sdepth=cv2.CV_64F)[-1],
        goal=1.5,
        most=1e-3,
        moved=36,
    )
    yield Case(
        "building",
        "SummedAreaTable (with the mean taken off), float32 c3 to float64",
        "OpenCV",
        pixels,
        lambda: cv2.integral(singles, sdepth=cv2.CV_64F)[-1],
        lambda: mt.SummedAreaTable(singles),
        most=np.inf,
    )


def science(side: int) -> Iterator[Case]:
    import scipy.ndimage
    import skimage.transform

    random = np.random.default_rng(3)
    image = random.random((side, side, 3))
    grey = image[..., 0].copy()
    matrix = np.vstack([turned(side), [0, 0, 1]])
    line = turned_map(side)
    places = np.stack([line[1], line[0]]).astype(np.float64)
    yield Case(
        "science",
        "warp order 1, float64 c3",
        "scikit-image",
        side * side,
        lambda: skimage.transform.warp(image, matrix, order=1),
        lambda: mt.compat.skimage.warp(image, matrix, order=1),
        goal=20,
        most=1e-9,
        moved=48,
    )
    yield Case(
        "science",
        "rescale by 0.37, anti-aliased, float64 c3",
        "scikit-image",
        side * side,
        lambda: skimage.transform.rescale(image, 0.37, anti_aliasing=True, channel_axis=-1),
        lambda: mt.compat.skimage.rescale(image, 0.37, anti_aliasing=True, channel_axis=-1),
        goal=10,
        most=1e-9,
        moved=24 * (1 + 0.37**2),
    )
    yield Case(
        "science",
        "map_coordinates order 1, float64 c1",
        "SciPy",
        side * side,
        lambda: scipy.ndimage.map_coordinates(grey, places, order=1, mode="constant"),
        lambda: mt.remap(grey, line[0], line[1], filter="bilinear", wrap="border"),
        most=np.inf,
    )


def panoramas(side: int) -> Iterator[Case]:
    import py360convert

    random = np.random.default_rng(4)
    image = codes(random, (side // 2, side, 3), np.uint8)
    face = side // 8
    yield Case(
        "science",
        "equirectangular to cube, bilinear, uint8 c3",
        "py360convert",
        6 * face * face,
        lambda: py360convert.e2c(image, face_w=face, mode="bilinear", cube_format="list"),
        lambda: mt.panorama.convert(image, source="equirect", target="cube", size=face, filter="bilinear"),
        most=np.inf,
    )


GROUPS = {
    "opencv": opencv,
    "resizing": resizing,
    "tables": tables,
    "science": science,
    "panoramas": panoramas,
}
