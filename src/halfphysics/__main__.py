"""``python -m halfphysics``: the command line."""

from __future__ import annotations

import sys

from halfphysics.cli import main

if __name__ == "__main__":
    sys.exit(main())
