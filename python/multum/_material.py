"""What surfaces look like: textures in slots, layers, materials, and the pictures that they name."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum
from ._files import read_image

_IDENTITY = np.array([[1, 0, 0], [0, 1, 0]], np.float32)


@dataclass(frozen=True, eq=False)
class TextureSlot:
    """A texture of a material."""

    image: int
    """Index into :attr:`Mesh.images`."""
    uv_set: int = 0
    """Index into :attr:`Mesh.uv_sets`."""
    transform: NDArray[np.float32] = field(default_factory=_IDENTITY.copy)
    """(2, 3): the texture is read at ``transform[:, :2] @ uv + transform[:, 2]``."""
    wrap: tuple[str, str] = ("repeat", "repeat")
    """Wrap modes of u and v."""
    mag_filter: str | None = None
    """Filter for enlargement, where the file names one."""
    min_filter: str | None = None
    """Filter for reduction, where the file names one."""
    encoding: str = "srgb"
    """What the codes mean in this slot: ``"srgb"``, ``"linear"`` or ``"normal"``."""

    def uv(
        self, uv: ArrayLike, jacobian: ArrayLike | None = None
    ) -> tuple[NDArray[np.floating], NDArray[np.floating] | None]:
        """Texture coordinates (..., 2), and their Jacobian (..., 2, 2), after the slot's transform."""
        linear, offset = self.transform[:, :2], self.transform[:, 2]
        moved = np.asarray(uv) @ linear.T + offset
        return moved, None if jacobian is None else linear @ np.asarray(jacobian)


@dataclass(frozen=True, eq=False)
class Layer:
    """One more texture of a material.

    With t and a for the texel's colour and alpha, c and b for those that are there, ``blend`` is ``"modulate"``
    (c t, b a), ``"replace"`` (t, a), ``"decal"`` (c (1 - a) + t a, b) or ``"add"`` (c + t, b a).
    """

    texture: TextureSlot
    blend: str = "modulate"
    after_light: bool = False
    """Whether it meets the lit colour rather than the base colour."""


@dataclass(frozen=True, eq=False)
class Material:
    """A material: glTF's metallic-roughness model and MTL's Phong model side by side.

    Each number is multiplied by the texture of its slot, where there is one; what a format does not have
    keeps its default. Colours are linear. Materials do not change: :func:`dataclasses.replace` makes others.
    """

    name: str = ""
    model: str = "phong"
    """``"phong"`` (kd is ``base_color``, ka ``ambient * base_color``, ks ``specular``, p ``shininess``) or
    ``"metallic_roughness"`` (all from ``base_color``, ``metallic`` and ``roughness``)."""
    base_color: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)
    metallic: float = 0.0
    roughness: float = 1.0
    normal_scale: float = 1.0
    normal_space: str = "tangent"
    """What normal maps hold: vectors in ``"tangent"`` space or in ``"object"`` space."""
    bump_scale: float = 1.0
    """Height, in the scene's unit, of the value 1 of ``bump_texture``."""
    displacement_scale: float = 1.0
    """How far the value 1 of ``displacement_texture`` moves a vertex along its normal, in the scene's unit."""
    displacement_offset: float = 0.0
    """How far the value 0 moves it."""
    occlusion_strength: float = 1.0
    emissive: tuple[float, ...] = (0.0, 0.0, 0.0)
    ambient: tuple[float, ...] = (1.0, 1.0, 1.0)
    specular: tuple[float, ...] = (0.0, 0.0, 0.0)
    shininess: float = 1.0
    mirror: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Share of an environment that is mirrored as in a smooth mirror; ``specular_texture`` multiplies it too."""
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
    displacement_texture: TextureSlot | None = None
    occlusion_texture: TextureSlot | None = None
    emissive_texture: TextureSlot | None = None
    specular_texture: TextureSlot | None = None
    shininess_texture: TextureSlot | None = None
    layers: tuple[Layer, ...] = ()


@dataclass(frozen=True, eq=False)
class MeshImage:
    """A picture that materials name: in a file of its own, still encoded in the mesh's file, or an array."""

    name: str
    path: Path | None = None
    data: bytes | None = field(default=None, repr=False)
    pixels: NDArray[Any] | None = field(default=None, repr=False)
    """(H, W) or (H, W, C), as :class:`Texture` takes them; goes before the other two."""

    def read(self) -> NDArray[Any]:
        """Decode the picture, as :func:`read_image` does.

        Raises
        ------
        OSError
            When it is missing or damaged.
        """
        if self.pixels is not None:
            return self.pixels
        if self.path is not None:
            return read_image(self.path)
        if self.data is None:
            raise OSError(f"image: {self.name}")
        return _multum.decode_image(self.name or "embedded image", self.data)


def moved(material: Material, images: int) -> Material:
    """The material with its slots naming pictures so many places later."""

    def later(slot: TextureSlot) -> TextureSlot:
        return replace(slot, image=slot.image + images)

    slots: dict[str, Any] = {
        name: later(value) for name, value in vars(material).items() if isinstance(value, TextureSlot)
    }
    layers = tuple(replace(layer, texture=later(layer.texture)) for layer in material.layers)
    return replace(material, **slots, layers=layers)


def from_file(values: dict[str, Any]) -> Material:
    fields: dict[str, Any] = dict(values)
    for key, value in values.items():
        if key.endswith("_texture"):
            fields[key] = TextureSlot(**value)
        elif isinstance(value, list):
            fields[key] = tuple(value)
    return Material(**fields)
