"""The command: draws calls, prints a table, and fails where a call differs for no known reason."""

import argparse
import importlib

from .verdicts import run

MODULES = {"cv2": "opencv", "skimage": "scikit"}


def main() -> int:
    parser = argparse.ArgumentParser("random_calls", description=__doc__)
    parser.add_argument("library", choices=sorted(MODULES))
    parser.add_argument("--calls", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", help="name of one function")
    parser.add_argument("--show", type=int, default=5, help="differences to print for each function")
    options = parser.parse_args()
    module = importlib.import_module(f"{__package__}.{MODULES[options.library]}")
    drawn = module.calls(options.seed, options.calls)
    found = run(call for call in drawn if options.only in (None, call.name))
    print(f"{'function':24}{'calls':>7}{'equal':>7}{'refused':>9}{'explained':>11}{'different':>11}")
    for name, verdict in sorted(found.items()):
        explained = sum(verdict.explained.values())
        numbers = (
            f"{verdict.calls:7}{verdict.equal:7}{verdict.refused:9}{explained:11}{len(verdict.different):11}"
        )
        print(f"{name:24}{numbers}")
        for text in verdict.different[: options.show]:
            print(f"    {text}")
        for reason, times in sorted(verdict.explained.items()):
            print(f"    {times} times: {reason}")
    total = sum(v.calls for v in found.values())
    equal = sum(v.equal for v in found.values())
    print(f"equal: {equal} of {total} ({equal / max(total, 1):.2%})")
    return int(any(v.different for v in found.values()))


if __name__ == "__main__":
    raise SystemExit(main())
