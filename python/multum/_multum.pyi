"""The compiled part."""

from typing import Any

from numpy.typing import ArrayLike, NDArray

__version__: str

def build_pyramid(
    image: ArrayLike,
    kind: str,
    encoding: str,
    alpha: str,
    wrap: tuple[str, str],
    coverage: float | None,
    levels: int | None,
) -> list[NDArray[Any]]: ...
