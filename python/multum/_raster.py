"""Triangles to pixels."""

from functools import cached_property
from typing import Literal, SupportsIndex, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import count, image_size

_Floats = NDArray[np.floating]


def _culling(cull: str | ArrayLike) -> tuple[str, NDArray[np.bool_] | None]:
    if isinstance(cull, str):
        return cull, None
    mask = np.asarray(cull)
    if mask.dtype != np.bool_:
        raise TypeError(
            f"cull: got dtype {mask.dtype}, expected a word or a bool array with one entry a face"
        )
    return "none", mask


class Fragments:
    """What is seen at each pixel; made by :func:`rasterize`. Arrays are made on first use and kept."""

    def __init__(
        self, native: _multum.Fragments, cull: tuple[str, NDArray[np.bool_] | None], samples: int
    ) -> None:
        self._native = native
        self._cull = cull
        self._samples = samples

    @property
    def size(self) -> tuple[int, int]:
        """Width and height."""
        return self._native.size

    @cached_property
    def triangle(self) -> NDArray[np.int32]:
        """Index of the nearest face at each pixel, -1 for none, (H, W)."""
        return self._native.triangle()

    @cached_property
    def depth(self) -> NDArray[np.float32]:
        """Depth z / w, from -1 (near plane) to 1 (far plane), infinity for none, (H, W)."""
        return self._native.depth()

    @cached_property
    def coverage(self) -> NDArray[np.float32]:
        """Share of the pixel's sample points that lie in some triangle, 0 to 1, (H, W)."""
        return self._native.coverage()

    @cached_property
    def barycentric(self) -> NDArray[np.float32]:
        """Perspective-correct weights of the face's corners 0, 1 and 2, zeros for none, (H, W, 3)."""
        return self._native.barycentric()

    @overload
    def interpolate(
        self, attributes: ArrayLike, derivatives: Literal[False] = False, *, fill: float = 0.0
    ) -> _Floats: ...
    @overload
    def interpolate(
        self, attributes: ArrayLike, derivatives: Literal[True], *, fill: float = 0.0
    ) -> tuple[_Floats, _Floats]: ...
    def interpolate(
        self, attributes: ArrayLike, derivatives: bool = False, *, fill: float = 0.0
    ) -> _Floats | tuple[_Floats, _Floats]:
        """Attributes at the centre of each pixel, perspective-correct.

        Parameters
        ----------
        attributes : array, shape (V,), (V, C) or (F, 3, C)
            Numbers for each vertex, or for each corner of each face; ``float64`` stays, all else becomes
            ``float32``.
        derivatives : bool
            Also return how each number changes from pixel to pixel.
        fill : float
            The value where there is no triangle. NaN makes a texture answer with its border colour there.

        Returns
        -------
        value : array, shape (H, W) or (H, W, C)
        jacobian : array, shape (H, W, 2) or (H, W, C, 2), only with ``derivatives``
            ``jacobian[..., i, 0]`` is the change of number i one pixel to the right, ``[..., i, 1]`` one
            pixel down: for uv the Jacobian that :meth:`Texture.sample` takes. They are the derivatives of
            the triangle's own plane, exact where it covers a single pixel too; 0 where there is none.

        Raises
        ------
        ValueError, TypeError
            For a shape or dtype that is not as above.

        Examples
        --------
        >>> import multum as mt
        >>> corners = [[-1, -1, 0, 1], [3, -1, 0, 1], [-1, 3, 0, 1]]
        >>> frag = mt.rasterize(corners, [[0, 1, 2]], (4, 2))
        >>> uv, jac = frag.interpolate([[0, 1], [2, 1], [0, -1]], derivatives=True)
        >>> uv[0, 0].tolist(), jac[0, 0].diagonal().tolist()
        ([0.125, 0.25], [0.25, 0.5])
        """
        numbers = np.asarray(attributes)
        if numbers.dtype.kind in "biu":
            numbers = numbers.astype(np.float32)
        value, jacobian = self._native.interpolate(numbers, derivatives, float(fill))
        return value if jacobian is None else (value, jacobian)

    def behind(self) -> "Fragments":
        """The next layer: what is seen when these fragments are taken away (depth peeling).

        Of two fragments at the same depth the one of the lower face index is in front, so no layer is lost.

        Examples
        --------
        >>> import multum as mt
        >>> corners = [[-1, -1, 0, 1], [3, -1, 0, 1], [-1, 3, 0, 1]]
        >>> front = mt.rasterize(corners, [[0, 1, 2], [0, 1, 2]], (1, 1))
        >>> back = front.behind()
        >>> front.triangle.item(), back.triangle.item(), back.behind().triangle.item()
        (0, 1, -1)
        """
        return Fragments(self._native.behind(*self._cull, self._samples), self._cull, self._samples)


def rasterize(
    clip_positions: ArrayLike,
    faces: ArrayLike,
    size: tuple[SupportsIndex, SupportsIndex],
    *,
    cull: str | ArrayLike = "none",
    samples: SupportsIndex = 1,
    threads: SupportsIndex | None = None,
) -> Fragments:
    """Find the nearest triangle at each pixel.

    Clip space is GL's: visible where -w <= x, y, z <= w, x to the right and y up; row 0 of the picture is the
    top. Pixel centres are at + 1/2. Vertices are snapped to 1/256 pixel and edges tested in exact integers by
    the top-left rule: triangles that share an edge leave no gap and draw no pixel twice. Triangles are cut at
    the near and far planes, so vertices behind the eye are fine. What :meth:`Fragments.interpolate` returns
    does not depend on the snapping.

    Parameters
    ----------
    clip_positions : array, shape (V, 4)
        ``float32`` or ``float64``. Triangles with a number that is not finite (or beyond 1e60) are left out.
    faces : array of whole numbers, shape (F, 3)
        Vertices of each triangle; counter-clockwise in the picture is the front.
    size : (int, int)
        Width and height in pixels, 1 to 16384.
    cull : str or bool array, shape (F,)
        ``"none"``, ``"back"`` or ``"front"``: sides to leave out; an array leaves out the backs of the faces
        where it is true.
    samples : int
        Sample points of a pixel for :attr:`Fragments.coverage`: 1, 4, 8 or 16. Above 1 a pixel whose centre
        is free but of which a sample is covered shows the nearest triangle of its samples, so silhouettes can
        be blended by coverage.
    threads : int, optional
        Threads to use; the result does not depend on it.

    Raises
    ------
    ValueError, TypeError
        For a shape, dtype, index, word or number that is not as above.

    Examples
    --------
    >>> import multum as mt
    >>> corners = [[-1, -1, 0, 1], [1, -1, 0, 1], [-1, 1, 0, 1]]
    >>> mt.rasterize(corners, [[0, 1, 2]], (4, 4)).triangle.tolist()
    [[-1, -1, -1, -1], [0, -1, -1, -1], [0, 0, -1, -1], [0, 0, 0, -1]]
    """
    culling = _culling(cull)
    number = count("samples", samples) or 1
    native = _multum.rasterize(
        clip_positions, faces, image_size(size), *culling, number, count("threads", threads)
    )
    return Fragments(native, culling, number)
