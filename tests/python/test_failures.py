"""Where methods fail: each is as wrong as docs/failures.md says, and what stands beside it is right."""

import re
from pathlib import Path

import failures
import numpy as np
import pytest
from failing.common import codes_of

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "failures.md").read_text(encoding="utf-8")

# How many times less wrong the second method is, at least; None: it is right to rounding.
LESS: dict[str, float | None] = {
    "minification": 100,
    "grazing": 4,
    "box_at_45": 10,
    "clamped": 2.5,
    "thin_ellipses": None,
    "seam": 4,
    "pole": 8,
    "horizon": 15,
    "cancellation": 1e6,
    "no_numbers": None,
    "tiling": 1e5,
    "chains": 10,
    "odd_sizes": 1e4,
    "codes": None,
    "hidden_colour": 100,
    "normals": 50,
}


def test_every_failure_has_a_test() -> None:
    assert list(LESS) == list(failures.CASES)


@pytest.mark.parametrize("name", LESS)
def test_it_fails_as_the_page_says(name: str) -> None:
    made = failures.CASES[name]()
    factor = LESS[name]
    if factor is None:
        assert made.wrong > 0.1
        assert made.right == 0
    else:
        assert made.wrong > factor * made.right
    title = re.escape(made.title)
    found = re.search(rf"^## {title}$.*?\*\*([^*]+)\*\* and \*\*([^*]+)\*\*", PAGE, re.MULTILINE | re.DOTALL)
    assert found is not None
    # Two digits; another machine's additions may turn the last.
    assert float(found[1]) == pytest.approx(made.wrong, rel=0.06)
    # What is right may get better.
    assert made.right <= 1.5 * float(found[2]) + 1e-5
    assert len(made.panels) >= 2
    shown = [codes_of(picture) for _, picture in made.panels]
    assert np.abs(shown[0].astype(int) - shown[1]).max() > 40
    assert (ROOT / "docs" / "img" / "failures" / f"{name}.png").is_file()


def test_numbers_are_written_short() -> None:
    assert [failures.number(x) for x in (0.0, 1e-9, 0.0345, 1.26, 63.4)] == ["0", "0", "0.035", "1.3", "63"]
