"""chart.png, and one page that holds everything and needs no server and no network."""

import base64
import html
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .._files import write_image
from ..demo.figure import Codes, enlarged
from . import draw
from .measure import Contest
from .method import Case
from .report import Chart
from .truth import block

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1240px; margin: 2em auto; padding: 0 1em; color: #18181c; }
img { max-width: 100%; height: auto; }
pre { font-size: 12px; overflow-x: auto; background: #f6f6f4; padding: 0.8em; }
.crops { display: flex; flex-wrap: wrap; gap: 8px; }
.crops figure { margin: 0; width: 144px; font-size: 11px; line-height: 1.25; }
.crops img { image-rendering: pixelated; width: 144px; }
p.about { color: #555; }
"""
_CROP = 48
_SHOWN = (
    ("multum", "bilinear"),
    ("multum", "trilinear"),
    ("multum", "anisotropic 16"),
    ("multum", "ewa"),
    ("multum", "area"),
    ("multum", "auto"),
    ("OpenCV", "remap linear"),
    ("OpenCV", "2x2 supersampled"),
    ("OpenCV", "8x8 supersampled"),
    ("reproject", "adaptive Hann"),
    ("OpenImageIO", "anisotropic 16"),
    ("Mesa", "anisotropic 16"),
)


def write(made: Chart, shown: Sequence[tuple[Case, Contest]], folder: Path) -> None:
    """Writes chart.png and index.html."""
    overview = draw.summary(made.points)
    (folder / "chart.png").write_bytes(overview)
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Speed against accuracy</title>',
        f"<style>{_STYLE}</style></head><body><h1>Speed against accuracy</h1>",
        f'<p class="about">{html.escape("; ".join(f"{k}: {v}" for k, v in made.about.items()))}</p>',
        "<p>Errors are against the exact integral over each pixel, in codes of 255; rounding to 8 bits alone is "
        "0.29. OpenCV's maps were made beforehand. The time of OpenImageIO is that of its look-ups as Python calls "
        "them, less that of the calls.</p>",
        _image(overview, "Summary"),
        "<h2>Peers, and how often some multum point is as accurate and as fast</h2>",
        f"<pre>{html.escape(chr(10).join(made.domination()))}</pre>",
        "<h2>What it costs to choose</h2>",
        f"<pre>{html.escape(chr(10).join(made.economy()))}</pre>",
        "<h2>All settings</h2>",
        f"<pre>{html.escape(chr(10).join(made.table()))}</pre>",
    ]
    if made.absences:
        parts.append(f"<h2>Left out</h2><pre>{html.escape(chr(10).join(made.missing()))}</pre>")
    for name in dict.fromkeys(case.view.scene.name for case, _ in shown):
        cases = [(case, result) for case, result in shown if case.view.scene.name == name]
        points = [p for p in made.points if p.scene == name]
        parts += [f"<h2>{html.escape(name)}: {html.escape(cases[0][0].view.scene.title)}</h2>"]
        parts += [_image(draw.scene(points), name)] if points else []
        for case, result in cases:
            parts += [f"<h3>{html.escape(name)}, {html.escape(case.texture)}</h3>", _crops(case, result)]
    (folder / "index.html").write_text("\n".join([*parts, "</body></html>", ""]), encoding="utf-8")


def _crops(case: Case, result: Contest) -> str:
    """A part of the view, as it should be and as methods make it."""
    side = min(_CROP, case.view.size)
    left, top = (case.view.size - side) // 2, case.view.size // 5
    top = min(top, case.view.size - side)
    exact = block(case.view, case.image, left, top, side, tol=1e-3)
    figures = [_figure(np.clip(np.rint(exact), 0, 255).astype(np.uint8), "the truth")]
    for start, method in _SHOWN:
        for (family, kind, name), picture in result.pictures.items():
            wanted = family.startswith(start) and name == method
            if wanted and (kind == "warp" or start in ("OpenImageIO", "Mesa")):
                figures.append(_figure(picture[top : top + side, left : left + side], f"{family} {name}"))
    return f'<div class="crops">{"".join(figures)}</div>'


def _figure(picture: Codes, caption: str) -> str:
    image = _image(_png(enlarged(picture, 2)), caption)
    return f"<figure>{image}<figcaption>{html.escape(caption)}</figcaption></figure>"


def _png(picture: Codes) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        write_image(path, np.ascontiguousarray(picture))
        return path.read_bytes()


def _image(png: bytes, title: str) -> str:
    text = base64.b64encode(png).decode("ascii")
    return f'<img alt="{html.escape(title, quote=True)}" src="data:image/png;base64,{text}">'
