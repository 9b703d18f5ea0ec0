"""The numbers of docs/errata.md."""

import numpy as np

import multum as mt

U = (np.arange(1 << 18) + 0.5) / (1 << 18)


def test_texels_by_rounding() -> None:
    for width, outside in [(256, 1 / 512), (2, 1 / 4)]:
        rounded = np.round(U * width)
        assert np.mean(rounded != np.floor(U * width)) == 0.5
        assert np.mean(rounded == width) == outside


def test_bilinear_and_corners_without_half_a_texel() -> None:
    ramp = ((np.arange(256) + 0.5) / 256)[None, :]
    inner = U[(U > 0.01) & (U < 0.99)]
    uv = np.stack([inner, np.full_like(inner, 0.5)], -1)
    texture = mt.Texture(ramp, wrap="clamp")
    assert np.abs(texture.sample(uv, filter="bilinear")[..., 0] - inner).max() < 1e-6
    shifted = np.interp(inner * 256, np.arange(256), ramp[0])
    assert np.isclose(np.abs(shifted - inner).max() * 256, 0.5)
    corners = np.arange(512) / 511 * 512 - (np.arange(512) + 0.5)
    assert np.isclose(np.abs(corners).max(), 0.5)


def test_angles() -> None:
    directions = np.stack([np.cos(2 * np.pi * U), np.sin(2 * np.pi * U), 0 * U], -1)
    slip = np.arctan2(directions[:, 1], directions[:, 0]) / (2 * np.pi)
    assert np.mean(slip < 0) == 0.5
    assert np.abs(mt.mapping.Spherical()(directions)[:, 0] - U).max() < 1e-12
    near_pole = np.array([np.sin(np.pi / 6), 0, np.cos(np.pi / 6)])
    assert np.isclose(np.degrees(np.arccos(near_pole[0])), 60)


def test_reflection() -> None:
    even = np.floor(U) % 2 == 0
    slip = np.where(even, 1 - U, U)
    assert np.isclose(np.abs(slip - U).mean(), 0.5)


def test_checkerboard_below_zero() -> None:
    cells = np.stack(np.meshgrid(np.arange(-10, 0), np.arange(-10, 0)), -1)
    white = mt.checkerboard((cells + 0.5) / 10.0)
    assert white.mean() == 0.5
    slip = np.fmod(cells.sum(-1), 2) != 1
    assert slip.all()


def test_quotient_rule() -> None:
    f = 512.0
    # A level floor: (U, V, w) = (x/f, 1, y/f).
    x, y = np.meshgrid(np.linspace(-256, 256, 64), np.linspace(8, 256, 64))
    w = y / f
    right, down = (1 / f / w, 0 / w), (0 / w, 0 / w)
    assert np.all(right[0] * down[1] - right[1] * down[0] == 0)
    u, v = x / f / w, 1 / w
    true = (1 / f / w) * ((0 - v / f) / w) - 0 * ((0 - u / f) / w)
    assert np.abs(true).min() > 0
    # A plane tilted by 1.9: the level by the slip, ½ log2 of areas, against the true one.
    y = np.linspace(-256, 256, 200)
    w = 1 + 1.9 * y / f
    error = 0.5 * np.log2((1 / f**2 / w**3) / (1 / f**2 / w**2))
    assert -0.49 < error.min() < -0.45
    assert 2.1 < error.max() < 2.2


def test_sphere_covered_twice_and_cylinder_cut_short() -> None:
    def slip(u: float, v: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        a, b = 2 * np.pi * u, 2 * np.pi * v
        return np.array([np.cos(a), np.sin(a) * np.cos(b), np.sin(a) * np.sin(b)])

    np.testing.assert_allclose(slip(0.2, 0.3), slip(0.8, 0.8), atol=1e-14)
    height = 2.0
    assert mt.mapping.Cylinder(height=(0, height))([0.0, 1.0]).point[2] == height
    assert height / (1 / height) == 4
