"""python -m evidence: make the report."""

import sys

from evidence.command import main

if __name__ == "__main__":
    sys.exit(main())
