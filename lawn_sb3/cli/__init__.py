"""The command line: ``lawn-sb3``, also ``python -m lawn_sb3``."""

import sys


def main() -> None:
    """Run the command line: exit status 2 for bad input, 1 for failed work, 130 when interrupted."""
    try:
        from lawn_sb3.cli.commands import run  # here, since loading the libraries takes long enough to interrupt it
    except KeyboardInterrupt:
        sys.exit(130)
    run()
