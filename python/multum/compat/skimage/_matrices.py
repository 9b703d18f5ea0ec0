"""Transformations by 3x3 matrices, as scikit-image names them; without estimation from points."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Matrix = NDArray[Any]
_HOMOGRAPHIES = frozenset({"ProjectiveTransform", "AffineTransform", "SimilarityTransform"})


def matrix_of(inverse_map: Any) -> NDArray[Any] | None:
    """The 3x3 matrix of an array or of a transform object of this module or of scikit-image, or None."""
    if isinstance(inverse_map, np.ndarray):
        return inverse_map if inverse_map.shape == (3, 3) else None
    owner = getattr(inverse_map, "__self__", None)
    if owner is not None and getattr(inverse_map, "__name__", "") == "inverse":
        # The bound method of older releases.
        forward = matrix_of(owner)
        return None if forward is None else np.linalg.inv(forward)
    if any(base.__name__ in _HOMOGRAPHIES for base in type(inverse_map).__mro__):
        params = np.asarray(inverse_map.params)
        return params if params.shape == (3, 3) else None
    return None


def apply(matrix: Matrix, coords: ArrayLike) -> Matrix:
    """Points (N, 2), as (x, y), through a matrix; a zero divisor counts as 2^-52."""
    points = np.array(coords, np.float64, ndmin=2)
    moved = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    divisor = moved[:, 2:]
    divisor[divisor == 0] = np.finfo(float).eps
    moved[:, :2] /= divisor
    return moved[:, :2]


def matrix_transform(coords: ArrayLike, matrix: ArrayLike) -> Matrix:
    """Points (N, 2), as (x, y), through a homogeneous 3x3 matrix.

    >>> matrix_transform([[1.0, 2.0]], [[2, 0, 1], [0, 2, 0], [0, 0, 1]]).tolist()
    [[3.0, 4.0]]
    """
    return ProjectiveTransform(matrix)(coords)


class ProjectiveTransform:
    """A homography of points (x, y): ``params`` is its 3x3 matrix.

    Call it with points (N, 2); ``inverse`` leads back; ``a + b`` does ``a`` first.

    >>> shift = ProjectiveTransform([[1, 0, 5], [0, 1, -2], [0, 0, 1]])
    >>> shift([[0, 0]]).tolist(), (shift + shift.inverse).params.tolist() == np.eye(3).tolist()
    ([[5.0, -2.0]], True)
    """

    params: Matrix

    def __init__(self, matrix: ArrayLike | None = None, *, dimensionality: int | None = None) -> None:
        """Make it from a 3x3 matrix; without one, the identity."""
        self.params = np.eye(3) if matrix is None else np.array(matrix, np.float64)
        if self.params.shape != (3, 3) or dimensionality not in (None, 2):
            raise ValueError(f"matrix: got shape {self.params.shape}, expected (3, 3)")

    def __call__(self, coords: ArrayLike) -> Matrix:
        """Points (N, 2) and where they go."""
        return apply(self.params, coords)

    @classmethod
    def _of(cls, matrix: Matrix) -> "ProjectiveTransform":
        made = cls.__new__(cls)
        made.params = matrix
        return made

    @property
    def inverse(self) -> "ProjectiveTransform":
        """The transform that leads back."""
        return self._of(np.linalg.inv(self.params))

    @property
    def dimensionality(self) -> int:
        """Always 2."""
        return 2

    def __add__(self, other: "ProjectiveTransform") -> "ProjectiveTransform":
        """This one and then another."""
        if not isinstance(other, ProjectiveTransform):
            raise TypeError(f"got a {type(other).__name__}, expected a transform")
        common = type(self) if type(self) is type(other) else ProjectiveTransform
        return common._of(other.params @ self.params)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """The matrix."""
        return np.array(self.params, dtype)

    def residuals(self, src: ArrayLike, dst: ArrayLike) -> NDArray[np.float64]:
        """Distances (N,) of the images of ``src`` from ``dst``."""
        distances: NDArray[np.float64] = np.sqrt(((self(src) - np.asarray(dst)) ** 2).sum(axis=1))
        return distances

    def __repr__(self) -> str:
        """The matrix, printed."""
        rows = np.array2string(self.params, separator=", ", prefix=f"<{type(self).__name__}(matrix=")
        return f"<{type(self).__name__}(matrix={rows})>"


def _pair(argument: str, value: Any) -> tuple[float, float]:
    pair = np.broadcast_to(np.asarray(value, np.float64), (2,))
    if np.ndim(value) not in (0, 1):
        raise ValueError(f"{argument}: got {value!r}, expected a number or two")
    return float(pair[0]), float(pair[1])


class AffineTransform(ProjectiveTransform):
    """Scale, then shear, then rotation (radians, counter-clockwise where y points up), then translation.

    >>> AffineTransform(scale=2, translation=(1, 0))([[1, 1]]).tolist()
    [[3.0, 2.0]]
    """

    def __init__(
        self,
        matrix: ArrayLike | None = None,
        *,
        scale: float | Sequence[float] | None = None,
        shear: float | Sequence[float] | None = None,
        rotation: float | None = None,
        translation: Sequence[float] | None = None,
        dimensionality: int | None = None,
    ) -> None:
        """Make it from a matrix, or from parts."""
        super().__init__(matrix, dimensionality=dimensionality)
        parts = (scale, shear, rotation, translation)
        if matrix is not None and any(part is not None for part in parts):
            raise ValueError("matrix: got parts beside it, expected one or the others")
        if matrix is not None or all(part is None for part in parts):
            return
        sx, sy = _pair("scale", 1 if scale is None else scale)
        slants = shear if isinstance(shear, Sequence) else (0 if shear is None else shear, 0)
        along_x, along_y = _pair("shear", slants)
        angle = 0.0 if rotation is None else rotation
        tx, ty = (0.0, 0.0) if translation is None else _pair("translation", translation)
        cos, sin = math.cos(angle), math.sin(angle)
        kx, ky = math.tan(along_x), math.tan(along_y)
        # Rotation times ((1, -kx), (-ky, 1)) times scale.
        self.params[0] = sx * (cos + ky * sin), -sy * (kx * cos + sin), tx
        self.params[1] = sx * (sin - ky * cos), -sy * (kx * sin - cos), ty

    @property
    def rotation(self) -> float:
        """Angle of the image of the x axis, in radians."""
        return math.atan2(self.params[1, 0], self.params[0, 0])

    @property
    def translation(self) -> NDArray[np.float64]:
        """Where (0, 0) goes."""
        return self.params[:2, 2]

    @property
    def shear(self) -> float:
        """Angle by which the image of the y axis leans, in radians."""
        return math.atan2(-self.params[0, 1], self.params[1, 1]) - self.rotation

    @property
    def scale(self) -> NDArray[np.float64]:
        """Factors of lengths along x and y."""
        squares = (self.params**2).sum(axis=0)
        squares[1] /= math.tan(self.shear) ** 2 + 1
        lengths: NDArray[np.float64] = np.sqrt(squares[:2])
        return lengths


class EuclideanTransform(ProjectiveTransform):
    """Rotation (radians), then translation.

    >>> EuclideanTransform(translation=(3, 4))([[0, 0]]).tolist()
    [[3.0, 4.0]]
    """

    def __init__(
        self,
        matrix: ArrayLike | None = None,
        *,
        rotation: float | None = None,
        translation: Sequence[float] | NDArray[Any] | None = None,
        dimensionality: int | None = None,
    ) -> None:
        """Make it from a matrix, or from parts."""
        super().__init__(matrix, dimensionality=dimensionality)
        if matrix is not None and (rotation is not None or translation is not None):
            raise ValueError("matrix: got parts beside it, expected one or the others")
        if rotation is not None:
            cos, sin = math.cos(rotation), math.sin(rotation)
            self.params[:2, :2] = [[cos, -sin], [sin, cos]]
        if translation is not None:
            self.params[:2, 2] = _pair("translation", translation)

    @property
    def rotation(self) -> float:
        """The angle, in radians."""
        return math.atan2(self.params[1, 0], self.params[1, 1])

    @property
    def translation(self) -> NDArray[np.float64]:
        """Where (0, 0) goes."""
        return self.params[:2, 2]


class SimilarityTransform(EuclideanTransform):
    """Scale and rotation (radians), then translation.

    >>> SimilarityTransform(scale=2, translation=(3, 4))([[1, 0]]).tolist()
    [[5.0, 4.0]]
    """

    def __init__(
        self,
        matrix: ArrayLike | None = None,
        *,
        scale: float | None = None,
        rotation: float | None = None,
        translation: Sequence[float] | NDArray[Any] | None = None,
        dimensionality: int | None = None,
    ) -> None:
        """Make it from a matrix, or from parts."""
        super().__init__(matrix, rotation=rotation, translation=translation, dimensionality=dimensionality)
        if scale is not None:
            if matrix is not None:
                raise ValueError("matrix: got parts beside it, expected one or the others")
            self.params[:2, :2] *= scale

    @property
    def scale(self) -> float:
        """The factor of all lengths."""
        return math.sqrt(float(np.linalg.det(self.params)))
