"""The drop-ins and their libraries, called alike at random. Any number by hand: see ``random_calls``."""

from collections.abc import Iterator

import pytest

from random_calls import Call, opencv, run, scikit

PEERS = (
    # Of 100 calls of the library's own kinds at least 98 are equal, whatever the others' reasons.
    pytest.param(opencv.calls, 2500, id="cv2"),
    pytest.param(scikit.calls, 800, id="skimage"),
)


@pytest.mark.parametrize(("calls", "count"), PEERS)
def test_calls_at_random_are_equal_or_explained(calls: object, count: int) -> None:
    assert callable(calls)
    drawn: Iterator[Call] = calls(20, count)
    found = run(drawn)
    different = [f"{name}: {text}" for name, verdict in found.items() for text in verdict.different]
    assert not different, "\n".join(different)
    assert sum(v.calls for v in found.values()) == count
    assert sum(v.equal for v in found.values()) >= 0.98 * count
    # Each function is drawn, and is right more often than it is refused.
    for name, verdict in found.items():
        assert verdict.refused < verdict.calls / 2, name
