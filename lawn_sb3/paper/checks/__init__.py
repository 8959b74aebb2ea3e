"""What claims and the price of anarchy rest on besides the runs, flown or planned before the report and kept in files.

One file here per check; ``kept`` makes what is missing and reads it back.
"""

from lawn_sb3.paper.checks.kept import export_checks, fly_checks, read_checks

__all__ = ["export_checks", "fly_checks", "read_checks"]
