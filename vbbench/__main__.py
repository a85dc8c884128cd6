"""``python -m vbbench``."""

import sys

from vbbench.cli import main

if __name__ == "__main__":
    sys.exit(main())
