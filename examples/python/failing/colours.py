"""Averages of what should not be averaged as it stands."""

import numpy as np

import multum as mt

from .common import Failure, checker


def codes() -> Failure:
    """Codes."""
    image = checker(128, 1)
    image[:, :64] = 188
    naive, got = (mt.resize(image, (32, 32), encoding=encoding) for encoding in ("linear", "srgb"))
    shown = [a.repeat(4, 0).repeat(4, 1) for a in (naive, got)]
    return Failure(
        "Averages of sRGB codes",
        "Black and white in equal parts send out half the light, whose code is 188. The mean of "
        "the codes is 128: a "
        "fifth of the light. Left half: 188 drawn plainly; right half: a checker of single texels, made smaller.",
        'codes that the right half is off, `encoding="linear"` and `"srgb"`',
        abs(float(naive[16, 24]) - 188),
        abs(float(got[16, 24]) - 188),
        [("averages of codes", shown[0]), ("averages of light", shown[1]), ("the checker", image)],
    )


def hidden_colour() -> Failure:
    """Hidden colour."""
    n = 96
    y, x = np.mgrid[:n, :n] - (n - 1) / 2
    inside = np.hypot(x, y) < 0.36 * n
    image = np.zeros((n, n, 4), np.uint8)
    image[..., 1] = 255
    image[inside] = (220, 30, 20, 255)
    naive, got = (mt.resize(image, (16, 16), alpha=alpha) for alpha in ("none", "straight"))

    def over_grey(picture: np.ndarray) -> np.ndarray:
        part = picture[..., 3:] / 255
        return (picture[..., :3] * part + 128 * (1 - part)).repeat(7, 0).repeat(7, 1)

    seen = (naive[..., 3] > 0) & (naive[..., 3] < 255)
    return Failure(
        "Straight alpha",
        "A red disc, and green where nothing shows. Averaged as they stand, rim colours take in "
        "the green that is "
        "hidden; multiplied by alpha first, they do not.",
        'codes of green too many on the rim, `alpha="none"` and `"straight"`',
        abs(float(naive[seen][:, 1].mean()) - 30),
        abs(float(got[seen][:, 1].mean()) - 30),
        [('alpha="none"', over_grey(naive)), ('alpha="straight"', over_grey(got))],
    )


def normals() -> Failure:
    """Normals."""
    n = 128
    slope = np.where(np.arange(n) // 2 % 2 == 0, 1.0, -1.0) * np.linspace(0, 1.5, n)[:, None]
    normal = np.stack([-slope, np.zeros_like(slope), np.ones_like(slope)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    image = np.rint(normal * 127 + 128).astype(np.uint8)
    texture = mt.Texture(image, wrap="clamp", encoding="normal")
    rows = (np.arange(n) + 0.5) / n
    uv = np.stack(np.broadcast_arrays(0.5, rows), axis=-1)
    jacobian = np.broadcast_to(np.diag([0.5, 1 / n]), (n, 2, 2))
    mean = texture.sample(uv, jacobian, filter="exact")
    length = np.linalg.norm(mean, axis=-1)
    right = normal[:, 0, 2]
    unit = np.ones(n)
    shown = [np.broadcast_to(255 * a[:, None], (n, n)) for a in (unit, length, right)]
    return Failure(
        "Averages of normals, made unit vectors again",
        "Grooves too fine to see, flat above and steep below, average to a shorter upward vector; "
        "its length tells "
        "how rough the surface is. Made a unit vector again it says that the surface is flat. "
        '`encoding="normal"` returns the average itself.',
        "largest error of the length, made unit again and as multum returns it",
        float(np.abs(unit - right).max()),
        float(np.abs(length - right).max()),
        [
            ("made unit again", shown[0]),
            ("length as returned", shown[1]),
            ("truth", shown[2]),
            ("the map", image),
        ],
    )
