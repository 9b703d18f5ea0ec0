"""Calls drawn at random for a drop-in and for the library that it stands for, and compared.

The tests draw a bounded number of them. Any number by hand, in this folder's parent::

    python -m random_calls cv2 --calls 10000 --seed 7
    python -m random_calls skimage --calls 1000
    python -m random_calls cv2 --only resize --show 3
"""

from .verdicts import Call, Verdict, run

__all__ = ["Call", "Verdict", "run"]
