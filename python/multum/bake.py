"""Maps from geometry: what a detailed mesh looks like, written into the texture of a simple one.

Every function takes the detailed mesh ``high``, the simple mesh ``low`` (with uv in [0, 1]) and the ``size`` of
the map, and returns a :class:`Map`: a NumPy array with a :class:`Report` of what happened.

Common options, all by keyword:

``samples`` : int, default 3
    Sample points along each side of a texel; the square of it in all. At most 8.
``method`` : ``"outermost"`` (default), ``"nearest"`` or ``"closest"``
    How a point of the high mesh is found. The first two look along a line through the point of the low mesh, on
    both sides, for surfaces that face outwards, and take the outermost (what is seen from outside) or the one
    with the shortest way. ``"closest"`` takes the closest point in space that faces the same side.
``distance`` : float, optional
    How far to look on each side, in the meshes' unit. Default: twice the largest distance of a vertex of one
    mesh to the other.
``cage`` : array (V, 3), optional
    Places of the cage's vertices, one a vertex of ``low``: lines run from the low mesh to the cage. Default:
    along smooth normals, shared by all vertices at one place.
``padding`` : int, optional
    Texels around the islands that are filled from the nearest texel inside. Default: all of the map, so that no
    level of its pyramid holds any background.
``threads`` : int, optional
    Threads to use; the result does not depend on it.
``progress`` : callable, optional
    Called now and then with the share that is done, from 0 to 1.

What cannot be done right is told by a :class:`BakeWarning` and marked in :attr:`Report.flags`.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, SupportsFloat, SupportsIndex, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import count, name, number, side_or_size
from ._mesh import Mesh

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = [
    "AMBIGUOUS",
    "COVERED",
    "MISSED",
    "OVERLAPPING",
    "PARTLY_MISSED",
    "BakeWarning",
    "Map",
    "Options",
    "Report",
    "ambient_occlusion",
    "closest",
    "color",
    "curvature",
    "height",
    "intersect",
    "normal_map",
    "position",
]

COVERED = 1
"""Bit of :attr:`Report.flags`: the texel has an answer of its own."""
MISSED = 2
"""The texel is on the low mesh, but nothing of the high mesh was found; filled from its neighbours."""
PARTLY_MISSED = 4
"""Some of the texel's samples found the high mesh and some did not."""
AMBIGUOUS = 8
"""A line met several surfaces that face outwards; the method decided."""
OVERLAPPING = 16
"""Several faces of the low mesh share the texel; the one of the lowest index was baked."""

Size = SupportsIndex | Sequence[SupportsIndex]


class BakeWarning(UserWarning):
    """Something about the meshes makes a map incomplete or not unique."""


class Options(TypedDict, total=False):
    """The options that all functions take; see the module's description."""

    samples: SupportsIndex
    method: str
    distance: SupportsFloat | None
    cage: ArrayLike | None
    padding: SupportsIndex | None
    threads: SupportsIndex | None
    progress: Callable[[float], object] | None


@dataclass(frozen=True, eq=False)
class Report:
    """What happened while baking."""

    texels: int
    """Texels of the map."""
    covered: int
    """Texels with an answer of their own."""
    missed: int
    """Texels on the low mesh where nothing of the high mesh was found."""
    partly_missed: int
    """Texels where some samples found it and some did not."""
    ambiguous: int
    """Texels where a line met several surfaces that face outwards."""
    overlapping: int
    """Texels that several faces share."""
    rays: int
    """Lines cast, or closest points looked for."""
    distance: float
    """How far was looked on each side."""
    mirrored_faces: int
    """Faces whose texture is mirrored."""
    degenerate_faces: int
    """Faces without an area in texture space."""
    outside_faces: int
    """Faces that reach out of [0, 1] in texture space."""
    non_manifold_edges: tuple[int, int]
    """Edges of the high and of the low mesh where more than two faces meet, or two with opposite sense."""
    range: tuple[float, float] | None
    """What 0 and full scale of integers stand for; of floats the smallest and largest number."""
    warnings: tuple[str, ...]
    """A sentence for each thing that is not as it should be."""
    coverage: NDArray[np.float32] = field(repr=False)
    """Share of each texel's sample points that have an answer, (H, W)."""
    flags: NDArray[np.uint8] = field(repr=False)
    """Bits for each texel, (H, W)."""


class Map(np.ndarray[Any, Any]):
    """A baked map: an array with its report."""

    report: Report | None
    """What happened; None for views."""

    def __array_finalize__(self, source: object) -> None:
        """Views of a map have no report."""
        self.report = None

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        """What is computed from a map is a plain array or number."""
        return array[()] if return_scalar else np.asarray(array)


def normal_map(
    high: Mesh,
    low: Mesh,
    size: Size,
    *,
    space: str = "tangent",
    dtype: str = "uint8",
    **options: Unpack[Options],
) -> Map:
    """Bake the normals of ``high`` into a normal map for ``low``.

    The interpolated normals of the high mesh, averaged over each texel as directions. Tangent space is that of
    MikkTSpace with the low mesh's own normals and tangents, green pointing up in the picture, as in glTF: a
    shader adds ``x * tangent + y * bitangent + z * normal``, bitangent ``w * cross(normal, tangent)``, of the
    interpolated vectors.

    Parameters
    ----------
    high, low : Mesh
        The detailed mesh, and the simple one with uv.
    size : int or (int, int)
        Width and height in texels.
    space : str
        ``"tangent"``, or ``"object"`` for the axes of the meshes' positions.
    dtype : str
        ``"uint8"``, ``"uint16"`` or ``"float32"``. Integers have their zero at 128 or 32768, floats at 0.5: what
        ``Texture(..., encoding="normal")`` reads.
    **options
        See :mod:`multum.bake`.

    Returns
    -------
    Map, shape (H, W, 3)

    Raises
    ------
    ValueError, TypeError
        For meshes, words or numbers that do not fit.

    Examples
    --------
    >>> import multum as mt
    >>> square = mt.Mesh.build([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]],
    ...                              uv=[[0, 1], [1, 1], [1, 0], [0, 0]])
    >>> flat = mt.bake.normal_map(square, square, 4)
    >>> flat.shape, flat[0, 0].tolist(), flat.report.covered
    ((4, 4, 3), [128, 128, 255], 16)
    """
    return _bake(high, low, size, "normal", dtype, "normal", None, space=name("space", space), **options)


def height(
    high: Mesh,
    low: Mesh,
    size: Size,
    *,
    dtype: str = "float32",
    range: tuple[float, float] | None = None,
    **options: Unpack[Options],
) -> Map:
    """Bake how far ``high`` lies above ``low``: the low mesh displaced by it is the high mesh.

    The distance along the direction of the cage (default: the smooth normal), in the meshes' unit.

    Parameters
    ----------
    high, low, size, **options
        See :func:`normal_map`.
    dtype : str
        ``"float32"`` for the lengths themselves, ``"uint8"`` or ``"uint16"`` for codes of a range.
    range : (float, float), optional
        What becomes 0 and full scale. Default for integers: the smallest and largest number found.

    Returns
    -------
    Map, shape (H, W)

    Examples
    --------
    >>> import multum as mt
    >>> corners, faces = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]
    >>> low = mt.Mesh.build(corners, faces, uv=[[0, 1], [1, 1], [1, 0], [0, 0]])
    >>> high = mt.Mesh.build([[x, y, 0.25] for x, y, _ in corners], faces)
    >>> mt.bake.height(high, low, (2, 1)).tolist()
    [[0.25, 0.25]]
    """
    return _bake(high, low, size, "height", dtype, "linear", range, ranged=True, **options)


def position(
    high: Mesh,
    low: Mesh,
    size: Size,
    *,
    dtype: str = "float32",
    range: tuple[float, float] | None = None,
    **options: Unpack[Options],
) -> Map:
    """Bake the places on ``high`` that belong to the texels of ``low``.

    Parameters
    ----------
    high, low, size, **options
        See :func:`normal_map`.
    dtype, range
        See :func:`height`; one range holds for all three coordinates.

    Returns
    -------
    Map, shape (H, W, 3)
    """
    return _bake(high, low, size, "position", dtype, "linear", range, ranged=True, **options)


def ambient_occlusion(
    high: Mesh,
    low: Mesh,
    size: Size,
    *,
    rays: SupportsIndex = 64,
    radius: SupportsFloat = math.inf,
    dtype: str = "uint8",
    **options: Unpack[Options],
) -> Map:
    """Bake the share of the sky that each point of ``high`` sees, weighted by the cosine: 1 in the open.

    Parameters
    ----------
    high, low, size, **options
        See :func:`normal_map`.
    rays : int
        Rays a texel, shared among its samples. The error falls about as 1 / rays ** 0.75.
    radius : float
        Surfaces farther away, in the meshes' unit, do not count.
    dtype : str
        ``"uint8"`` or ``"uint16"``, full scale for 1; or ``"float32"``.

    Returns
    -------
    Map, shape (H, W)
    """
    extra = {"rays": count("rays", rays), "radius": number("radius", radius)}
    return _bake(high, low, size, "occlusion", dtype, "linear", None, **extra, **options)


def curvature(
    high: Mesh,
    low: Mesh,
    size: Size,
    *,
    dtype: str = "float32",
    range: tuple[float, float] | None = None,
    **options: Unpack[Options],
) -> Map:
    """Bake the mean curvature of ``high`` in 1 / unit of length: positive where convex, 1 / r on a sphere.

    Half the divergence of the interpolated normals, averaged around each vertex.

    Parameters
    ----------
    high, low, size, **options
        See :func:`normal_map`.
    dtype, range
        See :func:`height`.

    Returns
    -------
    Map, shape (H, W)
    """
    return _bake(high, low, size, "curvature", dtype, "linear", range, ranged=True, **options)


def color(
    high: Mesh,
    low: Mesh,
    size: Size,
    *,
    encoding: str = "srgb",
    dtype: str = "uint8",
    **options: Unpack[Options],
) -> Map:
    """Transfer the colour of ``high``: its materials' base colours, their textures and its vertex colours.

    Textures are read with the footprint of each sample point and averaged in linear light, so a large texture
    becomes a small map without aliasing.

    Parameters
    ----------
    high, low, size, **options
        See :func:`normal_map`.
    encoding : str
        Of the codes: ``"srgb"`` or ``"linear"``.
    dtype : str
        ``"uint8"``, ``"uint16"`` or ``"float32"``.

    Returns
    -------
    Map, shape (H, W, 3)

    Raises
    ------
    OSError
        When a texture of the high mesh is missing or damaged.
    """
    if name("encoding", encoding) not in ("srgb", "linear"):
        raise ValueError(f"encoding: got {encoding!r}, expected 'srgb' or 'linear'")
    check_mesh("high", high)
    paints = []
    for material in high.materials:
        slot = material.base_color_texture
        texture = None if slot is None else high.texture(slot)._texture
        transform = np.eye(2, 3) if slot is None else slot.transform
        uv_set = 0 if slot is None else slot.uv_set
        paints.append((list(material.base_color[:3]), texture, uv_set, transform.tolist()))
    return _bake(high, low, size, "color", dtype, encoding, None, paints=paints, **options)


def intersect(
    mesh: Mesh, origins: ArrayLike, directions: ArrayLike, *, threads: SupportsIndex | None = None
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
    """Find the first face that each ray meets, from either side.

    Parameters
    ----------
    mesh : Mesh
    origins, directions : array, shape (..., 3)
        Directions need not be unit vectors.
    threads : int, optional
        Threads to use; the result does not depend on it.

    Returns
    -------
    face : array (...), int32
        -1 where nothing is met.
    distance : array (...), float64
        In lengths of the direction; infinity where nothing is met.
    barycentric : array (..., 3), float64
        Weights of the face's corners.

    Raises
    ------
    ValueError, TypeError
        For shapes that differ, numbers that are not finite, or a direction of zero.

    Examples
    --------
    >>> import multum as mt
    >>> triangle = mt.Mesh.build([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> face, distance, weights = mt.bake.intersect(triangle, [0.25, 0.25, 3], [0, 0, -1])
    >>> int(face), float(distance), weights.tolist()
    (0, 3.0, [0.5, 0.25, 0.25])
    """
    check_mesh("mesh", mesh)
    starts, ways = np.asarray(origins), np.asarray(directions)
    try:
        starts, ways = np.broadcast_arrays(starts, ways)
    except ValueError:
        raise ValueError(
            f"directions: got shape {ways.shape}, expected that of origins, {starts.shape}, or one that broadcasts"
        ) from None
    return _multum.cast_rays(mesh.positions, mesh.faces, starts, ways, count("threads", threads))


def closest(
    mesh: Mesh, points: ArrayLike, *, threads: SupportsIndex | None = None
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
    """Find the place of the mesh that is closest to each point; of equal ones that of the lowest face.

    Parameters
    ----------
    mesh : Mesh
    points : array, shape (..., 3)
    threads : int, optional
        Threads to use; the result does not depend on it.

    Returns
    -------
    face : array (...), int32
        -1 for a mesh without a face that has an area.
    distance : array (...), float64
        In the mesh's unit.
    barycentric : array (..., 3), float64
        Weights of the face's corners.

    Raises
    ------
    ValueError, TypeError
        For another shape, or numbers that are not finite.

    Examples
    --------
    >>> import multum as mt
    >>> triangle = mt.Mesh.build([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> face, distance, weights = mt.bake.closest(triangle, [-3, 0.5, 4])
    >>> int(face), float(distance), weights.tolist()
    (0, 5.0, [0.5, 0.0, 0.5])
    """
    check_mesh("mesh", mesh)
    return _multum.closest_points(mesh.positions, mesh.faces, points, count("threads", threads))


def check_mesh(argument: str, mesh: object) -> None:
    """Refuse what is no mesh."""
    if not isinstance(mesh, Mesh):
        raise TypeError(f"{argument}: got {type(mesh).__name__}, expected a Mesh")


def _range(value: object) -> tuple[float, float]:
    """Two numbers."""
    try:
        first, last = (float(x) for x in value)  # type: ignore[attr-defined]
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"range: got {value!r}, expected two numbers") from None
    return first, last


def bake_quietly(
    high: Mesh,
    low: Mesh,
    size: Size,
    what: str,
    dtype: str,
    encoding: str,
    range: tuple[float, float] | None,
    *,
    space: str = "tangent",
    rays: int = 1,
    radius: float = math.inf,
    paints: Sequence[Any] = (),
    ranged: bool = False,
    samples: SupportsIndex = 3,
    method: str = "outermost",
    distance: SupportsFloat | None = None,
    cage: ArrayLike | None = None,
    padding: SupportsIndex | None = None,
    threads: SupportsIndex | None = None,
    progress: Callable[[float], object] | None = None,
) -> tuple[Map, Report]:
    """Bake ``what`` without a warning."""
    check_mesh("high", high)
    check_mesh("low", low)
    try:
        kind = np.dtype(dtype).name
    except (TypeError, ValueError):
        kind = repr(dtype)
    if kind not in ("uint8", "uint16", "float32"):
        raise TypeError(f"dtype: got {kind}, expected uint8, uint16 or float32")
    ends = None if range is None else _range(range)
    if low.uv is None:
        raise ValueError("low: got a mesh without uv, expected one with uv; Mesh.unwrap makes them")
    baked = _multum.bake_map(
        high,
        low,
        side_or_size(size),
        what,
        space,
        rays,
        radius,
        list(paints),
        count("samples", samples, most=8),
        name("method", method),
        number("distance", distance),
        cage,
        count("padding", padding, least=0),
        count("threads", threads),
        progress,
    )
    found = baked.range()
    if ranged and ends is None and kind != "float32" and found is not None:
        # A map of one number has no range of its own.
        first, last = found
        ends = (first, last if last > first else first + 1.0)
    counts, told = baked.report()
    codes = baked.image(kind, encoding, ends)
    result = codes.view(Map)
    result.report = Report(
        **counts, range=ends or found, warnings=tuple(told), coverage=baked.coverage(), flags=baked.flags()
    )
    return result, result.report


def _bake(*arguments: Any, **options: Any) -> Map:
    result, report = bake_quietly(*arguments, **options)
    for text in report.warnings:
        warnings.warn(text, BakeWarning, stacklevel=3)
    return result
