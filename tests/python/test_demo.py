"""The demonstration, small, with and without the packages that it can use."""

import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import multum as mt
from multum.demo import PICTURES, make, summary
from multum.demo.pictures import floor_tiles, photograph
from multum.demo.truth import truth


class Links(HTMLParser):
    """What a page refers to."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found += [value or "" for name, value in attrs if name in ("src", "href")]


def test_all_pictures_and_the_page(tmp_path: Path) -> None:
    figures = make(tmp_path, scale=0.25)
    assert [f.name for f in figures] == list(PICTURES)
    links = Links()
    links.feed((tmp_path / "index.html").read_text(encoding="utf-8"))
    assert links.found == [f"{name}.png" for name in PICTURES]
    for name in PICTURES:
        image = mt.read_image(tmp_path / f"{name}.png")
        assert image.std() > 10
    told = "\n".join(summary(figures, tmp_path))
    assert "index.html" in told
    assert "OpenCV" in told


def test_the_warps_beat_interpolation(tmp_path: Path) -> None:
    for name, factor in (("homography", 1.5), ("plane", 3.0)):
        (figure,) = make(tmp_path, scale=0.25, only=[name])
        other, ours = (float(line.split("rms error ")[1].split()[0]) for line in figure.measured)
        assert ours * factor < other


def test_the_truth_is_the_mean_over_the_pixel() -> None:
    # Twice smaller: a pixel covers two texels, whose bilinear mean is (1, 6, 1)/8 around each texel's pair.
    row = np.array([0, 0, 80, 0, 0, 0, 0, 0])
    image = np.tile(row, (8, 1)).astype(np.uint8)
    half = np.array([[2.0, 0, 0.5], [0, 2.0, 0.5], [0, 0, 1.0]])
    made = truth(image, half, (4, 4), repeat=True)
    # Integral of the tent of height 80 over [1.5, 3.5] and [-0.5, 1.5], over a width of 2.
    np.testing.assert_allclose(made[1], [80 * 0.125 / 2, 80 * 0.875 / 2, 0, 0], atol=0.6)
    flat = truth(np.full((5, 7), 9, np.uint8), half, (3, 3), repeat=True)
    np.testing.assert_allclose(flat, 9.0, rtol=1e-6)


def test_shipped_pictures_are_what_the_attribution_says() -> None:
    shapes = {
        "astronaut": (512, 512, 3),
        "brick": (512, 512),
        "chelsea": (300, 451, 3),
        "coffee": (400, 600, 3),
        "gravel": (256, 256),
    }
    folder = Path(mt.__file__).parent / "data"
    told = (folder / "ATTRIBUTION.md").read_text(encoding="utf-8")
    assert {path.stem for path in folder.glob("*.jpg")} == set(shapes)
    for name, shape in shapes.items():
        assert photograph(name).shape == shape
        assert f"`{name}.jpg`" in told
    assert sum(path.stat().st_size for path in folder.iterdir()) < 1_000_000


def test_the_floor_repeats_without_a_seam() -> None:
    tiles = floor_tiles(64)
    assert tiles.shape == (128, 128, 3)
    np.testing.assert_array_equal(tiles[0], 238)
    np.testing.assert_array_equal(tiles[:, -1], 238)


@pytest.mark.parametrize("hidden", [("matplotlib",), ("cv2", "matplotlib")])
def test_numpy_is_enough(tmp_path: Path, hidden: tuple[str, ...]) -> None:
    code = f"""
import sys
for name in {hidden!r}:
    sys.modules[name] = None
from multum.cli import main
sys.exit(main(["demo", "-o", {str(tmp_path)!r}, "--scale", "0.25", "--only", "homography", "wrap"]))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "no labels because matplotlib is not installed" in done.stdout
    assert ("OpenCV is not installed" in done.stdout) == ("cv2" in hidden)
    assert (tmp_path / "homography.png").stat().st_size > 0
