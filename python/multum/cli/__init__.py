"""The command line: one file a command, each with ``add(commands)`` and ``run(arguments)``."""

import argparse
import sys
from collections.abc import Sequence

from .. import __version__
from . import bake, chart, demo, gallery, info, panorama, render, resize, warp

_COMMANDS = (demo, warp, resize, panorama, info, render, bake, chart, gallery)

_DESCRIPTION = """\
Texture sampling and filtering on the CPU.

  multum demo                              make pictures and a page that show what this is
  multum info photo.jpg                    what a file holds, and what it takes as a texture
  multum resize photo.jpg small.png --scale 0.25 --encoding srgb
  multum warp page.jpg flat.png --corners 90,40 610,80 640,900 60,860 --size 600x850
  multum panorama sky.hdr cross.hdr --to cube
  multum render model.glb -o view.png --size 1920x1080
  multum bake high.obj --simplify 0.01 --size 1024 -o out/
  multum gallery                           every mapping function, drawn on five shapes
  multum chart --quick                     speed against accuracy of all filters, on this machine
"""


def parser() -> argparse.ArgumentParser:
    """The parser of all commands."""
    top = argparse.ArgumentParser(
        prog="multum",
        description=_DESCRIPTION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="multum COMMAND --help tells more.",
    )
    top.add_argument("--version", action="version", version=f"multum {__version__}")
    commands = top.add_subparsers(title="commands", dest="command", metavar="COMMAND", required=True)
    for command in _COMMANDS:
        command.add(commands)
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code: 0, 2 for what the user can mend, 130 after Ctrl-C."""
    given = [_keep_numbers(a) for a in (sys.argv[1:] if arguments is None else arguments)]
    options = parser().parse_args(given)
    try:
        options.run(options)
    except KeyboardInterrupt:
        print(f"multum {options.command}: stopped", file=sys.stderr)
        return 130
    except (OSError, TypeError, ValueError, MemoryError) as error:
        text = str(error) or "not enough memory"
        print(f"multum {options.command}: error: {text}", file=sys.stderr)
        print(f"multum {options.command} --help shows all options", file=sys.stderr)
        return 2
    return 0


def _keep_numbers(argument: str) -> str:
    """A blank before ``-1e-5`` and ``-1,2``, which argparse would take for options."""
    if argument.startswith("-"):
        try:
            [float(part) for part in argument.split(",")]
        except ValueError:
            return argument
        return f" {argument}"
    return argument
