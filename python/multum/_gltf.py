"""Meshes to glTF files (Khronos, glTF 2.0 specification), with everything that :class:`Mesh` has of them."""

from __future__ import annotations

import json
import os
import struct
import tempfile
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from ._files import write_image
from ._material import Material, MeshImage, TextureSlot
from ._mesh import Mesh

_WRAPS = {"repeat": 10497, "clamp": 33071, "mirror": 33648}
_FILTERS = {
    "nearest": 9728,
    "bilinear": 9729,
    "nearest_mipmap_nearest": 9984,
    "linear_mipmap_nearest": 9985,
    "nearest_mipmap_linear": 9986,
    "trilinear": 9987,
}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def save(mesh: Mesh, path: str | os.PathLike[str]) -> None:
    """Write a mesh; see :meth:`Mesh.save`."""
    file = Path(path)
    if file.suffix.lower() not in (".gltf", ".glb"):
        raise ValueError(f"path: got {file.name!r}, expected a name that ends in .gltf or .glb")
    writer = _Writer(mesh, binary=file.suffix.lower() == ".glb", stem=file.stem)
    document = writer.document()
    if writer.binary:
        _write(file, _container(document, bytes(writer.data)))
        return
    document["buffers"][0]["uri"] = quote(f"{file.stem}.bin")
    for name, data in writer.files.items():
        _write(file.parent / name, data)
    _write(file.parent / f"{file.stem}.bin", bytes(writer.data))
    _write(file, json.dumps(document, indent=1).encode())


def _write(path: Path, data: bytes) -> None:
    """Whole or not at all."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_bytes(data)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def _container(document: dict[str, Any], data: bytes) -> bytes:
    """A GLB file: a header and two chunks, each filled up to four bytes."""
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = (
        struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _png(image: NDArray[Any]) -> bytes:
    """The bytes of a PNG file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "image.png")
        write_image(path, image)
        return path.read_bytes()


class _Writer:
    """Collects the parts of a document."""

    def __init__(self, mesh: Mesh, binary: bool, stem: str) -> None:
        self.mesh, self.binary, self.stem = mesh, binary, stem
        self.data = bytearray()
        self.files: dict[str, bytes] = {}
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self.images: list[dict[str, Any]] = []
        self.samplers: list[dict[str, Any]] = []
        self.textures: list[dict[str, Any]] = []
        self.transforms = False

    def document(self) -> dict[str, Any]:
        mesh = self.mesh
        attributes = {
            "POSITION": self._accessor(mesh.positions, 34962, bounds=True),
            "NORMAL": self._accessor(mesh.normals, 34962),
        }
        if mesh.uv_sets:
            attributes["TANGENT"] = self._accessor(mesh.tangents, 34962)
        for i, uv in enumerate(mesh.uv_sets):
            attributes[f"TEXCOORD_{i}"] = self._accessor(uv, 34962)
        if mesh.colors is not None:
            attributes["COLOR_0"] = self._accessor(mesh.colors, 34962)
        for i, image in enumerate(mesh.images):
            self.images.append(self._image(i, image))
        primitives = [
            {
                "attributes": attributes,
                "indices": self._accessor(mesh.faces[mesh.face_material == m].reshape(-1), 34963),
                "material": m,
            }
            for m in np.unique(mesh.face_material).tolist()
        ]
        if not primitives:
            raise ValueError("mesh: got a mesh without faces, expected at least one")
        made: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "multum"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": self.stem}],
            "meshes": [{"primitives": primitives}],
            "materials": [self._material(material) for material in mesh.materials],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.data)}],
        }
        optional = {"images": self.images, "samplers": self.samplers, "textures": self.textures}
        made.update({key: value for key, value in optional.items() if value})
        used = []
        if self.transforms:
            used.append("KHR_texture_transform")
        if any(material.unlit for material in mesh.materials):
            used.append("KHR_materials_unlit")
        if used:
            made["extensionsUsed"] = used
        return made

    def _view(self, data: bytes, target: int | None = None) -> int:
        self.data += b"\0" * (-len(self.data) % 4)
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        self.data += data
        self.views.append(view)
        return len(self.views) - 1

    def _accessor(self, array: NDArray[Any], target: int, bounds: bool = False) -> int:
        indices = array.ndim == 1
        packed = np.ascontiguousarray(array, "<u4" if indices else "<f4")
        accessor: dict[str, Any] = {
            "bufferView": self._view(packed.tobytes(), target),
            "componentType": 5125 if indices else 5126,
            "count": len(packed),
            "type": _TYPES[1 if indices else packed.shape[1]],
        }
        if bounds:
            accessor["min"], accessor["max"] = packed.min(axis=0).tolist(), packed.max(axis=0).tolist()
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def _image(self, index: int, image: MeshImage) -> dict[str, Any]:
        if image.pixels is not None:
            data = _png(image.pixels)
        elif image.path is not None:
            data = image.path.read_bytes()
        elif image.data is not None:
            data = image.data
        else:
            raise OSError(f"image: {image.name}")
        kinds = {b"\x89PNG": ("image/png", ".png"), b"\xff\xd8\xff": ("image/jpeg", ".jpg")}
        kind = next((kind for magic, kind in kinds.items() if data.startswith(magic)), None)
        if kind is None:
            raise ValueError(f"image {image.name!r}: glTF holds PNG and JPEG only")
        if self.binary:
            return {"bufferView": self._view(data), "mimeType": kind[0], "name": Path(image.name).stem}
        name = f"{self.stem}_{Path(image.name).stem or index}{kind[1]}"
        if name in self.files:
            name = f"{self.stem}_{index}{kind[1]}"
        self.files[name] = data
        return {"uri": quote(name), "mimeType": kind[0]}

    def _texture(self, slot: TextureSlot) -> dict[str, Any]:
        sampler: dict[str, Any] = {}
        for key, word in zip(("wrapS", "wrapT"), slot.wrap, strict=True):
            if word not in _WRAPS:
                raise ValueError(
                    f"wrap: got {word!r}, expected one of {', '.join(_WRAPS)}: glTF has no other"
                )
            sampler[key] = _WRAPS[word]
        for key, filter_name in (("magFilter", slot.mag_filter), ("minFilter", slot.min_filter)):
            if filter_name is not None:
                sampler[key] = _FILTERS[filter_name]
        if sampler not in self.samplers:
            self.samplers.append(sampler)
        texture = {"source": slot.image, "sampler": self.samplers.index(sampler)}
        if texture not in self.textures:
            self.textures.append(texture)
        info: dict[str, Any] = {"index": self.textures.index(texture), "texCoord": slot.uv_set}
        linear, offset = slot.transform[:, :2].astype(float), slot.transform[:, 2].astype(float)
        if not (np.array_equal(linear, np.eye(2)) and not offset.any()):
            info["extensions"] = {"KHR_texture_transform": _transform(linear, offset)}
            self.transforms = True
        return info

    def _material(self, m: Material) -> dict[str, Any]:
        if m.normal_texture is not None and m.normal_space != "tangent":
            raise ValueError("normal_space: got a normal map in object space, which glTF cannot hold")
        surface: dict[str, Any] = {
            "baseColorFactor": [float(c) for c in m.base_color],
            "metallicFactor": float(m.metallic),
            "roughnessFactor": float(m.roughness),
        }
        made: dict[str, Any] = {"name": m.name, "pbrMetallicRoughness": surface}
        if m.base_color_texture is not None:
            surface["baseColorTexture"] = self._texture(m.base_color_texture)
        if m.metallic_roughness_texture is not None:
            surface["metallicRoughnessTexture"] = self._texture(m.metallic_roughness_texture)
        if m.normal_texture is not None:
            made["normalTexture"] = {**self._texture(m.normal_texture), "scale": float(m.normal_scale)}
        if m.occlusion_texture is not None:
            strength = float(m.occlusion_strength)
            made["occlusionTexture"] = {**self._texture(m.occlusion_texture), "strength": strength}
        if m.emissive_texture is not None:
            made["emissiveTexture"] = self._texture(m.emissive_texture)
        if any(m.emissive):
            made["emissiveFactor"] = [min(float(c), 1.0) for c in m.emissive]
        if m.alpha_mode != "opaque":
            made["alphaMode"] = m.alpha_mode.upper()
            if m.alpha_mode == "mask":
                made["alphaCutoff"] = float(m.alpha_cutoff)
        if m.double_sided:
            made["doubleSided"] = True
        if m.unlit:
            made["extensions"] = {"KHR_materials_unlit": {}}
        return made


def _transform(linear: NDArray[np.float64], offset: NDArray[np.float64]) -> dict[str, Any]:
    """Offset, rotation and scale of KHR_texture_transform: the matrix is (rotation) (scale)."""
    scale = [float(np.hypot(*linear[:, 0])), 0.0]
    rotation = float(np.arctan2(-linear[1, 0], linear[0, 0]))
    cos, sin = np.cos(rotation), np.sin(rotation)
    turn = np.array([[cos, sin], [-sin, cos]])
    rest = turn.T @ linear
    scale[1] = float(rest[1, 1])
    if not np.allclose(rest, np.diag([scale[0], scale[1]]), atol=1e-5):
        raise ValueError("transform: got a shear, which glTF's texture transform cannot hold")
    return {"offset": offset.tolist(), "rotation": rotation, "scale": scale}
