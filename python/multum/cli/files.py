"""Read, work, write: the frame of the commands that turn one picture into another."""

import argparse
import os
from collections.abc import Callable
from typing import Any

from numpy.typing import NDArray

from .._files import read_image, write_image
from .convert import check_output, fit
from .progress import Progress

Work = Callable[[NDArray[Any], Callable[[float], None]], NDArray[Any]]


def transform(options: argparse.Namespace, name: str, work: Work) -> None:
    """Read IN, do ``work`` and write OUT, with progress and one line about the result.

    ``work`` gets the image and a function to call with the share that is done.
    """
    check_output(options.output)
    with Progress(3) as progress:
        progress.step(f"reading {os.path.basename(options.input)}")
        image = read_image(options.input)
        progress.step(name)
        result = work(image, progress.share)
        progress.step(f"writing {os.path.basename(options.output)}")
        result = fit(result, options.output, options.depth, options.encoding)
        write_image(options.output, result)
    height, width = result.shape[:2]
    channels = result.shape[2] if result.ndim == 3 else 1
    print(f"{options.output}: {width}x{height}, {channels} channel{'s'[: channels > 1]}, {result.dtype}")
