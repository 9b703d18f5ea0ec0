"""Other libraries, one file each; those that are not installed say so and stand aside."""

from collections.abc import Callable
from importlib import import_module

from ..method import Method

NAMES = ("opencv", "scikit", "reprojection", "oiio", "llvmpipe")


def methods(tell: Callable[[str], None] = lambda text: None) -> list[Method]:
    """Every method of every peer that can be imported; ``tell`` gets the reason for each that cannot."""
    found: list[Method] = []
    for name in NAMES:
        try:
            found += import_module(f".{name}", __name__).METHODS
        except ImportError as error:
            tell(f"{name}: {error}")
    return found
