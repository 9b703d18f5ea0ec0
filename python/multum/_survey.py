"""What a filter spends on each pixel, and on which level it reads."""

from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

_MOST: dict[str, float] = {"cost": 12.0, "lod": 8.0}
"""What the brightest colour stands for: 4096 look-ups, level 8."""

_COLOURS = np.array(
    [[12, 8, 38], [62, 24, 110], [140, 41, 129], [222, 73, 104], [254, 159, 109], [252, 253, 191]], np.float64
)


class Survey(NamedTuple):
    """Two arrays, ``float32``, one number a sample or pixel."""

    cost: NDArray[np.float32]
    """Texels and entries of tables that the filter looks at, all channels together."""
    lod: NDArray[np.float32]
    """The level of detail that is read; the mean by share of the footprint where there are several."""

    def picture(self, what: Literal["cost", "lod"] = "cost") -> NDArray[np.uint8]:
        """Colours from dark to light: one look-up to 4096 by their logarithm, or level 0 to 8.

        Raises
        ------
        ValueError
            For another word.

        Examples
        --------
        >>> import numpy as np
        >>> from multum import Survey
        >>> Survey(np.float32([[1, 4096]]), np.float32([[0, 8]])).picture("cost").tolist()
        [[[12, 8, 38], [252, 253, 191]]]
        """
        if what not in _MOST:
            raise ValueError(f"what: got {what!r}, expected 'cost' or 'lod'")
        values: NDArray[Any] = np.log2(np.maximum(self.cost, 1)) if what == "cost" else self.lod
        at = np.clip(np.nan_to_num(values) / _MOST[what], 0, 1) * (len(_COLOURS) - 1)
        low = np.minimum(at.astype(int), len(_COLOURS) - 2)
        part = (at - low)[..., None]
        drawn: NDArray[np.uint8] = np.rint(_COLOURS[low] * (1 - part) + _COLOURS[low + 1] * part).astype(
            np.uint8
        )
        return drawn
