"""Texture sampling and filtering on the CPU."""

from . import bake, compat, light, mapping, panorama, reference, unwrap
from ._camera import Camera
from ._chart import chart
from ._environment import Environment
from ._files import ImageInfo, image_info, read_image, write_image
from ._material import Layer, Material, MeshImage, TextureSlot
from ._mesh import Mesh, vertex_normals
from ._multum import __version__
from ._pyramid import build_pyramid
from ._raster import Fragments, rasterize
from ._render import TextureUse, render, right_size
from ._sat import SummedAreaTable
from ._scene import Scene
from ._sphere import SphereTexture
from ._survey import Survey
from ._texture import Texture
from ._threads import get_num_threads, set_num_threads
from ._warp import remap, resize, survey, warp
from .mapping import checkerboard

__all__ = [
    "Camera",
    "Environment",
    "Fragments",
    "ImageInfo",
    "Layer",
    "Material",
    "Mesh",
    "MeshImage",
    "Scene",
    "SphereTexture",
    "SummedAreaTable",
    "Survey",
    "Texture",
    "TextureSlot",
    "TextureUse",
    "__version__",
    "bake",
    "build_pyramid",
    "chart",
    "checkerboard",
    "compat",
    "get_num_threads",
    "image_info",
    "light",
    "mapping",
    "panorama",
    "rasterize",
    "read_image",
    "reference",
    "remap",
    "render",
    "resize",
    "right_size",
    "set_num_threads",
    "survey",
    "unwrap",
    "vertex_normals",
    "warp",
    "write_image",
]
