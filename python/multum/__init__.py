"""Texture sampling and filtering on the CPU."""

from ._multum import __version__
from ._pyramid import build_pyramid

__all__ = ["__version__", "build_pyramid"]
