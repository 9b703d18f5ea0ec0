"""What each filter costs and how far it is from the exact mean: a plane to the horizon and a tilted photograph.

Prints a table: rms error in codes of 255, and nanoseconds a pixel on one thread.
"""

import argparse

import numpy as np

import multum as mt
from multum.demo.compare import photograph_scene, plane_scene
from multum.demo.figure import rms
from multum.demo.peers import milliseconds
from multum.demo.truth import truth

FILTERS = (
    *("nearest", "bilinear", "bicubic", "mitchell"),
    *("nearest_mipmap_nearest", "linear_mipmap_nearest", "nearest_mipmap_linear", "trilinear"),
    *("anisotropic", "area", "ewa", "sat", "stochastic", "exact", "auto"),
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scale", type=float, default=1.0, help="size of the views (default: 1)")
    scale = parser.parse_args().scale
    tiles, plane, plane_shape, _ = plane_scene(scale)
    scenes = [(tiles, plane, plane_shape, "repeat"), (*photograph_scene(scale), "border")]
    exact = [truth(image, matrix, shape, wrap == "repeat") for image, matrix, shape, wrap in scenes]
    print("| filter | plane | photograph |\n|---|---:|---:|")
    for name in FILTERS:
        cells = []
        for (image, matrix, shape, wrap), right in zip(scenes, exact, strict=True):
            if name == "exact" and wrap == "repeat":
                cells.append("too dear")  # a pixel under the horizon covers millions of texels
                continue

            def work(name=name, image=image, matrix=matrix, shape=shape, wrap=wrap) -> np.ndarray:
                return mt.warp(image, matrix, shape, wrap=wrap, filter=name, threads=1)

            nanoseconds = 1e6 * milliseconds(work, 3) / (shape[0] * shape[1])
            cells.append(f"{rms(work(), right):.2f}, {nanoseconds:.0f} ns")
        print(f"| `{name}` | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
