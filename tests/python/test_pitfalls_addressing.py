"""What goes wrong far from the origin, on coarse levels and in tables."""

from __future__ import annotations

import numpy as np
import pytest

import multum as mt
from weights import turned


def test_a_plane_tiled_a_thousand_times_keeps_its_texels() -> None:
    """Singles hold 2^-14 near 1000: a sixteenth of a texel of 1024. Doubles lose nothing."""
    n = 1024
    image = np.random.default_rng(4).random((n, n))
    texture = mt.Texture(image, "repeat")
    uv = np.random.default_rng(5).uniform(900, 1020, (500, 2))
    right = mt.reference.sample(image, uv, pixel_filter="point", wrap="repeat")
    double = texture.sample(uv, filter="bilinear")
    # 2^-44 of a tile near 1000, in texels of 2^-10, on both axes, over a range of 1.
    assert mt.reference.max_error(double, right) <= 1e-9
    single = texture.sample(uv.astype(np.float32), filter="bilinear")
    assert mt.reference.max_error(single, right) <= 2 * n * 2.0**-15
    exact = mt.reference.sample(image, uv.astype(np.float32), pixel_filter="point", wrap="repeat")
    # The singles themselves are read without another error.
    assert mt.reference.max_error(single, exact) <= 1e-9


@pytest.mark.parametrize(
    "filter", ["nearest_mipmap_nearest", "nearest_mipmap_linear", "trilinear", "anisotropic"]
)
def test_levels_that_are_not_there_are_the_last(filter: str) -> None:
    for shape in ((1, 1), (1, 8), (8, 8)):
        image = np.random.default_rng(6).random(shape)
        texture = mt.Texture(image, "clamp")
        last = texture.level(texture.num_levels - 1)
        assert last.shape[:2] == (1, 1)
        for lod in (7.0, 100.0, 1e30):
            got = texture.sample([[0.2, 0.9], [0.5, 0.5]], lod=lod, filter=filter)
            np.testing.assert_allclose(got, np.ravel(last)[0], rtol=1e-15)


def test_upright_boxes_are_right_upright_and_too_wide_at_45_degrees() -> None:
    n = 128
    image = np.random.default_rng(8).random((n, n))
    texture = mt.Texture(image, "repeat")
    uv = np.random.default_rng(9).random((400, 2))
    error = {}
    for degrees in (0, 15, 30, 45):
        jacobian = np.broadcast_to(turned(degrees, 16.0, 4.0), (400, 2, 2)) / n
        right = mt.reference.sample(image, uv, jacobian, wrap="repeat")
        error[degrees] = mt.reference.rms(texture.sample(uv, jacobian, filter="sat"), right)
        # Independent texels of variance 1/12: the mean over A texels has 1/(12 A), over the box around them, of
        # B = (16 c + 4 s)(16 s + 4 c) texels, 1/(12 B); their difference 1/(12 A) - 1/(12 B), the parallelogram
        # lying in the box.
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        apart = max(0.0, (1 / 64 - 1 / ((16 * c + 4 * s) * (16 * s + 4 * c))) / 12)
        assert error[degrees] <= 1.15 * np.sqrt(apart) + 0.008, degrees
    assert error[0] < 0.008
    assert error[45] > 3 * error[0]
