"""Which level should an isotropic filter read? Both rules against the truth, on a plane to the horizon.

Prints a table: rms error in codes of 255, for textures of different kinds; and in brackets how much changes when
the plane moves by a few texels, as a multiple of the true change. Above 1 the picture flickers, below 1 it is too
calm.
"""

import argparse

import numpy as np

import multum as mt
from multum.demo.compare import plane_scene
from multum.demo.figure import rms
from multum.demo.pictures import floor_tiles, photograph
from multum.demo.truth import footprint, truth

CASES = {
    "area": {"filter": "trilinear", "lod_rule": "area"},
    "longest axis": {"filter": "trilinear", "lod_rule": "major"},
    "anisotropic": {"filter": "anisotropic"},
}


def textures() -> dict:
    """Pictures of several kinds."""
    y, x = np.mgrid[:256, :256]
    return {
        "tiles": floor_tiles(128),
        "gravel": photograph("gravel"),
        "brick": photograph("brick")[:256, :256],
        "cat": photograph("chelsea")[:256, :256],
        "checkers": np.where((x // 32 + y // 32) % 2, 255, 0).astype(np.uint8),
        "noise": np.random.default_rng(1).integers(0, 256, (256, 256), dtype=np.uint8),
    }


def view(image: np.ndarray, matrix: np.ndarray, shape: tuple[int, int]) -> list[np.ndarray]:
    """The truth, and what each case makes of it."""
    y, x = np.mgrid[: shape[0], : shape[1]].astype(np.float64)
    xyw = np.einsum("ij,jhw->hwi", matrix, np.stack([x, y, np.ones(shape)]))
    size = np.array(image.shape[1::-1])
    uv = (xyw[..., :2] / xyw[..., 2:] + 0.5) / size
    jacobian = footprint(matrix, x, y) / size[:, None]
    texture = mt.Texture(image, wrap="repeat")
    made = [255 * texture.sample(uv, jacobian, **case) for case in CASES.values()]
    return [truth(image, matrix, shape, repeat=True).reshape(*shape, -1), *made]


def main() -> None:
    """Print the table: the error, and in brackets how much of the motion is there when the plane moves a little."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scale", type=float, default=1.0, help="size of the view (default: 1)")
    parser.add_argument("--only", metavar="TEXTURE", help="one of the textures (default: all)")
    options = parser.parse_args()
    _, matrix, shape, _ = plane_scene(options.scale)
    print("| texture | " + " | ".join(CASES) + " |\n|---|" + "---:|" * len(CASES))
    step = np.array([[1, 0, 3.0], [0, 1, 5.0], [0, 0, 1]])
    for name, image in textures().items():
        if options.only not in (None, name):
            continue
        exact, *made = view(image, matrix, shape)
        exact_next, *made_next = view(image, step @ matrix, shape)
        moved = rms(exact_next, exact)
        cells = [
            f"{rms(a, exact):.1f} ({rms(b, a) / moved:.2f})" for a, b in zip(made, made_next, strict=True)
        ]
        print(f"| {name} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
