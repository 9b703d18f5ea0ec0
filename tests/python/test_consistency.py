"""What must hold between settings and between calls: more effort is no worse, and all ways to ask agree."""

import itertools

import numpy as np
import pytest

import multum as mt
from multum import reference
from multum._chart.scenes import SCENES, View
from multum._chart.textures import checker, noise

SIDE, SIZE = 128, 40
TEXTURES = {"checker": checker(SIDE), "noise": noise(SIDE)}
SHOWN = ("rotate", "homography", "plane", "cylinder", "sphere")


def made(name: str) -> mt.Texture:
    return mt.Texture(TEXTURES[name], wrap="repeat")


def off(texture: mt.Texture, view: View, **options: object) -> float:
    """Root mean square error of look-ups, against the integral over each pixel's parallelogram."""
    uv, jacobian = view.uv[::2, ::2].astype(float), view.jacobian[::2, ::2].astype(float)
    truth = reference.sample(texture.level(0), uv, jacobian, wrap="repeat")
    got = texture.sample(uv, jacobian, **options)  # type: ignore[arg-type]
    return float(np.sqrt(np.mean((got - truth) ** 2)))


@pytest.mark.parametrize("scene", SHOWN)
def test_more_anisotropy_is_no_worse(scene: str) -> None:
    """On noise. A checker finer than a pixel is grey, which every blur makes it: there, less may be nearer."""
    texture, view = made("noise"), View(SCENES[scene], SIZE, SIDE, SIDE)
    errors = [off(texture, view, filter="anisotropic", max_anisotropy=n) for n in (1, 2, 4, 8, 16, 64)]
    # Results are singles.
    assert all(b <= a + 1e-6 for a, b in itertools.pairwise(errors)), errors


@pytest.mark.parametrize("scene", SHOWN)
@pytest.mark.parametrize("name", sorted(TEXTURES))
def test_a_smaller_tolerance_is_kept_and_no_worse(name: str, scene: str) -> None:
    texture, view = made(name), View(SCENES[scene], SIZE, SIDE, SIDE)
    tolerances = (0.1, 0.03, 0.01, 0.003, 0.001, 1e-4)
    errors = [off(texture, view, filter="auto", tolerance=t) for t in tolerances]
    assert all(e <= t for e, t in zip(errors, tolerances, strict=True))
    assert all(b <= a + 1e-6 for a, b in itertools.pairwise(errors)), errors


@pytest.mark.parametrize("name", sorted(TEXTURES))
def test_more_effort_is_no_worse_from_filter_to_filter(name: str) -> None:
    """On the whole: root mean square over all scenes."""
    texture = made(name)
    views = [View(SCENES[scene], SIZE, SIDE, SIDE) for scene in SHOWN]

    def whole(filter: str) -> float:
        return float(np.sqrt(np.mean([off(texture, view, filter=filter) ** 2 for view in views])))

    errors = [whole(f) for f in ("nearest", "bilinear", "trilinear", "ewa", "area", "exact")]
    assert all(b <= a for a, b in itertools.pairwise(errors)), errors


MATRICES = {
    "shrunk": [[3.0, 0.0, 1.0], [0.0, 2.5, 0.75]],
    "turned": [[1.9, -1.1, 30.0], [1.2, 2.0, 4.0]],
    "enlarged": [[0.31, 0.04, 2.0], [-0.03, 0.42, 5.0]],
    "perspective": [[1.6, 0.3, 2.0], [0.1, 1.9, 3.0], [0.002, 0.004, 1.0]],
}


@pytest.mark.parametrize(
    "filter",
    ["nearest", "bilinear", "bicubic", "trilinear", "anisotropic", "ewa", "sat", "exact", "area", "auto"],
)
@pytest.mark.parametrize("matrix", sorted(MATRICES))
def test_warps_and_look_ups_agree(matrix: str, filter: str) -> None:
    """The same places and Jacobians, as a warp and as look-ups; bent pixels are cut by warps alone."""
    image = TEXTURES["noise"].astype(np.float32) / 255.0
    rows = np.vstack([np.asarray(MATRICES[matrix]), [[0.0, 0.0, 1.0]]])[:3]
    y, x = np.mgrid[:20, :24].astype(float)
    above, below = rows[:2], rows[2]
    w = below[0] * x + below[1] * y + below[2]
    places = np.stack([(r[0] * x + r[1] * y + r[2]) / w for r in above], axis=-1)
    slopes = np.stack(
        [
            np.stack([(r[k] - places[..., i] * below[k]) / w for k in (0, 1)], axis=-1)
            for i, r in enumerate(above)
        ],
        axis=-2,
    )
    uv, jacobian = (places + 0.5) / SIDE, slopes / SIDE
    looked_up = mt.Texture(image, wrap="repeat").sample(uv, jacobian, filter=filter)
    warped = mt.warp(image, rows, (20, 24), wrap="repeat", filter=filter)
    if matrix == "perspective" and filter in ("area", "exact", "auto"):
        truth = reference.warp(image, rows, (20, 24), wrap="repeat")
        assert reference.rms(warped, truth) <= reference.rms(looked_up, truth) + 1e-6
        assert reference.rms(warped, looked_up) < 0.02
    else:
        np.testing.assert_allclose(warped, looked_up, atol=2e-5)


@pytest.mark.parametrize("filter", ["trilinear", "area", "exact", "auto"])
def test_resizing_is_a_warp(filter: str) -> None:
    image = TEXTURES["noise"].astype(np.float32) / 255.0
    scale = [SIDE / 50, SIDE / 40]
    matrix = [[scale[0], 0.0, 0.5 * scale[0] - 0.5], [0.0, scale[1], 0.5 * scale[1] - 0.5]]
    warped = mt.warp(image, matrix, (40, 50), wrap="clamp", filter=filter)
    np.testing.assert_allclose(mt.resize(image, (40, 50), filter=filter), warped, atol=2e-5)
