"""Entry point of ``multum`` and ``python -m multum``."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
