"""The command that shows flights: replay."""

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lawn_sb3.choices import MOST_EPISODES
from lawn_sb3.cli.console import PICTURES, Changes, Trusted, progress, say
from lawn_sb3.cli.flyers import Flyer, player_flyer, run_flyer
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.registry import PLAYERS
from lawn_sb3.scenario import load_scenario

if TYPE_CHECKING:
    from lawn_sb3.results.tracks import Replay

app = typer.Typer()

PAGES, FILMS = (".html",), (".gif", ".mp4")
FIRST = 6
"""Episodes that a page shows if none is named."""


@app.command()
def replay(
    out: Annotated[
        Path, typer.Option(help="what to write, by its ending: .html a page, .gif or .mp4 a film, .png .svg .pdf")
    ],
    runs: Annotated[list[Path], typer.Option("--run", help="run directory of a trained model; repeatable")] = [],  # noqa: B006
    players: Annotated[
        list[str], typer.Option("--player", help=f"player that needs no training, repeatable: {', '.join(PLAYERS)}")
    ] = [],  # noqa: B006
    scenario: Annotated[
        str | None, typer.Option(help="preset or YAML file; default: the runs' own, or paper without one")
    ] = None,
    changes: Changes = [],  # noqa: B006
    episodes: Annotated[int, typer.Option(min=1, max=MOST_EPISODES, help="joint episodes to fly")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="picks the missions: the same as in evaluate")] = 20_000,
    chosen: Annotated[
        list[int],
        typer.Option("--episode", help=f"show this one, from 0, repeatable; default: the first {FIRST}"),
    ] = [],  # noqa: B006
    slot: Annotated[int | None, typer.Option(min=0, help="slot that a picture shows; default: the last")] = None,
    sample: Annotated[bool, typer.Option("--sample", help="sample actions instead of taking the likeliest")] = False,
    trusted: Trusted = [],  # noqa: B006
) -> None:
    """Show episodes slot by slot: UAVs in the airspace, the loads of its cells, rates and utilities.

    Name a run or a player, or several to see them side by side. They fly what evaluate flies with the same --episodes
    and --seed, so that all numbers are those of its --rows.
    """
    if out.suffix not in (*PAGES, *FILMS, *PICTURES):
        raise UserError(f"--out {str(out)!r}: a file that ends in {', '.join((*PAGES, *FILMS, *PICTURES))}")
    if not out.absolute().parent.is_dir():
        raise UserError(f"{str(out)!r} cannot be written: there is no folder {str(out.parent)!r}")
    if slot is not None and out.suffix not in PICTURES:
        raise UserError(f"--slot: only a picture shows one slot, not {out.suffix}")
    shown = list(dict.fromkeys(chosen)) or list(range(min(FIRST, episodes)))
    if out.suffix not in PAGES:
        if len(chosen) > 1:
            raise UserError(f"--episode: {out.suffix} shows one episode, a page (.html) several")
        shown = shown[:1]
    for number in shown:
        if not 0 <= number < episodes:
            raise UserError(f"--episode {number}: from 0 to {episodes - 1}, as --episodes {episodes}")
    flyers = _flyers(runs, players, scenario, changes, trusted)
    if out.suffix == ".mp4":
        _check_ffmpeg()

    seen = _flown(flyers, episodes, seed, shown, sample)
    if out.suffix in PAGES:
        from lawn_sb3.report.web.replay_page import replay_page
        from lawn_sb3.whole_files import write_text

        command = shlex.join(["lawn-sb3", *sys.argv[1:]])
        write_text(out, replay_page(seen, " · ".join(one.title for one in seen.flown), command))
    elif out.suffix in FILMS:
        from lawn_sb3.report.replay_figure import save_film

        with progress("slots") as advance:
            save_film(seen, out, advance)
    else:
        from lawn_sb3.report.replay_figure import replay_figure
        from lawn_sb3.report.style import save

        save(replay_figure(seen, slot), out.parent, out.stem, (out.suffix,))
    say(f"{'page' if out.suffix in PAGES else 'film' if out.suffix in FILMS else 'picture'}: {out}")


def _flyers(
    runs: list[Path], players: list[str], scenario: str | None, changes: list[str], trusted: list[str]
) -> list[Flyer]:
    """Who flies, all on one game."""
    if not runs and not players:
        raise UserError("name at least one --run DIR or --player NAME")
    flyers = [run_flyer(run, scenario, changes, trusted) for run in runs]
    game = flyers[0].game if flyers and scenario is None else load_scenario(scenario or "paper", changes)
    flyers += [player_flyer(name, game) for name in players]
    for flyer, what in zip(flyers, [*map(str, runs), *players], strict=True):
        if flyer.game != game:
            raise UserError(f"{what!r} flies on {flyer.game.title!r}, others on {game.title!r}: name one --scenario")
        if flyer.flies_alone:
            raise UserError(f"{what!r} cannot be shown: its UAVs never meet, each has a game of its own")
    return flyers


def _check_ffmpeg() -> None:
    from matplotlib.animation import FFMpegWriter

    if not FFMpegWriter.isAvailable():
        raise UserError("--out: .mp4 needs ffmpeg, which is not installed; .gif needs nothing")


def _flown(flyers: list[Flyer], episodes: int, seed: int, shown: list[int], sample: bool) -> "Replay":
    """Let all fly the missions of the seed; keep the chosen episodes."""
    from lawn_sb3.experiment.evaluation import fly
    from lawn_sb3.experiment.measures import summarize
    from lawn_sb3.results.tracks import Flown, replay_of, tracks_of

    titles, flown = _titles(flyers), []
    for flyer, title in zip(flyers, titles, strict=True):
        say(f"flying {episodes} episodes: {title}")
        flights = fly(flyer.load(sample), flyer.game, episodes, seed, flyer.seed, traced=max(shown) + 1)
        tracks = list(tracks_of(flyer.game, flights.rows, flights.paths, shown))
        flown.append(Flown(flyer.name, title, tracks, summarize(flights.rows)))
    return replay_of(flyers[0].game, seed, episodes, flown)


def _titles(flyers: list[Flyer]) -> list[str]:
    """What each is called; those of the same name by their seeds, and by their place if these are the same too."""
    titles = [flyer.label for flyer in flyers]
    seeds = [f"{flyer.label}, seed {flyer.seed}" for flyer in flyers]
    places = [f"{flyer.label} ({place})" for place, flyer in enumerate(flyers, 1)]
    for others in (seeds, places):
        titles = [other if titles.count(title) > 1 else title for title, other in zip(titles, others, strict=True)]
    return titles
