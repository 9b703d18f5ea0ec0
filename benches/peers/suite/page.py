"""What is written: Markdown, JSON, pictures."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from .clock import Timed
from .filtered import Contest
from .growth import Curve

BEGIN, END = "<!-- begin: written by benches/peers/run.py -->", "<!-- end -->"


def roofline(timed: Timed, copy: float) -> str:
    """Share of the copy's bandwidth that the bytes of a case that must move come to."""
    moved = timed.case.moved
    return "" if moved is None else f"{100 * moved * timed.rate('ours') * 1e6 / copy:.0f} %"


def header(machine: dict[str, Any]) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    return (
        f"{machine['cpu']}, {machine['cores']} cores, instruction set: {machine['simd']}; Python {machine['python']}, "
        f"{versions}. One thread copies {machine['copy'] / 1e9:.1f} GB/s (read and written bytes together). Load of the "
        f"machine at the start: {machine['load']}."
    )


def table(rows: Sequence[Timed], copy: float) -> str:
    lines = [
        "| case | peer | threads | peer Mpx/s | spread | multum Mpx/s | spread | ratio | goal | of the copy |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for t in rows:
        goal = "" if t.case.goal is None or t.threads > 1 else f"{t.case.goal:g}"
        lines.append(
            f"| {t.case.name} | {t.case.peer} | {t.threads} | {t.rate('theirs'):.1f} | {t.spread('theirs'):.0%} | "
            f"{t.rate('ours'):.1f} | {t.spread('ours'):.0%} | {t.ratio:.2f} | {goal} | {roofline(t, copy)} |"
        )
    return "\n".join(lines)


def filtered_table(rows: Sequence[Contest]) -> str:
    lines = [
        "| scene | kind | peer | its method, ns/px, rms | multum's method, ns/px, rms | ratio | goal |",
        "|---|---|---|---|---|---|---|",
    ]
    for c in rows:
        goal = "" if c.goal is None else f"{c.goal:g}"
        theirs, ours = (f"{name}, {ns:.1f}, {rms:.2f}" for name, ns, rms in (c.theirs, c.ours))
        lines.append(f"| {c.scene} | {c.kind} | {c.peer} | {theirs} | {ours} | {c.ratio:.1f} | {goal} |")
    return "\n".join(lines)


def speedups(curves: Sequence[Curve]) -> str:
    """How much faster two threads are than one."""
    lines = ["| work | two threads, times as fast as one |", "|---|---|"]
    for what, name, points in curves:
        if what == "threads" and len(points) > 1:
            lines.append(f"| {name} | {points[0][1] / points[1][1]:.2f} |")
    return "\n".join(lines)


def growth_table(curves: Sequence[Curve]) -> str:
    lines = ["| against | what | nanoseconds a pixel |", "|---|---|---|"]
    for what, name, points in curves:
        values = ", ".join(f"{value:g}: {ns:.2f}" for value, ns in points)
        lines.append(f"| {what} | {name} | {values} |")
    return "\n".join(lines)


def draw(rows: Sequence[Timed], curves: Sequence[Curve], path: Path) -> None:
    """Ratios as bars with the goals as marks, and the curves."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    single = [t for t in rows if t.threads == 1]
    kinds = list(dict.fromkeys(what for what, _, _ in curves))
    height = 0.24 * len(single) + 1.2
    figure = plt.figure(
        figsize=(11, height + (3.4 * ((len(kinds) + 2) // 3) if kinds else 0)), layout="constrained"
    )
    parts = (
        figure.subfigures(2, 1, height_ratios=[height, 3.4 * ((len(kinds) + 2) // 3)]) if kinds else [figure]
    )
    axes = parts[0].subplots()
    places = list(range(len(single)))[::-1]
    colours = ["#2a7f62" if t.ratio >= 1 else "#b5483a" for t in single]
    axes.barh(places, [t.ratio for t in single], color=colours, height=0.7)
    marked = [(t.case.goal, y) for t, y in zip(single, places, strict=True) if t.case.goal is not None]
    axes.plot([g for g, _ in marked], [y for _, y in marked], "k|", ms=9, mew=1.6, label="goal")
    axes.set_yticks(places, [f"{t.case.name} ({t.case.peer.split(' ')[0]})" for t in single], fontsize=8)
    axes.set_xscale("log", base=2)
    axes.xaxis.set_major_formatter(lambda v, _: f"{v:g}x")
    axes.axvline(1, color="k", lw=0.8)
    axes.set_ylim(-0.7, len(single) - 0.3)
    axes.set_title("How many times faster than the peer, one thread", fontsize=10)
    axes.legend(loc="lower right", fontsize=8)
    if kinds:
        grid = parts[1].subplots((len(kinds) + 2) // 3, 3, squeeze=False)
        for kind, ax in zip(kinds, grid.flat, strict=False):
            threads = kind == "threads"
            for what, name, points in curves:
                if what == kind:
                    first = points[0][1]
                    heights = [first / ns if threads else ns for _, ns in points]
                    ax.plot([v for v, _ in points], heights, "o-", ms=3, lw=1.2, label=name)
            ax.set_xscale("log", base=2)
            ax.xaxis.set_major_formatter(lambda v, _: f"{v:g}")
            if not threads:
                ax.set_yscale("log")
            ax.set_xlabel(kind, fontsize=8)
            ax.set_ylabel("times as fast as one" if threads else "ns a pixel", fontsize=8)
            ax.tick_params(labelsize=7, which="both")
            ax.grid(alpha=0.3, which="both", lw=0.4)
            ax.legend(fontsize=5.5, ncols=2, loc="best")
        for ax in list(grid.flat)[len(kinds) :]:
            ax.axis("off")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=80)


def write_json(
    path: Path, machine: Any, rows: Sequence[Timed], contests: Sequence[Contest], curves: Any
) -> None:
    cases = [
        {
            "group": t.case.group,
            "name": t.case.name,
            "peer": t.case.peer,
            "pixels": t.case.pixels,
            "threads": t.threads,
            "goal": t.case.goal,
            "seconds": {"peer": t.theirs, "multum": t.ours},
            "ratio": t.ratio,
        }
        for t in rows
    ]
    filtered = [{**asdict(c), "ratio": c.ratio} for c in contests]
    growth = [{"against": what, "name": name, "ns": points} for what, name, points in curves]
    path.parent.mkdir(parents=True, exist_ok=True)
    whole = {"machine": machine, "cases": cases, "filtered": filtered, "growth": growth}
    path.write_text(json.dumps(whole, indent=1))


def insert(document: Path, text: str) -> None:
    """Puts the text between the marks of a document."""
    old = document.read_text()
    before, _, rest = old.partition(BEGIN)
    _, _, after = rest.partition(END)
    if not rest:
        raise SystemExit(f"{document}: has no line {BEGIN}")
    document.write_text(f"{before}{BEGIN}\n\n{text}\n\n{END}{after}")
