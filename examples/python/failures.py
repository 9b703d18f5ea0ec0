"""Where methods of texture filtering fail: one picture and one number each.

python examples/python/failures.py [--out FOLDER]    writes failures.md and img/failures/*.png

``--out docs`` renews the page of the documentation.
"""

import argparse
import sys
from pathlib import Path

import multum as mt
from multum.demo.draw import sheet
from multum.demo.figure import Figure, Panel, colour, enlarged

sys.path.insert(0, str(Path(__file__).parent))

from failing import colours, footprints, numbers, places
from failing.common import Failure, codes_of

CASES = {
    "minification": footprints.minification,
    "grazing": footprints.grazing,
    "box_at_45": footprints.box_at_45,
    "clamped": footprints.clamped,
    "thin_ellipses": footprints.thin_ellipses,
    "seam": places.seam,
    "pole": places.pole,
    "horizon": places.horizon,
    "cancellation": numbers.cancellation,
    "no_numbers": numbers.no_numbers,
    "tiling": numbers.tiling,
    "chains": numbers.chains,
    "odd_sizes": numbers.odd_sizes,
    "codes": colours.codes,
    "hidden_colour": colours.hidden_colour,
    "normals": colours.normals,
}

HEAD = """# Where methods fail

Each method of texture filtering is right somewhere and wrong somewhere else. One picture and one number for each
way to be wrong, beside what is right; errors are against the integral of `multum.reference` where no other truth is
named. Made by `python examples/python/failures.py --out docs`; every number is checked by the tests.
"""


def section(name: str, failure: Failure) -> str:
    """One failure as Markdown."""
    numbers_line = f"{failure.quantity}: **{number(failure.wrong)}** and **{number(failure.right)}**"
    picture = f"![{failure.title}](img/failures/{name}.png)"
    return f"## {failure.title}\n\n{failure.text}\n\n{picture}\n\n{numbers_line}.\n"


def number(value: float) -> str:
    """Two digits."""
    return "0" if abs(value) < 1e-6 else f"{value:.2g}" if value < 10 else f"{value:.0f}"


def main() -> None:
    """Make the page and its pictures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", default="failures", type=Path)
    parser.add_argument("--only", nargs="+", choices=list(CASES), default=list(CASES), metavar="NAME")
    options = parser.parse_args()
    out = options.out
    pictures = out / "img" / "failures"
    pictures.mkdir(parents=True, exist_ok=True)
    parts = [HEAD]
    for name in options.only:
        failure = CASES[name]()
        panels = [
            Panel(enlarged(colour(codes_of(picture)), max(1, 256 // picture.shape[1])), title)
            for title, picture in failure.panels
        ]
        mt.write_image(pictures / f"{name}.png", sheet(Figure(name, failure.title, failure.text, [panels])))
        print(f"{failure.title}: {failure.quantity}: {number(failure.wrong)}, {number(failure.right)}")
        parts.append(section(name, failure))
    (out / "failures.md").write_text("\n".join(parts), encoding="utf-8")


if __name__ == "__main__":
    main()
