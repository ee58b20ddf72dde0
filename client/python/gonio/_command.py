"""The command line inside of a Python process: the `gonio` that pip installs."""

import signal
import sys

from . import _native


def main() -> int:
    """Runs `gonio` with the process's arguments; gives its exit code."""
    # The command listens for Ctrl-C itself, and Python has nothing to add to that.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.main(["gonio", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
