"""The commands together, and what each kind of failure ends in.

Their modules import what reads and checks what the user wrote. What does the work is imported inside a command, once it
is known that there is some: torch and the other libraries take seconds, and a misspelt name should not.
"""

import io
import sys
import warnings
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from lawn_sb3 import __version__
from lawn_sb3.cli import models, plans, recipes, replays, runs, tools, train
from lawn_sb3.cli.console import fail, say
from lawn_sb3.cli.ending import interrupted_status
from lawn_sb3.errors import FailedRunsError, HeldError, UserError, first_line
from lawn_sb3.experiment.backends.worker import tell_notices


class Commands(TyperGroup):
    """All commands; each ends in one line when it is interrupted."""

    def invoke(self, ctx: Any) -> object:
        """Run one of them."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            fail("interrupted; what was not finished is not kept, the same command begins anew", interrupted_status())


app = typer.Typer(
    cls=Commands,
    help="Train, evaluate and reproduce: game-theoretic trajectory planning of UAV swarms, with Stable-Baselines3.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
for group in (train.app, models.app, replays.app, runs.app, plans.app, recipes.app, tools.app):
    app.registered_commands += group.registered_commands


def show_version(asked: bool) -> None:
    """End after the version where that is asked for."""
    if asked:
        print(f"lawn-sb3 {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=show_version, is_eager=True, help="print the version and end")
    ] = False,
) -> None:
    """What no command has to be named for."""


def run() -> None:
    """Run the command that the arguments name."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Unicode gets question marks
    with warnings.catch_warnings():
        tell_notices(lambda text: say(f"lawn-sb3: {text}", "yellow"))
        _run()


def _run() -> None:
    try:
        app()
    except UserError as error:
        fail(str(error), 2)
    except HeldError as error:
        fail(str(error), 1)
    except FailedRunsError as error:
        fail(f"{error}; finished runs are kept, the same command resumes the others", 1)
    except MemoryError as error:
        fail(f"not enough memory: {first_line(error)}; what is finished is kept", 1)
    except OSError as error:
        fail(f"{error.strerror or error}: {error.filename or 'a file'}; what is finished is kept", 1)
