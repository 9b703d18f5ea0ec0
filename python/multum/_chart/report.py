"""The figures as JSON, CSV and text."""

import csv
import json
import platform
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path

import numpy as np

from .._multum import __version__
from .measure import Absence, Point
from .own import FAMILY
from .pareto import Verdict, prices, verdicts


@dataclass
class Chart:
    """What ``multum.chart`` measured.

    ``points`` has one entry for every method, scene and texture; ``absences`` tells which took no part and why;
    ``about`` names the machine, the versions and the settings.
    """

    about: dict[str, str]
    points: list[Point] = field(default_factory=list)
    absences: list[Absence] = field(default_factory=list)

    def verdicts(self) -> list[Verdict]:
        """For each peer's point, the quickest multum point that is at least as accurate."""
        return verdicts(self.points, FAMILY)

    def write(self, folder: Path) -> None:
        """Writes chart.json, chart.csv and dominated.csv."""
        content = {
            "about": self.about,
            "points": [asdict(p) for p in self.points],
            "absences": [asdict(a) for a in self.absences],
        }
        (folder / "chart.json").write_text(json.dumps(content, indent=1), encoding="utf-8")
        with (folder / "chart.csv").open("w", newline="", encoding="utf-8") as file:
            names = [f.name for f in fields(Point)]
            writer = csv.DictWriter(file, names)
            writer.writeheader()
            writer.writerows(asdict(p) for p in self.points)
        with (folder / "dominated.csv").open("w", newline="", encoding="utf-8") as file:
            rows = csv.writer(file)
            rows.writerow(
                [
                    "scene",
                    "texture",
                    "kind",
                    "peer",
                    "peer_ns",
                    "peer_rms",
                    "own",
                    "own_ns",
                    "own_rms",
                    "ratio",
                ]
            )
            for v in self.verdicts():
                own = (
                    ("", "", "") if v.own is None else (v.own.method, round(v.own.ns, 2), round(v.own.rms, 4))
                )
                peer = (f"{v.peer.family} {v.peer.method}", round(v.peer.ns, 2), round(v.peer.rms, 4))
                rows.writerow([v.peer.scene, v.peer.texture, v.peer.kind, *peer, *own, round(v.ratio, 3)])

    def table(self) -> list[str]:
        """Geometric means over all scenes and textures, one line a method."""
        lines = [f"{'':28s}{'method':26s}{'kind':8s}{'ns/px':>9s}{'rms':>9s}{'max':>9s}  cases"]
        for (family, name, kind), group in grouped(self.points).items():
            ns, rms, worst = (mean([getattr(p, key) for p in group]) for key in ("ns", "rms", "max"))
            lines.append(f"{family:28s}{name:26s}{kind:8s}{ns:9.1f}{rms:9.3f}{worst:9.2f}  {len(group)}")
        return lines

    def domination(self) -> list[str]:
        """One line for every peer's method: how often it is dominated, and the cases where it is not."""
        lines = []
        groups: dict[tuple[str, str, str], list[Verdict]] = {}
        for v in self.verdicts():
            groups.setdefault((v.peer.family, v.peer.method, v.peer.kind), []).append(v)
        for (family, name, _), group in groups.items():
            won = sum(v.dominated for v in group)
            lines.append(f"{family} {name}: dominated in {won} of {len(group)} cases, {_typical(group)}")
            for v in sorted((v for v in group if not v.dominated), key=lambda v: v.ratio):
                lines.append(f"    {_short(v)}")
        return lines

    def economy(self) -> list[str]:
        """What ``auto`` costs beside the cheapest fixed setting that is as accurate: the cases, dearest first."""
        found = sorted(prices(self.points, FAMILY, "auto"), key=lambda p: -p.ratio)
        if not found:
            return []
        middle, dear = np.median([p.ratio for p in found]), sum(p.ratio > 4 / 3 for p in found)
        lines = [
            f"auto beside the cheapest fixed setting that is as accurate: {middle:.2f} of its time in the middle "
            f"case, over 1.33 in {dear} of {len(found)}"
        ]
        for p in found:
            where = f"{p.chooser.scene}, {p.chooser.texture}, {p.chooser.kind}"
            lines.append(
                f"    {where}: {p.chooser.ns:.1f} ns, rms {p.chooser.rms:.3f}; "
                f"{p.fixed.method} {p.fixed.ns:.1f} ns, rms {p.fixed.rms:.3f}: {p.ratio:.2f}"
            )
        return lines

    def missing(self) -> list[str]:
        """Why methods took no part, one line a method and reason."""
        reasons = Counter((a.family, a.method, a.kind, _plain(a.reason)) for a in self.absences)
        return [
            f"{family} {name} ({kind}): {reason}, in {n} case{'s'[: n > 1]}"
            for (family, name, kind, reason), n in reasons.items()
        ]


def _plain(reason: str) -> str:
    return "takes too long" if reason.startswith("would take") else reason


def _typical(group: list[Verdict]) -> str:
    ratios = [v.ratio for v in group if v.own is not None]
    return f"{np.median(ratios):.2f} times faster in the middle case" if ratios else "never as accurate"


def _short(v: Verdict) -> str:
    where = f"{v.peer.scene}, {v.peer.texture}: peer {v.peer.ns:.1f} ns, rms {v.peer.rms:.3f}"
    if v.own is None:
        return f"{where}; nothing is as accurate"
    return f"{where}; {v.own.method} {v.own.ns:.1f} ns, rms {v.own.rms:.3f}: {v.ratio:.2f} of its speed"


def grouped(points: Sequence[Point]) -> dict[tuple[str, str, str], list[Point]]:
    """Points by family, method and kind."""
    groups: dict[tuple[str, str, str], list[Point]] = {}
    for p in points:
        groups.setdefault((p.family, p.method, p.kind), []).append(p)
    return groups


def mean(values: Sequence[float]) -> float:
    """Geometric mean; errors of nothing count as a millionth."""
    return float(np.exp(np.mean(np.log(np.maximum(values, 1e-6)))))


def machine() -> dict[str, str]:
    """CPU and versions."""
    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [
            line for line in info.read_text(encoding="utf-8").splitlines() if line.startswith("model name")
        ]
        cpu = names[0].partition(":")[2].strip() if names else cpu
    return {
        "cpu": f"{cpu} ({platform.machine()})",
        "multum": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
    }
