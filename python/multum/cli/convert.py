"""From the numbers of one file format to those of another."""

import os
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .options import FORMATS

_FLOAT_ONLY = (".hdr", ".exr")


def check_output(path: str) -> None:
    """Complain about a name that cannot be written before any work is done."""
    extension = os.path.splitext(path)[1].lower()
    if extension not in FORMATS:
        raise ValueError(f"OUT: got {path!r}, expected a name ending in {', '.join(FORMATS)}")
    folder = os.path.dirname(path) or "."
    if not os.path.isdir(folder):
        raise OSError(f"OUT: there is no folder {folder!r}; make it first")


def fit(image: NDArray[Any], path: str, depth: str | None, encoding: str | None) -> NDArray[Any]:
    """The image in numbers and channels that the format of ``path`` holds; says on stderr what had to change.

    Floats are light; integers are sRGB codes, or shares of full scale where ``encoding`` says ``"linear"`` or
    ``"normal"``.
    """
    extension = os.path.splitext(path)[1].lower()
    notes: list[str] = []
    wanted = _wanted(image, extension, depth)
    result = _to_dtype(image, wanted, encoding or "srgb", notes)
    result = _to_channels(result, extension, notes)
    if notes:
        print(f"multum: {path}: {'; '.join(notes)}", file=sys.stderr)
    return result


def _wanted(image: NDArray[Any], extension: str, depth: str | None) -> np.dtype[Any]:
    """The element type to write."""
    given = {"8": np.uint8, "16": np.uint16, "float": np.float32}
    if extension in _FLOAT_ONLY:
        if depth not in (None, "float"):
            raise ValueError(f"--depth: got {depth}, expected float for {extension}")
        return np.dtype(np.float32)
    if extension in (".jpg", ".jpeg"):
        if depth not in (None, "8"):
            raise ValueError(f"--depth: got {depth}, expected 8 for {extension}; PNG and TIFF hold more")
        return np.dtype(np.uint8)
    if extension == ".png" and depth == "float":
        raise ValueError("--depth: got float, expected 8 or 16 for .png; TIFF, HDR and EXR hold floats")
    if depth is not None:
        return np.dtype(given[depth])
    if extension == ".png" and image.dtype.kind == "f":
        return np.dtype(np.uint16)
    return image.dtype


def _to_dtype(image: NDArray[Any], wanted: np.dtype[Any], encoding: str, notes: list[str]) -> NDArray[Any]:
    if image.dtype == wanted:
        return image
    curve = "through the sRGB curve" if encoding == "srgb" else "as shares of full scale"
    if image.dtype.kind == "u" and wanted.kind == "u":
        notes.append(f"{8 * image.itemsize} bits became {8 * wanted.itemsize}")
        # 65535 = 257 * 255, so both ways are exact or rounded to nearest.
        wide = image.astype(np.uint32)
        return (wide * 257 if wanted.itemsize == 2 else (wide + 128) // 257).astype(wanted)
    if image.dtype.kind == "u":
        notes.append(f"{8 * image.itemsize}-bit numbers became floats, {curve}")
        share = image.astype(np.float64) / np.iinfo(image.dtype).max
        return _colours(share, _decode if encoding == "srgb" else None).astype(wanted)
    if wanted.kind == "f":
        return image.astype(wanted)
    notes.append(f"floats became {8 * wanted.itemsize}-bit numbers, {curve}, cut to 0..1")
    share = np.clip(np.nan_to_num(image.astype(np.float64), nan=0.0), 0.0, 1.0)
    share = _colours(share, _encode if encoding == "srgb" else None)
    return np.floor(share * np.iinfo(wanted).max + 0.5).astype(wanted)


def _colours(image: NDArray[np.float64], curve: Any) -> NDArray[np.float64]:
    """The curve over all channels but alpha."""
    if curve is None:
        return image
    if image.ndim == 3 and image.shape[2] in (2, 4):
        return np.concatenate([curve(image[..., :-1]), image[..., -1:]], axis=2)
    return np.asarray(curve(image))


def _decode(code: NDArray[np.float64]) -> NDArray[np.float64]:
    """IEC 61966-2-1: from codes to light."""
    return np.where(code <= 0.04045, code / 12.92, ((np.maximum(code, 0.04045) + 0.055) / 1.055) ** 2.4)


def _encode(light: NDArray[np.float64]) -> NDArray[np.float64]:
    """IEC 61966-2-1: from light to codes."""
    powered = 1.055 * np.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(light <= 0.0031308, light * 12.92, powered)


def _to_channels(image: NDArray[Any], extension: str, notes: list[str]) -> NDArray[Any]:
    channels = image.shape[2] if image.ndim == 3 else 1
    alpha = channels in (2, 4)
    if alpha and extension in (".jpg", ".jpeg", ".hdr"):
        notes.append(f"{extension} holds no alpha, which was dropped")
        image, channels, alpha = image[..., :-1], channels - 1, False
    if image.dtype.kind == "f" and channels < 3:
        notes.append("grey became three equal channels")
        grey = image.reshape(*image.shape[:2], channels)
        image = np.concatenate([grey[..., :1]] * 3 + ([grey[..., 1:]] if alpha else []), axis=2)
    return np.ascontiguousarray(image)
