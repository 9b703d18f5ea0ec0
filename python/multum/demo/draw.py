"""Panels on one sheet, with labels where matplotlib is installed."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .figure import Codes, Figure, Panel

try:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Sheet

    LABELS = True
except ImportError:
    LABELS = False

_GAP = 14
_TITLE, _NOTE = 19, 19
_DPI = 100
_INK = (24, 24, 28)


def sheet(figure: Figure) -> Codes:
    """The picture of a figure; panels keep their pixels."""
    above = [_label_height(row) for row in figure.rows]
    heights = [
        label + max(p.image.shape[0] for p in row) for label, row in zip(above, figure.rows, strict=True)
    ]
    widths = [sum(p.image.shape[1] + _GAP for p in row) for row in figure.rows]
    height, width = sum(heights) + _GAP * (len(heights) + 1), max(widths) + _GAP
    canvas = np.full((height, width, 3), 255, np.uint8)
    labels: list[tuple[int, int, str, str]] = []
    y = _GAP
    for row, label, row_height in zip(figure.rows, above, heights, strict=True):
        x = _GAP
        for panel in row:
            h, w = panel.image.shape[:2]
            canvas[y + label : y + label + h, x : x + w] = panel.image
            labels.append((x, y, panel.title, panel.note))
            x += w + _GAP
        y += row_height + _GAP
    return _with_labels(canvas, labels) if LABELS else canvas


def _label_height(row: list[Panel]) -> int:
    return (_TITLE + _NOTE * any(panel.note for panel in row)) if LABELS else 0


def _with_labels(canvas: Codes, labels: list[tuple[int, int, str, str]]) -> Codes:
    height, width = canvas.shape[:2]
    page = Sheet(figsize=(width / _DPI, height / _DPI), dpi=_DPI)
    agg = FigureCanvasAgg(page)
    ink = [c / 255 for c in _INK]
    for x, y, title, note in labels:
        for text, down, size, weight in ((title, 1, 9.5, "bold"), (note, 1 + _TITLE, 8.5, "normal")):
            page.text(x / width, 1 - (y + down) / height, text, size=size, weight=weight, va="top", color=ink)
    agg.draw()
    drawn: NDArray[Any] = np.asarray(agg.buffer_rgba())[..., :3]
    # Text is black on white: the darker of both keeps the panels as they are.
    return np.asarray(np.minimum(canvas, drawn), dtype=np.uint8)
