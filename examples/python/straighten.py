"""A page seen at an angle, made straight; and how much of each pixel came from the picture."""

import sys

import numpy as np

import multum as mt
from multum.demo.pictures import photograph


def main(out: str = "straight.png") -> None:
    """Write the straightened picture to ``out``."""
    image = photograph("brick")
    # From output pixels to the picture: narrow at the top, wide at the bottom.
    matrix = np.array([[0.55, 0.02, 110.0], [0.0, 0.80, 10.0], [0.0, -0.0005, 1.0]])
    straight, coverage = mt.warp(image, matrix, shape=(400, 500), encoding="srgb", coverage=True)
    mt.write_image(out, straight)
    inside = 100 * np.mean(coverage == 1)
    print(f"{out}: {straight.shape[1]}x{straight.shape[0]}, {inside:.0f} % of it inside the picture")


if __name__ == "__main__":
    main(*sys.argv[1:])
