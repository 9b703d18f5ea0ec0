"""Pictures of a map on what is seen of a shape."""

import numpy as np
from numpy.typing import NDArray

from .. import mapping
from .maps import Applied
from .shapes import View

Codes = NDArray[np.uint8]

CELLS = 10
#: Views are so many times finer than pictures.
FINER = 2
_LIGHT = np.array([0.75, -0.35, 0.56])
_AROUND = 247
_NO_ANSWER = 0.55


def _shade(view: View) -> NDArray[np.float64]:
    """How bright a white surface is."""
    length = np.linalg.norm(view.normal, axis=-1)
    return np.asarray(0.35 + 0.65 * np.clip(view.normal @ _LIGHT / np.maximum(length, 1e-30), 0, 1))


def _finished(colour: NDArray[np.float64], view: View) -> Codes:
    """Codes, squares of pixels averaged into one, for the outlines."""
    fine = np.where(view.inside[..., None], np.clip(colour, 0, 1) * 255, _AROUND)
    height, width = (n // FINER for n in fine.shape[:2])
    picture = fine.reshape(height, FINER, width, FINER, 3).mean((1, 3))
    return np.asarray(np.floor(picture + 0.5).astype(np.uint8))


def paint(applied: Applied, view: View) -> Codes:
    """The checkerboard, filtered exactly by the map's Jacobian: red grows with u, blue with v."""
    uv, jacobian = applied(view)
    there = np.asarray(np.isfinite(uv).all(-1))
    white = np.nan_to_num(mapping.checkerboard(uv, CELLS, jacobian=jacobian))
    u, v = np.clip(np.where(there[..., None], uv, 0.0), 0, 1).transpose(2, 0, 1)
    dark = np.stack([0.15 + 0.75 * u, np.full_like(u, 0.2), 0.15 + 0.75 * v], -1)
    colour = white[..., None] * 0.96 + (1 - white[..., None]) * dark
    colour = np.where(there[..., None], colour, _NO_ANSWER)
    return _finished(colour * _shade(view)[..., None], view)


def _tangents(normal: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two unit tangents of every normal."""
    n = normal / np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-30)
    least = np.eye(3)[np.abs(n).argmin(-1)]
    a = np.cross(n, least)
    a /= np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), 1e-30)
    return a, np.cross(n, a)


def stretch(applied: Applied, view: View, kind: str) -> Codes:
    """Heat map of the map's stretch of areas (against its median) or angles on the surface."""
    a, b = _tangents(view.normal)
    still = np.zeros_like(view.normal)
    _, jacobian = applied(View(view.inside, view.point, view.normal, a, b, still, still))
    finite = np.asarray(np.isfinite(jacobian).all((-1, -2)))
    known: NDArray[np.float64] = np.where(finite[..., None, None], jacobian, 0.0)
    sigma = np.linalg.svd(known, compute_uv=False)
    with np.errstate(divide="ignore", invalid="ignore"):
        values = sigma[..., 0] * sigma[..., 1] if kind == "area" else sigma[..., 0] / sigma[..., 1]
    values = np.where(finite & view.inside, values, np.nan)
    if kind == "area":
        usual = values[np.isfinite(values) & (values > 0)]
        values = values / (np.median(usual) if usual.size else 1.0)
    picture = mapping.distortion_picture(values, limit=4) / 255
    return _finished(picture * (0.4 + 0.6 * _shade(view)[..., None]), view)
