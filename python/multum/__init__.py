"""Texture sampling and filtering on the CPU."""

from . import mapping
from ._files import ImageInfo, image_info, read_image, write_image
from ._multum import __version__
from ._pyramid import build_pyramid
from ._sat import SummedAreaTable
from ._texture import Texture
from ._threads import get_num_threads, set_num_threads
from ._warp import remap, resize, warp
from .mapping import checkerboard

__all__ = [
    "ImageInfo",
    "SummedAreaTable",
    "Texture",
    "__version__",
    "build_pyramid",
    "checkerboard",
    "get_num_threads",
    "image_info",
    "mapping",
    "read_image",
    "remap",
    "resize",
    "set_num_threads",
    "warp",
    "write_image",
]
