"""Lights. Colours are linear: a white surface that squarely faces a light of colour c shows c.

A colour is three numbers, or one for grey.
"""

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum

__all__ = ["Ambient", "Directional", "Light", "Point", "bumped_normals"]

_Vector: TypeAlias = tuple[float, float, float]
_Parts: TypeAlias = tuple[str, _Vector, _Vector, float | None, tuple[_Vector, tuple[float, float]] | None]


@dataclass(frozen=True)
class Ambient:
    """Light from everywhere alike."""

    color: ArrayLike = 0.2


@dataclass(frozen=True)
class Directional:
    """Light from far away.

    ``direction`` is the way that light goes, of any length.
    """

    direction: ArrayLike
    color: ArrayLike = 1.0


@dataclass(frozen=True)
class Point:
    """Light from one place.

    With a ``falloff`` it has its colour at that distance and fades with the square of the distance; without,
    it does not fade. ``cone`` makes it a spot: its axis, and the angles from the axis, in degrees, up to which
    the light is full and from which there is none.
    """

    position: ArrayLike
    color: ArrayLike = 1.0
    falloff: float | None = None
    cone: tuple[ArrayLike, float, float] | None = None


Light: TypeAlias = Ambient | Directional | Point


def bumped_normals(
    p_u: ArrayLike,
    p_v: ArrayLike,
    normals: ArrayLike,
    slopes: ArrayLike,
    curvature: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
) -> NDArray[np.float32]:
    """Unit normals (N, 3) of surfaces moved by a height d along their unit normals.

    n' = p'_u x p'_v of p' = p + d n (Blinn, SIGGRAPH 1978). ``p_u`` and ``p_v`` (N, 3) are the surface's
    derivatives, ``slopes`` (N, 2) those of d by u and v; ``curvature`` is (d (N, 1), n_u (N, 3), n_v (N, 3)), or
    None to leave out the terms d n_u and d n_v.

    Examples
    --------
    >>> import multum as mt
    >>> mt.light.bumped_normals([[1, 0, 0]], [[0, 1, 0]], [[0, 0, 1]], [[0.75, 0]]).round(6).tolist()
    [[-0.6000000238418579, 0.0, 0.800000011920929]]
    """

    def rows(values: ArrayLike) -> NDArray[np.float32]:
        return np.asarray(values, np.float32)

    d, n_u, n_v = (None, None, None) if curvature is None else (rows(part) for part in curvature)
    return _multum.bumped_normals(rows(p_u), rows(p_v), rows(normals), rows(slopes), d, n_u, n_v)


def _vector(name: str, value: ArrayLike, spread: bool = False) -> _Vector:
    try:
        numbers = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"lights: got {name} {value!r}, expected 3 numbers") from None
    if spread and numbers.ndim == 0:
        numbers = np.repeat(numbers, 3)
    if numbers.shape != (3,):
        raise ValueError(f"lights: got {name} of shape {numbers.shape}, expected 3 numbers")
    return float(numbers[0]), float(numbers[1]), float(numbers[2])


def to_parts(light: Light) -> _Parts:
    """What the compiled part takes."""
    if isinstance(light, Ambient):
        return "ambient", (0.0, 0.0, 0.0), _vector("color", light.color, True), None, None
    if isinstance(light, Directional):
        color = _vector("color", light.color, True)
        return "directional", _vector("direction", light.direction), color, None, None
    if not isinstance(light, Point):
        raise TypeError(f"lights: got {light!r}, expected lights of multum.light")
    cone = None
    if light.cone is not None:
        axis, inner, outer = light.cone
        cone = (_vector("axis", axis), (math.radians(inner), math.radians(outer)))
    color = _vector("color", light.color, True)
    return "point", _vector("position", light.position), color, light.falloff, cone


def from_parts(
    kind: str,
    vector: _Vector,
    color: _Vector,
    falloff: float | None,
    cone: tuple[_Vector, tuple[float, float]] | None,
) -> Light:
    """A light of a file."""
    if kind == "ambient":
        return Ambient(color)
    if kind == "directional":
        return Directional(vector, color)
    if cone is None:
        return Point(vector, color, falloff)
    axis, (inner, outer) = cone
    return Point(vector, color, falloff, (axis, math.degrees(inner), math.degrees(outer)))
