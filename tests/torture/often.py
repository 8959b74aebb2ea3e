"""``lawn-sb3`` with a checkpoint after every 1,000 env steps, in its workers too: they import what was started."""

from lawn_sb3.experiment.backends.worker import end_with_parent

end_with_parent()  # as soon as workers of lawn-sb3 do, which load torch after that

from lawn_sb3.cli import main  # noqa: E402
from lawn_sb3.experiment.checkpoint import Checkpoints  # noqa: E402

Checkpoints.__init__.__defaults__ = (1_000,)

if __name__ == "__main__":
    main()
