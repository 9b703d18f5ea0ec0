"""A line on the terminal that tells how far long work has come."""

import sys
import threading
import time
from types import TracebackType
from typing import TextIO

_WIDTH = 24
_QUIET_SECONDS = 0.5


class Progress:
    """A bar over ``steps`` steps, redrawn while a step runs; silent where nobody watches.

    Nothing is shown before half a second has passed, nor where ``stream`` is no terminal.
    """

    def __init__(self, steps: int, stream: TextIO | None = None) -> None:
        """Count to ``steps``; standard error is the default stream."""
        self._stream = sys.stderr if stream is None else stream
        self._steps, self._done, self._name, self._share = steps, 0, "", 0.0
        self._start = time.monotonic()
        self._end = threading.Event()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None

    def __enter__(self) -> "Progress":
        """Start the clock."""
        if self._stream.isatty():
            self._thread = threading.Thread(target=self._redraw, daemon=True)
            self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Clear the line."""
        self._end.set()
        if self._thread is not None:
            self._thread.join()

    def step(self, name: str) -> None:
        """The work before is done; ``name`` begins."""
        with self._lock:
            self._done += bool(self._name)
            self._name, self._share = name, 0.0

    def share(self, done: float) -> None:
        """So much of the step that is under way is done, from 0 to 1."""
        with self._lock:
            self._share = max(self._share, min(done, 1.0))

    def line(self) -> str:
        """What the terminal shows now."""
        with self._lock:
            done, name, share = self._done, self._name, self._share
        filled = min(_WIDTH, int(_WIDTH * (done + share) / max(self._steps, 1)))
        bar = "#" * filled + "." * (_WIDTH - filled)
        return f"[{bar}] {done}/{self._steps} {name} ({time.monotonic() - self._start:.1f} s)"

    def _redraw(self) -> None:
        shown = 0
        wait = _QUIET_SECONDS
        while not self._end.wait(wait):
            line = self.line()
            self._stream.write("\r" + line.ljust(shown))
            self._stream.flush()
            shown, wait = len(line), 0.1
        if shown:
            self._stream.write("\r" + " " * shown + "\r")
            self._stream.flush()
