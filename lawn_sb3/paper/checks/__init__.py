"""What claims and the price of anarchy rest on besides the runs, read back; :mod:`lawn_sb3.paper.making` makes it."""

from lawn_sb3.paper.checks.kept import export_checks, read_checks

__all__ = ["export_checks", "read_checks"]
