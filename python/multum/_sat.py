"""Summed-area tables: the sum over any rectangle at a fixed price."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import numbers, wrap_pair


class SummedAreaTable:
    """Sums and means over upright rectangles of a texture, of any size and at any place.

    ``table[y, x]`` is the sum of all texels above and left of corner (x, y) (Crow, 1984). Sums of integers
    are exact: ``uint32`` where they cannot overflow, else ``uint64``. Floats are summed in ``float64`` less
    their mean, so small boxes far from the origin keep their digits.

    Parameters
    ----------
    image : array, shape (H, W) or (H, W, C)
        ``uint8``, ``uint16``, ``float16``, ``float32`` or ``float64``. Integers count as code / full scale.
    wrap : str or pair of str
        What lies outside of 0..1, for u and v: ``"clamp"``, ``"repeat"``, ``"mirror"``, ``"mirror_once"``,
        ``"border"`` or ``"extend"`` (the image's outermost texels are the extra ones).
    border : number or sequence of numbers, optional
        Colour of ``"border"`` and of boxes with a coordinate that is not finite; default 0.

    Raises
    ------
    ValueError, TypeError
        For a shape, dtype, name or number that is not as above.

    Examples
    --------
    >>> import numpy as np, multum as mt
    >>> sat = mt.SummedAreaTable(np.uint8([[0, 51], [102, 255]]), wrap="repeat")
    >>> sat.table[..., 0].tolist()
    [[0, 0, 0], [0, 0, 51], [0, 102, 408]]

    The mean of the lower half, and of the whole texture shifted by half a texel:

    >>> sat.mean([[0, 0.5, 1, 1], [0.25, 0.25, 1.25, 1.25]]).tolist()
    [[0.7], [0.4]]
    """

    def __init__(
        self,
        image: ArrayLike,
        wrap: str | Sequence[str] = "clamp",
        border: ArrayLike | None = None,
    ) -> None:
        shape = np.shape(image)
        colour = numbers("border", border, shape[2] if len(shape) == 3 else 1)
        self._table = _multum.SummedAreaTable(image, wrap_pair(wrap), colour)

    def sum(self, boxes: ArrayLike) -> NDArray[np.float64]:
        """Integrals of the texture over boxes.

        Parameters
        ----------
        boxes : array, shape (..., 4)
            u0, v0, u1, v1 in texture coordinates; corners may be fractional and anywhere. Texels are squares.

        Returns
        -------
        array, shape (..., C), float64
            Values times areas in texels. A box of no area is 0; one with a reversed side is negative; one
            with a coordinate that is not finite is NaN.
        """
        return self._table.boxes(boxes, False)

    def mean(self, boxes: ArrayLike) -> NDArray[np.float64]:
        """Means of the texture over boxes.

        Parameters
        ----------
        boxes : array, shape (..., 4)
            As for :meth:`sum`; the order of opposite sides does not matter.

        Returns
        -------
        array, shape (..., C), float64
            A side of no length stands for the texel that holds it, so a point has that texel's value. A box
            with a coordinate that is not finite has the border colour. A NaN or infinite texel makes every
            box that ends below or right of it NaN.
        """
        return self._table.boxes(boxes, True)

    @property
    def table(self) -> NDArray[Any]:
        """A copy of the entries, (H + 1, W + 1, C); of floats without :attr:`offset`."""
        return self._table.table()

    @property
    def offset(self) -> NDArray[np.float64]:
        """What was taken off each texel of a float image before it was summed, per channel."""
        return self._table.offset()

    @property
    def wrap(self) -> tuple[str, str]:
        """Wrap modes for u and v."""
        return self._table.wrap()
