"""``lawn-sb3`` with a checkpoint after every 1,000 env steps, in its workers too: they import what was started."""

from lawn_sb3.cli import main
from lawn_sb3.experiment.checkpoint import Checkpoints

Checkpoints.__init__.__defaults__ = (1_000,)

if __name__ == "__main__":
    main()
