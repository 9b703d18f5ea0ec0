"""What is printed on it: three that are drawn here and a photograph, all (side, side, 3) codes."""

from collections.abc import Callable

import numpy as np

from ..demo.figure import Codes, colour
from ..demo.pictures import photograph

_WORDS = (
    "much in little: what is the colour of this pixel, when it covers that piece of that texture? "
    "0123456789 ABCDEFGHIJKLMNOPQRSTUVWXYZ abcdefghijklmnopqrstuvwxyz (u, v) [0, 1] = {a + b} "
)


def checker(side: int) -> Codes:
    """Black and white squares of a 64th of the side."""
    cell = np.arange(side) * 64 // side
    return colour(np.uint8(255) * ((cell[:, None] + cell) % 2 == 0).astype(np.uint8))


def noise(side: int) -> Codes:
    """Every code equally likely, every texel and channel by itself."""
    return np.random.default_rng(4).integers(0, 256, (side, side, 3), np.uint8)


def text(side: int) -> Codes:
    """A page of dark print on light paper."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    sheet = Figure(figsize=(side / 100, side / 100), dpi=100, facecolor="#f6f1e4")
    canvas = FigureCanvasAgg(sheet)
    lines = max(4, side // 18)
    for line in range(lines):
        start = 17 * line % len(_WORDS)
        words = (_WORDS[start:] + 4 * _WORDS)[: side // 6]
        size = (13, 10, 8)[line % 3]
        sheet.text(
            0.01,
            1 - (line + 0.9) / lines,
            words,
            size=0.72 * size,
            color=("#101018", "#6a1010")[line % 5 == 0],
        )
    canvas.draw()
    return colour(np.asarray(canvas.buffer_rgba())[..., :3])


def photo(side: int) -> Codes:
    """The shipped portrait, mirrored until it fills the side, so that it repeats without a seam."""
    image = photograph("astronaut")
    half = side // 2
    step = max(1, image.shape[0] // half)
    part = image[: half * step : step, : half * step : step] if half < image.shape[0] else image
    rows = np.pad(part, ((0, half - part.shape[0]), (0, half - part.shape[1]), (0, 0)), mode="symmetric")
    top = np.concatenate([rows, rows[:, ::-1]], axis=1)
    return colour(np.concatenate([top, top[::-1]], axis=0))


TEXTURES: dict[str, Callable[[int], Codes]] = {
    "checker": checker,
    "text": text,
    "photo": photo,
    "noise": noise,
}
