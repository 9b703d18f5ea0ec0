"""``auto``: what it costs, that nothing jumps, that shapes are followed; and the surveys that tell."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import multum as mt
from multum import reference
from multum.cli import main

Array = NDArray[np.float64]
FEW = 12
"""A trilinear look-up, and the interpolation that it fades into."""


def turned(degrees: float, width: float, height: float) -> Array:
    a = np.radians(degrees)
    turn: Array = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    return turn @ np.diag([width, height])


def smooth(side: int) -> NDArray[np.uint8]:
    """A ramp and a wave as long as the picture, in 8 bits."""
    y, x = np.mgrid[:side, :side] / side
    value = 0.5 + 0.4 * np.cos(2 * np.pi * x) * np.cos(2 * np.pi * y)
    codes: NDArray[np.uint8] = np.rint(255 * np.stack([value, 1 - value, 0.5 * value], axis=-1)).astype(
        np.uint8
    )
    return codes


@pytest.mark.parametrize("tolerance", [None, 1 / 64, 1 / 255])
@pytest.mark.parametrize("content", ["flat", "smooth"])
def test_flat_and_smooth_pictures_cost_a_few_look_ups(tolerance: float | None, content: str) -> None:
    side = 1024 if content == "smooth" else 256
    image = smooth(side) if content == "smooth" else np.full((side, side, 3), 77, np.uint8)
    texture = mt.Texture(image, wrap="repeat")
    random = np.random.default_rng(1)
    # A smooth picture is a plane only as far as it does not bend: footprints up to an eightieth of its waves.
    longest = 12.0 if content == "smooth" else 200.0
    uv = random.uniform(0.45, 0.55, (200, 2))
    jacobian = np.stack(
        [
            turned(
                random.uniform(0, 180), 2 ** random.uniform(1, np.log2(longest)), 2 ** random.uniform(0, 3)
            )
            for _ in uv
        ]
    )
    survey = texture.survey(uv, jacobian / side, tolerance=tolerance)
    assert np.median(survey.cost) <= FEW
    if content == "flat":
        assert survey.cost.max() <= FEW
    values = texture.sample(uv, jacobian / side, tolerance=tolerance)
    right = reference.sample(image, uv, jacobian / side)
    assert np.abs(values - right).max() <= (tolerance or 4 / 255)


def test_cost_follows_content() -> None:
    """One picture, flat on the left and noise on the right, seen at one scale."""
    side = 256
    image = np.full((side, side), 90, np.uint8)
    image[:, side // 2 :] = np.random.default_rng(2).integers(0, 256, (side, side // 2))
    for tolerance in (None, 1 / 255):
        cost = mt.survey(image, np.diag([9.7, 9.7, 1.0]), (26, 26), wrap="clamp", tolerance=tolerance).cost
        assert cost[4:-4, 1:4].max() <= FEW
        assert cost[4:-4, 18:-4].min() >= 40


@pytest.mark.parametrize("tolerance", [1 / 16, 1 / 255])
def test_a_smaller_tolerance_costs_more_and_errs_less(tolerance: float) -> None:
    image = np.random.default_rng(3).random((64, 64), np.float32)
    texture = mt.Texture(image, wrap="repeat")
    random = np.random.default_rng(4)
    uv = random.random((300, 2))
    jacobian = np.stack([turned(random.uniform(0, 180), 60, 25) for _ in uv]) / 64
    right = reference.sample(image, uv, jacobian)

    def found(t: float) -> tuple[float, float]:
        values = texture.sample(uv, jacobian, tolerance=t)
        return reference.rms(values, right), float(texture.survey(uv, jacobian, tolerance=t).cost.mean())

    (coarse, cheap), (fine, dear) = found(tolerance), found(tolerance / 8)
    assert fine <= coarse
    assert dear >= cheap


SWEEPS: dict[str, Callable[[float], Array]] = {
    "growing": lambda x: turned(20, 0.8 * 100**x, 0.8 * 100**x),
    "turning": lambda x: turned(180 * x, 14, 5),
    "thinning": lambda x: turned(35, 12, 12 * 1e-2**x),
    "shearing": lambda x: turned(10, 9, 6) @ np.array([[1, 4 * x - 2], [0, 1]]),
}


@pytest.mark.parametrize("sweep", SWEEPS)
@pytest.mark.parametrize("content", ["noise", "squares"])
def test_nothing_jumps_where_the_method_changes(sweep: str, content: str) -> None:
    side, steps = 64, 4000
    y, x = np.mgrid[:side, :side]
    noise = np.random.default_rng(5).random((side, side), np.float32)
    image = noise if content == "noise" else np.float32((x // 8 + y // 8) & 1)
    texture = mt.Texture(image, wrap="repeat")
    jacobian = np.stack([SWEEPS[sweep](k / steps) for k in range(steps + 1)]) / side
    values = texture.sample(np.broadcast_to([0.41, 0.37], (steps + 1, 2)), jacobian)[:, 0]
    # A step changes a side by at most a five-hundredth of its length, and weights by a few times as much; levels
    # are blended over a quarter of an octave.
    assert np.abs(np.diff(values)).max() <= 0.015
    # The same along a line over the texture.
    uv = np.linspace([0.1, 0.2], [0.4, 0.5], steps + 1)
    values = texture.sample(uv, np.broadcast_to(turned(30, 11, 4) / side, (steps + 1, 2, 2)))[:, 0]
    assert np.abs(np.diff(values)).max() <= 0.015


def test_the_default_is_about_as_good_as_it_aims_to_be() -> None:
    """Rms below two steps of 8 bits on pictures of every kind, and a fifth of a trilinear look-up's."""
    side = 128
    random = np.random.default_rng(6)
    y, x = np.mgrid[:side, :side]
    pictures = {
        "noise": random.random((side, side)),
        "squares": ((x // 8 + y // 8) & 1) * 1.0,
        "strokes": np.where((x % 9 < 2) | (y % 13 == 5), 0.1, 0.95),
    }
    uv = random.random((400, 2))
    sizes = 2 ** random.uniform(0.5, 5, 400)
    jacobian = (
        np.stack([turned(random.uniform(0, 180), s, s * 2 ** random.uniform(-3, 0)) for s in sizes]) / side
    )
    for name, picture in pictures.items():
        texture = mt.Texture(np.rint(255 * picture).astype(np.uint8), wrap="repeat")
        right = reference.sample(np.rint(255 * picture) / 255, uv, jacobian)
        error = reference.rms(texture.sample(uv, jacobian), right)
        assert error <= 2 / 255, name
        assert error <= 0.2 * reference.rms(texture.sample(uv, jacobian, filter="trilinear"), right), name


@pytest.mark.parametrize("filter", ["area", "exact"])
def test_bent_pixels_have_their_own_shape(filter: str) -> None:
    """A floor to the horizon by its matrix, by its map, and by Jacobians alone, against the integral."""
    y, x = np.mgrid[:256, :512]
    image = np.float32((x // 4 + y // 4) & 1)
    side, horizon = 64, 3.0
    matrix = np.array([[64, 0, -2016.0], [0, 0, 2000.0], [0, 1, horizon]])
    column, row = np.meshgrid(np.arange(64.0), np.arange(64.0))
    w = row + horizon
    places = np.stack([(64 * column - 2016) / w, 2000 / w], axis=-1)
    slopes = [[64 / w, -places[..., 0] / w], [0 * w, -places[..., 1] / w]]
    jacobian = np.moveaxis(np.array(slopes), (0, 1), (-2, -1)) / [[512], [256]]
    right = reference.warp(image, matrix, (side, side), wrap="repeat", tol=1e-4)
    straight = mt.Texture(image, wrap="repeat").sample((places + 0.5) / [512, 256], jacobian, filter=filter)
    by_matrix = mt.warp(image, matrix, (side, side), wrap="repeat", filter=filter)
    by_map = mt.warp(image, places, wrap="repeat", filter=filter)

    def error(picture: NDArray[Any], rows: slice) -> float:
        return reference.rms(picture.reshape(side, side)[rows], right[rows])

    near, next_to_it = slice(1, 9), slice(5, 9)
    assert error(by_matrix, near) < 0.6 * error(straight, near)
    assert error(by_map, next_to_it) < 0.7 * error(straight, next_to_it)
    assert error(by_matrix, slice(1, None)) < 0.005


def test_surveys_have_the_shape_of_results() -> None:
    texture = mt.Texture(np.random.default_rng(7).random((16, 16, 5)), wrap="mirror")
    uv = np.random.default_rng(8).random((3, 4, 2))
    for filter in (
        "nearest",
        "bilinear",
        "bicubic",
        "trilinear",
        "anisotropic",
        "ewa",
        "sat",
        "area",
        "exact",
    ):
        survey = texture.survey(uv, np.eye(2) / 4, filter=filter)
        assert survey.cost.shape == survey.lod.shape == (3, 4)
        assert survey.cost.dtype == np.float32
        assert (survey.cost > 0).all()
        assert (survey.lod >= 0).all()
        assert (survey.lod <= 4).all()
    # Two groups of channels.
    assert texture.survey(uv, filter="nearest").cost.tolist() == [[2.0] * 4] * 3
    assert texture.survey(uv, lod=1.5, filter="trilinear").lod.max() == 1.5
    assert texture.survey([[np.nan, 0]]).cost.tolist() == [0.0]
    assert texture.survey(np.zeros((0, 2))).cost.shape == (0,)


def test_surveys_refuse_what_sampling_refuses() -> None:
    texture = mt.Texture(np.zeros((4, 4)))
    bad: list[tuple[Any, dict[str, Any]]] = [
        ([0.5], {}),
        ([[0.5, 0.5]], {"filter": "best"}),
        ([[0.5, 0.5]], {"tolerance": 0}),
        ([[0.5, 0.5]], {"tolerance": float("nan")}),
        ([[0.5, 0.5]], {"lod": 1, "jacobian": np.eye(2)}),
    ]
    for uv, options in bad:
        with pytest.raises((ValueError, TypeError)):
            texture.survey(uv, **options)
    with pytest.raises(ValueError, match="what"):
        texture.survey([[0.5, 0.5]]).picture("time")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="mapping"):
        mt.survey(np.zeros((4, 4)), np.zeros(3))


@pytest.mark.parametrize("what", ["cost", "lod"])
def test_the_command_draws_surveys(what: str, tmp_path: Path) -> None:
    image = np.random.default_rng(9).integers(0, 256, (60, 80, 3), np.uint8)
    image[:, :40] = 5
    source, target = tmp_path / "in.png", tmp_path / "out.png"
    mt.write_image(source, image)
    matrix = ["4", "0", "0", "0", "4", "0"]
    arguments = ["warp", str(source), str(target), "--matrix", *matrix, "--size", "20x15", "--debug", what]
    assert main(arguments) in (0, None)
    drawn = mt.read_image(target)
    expected = mt.survey(image, [[4, 0, 0], [0, 4, 0]], (15, 20)).picture(what)  # type: ignore[arg-type]
    np.testing.assert_array_equal(drawn, expected)
    assert (drawn[7, 3] != drawn[7, 15]).any()
