"""A texture sampled where a ray tracer would: places, and how far they move from pixel to pixel."""

import numpy as np

import multum as mt
from multum.demo.pictures import floor_tiles


def main() -> None:
    """Print one row of colours of a floor that recedes."""
    texture = mt.Texture(floor_tiles(64), wrap="repeat", encoding="srgb")
    depth = np.array([1.0, 2.0, 8.0, 64.0])
    uv = np.stack([np.full(4, 0.3), depth], axis=-1)
    # A pixel is 1/100 of the depth wide; seen at a slant, it is longer along v.
    jacobian = np.zeros((4, 2, 2))
    jacobian[:, 0, 0] = depth / 100
    jacobian[:, 1, 1] = depth**2 / 100
    for name in ("bilinear", "trilinear", "anisotropic"):
        red = texture.sample(uv, jacobian, filter=name)[:, 0]
        print(f"{name:<12}" + " ".join(f"{value:.3f}" for value in red))


if __name__ == "__main__":
    main()
