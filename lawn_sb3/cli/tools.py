"""Commands about the game, the paper and the machine: scenario, identify, bench."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from lawn_sb3.choices import MOST_EPISODES
from lawn_sb3.cli.console import (
    PAPER_RECIPE,
    PICTURES,
    AsJson,
    Changes,
    messages,
    print_figures,
    print_table,
    progress,
    say,
)
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.recipe import load_recipe
from lawn_sb3.experiment.shipped import shipped_recipe
from lawn_sb3.scenario import PRESETS, Scenario, load_scenario
from lawn_sb3.whole_files import write_json, write_text

if TYPE_CHECKING:
    from lawn_sb3.paper.identification import Identification

app = typer.Typer()

WIDE_ENOUGH_FOR_SENTENCES = 120

ASKED = {"CTDE-MAPPO": "mappo-state", "QMIX": "qmix"}
"""Rows of the paper's Table II whose trained players ``identify`` asks: the method of ``runs/paper.yaml`` that stands
for each; training gives nothing like its IQL row."""
IDENTIFIED = "identify.json"


@app.command()
def bench(
    quick: Annotated[bool, typer.Option("--quick", help="in about a minute: shorter, and no whole trainings")] = False,
    out: Annotated[Path | None, typer.Option(help="folder for bench.json and growth.png")] = None,
    profile: Annotated[
        bool, typer.Option("--profile", help="instead say where the time of a training goes, in percent")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Measure the speed of simulator, environments, planning and learning, on one core."""
    methods = load_recipe(shipped_recipe(PAPER_RECIPE)).methods
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)  # before minutes are spent

    from lawn_sb3.experiment.benchmark import benchmark, training_profile
    from lawn_sb3.experiment.provenance import provenance
    from lawn_sb3.report.speed import growth_figure
    from lawn_sb3.report.style import save

    if profile:
        with progress("trainings") as advance:
            shares = training_profile(methods, 10_000 if quick else 50_000, advance)
        print_table(shares.round(1).rename_axis("part").reset_index(), "own time of each part of a training, percent")
        return
    made = provenance()
    with progress("parts") as advance:
        speeds = benchmark(methods, quick, advance)
    if out is not None:
        growth = json.loads(speeds.growth.to_json(orient="records"))
        write_json(out / "bench.json", {**made, "quick": quick, "figures": speeds.figures, "growth": growth})
        save(growth_figure(speeds.growth), out, "growth", (".png",))
    print_figures(speeds.figures, as_json, "speed on one core")
    if not as_json:
        print_table(speeds.growth.round(2), "how the simulator's speed changes as games grow")


@app.command("scenario")
def scenario_command(
    name: Annotated[str, typer.Argument(help=f"{', '.join(PRESETS)}, or the path of a YAML file")] = "paper",
    changes: Changes = [],  # noqa: B006
    as_yaml: Annotated[bool, typer.Option("--yaml", help="print YAML that --scenario FILE.yaml reads")] = False,
    picture: Annotated[
        Path | None, typer.Option(help="draw airspace, cells and one mission of each UAV to this .png, .pdf or .svg")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="picks the missions of the picture")] = 20_000,
) -> None:
    """Show every constant of a scenario: value, unit, the paper's symbol, and where the value comes from.

    Stated in the paper, inferred from its figures, chosen by this kit, of another preset, or yours.
    """
    chosen = load_scenario(name, changes)
    if picture is not None:
        if picture.suffix not in PICTURES:
            raise UserError(f"--picture {str(picture)!r}: a file that ends in {', '.join(PICTURES)}")

        from lawn_sb3.report.airspace import airspace_figure
        from lawn_sb3.report.style import save

        save(airspace_figure(chosen, seed), picture.parent, picture.stem, (picture.suffix,))
        say(f"picture: {picture}")
        return
    if as_yaml:
        print(chosen.to_yaml(), end="")
        return
    console, table = Console(), Table(title=f"scenario {chosen.name}")
    wide = console.width >= WIDE_ENOUGH_FOR_SENTENCES
    for heading in ("constant", "symbol", "value", "unit", "source", *(["what it is"] if wide else [])):
        table.add_column(heading, overflow="fold")
    for key, field in Scenario.model_fields.items():
        extra = field.json_schema_extra
        if isinstance(extra, dict):
            unused = key == "gbs_grid" and chosen.gbs_positions_m is not None
            value = "not used: gbs_positions_m" if unused else str(getattr(chosen, key))
            cells = key, str(extra["symbol"]), value, str(extra["unit"]), "–" if unused else chosen.source(key)
            table.add_row(*cells, *([field.description] if wide else []))
    console.print(table)
    if not wide:
        say(f"in a window of {WIDE_ENOUGH_FOR_SENTENCES} columns it also says what each constant is")


@app.command("identify")
def identify_command(
    episodes: Annotated[
        int, typer.Option(min=1, max=MOST_EPISODES, help="joint episodes of the Random player a candidate")
    ] = 2_000,
    seed: Annotated[int, typer.Option(min=0, help="picks the missions")] = 50_000,
    models: Annotated[
        Path, typer.Option(help="runs of the paper's methods, whose trained players are asked too")
    ] = Path("runs/reference/paper"),
    out: Annotated[Path | None, typer.Option(help="folder for README.md and identify.json")] = None,
    alone: Annotated[
        bool, typer.Option("--alone", help="one constant at a time only: a minute in place of half an hour")
    ] = False,
    kept: Annotated[
        Path | None, typer.Option("--from", help="show what this --out of an earlier call holds, without flying anew")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Which games the paper's figures allow: every open constant and reading, alone and jointly. Takes half an hour."""
    found = None if kept is None else (kept / IDENTIFIED, _read(kept / IDENTIFIED))

    import pandas as pd

    from lawn_sb3.paper.identification import as_markdown

    result = _identified(episodes, seed, models, alone) if found is None else _kept(*found)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        write_text(out / "README.md", as_markdown(result))
        write_text(out / IDENTIFIED, result.as_text())
    if as_json:
        print(json.dumps(result.as_json()))
        return
    said = (
        (result.joint_findings, "all readings jointly, the free constants fitted"),
        (result.findings, "one constant at a time, the others as in the preset"),
    )
    for findings, title in said if result.joint_findings else said[1:]:
        shown = pd.DataFrame({"constant": list(findings), "what the paper's figures say": findings.values()})
        print_table(shown, f"{title}, {result.episodes:,} episodes a candidate")
    if out is not None:
        say(f"all tables: {out / 'README.md'}")


def _identified(episodes: int, seed: int, models: Path, alone: bool) -> "Identification":
    """Fly, under a bar."""
    from lawn_sb3.experiment.players import kept_player
    from lawn_sb3.paper.identification import identify

    kept = {row: kept_player(models / method) for row, method in ASKED.items()}
    players = {row: player for row, player in kept.items() if player is not None}
    if not players:
        say(f"no trained players in {models}: the Random player alone is asked")
    with Progress(console=messages, transient=True) as bar:
        task = bar.add_task("trying candidates")
        return identify(
            episodes,
            seed,
            players,
            lambda done, total: bar.update(task, completed=done, total=total),
            [] if alone else None,
        )


def _read(path: Path) -> dict[str, Any]:
    """What an earlier call kept."""
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise UserError(f"--from {str(path.parent)!r}: holds no {path.name}") from None
    except ValueError:
        values = None
    if not isinstance(values, dict):
        raise _not_kept(path)
    return values


def _kept(path: Path, values: dict[str, Any]) -> "Identification":
    """The same as an identification."""
    from lawn_sb3.paper.identification import Identification

    try:
        return Identification.from_json(values)
    except (KeyError, TypeError, ValueError):
        raise _not_kept(path) from None


def _not_kept(path: Path) -> UserError:
    return UserError(f"{str(path)!r} holds no identification that this version wrote")
