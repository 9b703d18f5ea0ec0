"""Scenes without light drawn by Mesa's llvmpipe: OpenGL on the CPU, through moderngl."""

import ctypes
import os
from typing import Any

# No threads beside the caller's: read when the first context is made.
os.environ.setdefault("LP_NUM_THREADS", "0")

import moderngl
import numpy as np
from numpy.typing import NDArray

import multum as mt

VERTEX = """#version 330
uniform mat4 matrix;
in vec3 place;
in vec2 uv;
out vec2 at;
void main() { gl_Position = matrix * vec4(place, 1); at = uv; }
"""
FRAGMENT = """#version 330
uniform sampler2D picture;
uniform vec4 factor;
in vec2 at;
out vec4 colour;
void main() { colour = factor * texture(picture, at); }
"""
SRGB8_ALPHA8, FRAMEBUFFER_SRGB = 0x8C43, 0x8DB9
FILTERS = {
    "nearest": (moderngl.NEAREST, moderngl.NEAREST, 1.0),
    "bilinear": (moderngl.LINEAR, moderngl.LINEAR, 1.0),
    "trilinear": (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR, 1.0),
    "anisotropic": (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR, 16.0),
}


class Unavailable(Exception):
    """There is no llvmpipe here, and why."""


def context() -> Any:
    """A context of its own, whose allocator keeps what it has: Mesa gains by that at small sizes."""
    keep = ctypes.CDLL(None)
    if hasattr(keep, "mallopt"):
        keep.mallopt(-1, 1 << 30)
        keep.mallopt(-3, 1 << 30)
    options: dict[str, Any] = {"backend": "egl"}
    try:
        made = moderngl.create_context(standalone=True, **options)
    except Exception as error:
        raise Unavailable(f"no OpenGL without a display: {error}") from error
    if "llvmpipe" not in made.info["GL_RENDERER"]:
        raise Unavailable(f"OpenGL is {made.info['GL_RENDERER']}, not llvmpipe")
    return made


class Llvmpipe:
    """A scene ready to be drawn: base colour textures, blended materials after the others.

    Codes are taken for light; with ``srgb`` textures are decoded and the target's codes are sRGB. ``dtype`` is that
    of the target, ``"f1"`` for 8 bits or ``"f4"`` for singles.
    """

    def __init__(
        self,
        scene: mt.Scene,
        camera: mt.Camera,
        size: tuple[int, int],
        *,
        dtype: str = "f1",
        srgb: bool = False,
    ) -> None:
        self.context = context()
        self.size, self._dtype = size, dtype
        kind: dict[str, Any] = {"internal_format": SRGB8_ALPHA8} if srgb else {}
        if srgb:
            self.context.enable_direct(FRAMEBUFFER_SRGB)
        color = self.context.texture(size, 4, alignment=1, dtype=dtype, **kind)
        self._target = self.context.framebuffer([color], self.context.depth_renderbuffer(size))
        self._program = self.context.program(vertex_shader=VERTEX, fragment_shader=FRAGMENT)
        self._program["matrix"].write(camera.matrix(size).T.astype("f4").tobytes())
        mesh = scene.mesh
        assert mesh.uv is not None
        vertices = self.context.buffer(
            np.concatenate([mesh.positions, mesh.uv], axis=1).astype("f4").tobytes()
        )
        self._pictures: dict[int | None, Any] = {}
        self._parts = []
        for number in sorted(
            range(len(mesh.materials)), key=lambda m: mesh.materials[m].alpha_mode == "blend"
        ):
            material, slot = mesh.materials[number], mesh.materials[number].base_color_texture
            faces = np.ascontiguousarray(mesh.faces[mesh.face_material == number], np.uint32)
            if len(faces) == 0:
                continue
            key = None if slot is None else slot.image
            if key not in self._pictures:
                image = np.full((1, 1, 4), 255, np.uint8) if key is None else mesh.images[key].read()
                self._pictures[key] = self._texture(image, kind)
            indices = self.context.buffer(faces.tobytes())
            array = self.context.vertex_array(self._program, [(vertices, "3f 2f", "place", "uv")], indices)
            self._parts.append((material, self._pictures[key], array))

    def _texture(self, image: NDArray[np.uint8], kind: dict[str, Any]) -> Any:
        codes = np.full((*image.shape[:2], 4), 255, np.uint8)
        codes[..., : image.shape[2]] = image
        texture = self.context.texture(image.shape[1::-1], 4, codes.tobytes(), alignment=1, **kind)
        texture.build_mipmaps()
        return texture

    def draw(self, filter: str) -> None:
        """Draw, and wait until it is done."""
        reducing, enlarging, anisotropy = FILTERS[filter]
        for texture in self._pictures.values():
            texture.filter = (reducing, enlarging)
            texture.anisotropy = anisotropy
        context = self.context
        self._target.use()
        self._target.clear(0.0, 0.0, 0.0, 0.0)
        context.enable_only(moderngl.DEPTH_TEST)
        for material, texture, array in self._parts:
            context.disable(moderngl.BLEND | moderngl.CULL_FACE)
            context.enable(moderngl.NOTHING if material.double_sided else moderngl.CULL_FACE)
            context.enable(moderngl.BLEND if material.alpha_mode == "blend" else moderngl.NOTHING)
            texture.use(0)
            self._program["factor"].value = tuple(material.base_color)
            array.render()
        context.finish()

    def picture(self, filter: str) -> NDArray[np.float64]:
        """What is drawn, (H, W, 4), codes from 0 to 1; rows run down."""
        self.draw(filter)
        w, h = self.size
        data = self._target.read(components=4, alignment=1, dtype=self._dtype)
        codes = (
            np.frombuffer(data, np.uint8) / 255.0
            if self._dtype == "f1"
            else np.frombuffer(data, np.float32).astype(np.float64)
        )
        return np.asarray(codes.reshape(h, w, 4)[::-1], np.float64)
