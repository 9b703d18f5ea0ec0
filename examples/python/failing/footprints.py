"""Filters of the wrong shape or size."""

import numpy as np

import multum as mt
from multum.demo.pictures import floor_tiles, photograph
from multum.reference import rms

from .common import Failure, about_centre, ground, rings, turned, warped


def minification() -> Failure:
    """Minification."""
    image, shape = rings(512), (112, 112)
    matrix = about_centre(np.eye(2) * 512 / 112, shape, 512)
    truth, made = warped(
        image, matrix, shape, [("bilinear", {"filter": "bilinear"}), ("area", {"filter": "area"})]
    )
    return Failure(
        "Interpolation where a picture gets smaller",
        "Four texels are read where twenty are covered. Fine circles come back as coarse ones that "
        "are not there. "
        "Any filter that reads the whole footprint is right; more bits or a better interpolation are no help.",
        "rms error of 255, bilinear and area",
        rms(made[0][1], truth),
        rms(made[1][1], truth),
        [*made, ("truth", truth)],
    )


def grazing() -> Failure:
    """Grazing."""
    image, shape = floor_tiles(128), (96, 128)
    names = [("trilinear", {"filter": "trilinear"}), ("anisotropic 16", {"filter": "anisotropic"})]
    truth, made = warped(image, ground(*shape, 6.0), shape, names)
    return Failure(
        "Trilinear on a slanted plane",
        "One size of texel for footprints ten times longer than wide: by the longer axis it blurs across, by the "
        "area it aliases along. Probes along the longer axis, on the level of the shorter one, do neither.",
        "rms error of 255, trilinear and anisotropic 16",
        rms(made[0][1], truth),
        rms(made[1][1], truth),
        [*made, ("truth", truth)],
    )


def box_at_45() -> Failure:
    """Box at 45."""
    image, shape = photograph("astronaut")[..., :3], (112, 112)
    matrix = about_centre(turned(45, 6.0, 1.2), shape, 512)
    names = [("summed-area table", {"filter": "sat"}), ("area", {"filter": "area"})]
    truth, made = warped(image, matrix, shape, names)
    return Failure(
        "Upright boxes at 45 degrees",
        "A summed-area table averages the upright rectangle around the footprint. At 45 degrees and a ratio of 5 "
        "that rectangle holds three and a half times the footprint's area.",
        "rms error of 255, summed-area table and area",
        rms(made[0][1], truth),
        rms(made[1][1], truth),
        [*made, ("truth", truth)],
    )


def clamped() -> Failure:
    """Clamped."""
    image, shape = floor_tiles(128), (96, 128)
    names = [
        ("at most 2", {"filter": "anisotropic", "max_anisotropy": 2}),
        ("at most 64", {"filter": "anisotropic", "max_anisotropy": 64}),
    ]
    truth, made = warped(image, ground(*shape, 4.0), shape, names)
    return Failure(
        "A limit to anisotropy",
        "Footprints longer than the limit allows are blurred across, so that they do not alias "
        "along: seams of the "
        "tiles are gone long before the horizon. The limit bounds the time of a pixel and nothing else.",
        "rms error of 255, limits of 2 and of 64",
        rms(made[0][1], truth),
        rms(made[1][1], truth),
        [*made, ("truth", truth)],
    )


def thin_ellipses() -> Failure:
    """Thin ellipses."""
    image = photograph("astronaut")[..., :3]
    n, k = 512, 96
    jacobian = turned(30, 6.0, 0.05)
    y, x = np.mgrid[:k, :k].astype(float)
    centre = 200 + np.stack([x, y], axis=-1) * 1.31
    # The ellipse of the footprint alone: weights of texels in it, without the width of the texels themselves.
    inverse = np.linalg.inv(jacobian @ jacobian.T / (12 * 0.136))
    total, colours = np.zeros((k, k)), np.zeros((k, k, 3))
    base = np.floor(centre).astype(int)
    for j in range(-6, 7):
        for i in range(-6, 7):
            off = base + [i, j] + 0.5 - centre
            r2 = np.einsum("...i,ij,...j", off, inverse, off)
            weight = np.where(r2 < 1, np.exp(-2 * r2) - np.exp(-2), 0)
            total += weight
            colours += weight[..., None] * image[base[..., 1] + j, base[..., 0] + i]
    naive = np.where(total[..., None] > 0, colours / np.maximum(total, 1e-30)[..., None], 0)
    got = 255 * mt.Texture(image).sample(
        centre / n, np.broadcast_to(jacobian / n, (k, k, 2, 2)), filter="ewa", max_anisotropy=None
    )
    return Failure(
        "Ellipses thinner than a texel",
        "An ellipse of the footprint alone may hold no texel's centre: zero divided by zero. The "
        "unit term of the "
        "elliptical weighted average is the texel's own width; with it there always is a texel inside.",
        "share of pixels without a texel, without and with the unit term",
        float((total == 0).mean()),
        float((~np.isfinite(got)).mean()),
        [("without the unit term", naive), ("ewa", got)],
    )
