"""Places where maps jump, whirl or end."""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

import multum as mt
from multum.demo.pictures import floor_tiles
from multum.reference import rms

from .common import Failure, ground, warped

Array = NDArray[Any]
SIDE = 80


def on_ball(pixels: Array) -> Array:
    """(u, v) at pixels (..., 2) of a ball, its pole towards the eye: three tiles round, two from pole to pole."""
    x, y = np.moveaxis(0.66 * ((pixels + 0.5) / SIDE * 2 - 1), -1, 0)
    z = np.sqrt(1 - x**2 - y**2)
    c, s = np.cos(0.5), np.sin(0.5)
    p = np.stack([c * y + s * z, x, c * z - s * y], axis=-1)
    return np.stack(
        [1.5 * np.arctan2(p[..., 1], -p[..., 0]) / np.pi, 2 * np.arccos(p[..., 2]) / np.pi], axis=-1
    )


def ball() -> tuple[Array, Array, Array]:
    """Places, true Jacobians and differences between neighbouring pixels."""
    pixels = np.stack(np.meshgrid(np.arange(float(SIDE)), np.arange(float(SIDE))), axis=-1)
    uv, h = on_ball(pixels), 1e-5
    slopes = np.stack(
        [on_ball(pixels + h * axis) - on_ball(pixels - h * axis) for axis in np.eye(2)], axis=-1
    )
    slopes[..., 0, :] -= np.rint(slopes[..., 0, :] / 3) * 3
    return uv, slopes / (2 * h), np.stack([np.gradient(uv, axis=1), np.gradient(uv, axis=0)], axis=-1)


@cache
def ball_truth() -> Array:
    """The integral over each pixel's true shape."""
    image = floor_tiles(64)
    size = np.array(image.shape[1::-1])
    places = lambda xy: on_ball(xy) * size - 0.5  # noqa: E731
    return 255 * mt.reference.warp(image, places, (SIDE, SIDE), wrap="repeat", tol=4e-3)


def seam() -> Failure:
    """Seam."""
    image = floor_tiles(64)
    texture = mt.Texture(image, wrap="repeat")
    uv, slopes, differences = ball()
    wrong, right = (255 * texture.sample(uv, j, filter="trilinear") for j in (differences, slopes))
    jumps = np.abs(differences[..., 0, :]).max(axis=-1) > 1
    truth = ball_truth()
    return Failure(
        "The seam of a sphere",
        "Longitude jumps by a turn. Differences between neighbouring pixels take the jump for a "
        "footprint as long "
        "as the texture, and a line of its mean colour runs down the ball. Slopes from the formula "
        "of the map know of "
        'no seam; differences of `warp` and `remap` under `wrap="repeat"` leave whole periods out.',
        "rms error of 255 on the pixels of the seam, trilinear by differences and by slopes",
        rms(wrong[jumps], truth[jumps]),
        rms(right[jumps], truth[jumps]),
        [("differences", wrong), ("slopes", right), ("truth", truth)],
    )


def pole() -> Failure:
    """Pole."""
    image = floor_tiles(64)
    texture = mt.Texture(image, wrap="repeat")
    uv, slopes, _ = ball()
    wrong = 255 * texture.sample(uv, slopes, filter="trilinear")
    right = 255 * texture.sample(uv, slopes, filter="auto")
    truth = ball_truth()
    near = np.abs(uv[..., 1] - np.rint(uv[..., 1] / 2) * 2) < 0.12
    return Failure(
        "The pole of a sphere",
        "Towards a pole a pixel covers ever more of the circle and no more of the meridian. One size of texel "
        "blurs the meridian too; the mean over the footprint does not. At the pole itself the "
        "pixel is no parallelogram: "
        "what is left of the error is there.",
        "rms error of 255 within 11 degrees of the pole, trilinear and auto",
        rms(wrong[near], truth[near]),
        rms(right[near], truth[near]),
        [("trilinear", wrong), ("auto", right), ("truth", truth)],
    )


def horizon() -> Failure:
    """Horizon."""
    image, shape = floor_tiles(128), (20, 96)
    matrix = ground(96, 96, 3.0)
    names: list[tuple[str, dict[str, Any]]] = [
        ("bilinear", {"filter": "bilinear"}),
        ("auto", {"filter": "auto"}),
    ]
    truth, made = warped(image, matrix, shape, names)
    tall = [(name, np.repeat(picture, 4, axis=0)) for name, picture in [*made, ("truth", truth)]]
    return Failure(
        "The rows below a horizon",
        "One pixel below the horizon covers hundreds of tiles; interpolation shows one texel of them, another in "
        "every pixel and every picture of a film. Their mean is grey and still. (Rows drawn four times as tall.)",
        "rms error of 255 in the first 20 rows, bilinear and auto",
        rms(made[0][1], truth),
        rms(made[1][1], truth),
        tall,
    )
