"""Texture sampling and filtering on the CPU."""

from ._multum import __version__

__all__ = ["__version__"]
