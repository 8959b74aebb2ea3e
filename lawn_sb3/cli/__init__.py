"""The command line: ``lawn-sb3``, also ``python -m lawn_sb3``."""

import sys

from lawn_sb3.cli.ending import ending_in_order, interrupted_status


def main() -> None:
    """Run the command line: exit status 2 for bad input, 1 for failed work, 130 when interrupted, 143 by SIGTERM."""
    try:
        with ending_in_order():
            from lawn_sb3.cli.commands import run  # here: loading the libraries takes long enough to interrupt it

            run()
    except KeyboardInterrupt:
        print("lawn-sb3: interrupted before it began", file=sys.stderr)
        sys.exit(interrupted_status())
