"""Panoramas: from one form of a picture of all directions to another, anti-aliased by the exact footprint."""

from collections.abc import Callable, Sequence
from typing import Any, SupportsFloat, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import count, finite_matrix, name, number, size_pair
from ._sampling import stacked_faces
from ._warp import Border, _options

__all__ = ["convert", "rotation"]

_CELLS = {"faces": (1, 6), "stacked": (1, 6), "strip": (6, 1), "cross": (4, 3)}
#: Sides that are refused here, before they are multiplied by the cells of a cube.
_LONGEST = 2**31
_ANGLES = {"perspective": 90.0, "fisheye": 180.0, "stereographic": 270.0}


def _pixels_a_turn(form: str, width: int, columns: int, fov: float | None) -> float:
    """How many pixels a picture has for a whole turn, near its middle."""
    if form == "cube":
        return 4 * width / columns
    if form == "octahedral":
        return 2 * width
    return width * 360 / (fov or _ANGLES.get(form, 360.0))


def _default_size(form: str, turn: float, fov: float | None) -> tuple[int, int]:
    """A picture of this form with as many pixels a turn."""
    if form in ("equirect", "dual_paraboloid"):
        width = max(2, round(turn))
        return width, width // 2
    share = {"cube": 0.25, "octahedral": 0.5}.get(form, (fov or _ANGLES.get(form, 360.0)) / 360)
    side = max(1, round(turn * share))
    return side, side


def rotation(right: SupportsFloat, up: SupportsFloat = 0.0, roll: SupportsFloat = 0.0) -> NDArray[np.float64]:
    """The matrix that makes the target look ``right`` and ``up`` from the source's forward, in degrees.

    ``roll`` turns the camera clockwise before it looks there.

    >>> (rotation(90) @ [0.0, 0.0, 1.0]).round(12).tolist()
    [1.0, 0.0, 0.0]
    >>> (rotation(0, 90) @ [0.0, 0.0, 1.0]).round(12).tolist()
    [0.0, 1.0, 0.0]
    >>> (rotation(0, 0, 90) @ [0.0, 1.0, 0.0]).round(12).tolist()
    [1.0, 0.0, 0.0]
    """
    angles = [np.radians(number(n, a)) for n, a in (("right", right), ("up", up), ("roll", roll))]
    (ca, cb, cc), (sa, sb, sc) = np.cos(angles), np.sin(angles)
    around_up = np.array([[ca, 0, sa], [0, 1, 0], [-sa, 0, ca]])
    around_right = np.array([[1, 0, 0], [0, cb, sb], [0, -sb, cb]])
    around_forward = np.array([[cc, sc, 0], [-sc, cc, 0], [0, 0, 1]])
    return np.asarray(around_up @ around_right @ around_forward)


def convert(
    image: ArrayLike,
    source: str = "equirect",
    target: str = "cube",
    size: SupportsIndex | Sequence[SupportsIndex] | None = None,
    rotation: ArrayLike | None = None,
    fov: SupportsFloat | None = None,
    *,
    source_fov: SupportsFloat | None = None,
    layout: str = "faces",
    source_layout: str = "faces",
    model: str = "equidistant",
    source_model: str = "equidistant",
    filter: str = "auto",
    border: Border = 0,
    encoding: str = "linear",
    alpha: str = "none",
    tolerance: float | None = None,
    max_anisotropy: SupportsFloat | None = 16,
    threads: int | None = None,
    progress: Callable[[float], object] | None = None,
) -> NDArray[Any]:
    """Convert a panorama.

    Every pixel is the mean over what it covers: nearly everywhere an integral of the interpolated picture, on a
    map that is followed to 1/64 texel or 1/32 pixel; around poles, rims and folds a mean of points. Where source
    and target are the same picture in another layout, it is copied.

    Directions are seen in the frame x right, y up, z forward. Equirectangular pictures, fisheyes and light
    probes have forward at their centre, mirror balls backward; cubes are OpenGL's.

    Parameters
    ----------
    image : (H, W) or (H, W, C), or (6, n, n) or (6, n, n, C) for a cube with ``source_layout="faces"``
        Of any dtype; so is the result.
    source, target : str
        ``"equirect"``, ``"cube"``, ``"perspective"``, ``"fisheye"``, ``"probe"``, ``"mirror_ball"``,
        ``"stereographic"``, ``"dual_paraboloid"`` or ``"octahedral"``.
    size : int or (width, height), optional
        Of the result. A whole number is the width (the side of a face for a cube). Default: as many pixels a
        turn as the source has.
    rotation : (3, 3), optional
        Turns a direction of the target into one of the source: its columns say where the target's right, up and
        forward lie in the source.
    fov, source_fov : float, optional
        Degrees that a perspective (default 90), fisheye (180) or stereographic picture (270) sees across.
    layout, source_layout : str
        Of a cube: ``"faces"`` (six arrays), ``"cross"``, ``"strip"`` or ``"stacked"``.
    model, source_model : str
        Of a fisheye: ``"equidistant"`` or ``"equisolid"``.
    border : number or sequence of numbers
        Colour where the target has no direction or the source no picture, in the image's own units.
    filter, encoding, alpha, tolerance, max_anisotropy, threads
        As for :func:`multum.warp`; ``"bilinear"`` is the interpolation at each pixel's centre.
    progress : callable, optional
        Gets the share that is done, now and then; what it raises ends the work.

    Returns
    -------
    (height, width), (height, width, C), (6, n, n) or (6, n, n, C)

    Raises
    ------
    ValueError, TypeError
        For a shape, dtype, name or number that is not as above.

    Examples
    --------
    >>> import numpy as np, multum as mt
    >>> sky = np.zeros((32, 64), np.uint8)
    >>> sky[:16] = 200
    >>> faces = mt.panorama.convert(sky, size=8)
    >>> faces.shape, int(faces[2].min()), int(faces[3].max())
    ((6, 8, 8), 200, 0)
    """
    pixels = np.asarray(image)
    source, target = name("source", source), name("target", target)
    if source == "cube" and source_layout == "faces":
        pixels = stacked_faces(pixels)
    if pixels.ndim not in (2, 3):
        raise ValueError(f"image: got shape {pixels.shape}, expected (H, W) or (H, W, C)")
    for argument, word in (("layout", layout), ("source_layout", source_layout)):
        if name(argument, word) not in _CELLS:
            raise ValueError(f"{argument}: got {word!r}, expected one of {', '.join(map(repr, _CELLS))}")
    angle, source_angle = number("fov", fov), number("source_fov", source_fov)
    if size is None:
        turn = _pixels_a_turn(source, pixels.shape[1], _CELLS[source_layout][0], source_angle)
        width, height = _default_size(target, turn, angle)
    elif isinstance(size, Sequence) or np.ndim(np.asarray(size)) > 0:
        sides = size_pair("size", np.asarray(size).tolist())
        width, height = (count("size", side, most=_LONGEST) for side in sides)
        if target == "cube" and width != height:
            raise ValueError(f"size: got {(width, height)}, expected the side of a face")
    else:
        width = height = count("size", size, most=_LONGEST)
        if target in ("equirect", "dual_paraboloid"):
            height = max(1, width // 2)
    if target == "cube":
        columns, rows = _CELLS[layout]
        width, height = width * columns, height * rows
    turn_by = np.eye(3) if rotation is None else finite_matrix("rotation", rotation, ((3, 3),))
    options = _options(pixels, filter, "clamp", border, tolerance, encoding, alpha, max_anisotropy, threads)
    made = _multum.panorama_convert(
        pixels,
        (source, "stacked" if source_layout == "faces" else source_layout, source_model, source_angle),
        (target, "stacked" if layout == "faces" else layout, model, angle),
        (width, height),
        turn_by.tolist(),
        options,
        progress,
    )
    if target == "cube" and layout == "faces":
        return made.reshape(6, width, width, *made.shape[2:])
    return made
