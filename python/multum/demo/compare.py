"""Warps against the truth: a homography, a plane to the horizon, the rules for the level of detail."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._texture import Texture
from .._warp import resize, warp
from ..cli.warp import corners_matrix
from . import peers
from .figure import Codes, Figure, Panel, colour, enlarged, error_picture, rms
from .pictures import floor_tiles, photograph
from .truth import footprint, truth

_TIMES = 4
_ZOOM = 6
_SKY = np.array([176, 204, 232], np.uint8)


def photograph_scene(scale: float) -> tuple[NDArray[np.uint8], NDArray[np.float64], tuple[int, int]]:
    """A photograph, the matrix that shows it on a tilted sheet, and the shape of the view."""
    image = photograph("astronaut")
    width, height = round(360 * scale), round(270 * scale)
    sheet = np.array([[0.40, 0.08], [0.76, 0.16], [0.98, 0.94], [0.02, 0.86]]) * [width, height]
    inside = corners_matrix([float(v) for v in sheet.ravel()], image.shape[:2])
    return image, np.asarray(np.linalg.inv(inside), dtype=np.float64), (height, width)


def homography(scale: float) -> Figure:
    """A photograph on a tilted sheet."""
    image, matrix, shape = photograph_scene(scale)
    height, width = shape
    exact = truth(image, matrix, shape, repeat=False)
    other = peers.plain_warp(image, matrix, shape, repeat=False)
    ours = warp(image, matrix, shape)
    times = [
        peers.milliseconds(lambda: peers.plain_warp(image, matrix, shape, repeat=False)),
        peers.milliseconds(lambda: warp(image, matrix, shape)),
    ]
    side = min(shape)
    shown = np.zeros((height, width, 3), np.uint8)
    left = (width - side) // 2
    shown[:side, left : left + side] = resize(image, (side, side), encoding="srgb")
    return _comparison(
        "homography",
        "A photograph seen at an angle",
        "A 512 x 512 photograph on a tilted sheet. Interpolation looks at one point of the photograph for each "
        "pixel, so hair, flag and lettering break up; multum takes the average of all that the pixel covers.",
        [shown, exact, other, ours],
        times,
        Panel(shown, "the photograph", f"{image.shape[1]} x {image.shape[0]}"),
        (0.44, 0.13),
    )


def plane_scene(scale: float) -> tuple[NDArray[np.uint8], NDArray[np.float64], tuple[int, int], int]:
    """Tiles, matrix of the rows below the horizon, their shape, rows of sky."""
    width, height = round(360 * scale), round(270 * scale)
    sky = height // 5
    shape = (height - sky, width)
    tiles = floor_tiles(128)
    # Ground at depth d is seen 1/d below the horizon, which is half a pixel above the first row.
    distance = 1.1 * shape[0] * 128.0
    view = np.array(
        [[distance / shape[0], 0, -0.5 * distance * width / shape[0]], [0, 0, 0.9 * distance], [0, 1, 0.5]]
    )
    angle = np.radians(24.0)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return tiles, turn @ view, shape, sky


def plane(scale: float) -> Figure:
    """A tiled plane to the horizon."""
    tiles, matrix, shape, sky = plane_scene(scale)
    exact = truth(tiles, matrix, shape, repeat=True)
    other = peers.plain_warp(tiles, matrix, shape, repeat=True)
    ours = warp(tiles, matrix, shape, wrap="repeat")
    times = [
        peers.milliseconds(lambda: peers.plain_warp(tiles, matrix, shape, repeat=True)),
        peers.milliseconds(lambda: warp(tiles, matrix, shape, wrap="repeat")),
    ]
    above = np.broadcast_to(_SKY, (sky, shape[1], 3))
    full = [np.concatenate([above, part]) for part in (exact, other, ours)]
    shown = np.full((sky + shape[0], shape[1], 3), 24, np.uint8)
    side = min(shown.shape[:2]) - 8
    top, left = 4, (shape[1] - side) // 2
    shown[top : top + side, left : left + side] = resize(tiles, (side, side), encoding="srgb")
    return _comparison(
        "plane",
        "A tiled floor to the horizon",
        "One pixel below the horizon covers hundreds of tiles. Interpolation picks one point among them, which "
        "makes noise and moire; multum gives their average, and keeps the joints sharp where they can be seen.",
        [shown, *full],
        times,
        Panel(shown, "the texture", f"{tiles.shape[1]} x {tiles.shape[0]}"),
        (0.26, 0.15),
    )


def _comparison(
    name: str,
    title: str,
    text: str,
    images: list[NDArray[Any]],
    times: list[float],
    source: Panel,
    look: tuple[float, float],
) -> Figure:
    """Truth, the other and ours; below, a part of each enlarged; last, source and errors."""
    _, exact, other, ours = images
    exact_codes = np.clip(np.floor(exact + 0.5), 0, 255)
    other_rms, ours_rms = rms(other, exact), rms(ours, exact)
    measured = [
        f"{peers.NAME}: rms error {other_rms:.2f} of 255, {times[0]:.1f} ms",
        f"multum: rms error {ours_rms:.2f} of 255, {times[1]:.1f} ms ({other_rms / ours_rms:.1f} times less error)",
    ]
    parts = ((exact_codes, "the truth"), (other, peers.NAME), (ours, "multum"))
    rows = [
        [
            Panel(colour(exact_codes), "truth", "mean over each pixel"),
            Panel(colour(other), peers.NAME, f"rms error {other_rms:.2f}, {times[0]:.1f} ms"),
            Panel(colour(ours), "multum", f"rms error {ours_rms:.2f}, {times[1]:.1f} ms"),
        ],
        [Panel(_part(image, look), f"part of {whose}", f"{_ZOOM} times enlarged") for image, whose in parts],
        [
            source,
            Panel(error_picture(other, exact, _TIMES), f"error of {peers.NAME}", f"{_TIMES} times amplified"),
            Panel(error_picture(ours, exact, _TIMES), "error of multum", f"{_TIMES} times amplified"),
        ],
    ]
    return Figure(name, title, f"{text} {peers.NOTE}".strip(), rows, measured)


def _part(image: NDArray[Any], look: tuple[float, float]) -> Codes:
    """A sixth of the picture each way, from the share ``look`` of its width and height on, enlarged."""
    height, width = (side // _ZOOM for side in image.shape[:2])
    left, top = round(look[0] * image.shape[1]), round(look[1] * image.shape[0])
    return enlarged(colour(image[top : top + height, left : left + width]), _ZOOM)


def levels_of_detail(scale: float) -> Figure:
    """The two rules for the level, and the filter that needs none of them."""
    tiles, matrix, shape, _ = plane_scene(scale)
    exact = truth(tiles, matrix, shape, repeat=True)
    texture = Texture(tiles, wrap="repeat")
    y, x = np.mgrid[: shape[0], : shape[1]].astype(np.float64)
    place = np.stack(
        [
            (matrix[i, 0] * x + matrix[i, 1] * y + matrix[i, 2])
            / (matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2])
            for i in (0, 1)
        ],
        axis=-1,
    )
    size = np.array([texture.width, texture.height])
    uv = (place + 0.5) / size
    jacobian = footprint(matrix, x, y) / size[:, None]
    cases: list[tuple[str, dict[str, Any]]] = [
        ("trilinear, level by area", {"filter": "trilinear", "lod_rule": "area"}),
        ("trilinear, level by longest axis", {"filter": "trilinear", "lod_rule": "major"}),
        ("anisotropic", {"filter": "anisotropic"}),
    ]
    top, bottom, measured = [], [], []
    for title, options in cases:
        value = np.clip(np.floor(255.0 * texture.sample(uv, jacobian, **options) + 0.5), 0, 255)
        error = rms(value, exact)
        top.append(Panel(colour(value), title, f"rms error {error:.2f}"))
        bottom.append(Panel(error_picture(value, exact, _TIMES), "error", f"{_TIMES} times amplified"))
        measured.append(f"{title}: rms error {error:.2f} of 255")
    return Figure(
        "levels",
        "Which level of the pyramid?",
        "An isotropic filter reads one size of texel for a long, thin footprint. By the footprint's area the level "
        "is too fine along it and noise comes back; by its longest axis it is too coarse across it and the picture "
        "blurs. Several probes along the footprint avoid both.",
        [top, bottom],
        measured,
    )
