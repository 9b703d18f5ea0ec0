"""A GPU's filters on the CPU: Mesa's llvmpipe through OpenGL, one thread.

A fragment reads its place and its Jacobian from two textures of singles and writes 8 bits. llvmpipe takes
given gradients for bilinear and trilinear; where anisotropy is on it takes the differences between neighbouring
fragments.
"""

import ctypes
import os
from functools import cache
from typing import Any

os.environ.setdefault("LP_NUM_THREADS", "0")

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..method import Case, Method, Run, Unavailable

FAMILY = "Mesa llvmpipe"

_VERTEX = """#version 330
const vec2 corners[3] = vec2[3](vec2(-1, -1), vec2(3, -1), vec2(-1, 3));
void main() { gl_Position = vec4(corners[gl_VertexID], 0, 1); }
"""

_FRAGMENT = """#version 330
uniform sampler2D picture;
uniform sampler2D places;
uniform sampler2D slopes;
out vec4 colour;
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec2 uv = texelFetch(places, at, 0).xy;
    vec4 j = texelFetch(slopes, at, 0);
    colour = %s;
}
"""

_GIVEN, _DIFFERENCES, _POINT = (
    "textureGrad(picture, uv, j.xz, j.yw)",
    "texture(picture, uv)",
    "textureLod(picture, uv, 0.0)",
)


@cache
def _context() -> Any:
    """One context for all; its allocator keeps what it has, which Mesa gains by at small sizes."""
    keep = ctypes.CDLL(None)
    if hasattr(keep, "mallopt"):
        keep.mallopt(-1, 1 << 30)
        keep.mallopt(-3, 1 << 30)
    try:
        options: dict[str, Any] = {"backend": "egl"}
        context = moderngl.create_context(standalone=True, **options)
    except Exception as error:
        raise Unavailable(f"no OpenGL without a display: {error}") from error
    if "llvmpipe" not in context.info["GL_RENDERER"]:
        raise Unavailable(f"OpenGL is {context.info['GL_RENDERER']}, not llvmpipe")
    return context


def _draw(case: Case, look_up: str, levels: bool, anisotropy: float) -> Run:
    context = _context()
    view, size = case.view, case.view.size
    height, width, channels = case.image.shape
    codes = np.full((height, width, 4), 255, np.uint8)
    codes[..., :channels] = case.image
    picture = context.texture((width, height), 4, codes.tobytes(), alignment=1)
    picture.repeat_x = picture.repeat_y = True
    if levels:
        picture.build_mipmaps()
        picture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        picture.anisotropy = anisotropy
    else:
        picture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    # Differences between neighbours must not see the seam of the period.
    uv = view.uv if look_up != _DIFFERENCES else _unwrapped(case)
    places = context.texture((size, size), 2, uv.tobytes(), dtype="f4", alignment=1)
    slopes = context.texture(
        (size, size), 4, np.ascontiguousarray(view.jacobian).tobytes(), dtype="f4", alignment=1
    )
    for table in (places, slopes):
        table.filter = (moderngl.NEAREST, moderngl.NEAREST)
    target = context.framebuffer([context.texture((size, size), 4, alignment=1)])
    program = context.program(vertex_shader=_VERTEX, fragment_shader=_FRAGMENT % look_up)
    for unit, (name, table) in enumerate((("picture", picture), ("places", places), ("slopes", slopes))):
        if name in program:
            program[name].value = unit
        table.use(unit)
    triangle = context.vertex_array(program, [])

    def work() -> NDArray[Any]:
        for unit, table in enumerate((picture, places, slopes)):
            table.use(unit)
        target.use()
        triangle.render(moderngl.TRIANGLES, vertices=3)
        context.finish()
        return _Framebuffer(target, size, channels)  # type: ignore[return-value]

    return Run(work)


def _unwrapped(case: Case) -> NDArray[np.float32]:
    view = case.view
    y, x = np.mgrid[: view.size, : view.size].astype(np.float64)
    pairs = view.places(np.column_stack([x.ravel(), y.ravel()])).reshape(view.size, view.size, 2)
    return np.ascontiguousarray((pairs + 0.5) / [view.width, view.height], np.float32)


class _Framebuffer:
    """Pixels that are read when they are asked for, after the clock has stopped."""

    def __init__(self, target: Any, size: int, channels: int) -> None:
        self._target, self._size, self._channels = target, size, channels

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        codes = np.frombuffer(self._target.read(components=4, alignment=1), np.uint8)
        codes = codes.reshape(self._size, self._size, 4)[..., : self._channels]
        return np.array(codes, dtype)


METHODS = [
    Method("bilinear", FAMILY, "sample", lambda case: _draw(case, _POINT, False, 1.0)),
    Method("trilinear", FAMILY, "sample", lambda case: _draw(case, _GIVEN, True, 1.0)),
    Method("anisotropic 4", FAMILY, "sample", lambda case: _draw(case, _DIFFERENCES, True, 4.0)),
    Method("anisotropic 16", FAMILY, "sample", lambda case: _draw(case, _DIFFERENCES, True, 16.0)),
]
