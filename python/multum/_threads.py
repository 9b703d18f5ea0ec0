"""How many threads calls may use."""

from typing import SupportsIndex

from . import _multum
from ._arguments import count


def set_num_threads(threads: SupportsIndex | None) -> None:
    """Limit every later call in this process to so many threads; None for all that the machine has.

    Results do not depend on it. The environment variable ``MULTUM_NUM_THREADS``, or else ``OMP_NUM_THREADS``, by
    which joblib tells its worker processes how many threads are theirs, sets the limit at import; a call's own
    ``threads=`` goes before it. All calls of a process share their threads, so that calls from several threads, as
    dask makes them, do not add up to more.

    Raises
    ------
    ValueError, TypeError
        For anything but a whole number of at least 1, or None.
    """
    _multum.set_num_threads(count("threads", threads) or 0)


def get_num_threads() -> int:
    """Threads that a call uses now.

    Examples
    --------
    >>> import multum as mt
    >>> mt.set_num_threads(1)
    >>> mt.get_num_threads()
    1
    >>> mt.set_num_threads(None)
    """
    return _multum.get_num_threads()
