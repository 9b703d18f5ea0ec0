"""Meshes, materials, cameras, and the files that hold them."""

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import image_size
from ._files import read_image
from ._texture import Texture


@dataclass(frozen=True, eq=False)
class TextureSlot:
    """A texture of a material."""

    image: int
    """Index into :attr:`Mesh.images`."""
    uv_set: int
    """Index into :attr:`Mesh.uv_sets`."""
    transform: NDArray[np.float32]
    """(2, 3): the texture is read at ``transform[:, :2] @ uv + transform[:, 2]``."""
    wrap: tuple[str, str]
    """Wrap modes of u and v."""
    mag_filter: str | None
    """Filter for enlargement, where the file names one."""
    min_filter: str | None
    """Filter for reduction, where the file names one."""
    encoding: str
    """What the codes mean in this slot: ``"srgb"``, ``"linear"`` or ``"normal"``."""

    def uv(
        self, uv: ArrayLike, jacobian: ArrayLike | None = None
    ) -> tuple[NDArray[np.floating], NDArray[np.floating] | None]:
        """Texture coordinates (..., 2), and their Jacobian (..., 2, 2), after the slot's transform."""
        linear, offset = self.transform[:, :2], self.transform[:, 2]
        moved = np.asarray(uv) @ linear.T + offset
        return moved, None if jacobian is None else linear @ np.asarray(jacobian)


@dataclass(frozen=True, eq=False)
class Material:
    """A material: glTF's metallic-roughness model and MTL's Phong model side by side.

    Each number is multiplied by the texture of its slot, where there is one; what a format does not have
    keeps its default. Colours are linear.
    """

    name: str = ""
    base_color: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)
    metallic: float = 0.0
    roughness: float = 1.0
    normal_scale: float = 1.0
    bump_scale: float = 1.0
    occlusion_strength: float = 1.0
    emissive: tuple[float, ...] = (0.0, 0.0, 0.0)
    ambient: tuple[float, ...] = (1.0, 1.0, 1.0)
    specular: tuple[float, ...] = (0.0, 0.0, 0.0)
    shininess: float = 1.0
    alpha_mode: str = "opaque"
    """``"opaque"``, ``"mask"`` (shown where alpha is at least ``alpha_cutoff``) or ``"blend"``."""
    alpha_cutoff: float = 0.5
    double_sided: bool = False
    unlit: bool = False
    base_color_texture: TextureSlot | None = None
    alpha_texture: TextureSlot | None = None
    metallic_roughness_texture: TextureSlot | None = None
    normal_texture: TextureSlot | None = None
    bump_texture: TextureSlot | None = None
    occlusion_texture: TextureSlot | None = None
    emissive_texture: TextureSlot | None = None
    specular_texture: TextureSlot | None = None
    shininess_texture: TextureSlot | None = None


@dataclass(frozen=True, eq=False)
class MeshImage:
    """A picture that materials name: in a file of its own, or still encoded in the mesh's file."""

    name: str
    path: Path | None
    data: bytes | None = field(repr=False)

    def read(self) -> NDArray[Any]:
        """Decode the picture, as :func:`read_image` does.

        Raises
        ------
        OSError
            When it is missing or damaged.
        """
        if self.path is not None:
            return read_image(self.path)
        if self.data is None:
            raise OSError(f"image: {self.name}")
        return _multum.decode_image(self.name or "embedded image", self.data)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles with normals, tangents, texture coordinates and materials; all vertex arrays have V rows.

    v runs down as everywhere here; OBJ files, where it runs up, are flipped when opened.
    """

    positions: NDArray[np.float32]
    """(V, 3)"""
    normals: NDArray[np.float32]
    """(V, 3), unit vectors."""
    tangents: NDArray[np.float32]
    """(V, 4), unit vectors and the sign w of the bitangent ``w * cross(normal, tangent)``."""
    uv_sets: list[NDArray[np.float32]]
    """Each (V, 2)."""
    colors: NDArray[np.float32] | None
    """(V, 4), linear; multiplied with the material's colour."""
    faces: NDArray[np.uint32]
    """(F, 3), counter-clockwise seen from the front."""
    face_material: NDArray[np.uint32]
    """(F,), indices into ``materials``."""
    materials: list[Material]
    images: list[MeshImage]

    @property
    def uv(self) -> NDArray[np.float32] | None:
        """The first set of texture coordinates, (V, 2), or None."""
        return self.uv_sets[0] if self.uv_sets else None

    @classmethod
    def open(cls, path: str | os.PathLike[str], *, normals: str = "auto") -> "Mesh":
        """Read a glTF (``.gltf``, ``.glb``) or OBJ file as one mesh in world space.

        Nodes are applied; skins, morphs and animations are not. Missing tangents are made by MikkTSpace,
        which splits vertices where uv is mirrored.

        Parameters
        ----------
        path : path
            Files that it names (buffers, pictures, material libraries) must lie in or below its folder.
        normals : str
            What to do where there are none: ``"smooth"`` (weighted by angle, shared across uv seams),
            ``"flat"`` (one a face), or ``"auto"``: flat for glTF, as its specification says, smooth for OBJ.

        Raises
        ------
        OSError
            When a file is missing, damaged, hostile or of another kind.

        Examples
        --------
        >>> import multum as mt, pathlib, tempfile
        >>> path = pathlib.Path(tempfile.mkdtemp(), "triangle.obj")
        >>> _ = path.write_text("v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nvt 0 1\\nf 1/1 2/1 3/1\\n")
        >>> mesh = mt.Mesh.open(path)
        >>> mesh.faces.tolist(), mesh.normals[0].tolist(), mesh.uv[0].tolist()
        ([[0, 1, 2]], [0.0, 0.0, 1.0], [0.0, 0.0])
        """
        return Scene.open(path, normals=normals).mesh

    def texture(self, slot: TextureSlot) -> Texture:
        """Decode the picture of a slot into a texture with the slot's encoding and wrap modes.

        The fourth (or second) channel is straight alpha.
        """
        image = self.images[slot.image].read()
        alpha = image.ndim == 3 and image.shape[2] in (2, 4) and slot.encoding != "normal"
        return Texture(image, slot.wrap, encoding=slot.encoding, alpha="straight" if alpha else "none")


class Camera:
    """Where the eye is and what it sees. It looks along its own -z, with y up in the picture.

    Parameters
    ----------
    eye, target : 3 numbers
        Where it is, and what it looks at.
    up : 3 numbers
        What is upwards in the picture.
    fov : float
        Angle of view from bottom to top, in degrees.
    near, far : float
        Nearest and farthest distance seen; ``far`` may be infinite.

    Raises
    ------
    ValueError, TypeError
        For numbers that make no camera.

    Examples
    --------
    >>> import multum as mt
    >>> camera = mt.Camera((0, 0, 5), (0, 0, 0), fov=90)
    >>> camera.project([0, 5, 0], (64, 64)).round(6).tolist()[:2]
    [0.0, 5.0]
    """

    def __init__(
        self,
        eye: ArrayLike,
        target: ArrayLike = (0.0, 0.0, 0.0),
        up: ArrayLike = (0.0, 1.0, 0.0),
        fov: float = 45.0,
        near: float = 0.01,
        far: float = math.inf,
    ) -> None:
        places = [_place(name, v) for name, v in (("eye", eye), ("target", target), ("up", up))]
        self._native = _multum.Camera(
            places[0], places[1], places[2], math.radians(fov), float(near), float(far)
        )

    @classmethod
    def _of(cls, native: _multum.Camera) -> "Camera":
        camera = cls.__new__(cls)
        camera._native = native
        return camera

    @property
    def name(self) -> str:
        """Name in the file."""
        return self._native.name

    @property
    def eye(self) -> NDArray[np.float64]:
        """Where it is, (3,)."""
        return np.array(self._native.eye)

    @property
    def view(self) -> NDArray[np.float64]:
        """World space to the camera's own space, (4, 4), for column vectors."""
        return self._native.view()

    def matrix(self, size: tuple[SupportsIndex, SupportsIndex]) -> NDArray[np.float64]:
        """World space to clip space for a picture of this (width, height), (4, 4), for column vectors."""
        return self._native.matrix(image_size(size))

    def project(self, points: ArrayLike, size: tuple[SupportsIndex, SupportsIndex]) -> NDArray[np.float64]:
        """Clip-space positions (..., 4) of points (..., 3): what :func:`rasterize` takes."""
        return self._native.project(points, image_size(size))


class Scene:
    """A mesh and the cameras of its file.

    Examples
    --------
    >>> import multum as mt, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "triangle.obj")
    >>> _ = path.write_text("v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nf 1 2 3\\n")
    >>> scene = mt.Scene.open(path)
    >>> clip = scene.camera("auto").project(scene.mesh.positions, (64, 48))
    >>> int((mt.rasterize(clip, scene.mesh.faces, (64, 48)).triangle == 0).sum()) > 200
    True
    """

    def __init__(self, mesh: Mesh, cameras: Sequence[Camera], default: Camera) -> None:
        self.mesh = mesh
        self.cameras = list(cameras)
        self._default = default

    @classmethod
    def open(cls, path: str | os.PathLike[str], *, normals: str = "auto") -> "Scene":
        """Read a glTF (``.gltf``, ``.glb``) or OBJ file; see :meth:`Mesh.open`."""
        parts, cameras, default = _multum.open_scene(os.fspath(path), normals)
        mesh = Mesh(
            **{
                **parts,
                "materials": [_material(values) for values in parts["materials"]],
                "images": [
                    MeshImage(name, None if file is None else Path(file), data)
                    for name, file, data in parts["images"]
                ],
            }
        )
        return cls(mesh, [Camera._of(camera) for camera in cameras], Camera._of(default))

    def camera(self, name: str = "auto") -> Camera:
        """The camera of this name; ``"auto"``: the file's first, or one that frames the scene.

        Raises
        ------
        ValueError
            When there is no camera of this name.
        """
        if name == "auto":
            return self._default
        for camera in self.cameras:
            if camera.name == name:
                return camera
        names = ", ".join(repr(camera.name) for camera in self.cameras)
        raise ValueError(f"camera: got {name!r}, expected 'auto' or one of [{names}]")


def _place(name: str, value: ArrayLike) -> list[float]:
    try:
        place = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: got {value!r}, expected 3 numbers") from None
    if place.shape != (3,):
        raise ValueError(f"{name}: got shape {place.shape}, expected 3 numbers")
    return [float(x) for x in place]


def _material(values: dict[str, Any]) -> Material:
    fields: dict[str, Any] = dict(values)
    for key, value in values.items():
        if key.endswith("_texture"):
            fields[key] = TextureSlot(**value)
        elif isinstance(value, list):
            fields[key] = tuple(value)
    return Material(**fields)


def vertex_normals(positions: ArrayLike, faces: ArrayLike) -> NDArray[np.float32]:
    """Smooth unit normals: each face weighted by its angle at the vertex.

    Vertices at the same place share their normal, as uv seams need. Where no face has an area: +z.

    Parameters
    ----------
    positions : array, shape (V, 3)
    faces : array of whole numbers, shape (F, 3)

    Returns
    -------
    array, shape (V, 3), float32

    Raises
    ------
    ValueError, TypeError
        For a shape, dtype or index that does not fit.

    Examples
    --------
    >>> import multum as mt
    >>> mt.vertex_normals([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])[0].tolist()
    [0.0, 0.0, 1.0]
    """
    return _multum.vertex_normals(positions, faces)
