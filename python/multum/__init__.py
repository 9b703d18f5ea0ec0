"""Texture sampling and filtering on the CPU."""

from ._files import ImageInfo, image_info, read_image, write_image
from ._multum import __version__
from ._pyramid import build_pyramid
from ._texture import Texture

__all__ = [
    "ImageInfo",
    "Texture",
    "__version__",
    "build_pyramid",
    "image_info",
    "read_image",
    "write_image",
]
