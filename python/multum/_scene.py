"""A mesh, cameras and lights, and the files that hold them."""

import os
from collections.abc import Iterable
from pathlib import Path
from typing import SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _material, _multum
from ._arguments import image_size
from ._camera import Camera
from ._material import MeshImage
from ._mesh import Mesh
from .light import Light, from_parts


class Scene:
    """A mesh, cameras and lights: what :func:`render` draws.

    Everything may be replaced: ``scene.mesh``, ``scene.cameras``, ``scene.lights``. Without lights (None) a lamp
    at the camera and some ambient light are used.

    Examples
    --------
    >>> import multum as mt, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "triangle.obj")
    >>> _ = path.write_text("v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nf 1 2 3\\n")
    >>> scene = mt.Scene.open(path)
    >>> clip = scene.camera("auto").project(scene.mesh.positions, (64, 48))
    >>> int((mt.rasterize(clip, scene.mesh.faces, (64, 48)).triangle == 0).sum()) > 200
    True
    >>> scene.lights = [mt.light.Directional((0, 0, -1)), mt.light.Ambient(0.1)]
    >>> mt.render(scene, size=(64, 48)).dtype
    dtype('uint8')
    """

    def __init__(
        self, mesh: Mesh, cameras: Iterable[Camera] = (), lights: Iterable[Light] | None = None
    ) -> None:
        self.mesh = mesh
        self.cameras = list(cameras)
        self.lights: list[Light] | None = None if lights is None else list(lights)
        self._textures: tuple[list[MeshImage], _multum.Textures] | None = None

    @classmethod
    def open(cls, path: str | os.PathLike[str], *, normals: str = "auto") -> "Scene":
        """Read a glTF (``.gltf``, ``.glb``) or OBJ file; see :meth:`Mesh.open`."""
        parts, cameras, lights = _multum.open_scene(os.fspath(path), normals)
        mesh = Mesh(
            **{
                **parts,
                "materials": [_material.from_file(values) for values in parts["materials"]],
                "images": [
                    MeshImage(name, None if file is None else Path(file), data)
                    for name, file, data in parts["images"]
                ],
            }
        )
        lamps = [from_parts(*light) for light in lights]
        return cls(mesh, [Camera._of(camera) for camera in cameras], lamps or None)

    def add(self, mesh: Mesh, matrix: ArrayLike | None = None) -> None:
        """Put one more mesh into the scene, moved by a matrix as :meth:`Mesh.moved` takes it."""
        self.mesh = Mesh.join([self.mesh, mesh if matrix is None else mesh.moved(matrix)])

    @property
    def center(self) -> NDArray[np.float64]:
        """The middle of the box around the mesh, (3,)."""
        used = self.mesh.positions[self.mesh.faces].reshape(-1, 3).astype(np.float64)
        return np.zeros(3) if len(used) == 0 else (used.min(0) + used.max(0)) / 2

    def _texture_store(self) -> _multum.Textures:
        """The textures made so far, as long as the mesh has the same pictures."""
        images = self.mesh.images
        if self._textures is not None:
            known, store = self._textures
            if len(known) == len(images) and all(a is b for a, b in zip(known, images, strict=True)):
                return store
        store = _multum.Textures()
        self._textures = (list(images), store)
        return store

    def camera(
        self,
        name: str = "auto",
        size: tuple[SupportsIndex, SupportsIndex] | None = None,
        *,
        turning: bool = False,
    ) -> Camera:
        """The camera of this name; ``"auto"``: the file's first, or one that frames the scene.

        The camera that frames looks from the front (+z), a little from the right and above, from as near as the
        whole scene fits into a picture of ``size``, (width, height), or without it into a square. With ``turning``
        it also fits when the camera is :meth:`~Camera.turned` about :attr:`center`.

        Raises
        ------
        ValueError
            When there is no camera of this name.
        """
        if name == "auto":
            if self.cameras:
                return self.cameras[0]
            width, height = (1, 1) if size is None else image_size(size)
            points, faces = self.mesh.positions, self.mesh.faces
            if turning and len(faces):
                points, faces = _turned_around(points[faces].reshape(-1, 3), self.center)
            return Camera._of(_multum.Camera.framing(points, faces, width / max(height, 1)))
        for camera in self.cameras:
            if camera.name == name:
                return camera
        names = ", ".join(repr(camera.name) for camera in self.cameras)
        raise ValueError(f"camera: got {name!r}, expected 'auto' or one of [{names}]")


def _turned_around(
    points: NDArray[np.float32], center: NDArray[np.float64]
) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """A solid of revolution about the vertical axis through a point, and faces of it, with all points inside."""
    slices, sides = 128, 96
    away = points.astype(np.float64) - center
    low, high = away[:, 1].min(), away[:, 1].max()
    place = np.clip((away[:, 1] - low) / max(high - low, 1e-300) * slices, 0, slices - 1).astype(int)
    radius = np.zeros(slices)
    np.maximum.at(radius, place, np.hypot(away[:, 0], away[:, 2]))
    # Sides of a polygon lie within its circle; corners of one that lie outside reach around it.
    radius /= np.cos(np.pi / sides)
    angle = np.arange(sides) * (2 * np.pi / sides)
    ends = low + (np.arange(slices)[:, None] + [0, 1]) * ((high - low) / slices)
    ring = radius[:, None, None] * np.stack([np.cos(angle), 0 * angle, np.sin(angle)], -1)
    solid = ring[:, None] + ends[..., None, None] * [0.0, 1.0, 0.0] + center
    solid = solid[radius > 0] if (radius > 0).any() else solid
    made = solid.reshape(-1, 3).astype(np.float32)
    return made, np.arange(len(made) // 3 * 3, dtype=np.uint32).reshape(-1, 3)
