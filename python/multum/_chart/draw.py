"""Nanoseconds against error, log-log, with the front of what nothing beats."""

import io
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from .measure import Point
from .own import FAMILY
from .pareto import front
from .report import grouped, mean

_OWN = "#0b6e4f"
_PEERS = ("#c1292e", "#e08e0b", "#5f4bb6", "#2274a5", "#7a5230", "#444444")
_MARKS = ("s", "^", "D", "v", "P", "X")
_TITLES = {
    "warp": "warp: 8-bit picture and map in, 8-bit picture out",
    "sample": "look-up: place and Jacobian given",
}
_ERRORS = {"rms": "rms error, of 255", "max": "largest error, of 255"}

Mark = tuple[str, str, float, float, bool]
"""Family, method, nanoseconds, error, whether it stands for all cases."""


def summary(points: Sequence[Point]) -> bytes:
    """PNG of the geometric means over all scenes and textures."""
    cases = len({(p.scene, p.texture) for p in points})
    kinds = [kind for kind in _TITLES if any(p.kind == kind for p in points)]
    sheet = Figure(figsize=(6.4 * len(kinds), 9.6), dpi=90, layout="constrained")
    grid = sheet.subplots(2, len(kinds), squeeze=False)
    families = _families(points)
    for column, kind in enumerate(kinds):
        for row, key in enumerate(_ERRORS):
            marks = [
                (
                    family,
                    name,
                    mean([p.ns for p in group]),
                    mean([getattr(p, key) for p in group]),
                    len(group) == cases,
                )
                for (family, name, k), group in grouped(points).items()
                if k == kind
            ]
            axes = grid[row][column]
            _scatter(axes, families, marks, labels=True)
            axes.set_ylabel(_ERRORS[key])
            axes.set_xlabel("ns a pixel, one thread")
            axes.set_title(_TITLES[kind] if row == 0 else "", fontsize=10)
        grid[0][column].legend(fontsize=7, loc="upper right" if kind == "warp" else "lower left")
    sheet.suptitle(
        f"Geometric means over {cases} scenes and textures; hollow: not in all; lower left is better",
        fontsize=10,
    )
    return _png(sheet)


def scene(points: Sequence[Point]) -> bytes:
    """PNG of one scene: a column for each texture, a row for each kind and measure of error."""
    textures = list(dict.fromkeys(p.texture for p in points))
    rows = [(kind, key) for kind in _TITLES if any(p.kind == kind for p in points) for key in _ERRORS]
    sheet = Figure(figsize=(3.7 * len(textures), 2.9 * len(rows)), dpi=80, layout="constrained")
    grid = sheet.subplots(len(rows), len(textures), squeeze=False)
    families = _families(points)
    for column, texture in enumerate(textures):
        for row, (kind, key) in enumerate(rows):
            marks = [
                (p.family, p.method, p.ns, getattr(p, key), True)
                for p in points
                if p.texture == texture and p.kind == kind
            ]
            axes = grid[row][column]
            _scatter(axes, families, marks, labels=False)
            axes.tick_params(labelsize=7)
            if row == 0:
                axes.set_title(texture, fontsize=10)
            if column == 0:
                axes.set_ylabel(f"{kind}\n{_ERRORS[key]}", fontsize=8)
    handles, names = grid[0][0].get_legend_handles_labels()
    sheet.legend(handles, names, fontsize=8, loc="outside lower center", ncols=len(names))
    return _png(sheet)


def _scatter(axes: Axes, families: list[str], marks: list[Mark], labels: bool) -> None:
    """One colour a family, own points joined along their front, the common front ringed."""
    floor = 1e-3
    for n, family in enumerate(families):
        mine = [m for m in marks if m[0] == family]
        if not mine:
            continue
        colour, mark = (_OWN, "o") if family == FAMILY else (_PEERS[(n - 1) % 6], _MARKS[(n - 1) % 6])
        x, y = [m[2] for m in mine], [max(m[3], floor) for m in mine]
        faces = [colour if m[4] else "none" for m in mine]
        axes.scatter(
            x,
            y,
            s=26 if labels else 14,
            marker=mark,
            c=faces,
            edgecolors=colour,
            linewidths=0.9,
            label=family,
            zorder=3,
        )
        if family == FAMILY:
            best = front(x, y)
            axes.step(
                [x[i] for i in best], [y[i] for i in best], where="post", color=_OWN, linewidth=0.8, alpha=0.6
            )
        if labels:
            for m, a, b in zip(mine, x, y, strict=True):
                axes.annotate(
                    m[1], (a, b), xytext=(3, 3), textcoords="offset points", fontsize=5.5, color=colour
                )
    x, y = [m[2] for m in marks], [max(m[3], floor) for m in marks]
    best = front(x, y)
    axes.scatter(
        [x[i] for i in best],
        [y[i] for i in best],
        s=90 if labels else 50,
        facecolors="none",
        edgecolors="#222222",
        linewidths=0.7,
        zorder=2,
        label="not beaten",
    )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True, which="major", color="#dddddd", linewidth=0.6)


def _families(points: Sequence[Point]) -> list[str]:
    """multum first, then the others, so that each keeps its colour in every panel."""
    return [FAMILY, *dict.fromkeys(p.family for p in points if p.family != FAMILY)]


def _png(sheet: Any) -> bytes:
    FigureCanvasAgg(sheet)
    buffer = io.BytesIO()
    sheet.savefig(buffer, format="png")
    return buffer.getvalue()
