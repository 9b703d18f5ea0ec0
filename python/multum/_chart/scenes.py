"""What is looked at: from views that enlarge to horizons and poles."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Places = Callable[[Floats], Floats]


@dataclass(frozen=True)
class Scene:
    """A view of a repeated texture.

    Exactly one of ``matrix`` and ``curve`` is given. ``matrix(view, width, height)`` leads from pixels of a view
    of ``view`` squared to texels, centres at whole numbers on both sides; ``curve`` leads from (a, b) in
    [-1, 1] x [-1, 1] across the view to (u, v).
    """

    name: str
    title: str
    matrix: Callable[[int, int, int], Floats] | None = None
    curve: Places | None = None


class View:
    """A scene at a size, over a texture of a size: its map, Jacobians and supersampled maps, made once."""

    def __init__(self, scene: Scene, size: int, width: int, height: int) -> None:
        """``size`` pixels squared onto ``width`` by ``height`` texels."""
        self.scene, self.size, self.width, self.height = scene, size, width, height
        self._maps: dict[int, tuple[NDArray[np.float32], NDArray[np.float32]]] = {}

    @cached_property
    def matrix(self) -> Floats | None:
        """From pixels to texels, or None where the scene is curved."""
        make = self.scene.matrix
        return None if make is None else make(self.size, self.width, self.height)

    def places(self, pixels: Floats) -> Floats:
        """Texels (N, 2) at pixels (N, 2); not reduced to the period."""
        if self.matrix is not None:
            rows = np.column_stack([pixels, np.ones(len(pixels))]) @ self.matrix.T
            return np.asarray(rows[:, :2] / rows[:, 2:])
        assert self.scene.curve is not None
        uv = self.scene.curve((2.0 * pixels + 1.0) / self.size - 1.0)
        return np.asarray(uv * [self.width, self.height] - 0.5)

    def maps(self, times: int = 1) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """x and y in [0, width) and [0, height) for ``times`` squared places in every pixel."""
        if times not in self._maps:
            side = self.size * times
            x, y = np.empty((side, side), np.float32), np.empty((side, side), np.float32)
            across = (np.arange(side) + 0.5) / times - 0.5
            for row, down in enumerate(across):
                place = self.places(np.column_stack([across, np.full(side, down)]))
                x[row], y[row] = place[:, 0] % self.width, place[:, 1] % self.height
            # Rounding to single precision may reach the period itself.
            x[x >= self.width] = 0.0
            y[y >= self.height] = 0.0
            self._maps[times] = x, y
        return self._maps[times]

    def forget(self, times: int) -> None:
        """Frees a map."""
        self._maps.pop(times, None)

    @cached_property
    def uv(self) -> NDArray[np.float32]:
        """Texture coordinates (size, size, 2) in [0, 1)."""
        pairs = self.places(self._centres()).reshape(self.size, self.size, 2)
        return np.asarray(((pairs + 0.5) / [self.width, self.height]) % 1.0, np.float32)

    @cached_property
    def jacobian(self) -> NDArray[np.float32]:
        """Derivatives (size, size, 2, 2) of (u, v) by pixel, from central differences of the map in doubles."""
        centres, step = self._centres(), 1e-4
        period = np.array([self.width, self.height], np.float64)
        columns = []
        for axis in np.eye(2):
            moved = self.places(centres + step * axis) - self.places(centres - step * axis)
            # A seam lies where the difference is a whole period.
            moved -= np.rint(moved / period) * period
            columns.append(moved / (2.0 * step * period))
        return np.stack(columns, axis=-1).reshape(self.size, self.size, 2, 2).astype(np.float32)

    def _centres(self) -> Floats:
        y, x = np.mgrid[: self.size, : self.size].astype(np.float64)
        return np.column_stack([x.ravel(), y.ravel()])


def _turned(degrees: float, scale: float) -> Callable[[int, int, int], Floats]:
    def matrix(view: int, width: int, height: int) -> Floats:
        angle = np.radians(degrees)
        c, s, middle = scale * np.cos(angle), scale * np.sin(angle), (view - 1) / 2
        x, y = (width - 1) / 2 - (c - s) * middle, (height - 1) / 2 - (s + c) * middle
        return np.array([[c, -s, x], [s, c, y], [0.0, 0.0, 1.0]])

    return matrix


def _homography(view: int, width: int, height: int) -> Floats:
    ab = np.array([[2 / view, 0, 1 / view - 1], [0, 2 / view, 1 / view - 1], [0, 0, 1]])
    sheet = np.array([[0.55, 0.16, 0.45], [-0.12, 0.58, 0.48], [0.22, 0.34, 1.0]])
    texels = np.array([[width, 0, -0.5], [0, height, -0.5], [0, 0, 1.0]])
    return np.asarray(texels @ sheet @ ab)


def _plane(view: int, width: int, height: int) -> Floats:
    """Ground whose horizon is one pixel above the first row; the last row shows a texel a pixel."""
    turn = np.radians(24.0)
    c, s = np.cos(turn), np.sin(turn)
    ground = np.array([[view, 0, -0.5 * view * (view - 1)], [0, 0, 1.2 * view**2], [0, 1, 1.0]])
    return np.asarray(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ ground)


def _barrel(ab: Floats) -> Floats:
    return np.asarray(0.5 + 0.42 * ab * (1.0 + 0.3 * (ab**2).sum(1, keepdims=True)))


def _cylinder(ab: Floats) -> Floats:
    return np.column_stack(
        [0.5 + np.arcsin(np.clip(0.995 * ab[:, 0], -1.0, 1.0)) / 1.4, 0.5 + 0.6 * ab[:, 1]]
    )


def _longitude_latitude(direction: Floats) -> Floats:
    """From unit vectors, pole on +z; the seam jumps by a whole number of periods."""
    longitude = np.arctan2(direction[:, 1], direction[:, 0]) / (2.0 * np.pi)
    colatitude = np.arccos(np.clip(direction[:, 2], -1.0, 1.0)) / np.pi
    return np.column_stack([3.0 * longitude, 2.0 * colatitude])


def _sphere(ab: Floats) -> Floats:
    """A ball from straight ahead, its pole in the upper half of the view."""
    x, y = 0.66 * ab[:, 0], -0.66 * ab[:, 1]
    z = np.sqrt(1.0 - x**2 - y**2)
    c, s = np.cos(np.radians(62.0)), np.sin(np.radians(62.0))
    return _longitude_latitude(np.column_stack([x, c * y - s * z, s * y + c * z]))


def _planet(ab: Floats) -> Floats:
    """The stereographic view straight down: the nadir in the middle, the sky around."""
    x, y = 2.6 * ab[:, 0], 2.6 * ab[:, 1]
    share = 2.0 / (1.0 + x**2 + y**2)
    return _longitude_latitude(np.column_stack([x * share, y * share, share - 1.0]))


SCENES: dict[str, Scene] = {
    scene.name: scene
    for scene in (
        Scene("magnify", "enlarged 3.3 times, turned", matrix=_turned(10.0, 0.3)),
        Scene("rotate", "reduced 2.7 times, turned", matrix=_turned(30.0, 2.7)),
        Scene("homography", "sheet in perspective", matrix=_homography),
        Scene("barrel", "barrel distortion", curve=_barrel),
        Scene("cylinder", "around a cylinder", curve=_cylinder),
        Scene("sphere", "ball with its pole", curve=_sphere),
        Scene("planet", "little planet", curve=_planet),
        Scene("plane", "plane to the horizon", matrix=_plane),
    )
}
