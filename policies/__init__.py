"""Networks that can be swapped: one file, one policy class; ``--policy NAME`` finds ``policies/NAME.py``."""
