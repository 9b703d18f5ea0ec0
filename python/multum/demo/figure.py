"""What a demonstration consists of."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Codes = NDArray[np.uint8]


@dataclass
class Panel:
    """One picture, (H, W, 3) codes, with a title and a line of figures."""

    image: Codes
    title: str
    note: str = ""


@dataclass
class Figure:
    """Rows of panels, what they show, and what was measured."""

    name: str
    title: str
    text: str
    rows: list[list[Panel]]
    measured: list[str] = field(default_factory=list)


def colour(image: NDArray[Any]) -> Codes:
    """Codes of 8 bits as (H, W, 3)."""
    codes = np.asarray(image, dtype=np.uint8)
    if codes.ndim == 2:
        codes = codes[..., None]
    return np.ascontiguousarray(np.broadcast_to(codes[..., :3], (*codes.shape[:2], 3)))


def enlarged(image: NDArray[Any], times: int) -> NDArray[Any]:
    """Every pixel as a square of pixels."""
    return image.repeat(times, axis=0).repeat(times, axis=1)


def error_picture(image: NDArray[Any], truth: NDArray[np.float64], times: float) -> Codes:
    """The mean distance from the truth, amplified: black, red, yellow, white from 0 to 255."""
    distance = np.abs(image.astype(np.float64) - truth)
    if distance.ndim == 3:
        distance = distance.mean(axis=2)
    level = np.clip(distance * times / 255.0, 0.0, 1.0)
    stops = [0.0, 0.35, 0.7, 1.0]
    ramp = [[8, 200, 250, 255], [8, 30, 190, 255], [16, 20, 40, 255]]
    return np.stack([np.interp(level, stops, part) for part in ramp], axis=2).astype(np.uint8)


def rms(image: NDArray[Any], truth: NDArray[np.float64]) -> float:
    """Root of the mean squared error, in codes."""
    return float(np.sqrt(np.mean((image.astype(np.float64) - truth) ** 2)))
