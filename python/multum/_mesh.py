"""Triangles with what textures need."""

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, SupportsFloat, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._arguments import finite_matrix, number
from ._material import Material, MeshImage, TextureSlot, moved
from ._texture import Texture


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
        from ._scene import Scene

        return Scene.open(path, normals=normals).mesh

    @classmethod
    def build(
        cls,
        positions: ArrayLike,
        faces: ArrayLike,
        *,
        uv: ArrayLike | None = None,
        normals: ArrayLike | str = "smooth",
        colors: ArrayLike | None = None,
        material: Material | None = None,
        texture: ArrayLike | None = None,
        images: Sequence[MeshImage | ArrayLike] = (),
    ) -> "Mesh":
        """Make a mesh of one material from arrays. Tangents are made by MikkTSpace, which may split vertices.

        Parameters
        ----------
        positions : array, shape (V, 3)
        faces : array of whole numbers, shape (F, 3)
            Counter-clockwise seen from the front.
        uv : array, shape (V, 2), optional
            Texture coordinates, v down.
        normals : array, shape (V, 3), or str
            Unit vectors, or how to make them: ``"smooth"`` or ``"flat"``.
        colors : array, shape (V, 4), optional
            Linear colours with alpha.
        material : Material, optional
            Default: white.
        texture : array, shape (H, W) or (H, W, C), optional
            A picture in sRGB for the base colour; it becomes the last of ``images``.
        images : sequence of MeshImage or arrays
            What the slots of ``material`` name.

        Raises
        ------
        ValueError, TypeError
            For a shape, dtype, index or word that does not fit.

        Examples
        --------
        >>> import numpy as np, multum as mt
        >>> square = [[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]
        >>> board = np.uint8([[0, 255], [255, 0]])
        >>> mesh = mt.Mesh.build(
        ...     square, [[0, 3, 2], [0, 2, 1]], uv=[[0, 0], [1, 0], [1, 1], [0, 1]], texture=board
        ... )
        >>> mt.render(mt.Scene(mesh), size=(64, 48)).shape
        (48, 64, 4)
        """
        word, given = (normals, None) if isinstance(normals, str) else ("smooth", normals)
        parts = _multum.build_mesh(positions, faces, given, [] if uv is None else [uv], colors, word)
        pictures = [
            image if isinstance(image, MeshImage) else MeshImage("pixels", pixels=np.asarray(image))
            for image in images
        ]
        made = Material() if material is None else material
        if texture is not None:
            made = replace(made, base_color_texture=TextureSlot(len(pictures)))
            pictures.append(MeshImage("texture", pixels=np.asarray(texture)))
        return cls(**{**parts, "materials": [made], "images": pictures})

    @classmethod
    def join(cls, meshes: Iterable["Mesh"]) -> "Mesh":
        """One mesh from several, which keep their materials and pictures.

        Raises
        ------
        ValueError
            For no mesh at all.
        TypeError
            For what is no mesh.
        """
        parts = list(meshes) if isinstance(meshes, Iterable) else [meshes]
        if not parts:
            raise ValueError("meshes: got none, expected at least one mesh")
        for part in parts:
            if not isinstance(part, Mesh):
                raise TypeError(f"meshes: got {type(part).__name__}, expected meshes")
        sets = max(len(mesh.uv_sets) for mesh in parts)
        colored = any(mesh.colors is not None for mesh in parts)
        vertices = np.cumsum([0, *(len(mesh.positions) for mesh in parts)])
        materials: list[Material] = []
        images: list[MeshImage] = []
        face_material = []
        for mesh in parts:
            face_material.append(mesh.face_material + np.uint32(len(materials)))
            materials += [moved(material, len(images)) for material in mesh.materials]
            images += mesh.images

        def rows(get: Any) -> Any:
            return np.concatenate([get(mesh) for mesh in parts])

        def uv_set(mesh: Mesh, k: int) -> NDArray[np.float32]:
            return (
                mesh.uv_sets[k] if k < len(mesh.uv_sets) else np.zeros((len(mesh.positions), 2), np.float32)
            )

        def color(mesh: Mesh) -> NDArray[np.float32]:
            white = np.ones((len(mesh.positions), 4), np.float32)
            return white if mesh.colors is None else mesh.colors

        return cls(
            positions=rows(lambda m: m.positions),
            normals=rows(lambda m: m.normals),
            tangents=rows(lambda m: m.tangents),
            uv_sets=[np.concatenate([uv_set(mesh, k) for mesh in parts]) for k in range(sets)],
            colors=rows(color) if colored else None,
            faces=np.concatenate(
                [mesh.faces + np.uint32(first) for mesh, first in zip(parts, vertices, strict=False)]
            ),
            face_material=np.concatenate(face_material),
            materials=materials,
            images=images,
        )

    def moved(self, matrix: ArrayLike) -> "Mesh":
        """The mesh moved by a (4, 4) or (3, 4) matrix for column vectors; a mirroring one turns the faces.

        Raises
        ------
        ValueError, TypeError
            For a shape that does not fit and for matrices that are not finite.
        """
        m = finite_matrix("matrix", matrix, ((4, 4), (3, 4)))
        linear = m[:3, :3]
        cofactors = np.cross(linear[[1, 2, 0]], linear[[2, 0, 1]])
        mirrors = float(np.linalg.det(linear)) < 0
        normals = _unit(self.normals @ cofactors.T * (-1 if mirrors else 1))
        tangents = np.concatenate(
            [_unit(self.tangents[:, :3] @ linear.T), self.tangents[:, 3:] * (-1 if mirrors else 1)], 1
        )
        return replace(
            self,
            positions=(self.positions @ linear.T + m[:3, 3]).astype(np.float32),
            normals=normals,
            tangents=tangents.astype(np.float32),
            faces=self.faces[:, ::-1] if mirrors else self.faces,
        )

    def simplify(self, ratio: SupportsFloat) -> "Mesh":
        """Leave about ``ratio`` of the faces, by quadric error metrics (Garland and Heckbert, SIGGRAPH 1997).

        By meshoptimizer. Vertices that stay are vertices that were there, with their uv and colours; where uv,
        colours or materials part, both sides lose the same edges, so cuts stay cuts and nothing tears. Vertices
        that differ by rounding, at most a millionth of the mesh, are one. Normals, smooth ones, and tangents are
        made anew.

        Parameters
        ----------
        ratio : float
            Above 0, at most 1. What cannot get simpler without tearing keeps more.

        Raises
        ------
        ValueError, TypeError
            For a number that is not as above, or that leaves no face.

        Examples
        --------
        >>> import multum as mt, numpy as np
        >>> x, y = np.meshgrid(np.arange(9), np.arange(9))
        >>> corner = (np.arange(8)[:, None] * 9 + np.arange(8)).reshape(-1, 1)
        >>> faces = np.concatenate([corner + [0, 1, 10], corner + [0, 10, 9]])
        >>> flat = mt.Mesh.build(np.stack([x, y, 0 * x], -1).reshape(-1, 3), faces)
        >>> simple = flat.simplify(1 / 64)
        >>> len(flat.faces), len(simple.faces), len(simple.positions)
        (128, 2, 4)
        """
        parts = _multum.simplify_mesh(self, number("ratio", ratio))
        return replace(self, **{**parts, "materials": self.materials, "images": self.images})

    def unwrap(
        self,
        size: SupportsIndex = 1024,
        *,
        padding: SupportsIndex | None = None,
        lowest_level: SupportsIndex = 2,
        method: str = "xatlas",
        iterations: SupportsIndex = 20,
    ) -> "Mesh":
        """Make texture coordinates in which no two faces overlap; uv that were there become the next sets.

        Parameters
        ----------
        size : int
            Side of the square map for which charts are packed, in texels.
        padding : int, optional
            Texels between charts. Default: two texels of ``lowest_level``, 2 ** (lowest_level + 1).
        lowest_level : int
            Coarsest level of the map's pyramid on which charts should not run into each other.
        method : str
            ``"xatlas"``: charts cut and packed by the package xatlas, for any mesh. ``"lscm"`` and ``"arap"``:
            the mesh is a disk, laid flat as one chart that keeps angles, or shapes; they need SciPy.
        iterations : int
            Of ``"arap"``.

        Returns
        -------
        Mesh
            With vertices split at cuts, and with new tangents.

        Raises
        ------
        ValueError, TypeError
            For a word or number that is not as above, charts that do not fit, or a mesh that is no disk where
            it must be one.
        ImportError
            Without the package; ``pip install 'multum[bake]'`` brings both.
        """
        from .unwrap import unwrap

        return unwrap(
            self, size, padding=padding, lowest_level=lowest_level, method=method, iterations=iterations
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a glTF file: ``.glb`` in one file, ``.gltf`` with its buffer and pictures beside it.

        Parameters
        ----------
        path : path
            PNG and JPEG pictures are written as they are, arrays as PNG. What glTF has no place for is left out:
            bump maps, specular and shininess of the Phong model, layers.

        Raises
        ------
        ValueError
            For another extension, or what glTF cannot hold.
        OSError
            When a file cannot be written, or a picture cannot be read.

        Examples
        --------
        >>> import multum as mt, pathlib, tempfile
        >>> path = pathlib.Path(tempfile.mkdtemp(), "triangle.glb")
        >>> mt.Mesh.build([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).save(path)
        >>> mt.Mesh.open(path).positions.shape
        (3, 3)
        """
        from ._gltf import save

        save(self, path)

    def texture(self, slot: TextureSlot) -> Texture:
        """Decode the picture of a slot into a texture with the slot's encoding and wrap modes.

        The fourth (or second) channel is straight alpha.
        """
        image = self.images[slot.image].read()
        alpha = image.ndim == 3 and image.shape[2] in (2, 4) and slot.encoding != "normal"
        return Texture(image, slot.wrap, encoding=slot.encoding, alpha="straight" if alpha else "none")


def _unit(vectors: NDArray[np.floating]) -> NDArray[np.float32]:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return (vectors / np.where(lengths > 0, lengths, 1)).astype(np.float32)


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
