"""Image files."""

import os
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _multum


class ImageInfo(NamedTuple):
    """What an image file's header says."""

    format: str
    width: int
    height: int
    channels: int
    dtype: np.dtype[Any]


def read_image(path: str | os.PathLike[str]) -> NDArray[Any]:
    """Read a PNG, JPEG, TIFF, Radiance HDR or OpenEXR file.

    Returns
    -------
    array, shape (H, W) for one channel, else (H, W, C)
        ``uint8`` or ``uint16`` codes as stored, or ``float32``; channels in the order R, G, B, A; turned
        upright where the file's metadata say so.

    Raises
    ------
    OSError
        When the file is missing, damaged, no image, or claims more pixels than a file of its size can hold.

    Examples
    --------
    >>> import multum as mt, numpy as np, tempfile, os
    >>> path = os.path.join(tempfile.mkdtemp(), "dot.png")
    >>> mt.write_image(path, np.uint16([[1, 2], [3, 65535]]))
    >>> mt.read_image(path).tolist()
    [[1, 2], [3, 65535]]
    >>> mt.image_info(path)
    ImageInfo(format='Png', width=2, height=2, channels=1, dtype=dtype('uint16'))
    """
    return _multum.read_image(os.fspath(path))


def write_image(path: str | os.PathLike[str], image: ArrayLike) -> None:
    """Write an image; the name's extension chooses the format.

    PNG takes 8 and 16 bits of 1 to 4 channels, TIFF of 1, 3 or 4 and ``float32`` of 3 or 4, JPEG 8 bits of
    1 or 3, HDR floats of 3, EXR floats of 3 or 4. The file is written beside its place and then renamed: it is
    whole or absent.

    Raises
    ------
    ValueError, TypeError
        For an extension that is not known, or an image that the format cannot hold.
    OSError
        When the file cannot be written.
    """
    _multum.write_image(os.fspath(path), np.asarray(image))


def image_info(path: str | os.PathLike[str]) -> ImageInfo:
    """Read an image file's header.

    Raises
    ------
    OSError
        When the file is missing, damaged or no image.
    """
    name, width, height, channels, dtype = _multum.image_info(os.fspath(path))
    return ImageInfo(name, width, height, channels, np.dtype(dtype))
