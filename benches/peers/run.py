"""multum beside its peers: one command, one process, both sides in turn, results compared before they are timed.

    python -m pip install 'multum[peers]'
    python benches/peers/run.py [--quick] [--only WORD] [--threads 1 2] [--out out/bench] [--docs docs/benchmarks.md]

Writes results.json, results.md and results.png; with --docs also the tables between the marks of that document and the
picture into its img folder. Peers that are not installed stand aside. ``MULTUM_SIMD=avx2`` measures the AVX2 kernels.
One thread is timed by the processor time that the thread had, so that others on the machine count little; two threads
by the clock on the wall.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from suite import filtered, growth, machine, page, plain
from suite.clock import Case, Timed, alternate, compare

import multum as mt


def set_threads(count: int) -> None:
    mt.set_num_threads(count)
    try:
        import cv2

        cv2.setNumThreads(count)
    except ImportError:
        pass


def cases(options: argparse.Namespace) -> Iterator[Case]:
    """Those that were asked for, of the peers that are installed."""
    side = 1024 if options.quick else 2048
    for name, group in plain.GROUPS.items():
        if options.only not in ("", name) and options.only in plain.GROUPS:
            continue
        try:
            for case in group(4096 if name == "tables" and not options.quick else side):
                if options.only in plain.GROUPS or options.only in case.name:
                    yield case
        except ImportError as error:
            print(f"{name}: {error}", file=sys.stderr)


def timed(options: argparse.Namespace) -> tuple[list[Timed], list[str]]:
    """Times, and what stood in their way: results that differ are not timed."""
    rows, failures = [], []
    for case in cases(options):
        try:
            if wrong := compare(case):
                failures.append(f"{case.name}: {wrong}")
                continue
            for threads in options.threads:
                # These peers have one thread.
                if threads > 1 and case.peer.split(" ")[0] != "OpenCV":
                    continue
                set_threads(threads)
                row = alternate(case, threads, 3 if options.quick else 11)
                rows.append(row)
                print(f"{case.name}, {threads} threads: {row.ratio:.2f} of {case.peer}", flush=True)
        except (ArithmeticError, RuntimeError, TypeError, ValueError) as error:
            failures.append(f"{case.name}: {type(error).__name__}: {error}")
        finally:
            set_threads(1)
    return rows, failures


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="smaller pictures, fewer rounds")
    parser.add_argument("--only", default="", help="one group, or cases whose name holds this")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    parser.add_argument("--docs", type=Path, help="a document with marks to write the tables between")
    parser.add_argument(
        "--largest", type=int, default=16384, help="side of the largest picture of the growth curves"
    )
    parser.add_argument("--skip", nargs="*", default=[], choices=["filtered", "growth"])
    options = parser.parse_args()
    set_threads(1)
    about: dict[str, Any] = machine.describe()
    print(page.header(about))
    start = time.perf_counter()
    rows, failures = timed(options)
    contests: list[filtered.Contest] = []
    curves: list[growth.Curve] = []
    if not options.only:
        if "filtered" not in options.skip:
            contests = list(filtered.contests(options.quick, lambda text: print(text, flush=True)))
        if "growth" not in options.skip:
            largest = 1024 if options.quick else options.largest
            for part in (
                growth.sizes(largest),
                growth.textures(min(largest, 4096)),
                growth.footprints(),
                growth.threads(2),
            ):
                for curve in part:
                    print(", ".join(curve[:2]), flush=True)
                    curves.append(curve)
    parts = [page.header(about), "### Beside the peers", page.table(rows, about["copy"])]
    if contests:
        parts += ["### Filtered", page.filtered_table(contests)]
    if curves:
        parts += ["### Growth", page.growth_table(curves), "### Threads", page.speedups(curves)]
    text = "\n\n".join(parts)
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "results.md").write_text(text + "\n")
    page.write_json(options.out / "results.json", about, rows, contests, curves)
    page.draw(rows, curves, options.out / "results.png")
    if options.docs:
        picture = options.docs.parent / "img" / "benchmarks.png"
        page.draw(rows, curves, picture)
        page.insert(options.docs, text + "\n\n![Ratios, goals and growth](img/benchmarks.png)")
    print(f"written to {options.out} after {time.perf_counter() - start:.0f} s")
    for failure in failures:
        print(failure, file=sys.stderr)
    if failures:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
