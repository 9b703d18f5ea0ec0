"""What a contestant is."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..demo.figure import Codes
from .scenes import View

Kind = Literal["warp", "sample"]
"""``"warp"``: from a picture of 8 bits and a matrix or map to a picture of 8 bits, everything included.
``"sample"``: from a texture made ready, places and Jacobians to colours."""


class Unavailable(Exception):
    """Why a method takes no part."""


@dataclass(frozen=True)
class Case:
    """A texture in a scene."""

    view: View
    texture: str
    image: Codes

    @property
    def texels(self) -> float:
        """Texels under all pixels together."""
        jacobian = self.view.jacobian.astype(np.float64)
        return float(np.abs(np.linalg.det(jacobian)).sum() * self.view.width * self.view.height)


@dataclass(frozen=True)
class Run:
    """A method made ready for a case."""

    work: Callable[[], NDArray[Any]]
    """Returns the view (H, W, C) in codes of 255."""
    scale: float = 1.0
    """What the result has to be multiplied by to be in codes of 255."""
    overhead: float = 0.0
    """Seconds of a call that are not the method's own work; taken off its time."""


@dataclass(frozen=True)
class Method:
    """A filter of one library at one setting."""

    name: str
    family: str
    kind: Kind
    prepare: Callable[[Case], Run]
    """May raise `Unavailable`."""
    note: str = ""
