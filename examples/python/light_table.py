"""What a texture can be: one small picture for each row of the table in docs/render.md, on one sheet.

python examples/python/light_table.py [--out light.jpg] [--side 192] [--only NAME ...]

``--out docs/img/light.jpg`` renews the sheet of the documentation.
"""

import argparse
import sys
from pathlib import Path

import multum as mt
from multum.demo.draw import sheet
from multum.demo.figure import Figure, Panel

sys.path.insert(0, str(Path(__file__).parent))

from lit.rows import ROWS

COLUMNS = 5


def main() -> None:
    """Draw the sheet."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", default="light.jpg", type=Path)
    parser.add_argument("--side", default=192, type=int, help="of a picture, in pixels")
    parser.add_argument("--only", nargs="+", choices=list(ROWS), default=list(ROWS), metavar="NAME")
    options = parser.parse_args()
    panels = []
    for name in options.only:
        row = ROWS[name]
        panels.append(Panel(row.draw(options.side), row.title, row.text))
        print(f"{row.title}: {row.text}")
    rows = [panels[k : k + COLUMNS] for k in range(0, len(panels), COLUMNS)]
    mt.write_image(options.out, sheet(Figure("light", "What a texture can be", "", rows)))


if __name__ == "__main__":
    main()
