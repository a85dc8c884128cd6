"""The command ``vbbench``, and ``python -m vbbench``."""

import sys

from vbbench.parallel.stopping import stoppable


def main() -> int:
    """Run the command line; signals stop it from the first import on."""
    return stoppable(_command_line)


def _command_line() -> int:
    from vbbench.cli import main as run

    return run()


if __name__ == "__main__":
    sys.exit(main())
