"""``python -m lawn_sb3``."""

from lawn_sb3.cli import main

main()
