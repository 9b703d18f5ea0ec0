"""Filtered look-ups beside OpenImageIO and llvmpipe: one thread, one process, every method in turn.

    python benches/peers/lookups.py [side of the view] [rounds]

Scenes and contestants are those of the chart: uv and Jacobian of every pixel are given, a texture with its levels is made
ready, colours come out. Prints CPU and versions, then the least time of a look-up, in ns, and how many times as long the
peer's look-up takes. ``MULTUM_SIMD=avx2`` measures the AVX2 kernels.
"""

import os
import platform
import sys
import time
from pathlib import Path

import numpy as np

import multum as mt
from multum._chart import own, textures
from multum._chart.method import Case, Unavailable
from multum._chart.scenes import SCENES, View

OWN = ["bilinear", "trilinear", "anisotropic 16", "area", "ewa"]
PAIRS = [
    ("OpenImageIO", "bilinear", "bilinear"),
    ("OpenImageIO", "trilinear", "trilinear"),
    ("OpenImageIO", "anisotropic 16", "anisotropic 16"),
    ("Mesa llvmpipe", "bilinear", "bilinear"),
    ("Mesa llvmpipe", "trilinear", "trilinear"),
    ("Mesa llvmpipe", "anisotropic 16", "anisotropic 16"),
]


def cpu():
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor()


def contestants():
    """Methods by family and name; families that are not installed are told of."""
    found = {("multum", m.name): m for m in own.methods(60.0) if m.kind == "sample" and m.name in OWN}
    for module in ("oiio", "llvmpipe"):
        try:
            peer = __import__(f"multum._chart.peers.{module}", fromlist=["METHODS"])
        except ImportError as error:
            print(f"without {module}: {error}")
            continue
        found |= {
            (peer.FAMILY.rpartition(" ")[0] if module == "oiio" else peer.FAMILY, m.name): m
            for m in peer.METHODS
        }
    return found


def main():
    side = int(sys.argv[1]) if len(sys.argv) > 1 else 384
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 7
    print(f"{cpu()}, MULTUM_SIMD={os.environ.get('MULTUM_SIMD', 'best')}, one thread, view {side} x {side}")
    print(f"multum {mt.__version__}, NumPy {np.__version__}\n")
    methods = contestants()
    pairs = [p for p in PAIRS if p[:2] in methods]
    print(f"| scene | {' | '.join(OWN)} | {' | '.join(f'{family}, {name}' for family, name, _ in pairs)} |")
    print("|---|" + "---|" * (len(OWN) + len(pairs)))
    image = textures.photo(1024)
    for name in ("rotate", "homography", "sphere", "planet", "plane"):
        view = View(SCENES[name], side, 1024, 1024)
        case = Case(view, "photo", image)
        runs = {}
        for key in [("multum", name) for name in OWN] + [p[:2] for p in pairs]:
            try:
                runs[key] = methods[key].prepare(case)
            except Unavailable as reason:
                print(f"without {key}: {reason}")
        best = dict.fromkeys(runs, np.inf)
        for _ in range(rounds):
            for key, run in runs.items():
                start = time.perf_counter()
                run.work()
                best[key] = min(best[key], time.perf_counter() - start - run.overhead)
        ns = {key: seconds / side**2 * 1e9 for key, seconds in best.items()}
        cells = [f"{ns[('multum', name)]:.1f}" for name in OWN]
        for family, peer, own_name in pairs:
            ratio = ns[family, peer] / ns["multum", own_name]
            cells.append(f"{ns[family, peer]:.0f}, {ratio:.1f}x")
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
