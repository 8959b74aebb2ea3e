"""Figures on the pages are those of the results kept with the code; a failure says what has to stand there."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from lawn_sb3.experiment.recipe import load_recipe
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.experiment.search import load_search
from lawn_sb3.experiment.tuning import ranked_settings, read_trainings
from lawn_sb3.paper.claims import load_claims
from lawn_sb3.paper.claims.claim import VERDICTS
from lawn_sb3.results.pairing import EFFECTS
from lawn_sb3.results.statistics import crossed_t, holm
from tests.docs.pages import PAGES, kept, reference, says, table_rows

OFF = ("normalize_per_rollout", "clip_apart")
"""Settings that a recipe leaves out where they are off."""
LEARNERS = ["iql", "qmix", "mappo", "mappo-state", "mappo-local", "mappo-blind"]


def test_the_table_of_the_readme_is_made_of_table_two() -> None:
    heading, *rows = table_rows(reference("paper/table2.md").read_text("utf-8"))
    columns = [heading.index(name) for name in ("Method", "J̄", "R̂ (Mbps)", "T̄ (slots)", "Success (%)", "U (Mbps)")]
    by_method = {row[0]: [row[column] for column in columns] for row in rows}
    shown = table_rows(PAGES["README.md"])
    assert shown[0] == [heading[column] for column in columns]
    assert len(shown[1:]) == 7
    assert shown[1:] == [by_method[row[0]] for row in shown[1:]]


def test_the_findings_of_the_readme() -> None:
    reward, utility = kept("paper/table2", "reward"), kept("paper/table2", "utility_mbps")
    told = kept("ladder/ladder_table", "utility_mbps")
    says(
        "README.md",
        f"{reward['iql']:.2f} and {reward['qmix']:.2f} against {reward['mappo']:.2f}, or "
        f"{reward['mappo-state']:.2f} with V(x)",
        f"the best, QMIX, has U = {max(utility[key] for key in LEARNERS):.1f} Mbps, flying straight "
        f"{utility['shortest-path']:.1f}",
        f"one gets {told['loads']:.1f} Mbps from what the paper lets it see",
        f"it has {told['intents-in-time']:.1f}, with a slot to spare and more training besides {told['intents']:.1f}; "
        f"the best flights known have {told['welfare']:.1f}",
        f"no closer than {utility['welfare']:.1f} to {utility['bound']:.1f} Mbps a UAV",
    )


def verdicts_of(*names: str) -> dict[str, str]:
    """Claim: verdict in the kept reports."""
    verdicts: dict[str, str] = {}
    for name in names:
        with reference(f"{name}/claims.csv").open(encoding="utf-8", newline="") as file:
            verdicts |= {row["id"]: row["verdict"] for row in csv.DictReader(file)}
    return verdicts


def test_the_tally_of_the_claims() -> None:
    verdicts = verdicts_of("paper", "ablation", "ladder")
    assert set(verdicts) == {claim.id for claim in load_claims()}
    counts = [(list(verdicts.values()).count(verdict), verdict) for verdict in VERDICTS]
    parts = [f"{count} {verdict}" for count, verdict in counts if count]
    says("docs/results.md", f"{', '.join(parts)}.", f"{len(verdicts)} checkable claims")
    says("README.md", f"{len(verdicts)} of its claims", *(f"- {part}" for part in parts))
    caption = reference("paper/README.md").read_text("utf-8")
    (tested,) = re.findall(r"Holm's correction over all (\d+) that these claims need", caption)
    says("docs/results.md", f"that the claims of a report need, {tested} in that of this comparison")


def test_what_moved_between_the_verdicts() -> None:
    verdicts = verdicts_of("paper", "ablation", "ladder")
    rows = [row for row in table_rows(PAGES["docs/results.md"]) if len(row) == 4 and row[1] in VERDICTS]
    moved = {claim: now for _, now, claims, _ in rows for claim in claims.split(", ")}
    assert moved == {claim: verdicts[claim] for claim in moved}
    stayed = {claim: verdict for claim, verdict in verdicts.items() if claim not in moved}
    assert set(stayed.values()) == {"reproduced", "partly", "impossible as printed"}
    before = [before for before, _, claims, _ in rows for _ in claims.split(", ")] + list(stayed.values())
    says(
        "docs/results.md",
        f"{before.count('reproduced')} reproduced, {before.count('partly')} partly, {before.count('not reproduced')} "
        f"not reproduced, {before.count('impossible as printed')} impossible as printed. The rules are stricter",
        f"had {len(verdicts) - before.count('new')} claims",
    )


def test_straight_flight_is_not_measurably_ahead() -> None:
    (sentence, _) = json.loads(reference("paper/report.json").read_text("utf-8"))["summary"]
    assert "none of the 6 learners have measurably less J̄ and none more" in sentence
    assert "QMIX, differs by -0.019 [-0.042, 0.005]" in sentence
    straight, learner = (
        np.stack([pd.read_csv(path).groupby("episode")["reward"].mean() for path in paths])
        for _, paths in evaluations("shortest-path", "mappo")
    )
    lead = crossed_t(straight, learner).interval
    says("docs/results.md", f"of V(o, x) by {lead.text(3)}, of the best, QMIX, by 0.019 [-0.005, 0.042]")


def evaluations(*methods: str) -> list[tuple[str, list[Path]]]:
    """The kept evaluations of methods of the paper's comparison, by seed."""
    folder = REPOSITORY / "runs" / "reference" / "paper"
    return [(method, sorted((folder / method).glob("seed-*/evaluation.csv"))) for method in methods]


def test_what_the_runs_of_the_paper_cost() -> None:
    paths = (REPOSITORY / "runs" / "reference" / "paper").glob("*/seed-*/provenance.json")
    records = [json.loads(path.read_text("utf-8")) for path in paths]
    minutes = sum(record["train_seconds"] + record["evaluate_seconds"] for record in records) / 60.0
    says("README.md", f"The {len(records)} runs of `make reproduce` add up to {minutes:.0f} minutes of one core")
    assert {(record["hardware"]["processor"], record["hardware"]["cores"]) for record in records} == {("AMD EPYC", 2)}


def test_how_far_from_the_optimum() -> None:
    utility = kept("paper/table2", "utility_mbps")
    best = max(LEARNERS, key=lambda key: utility[key])
    share = [kept("paper/table2", f"share_{side}_percent")[best] for side in ("high", "low")]
    gaps = [kept("paper/regret", "nash_gap_mbps")[key] for key in LEARNERS]
    worst = kept("paper/fairness", "worst_mbps")
    least, most = kept("paper/anarchy", "at_least"), kept("paper/anarchy", "at_most")
    (anarchy,) = (name for name in most if name.startswith("Price of anarchy"))
    (stability,) = (name for name in most if name.startswith("Price of stability"))
    says(
        "docs/optimum.md",
        f"{100.0 - share[0]:.0f} to {100.0 - share[1]:.0f} % of the welfare is left on the table",
        f"mean utility of {utility['welfare']:.1f} Mbps are known, and none can have more than {utility['bound']:.1f}",
        f"collects {utility[best]:.1f}, a shortest path {utility['shortest-path']:.1f}",
        f"`forecast` earns {utility['forecast']:.1f} Mbps",
        f"have {utility['worst-equilibrium']:.1f} to {utility['equilibrium']:.1f} Mbps there",
        f"price of anarchy is at least {least[anarchy]:.2f}",
        f"at most {most[anarchy]:.0f}, from",
        f"price of stability is at most {most[stability]:.2f}",
        f"Nash gap is {min(gaps):.0f} to {max(gaps):.0f} Mbps",
        f"the least has {worst['welfare']:.1f} Mbps on average, with a shortest path {worst['shortest-path']:.1f}",
    )
    assert all(60.0 < kept("paper/regret", "gaining_percent")[key] < 72.0 for key in LEARNERS)  # two in three
    assert kept("paper/regret", "equilibria_percent")["welfare"] == pytest.approx(50.0, abs=2.0)  # half


def test_the_ladder_on_the_test_missions() -> None:
    told = kept("ladder/ladder_table", "utility_mbps")
    says("docs/knowledge.md", f"test missions {told['intents']:.1f} against {told['worst-equilibrium']:.1f}")


def test_what_each_part_is_worth() -> None:
    learning, utility = (
        kept("ablation/learning_effects", "mean_success_percent"),
        kept("ablation/effects", "utility_mbps"),
    )
    success = {key: 100.0 + value for key, value in kept("ablation/effects", "success_percent").items()}
    says(
        "docs/ablations.md",
        f"success {success['mappo-no-nav']:.0f} % instead of 100 %",
        f"by {kept('ablation/effects', 'makespan_slots')['mappo-separate']:.2f} slots until the last arrives; the "
        f"{-utility['mappo-separate']:.1f} Mbps of utility",
        f"{-learning['mappo-separate']:.1f} points of mean success during training, do not pass",
        f"lead of {utility['iql-shared']:.1f} Mbps with one shared network does not pass",
        f"success of {success['mappo-recurrent']:.0f} % with memory",
        f"has {-utility['mappo-state']:.1f} Mbps of utility less, which does not pass",
        f"by {-learning['mappo-state']:.1f} points of mean success on the way",
    )
    p_values = {name: kept("ablation/effects", f"{name}_p") for name in EFFECTS}
    tests = [p_value for by_method in p_values.values() for p_value in by_method.values()]
    passed = [(key, name) for name, own in p_values.items() for key, p_value in own.items() if p_value <= holm(tests)]
    assert sorted(passed) == [
        ("mappo-no-nav", "makespan_slots"),
        ("mappo-no-nav", "success_percent"),
        ("mappo-no-nav", "utility_mbps"),
        ("mappo-separate", "makespan_slots"),
    ]
    alone = sum(p_value < 0.05 for p_value in tests)
    says(
        "docs/ablations.md",
        f"{len(tests)} effects on what the finished players do are tested at once",
        f"and {alone} of",
    )
    faster_p = kept("ablation/learning_effects", "mean_success_percent_p")
    assert {key for key, p_value in faster_p.items() if p_value <= holm([*faster_p.values()])} == {"mappo-no-nav"}
    for quantity in EFFECTS:
        low, high = kept("ablation/effects", f"{quantity}_low"), kept("ablation/effects", f"{quantity}_high")
        for name in ("no-rate", "no-col", "no-term", "blind", "relative", "masked", "local", "raw"):
            assert low[f"mappo-{name}"] <= 0.0 <= high[f"mappo-{name}"], (quantity, name)


def test_which_trainings_of_the_ablations_collapse() -> None:
    folder = REPOSITORY / "runs" / "reference" / "ablation"
    failed: dict[str, int] = {}
    for path in sorted(folder.glob("*/seed-*/evaluation.csv")):
        if path.parts[-3] != "random" and pd.read_csv(path)["arrived"].mean() < 0.9:
            failed[path.parts[-3]] = failed.get(path.parts[-3], 0) + 1
    assert failed == {"mappo-no-nav": 5, "mappo-recurrent": 4, "mappo-set": 1}


def test_the_rungs_of_the_ladder() -> None:
    bits, slack = kept("ladder/ladder_table", "told_bits"), kept("ladder/ladder_table", "slack")
    env_steps = kept("ladder/ladder_table", "env_steps")
    rungs = [row for row in table_rows(PAGES["docs/knowledge.md"]) if len(row) == 7][1:]
    for method, _, told, learns, steps, _, _ in rungs:
        key = method.split("`")[1]
        if key in bits:
            assert float(told) == bits[key], method
            assert ("(slack 1)" in method) == (slack.get(key) == 1.0), method
        if learns == "–" or steps == "3.6 M":
            continue
        number, unit = steps.split()
        assert float(number) * {"K": 1e3, "M": 1e6}[unit] == env_steps[key], method
    assert {key for key in env_steps if key in bits} <= {row[0].split("`")[1] for row in rungs}


@pytest.mark.parametrize(("name", "page"), [("ladder", "docs/knowledge.md"), ("ablation", "docs/ablations.md")])
def test_how_many_runs_there_are(name: str, page: str) -> None:
    paths = sorted((REPOSITORY / "runs" / "reference" / name).glob("*/seed-*/provenance.json"))
    trained = [seconds for path in paths if (seconds := json.loads(path.read_text("utf-8"))["train_seconds"]) > 0.0]
    if name == "ladder":
        minutes = round(sum(trained) / 60.0)
        says(page, f"{len(trained)} trainings, which add up to {minutes // 60} h {minutes % 60} min")
    else:
        says(page, f"Of the {len(paths)} runs")
        assert len(kept("ablation/effects", "reward")) == 17 + 3
    assert re.search(rf"`runs/{name}\.yaml`: .*\({len(paths)} runs\)", PAGES["docs/commands.md"])


def test_the_verdicts_that_other_recipes_give() -> None:
    here, elsewhere = verdicts_of("paper"), verdicts_of("ablation", "ladder")
    assert {claim.id for claim in load_claims() if claim.needs is not None} == set(elsewhere)
    assert not set(here) & set(elsewhere)
    assert (len(elsewhere), len(verdicts_of("ablation"))) == (10, 9)
    says("docs/results.md", "all but ten claims", "judge nine of these")


def test_the_search_for_settings() -> None:
    search, methods = load_search(REPOSITORY / "runs" / "tuning.yaml")
    file = REPOSITORY / "runs" / "tuning.csv"
    trainings, ranked = read_trainings(file), ranked_settings(search, file)
    rows = {row[0]: row for row in table_rows(PAGES["docs/results.md"]) if len(row) == 6}
    for key in search.space:
        mine, method = trainings[trainings["method"] == key], methods[key]
        first = mine[mine["seed"] == search.seeds[0]]
        best = ranked[(ranked["method"] == key) & (ranked["seeds"] == len(search.seeds))].nlargest(1, "reward").iloc[0]
        _, tried, of_one, of_three, shown, minutes = rows[method.label]
        assert (tried, minutes) == (str(len(first)), f"{mine['cpu_seconds'].sum() / 60:.0f}"), key
        assert (of_one, of_three) == (f"{first['reward'].max():.3f}", f"{best['reward']:.3f}"), key
        named = [f"{name} {value}".lower() for name, value in best["settings"].items()]
        assert shown.replace("*", "").split(", ") == named, key
        assert {name for name in best["settings"] if f"{name}* " in shown} == set(best["at_edge"]), key
        assert best["settings"].items() <= {**dict.fromkeys(OFF, False), **method.settings}.items(), key
        assert len(first) >= search.trials, key
        assert first["cpu_seconds"].sum() >= 60.0 * search.cpu_minutes, key


def test_at_the_defaults_no_row_of_the_paper_comes_out() -> None:
    success, printed = (kept("defaults/table2", name) for name in ("success_percent", "success_percent_paper"))
    says(
        "docs/results.md",
        f"QMIX, {printed['qmix']:.0f} % in the paper, succeeds in {success['qmix']:.0f} % of the missions",
        f"CTDE-MAPPO in {success['mappo-state']:.0f} % or {success['mappo-authors']:.0f} % instead of 100 %, and IQL "
        f"in {success['iql']:.0f} %, far below the paper's {printed['iql']} %",
    )
    assert all(abs(success[key] - printed[key]) > 10.0 for key in success if key != "random")
    folder = REPOSITORY / "runs" / "reference" / "defaults"
    sampled = [
        pd.read_csv(folder / key / "seed-0" / "evaluation_sampled.csv") for key in ("mappo-state", "mappo-authors")
    ]
    shares = [f"{100 * rows['arrived'].mean():.1f} % and J̄ {rows['reward'].mean():.2f} with" for rows in sampled]
    says("docs/results.md", f"{shares[0]} SB3's, {shares[1]} its authors' settings")
    slots = [rows.groupby("episode")["makespan_slots"].first().mean() for rows in sampled]
    says("docs/results.md", f"with T̄ of {slots[0]:.0f} and {slots[1]:.0f} slots")
    curves = {
        key: pd.read_csv(REPOSITORY / f"runs/reference/defaults/{key}/seed-0/progress.csv").dropna(
            subset="greedy/success_percent"
        )
        for key in ("iql", "qmix")
    }
    iql = {round(row["time/env_steps"] / 1e3): row for _, row in curves["iql"].iterrows()}
    qmix = curves["qmix"]["greedy/success_percent"]
    says(
        "docs/results.md",
        f"greedy success of IQL is {iql[50]['greedy/success_percent']:.0f} % after 50 K env steps",
        f"between 75 K ({iql[75]['greedy/success_percent']:.0f} %, J̄ {iql[75]['greedy/reward']:.2f}) and 80 K "
        f"({iql[80]['greedy/success_percent']:.0f} %, J̄ {iql[80]['greedy/reward']:.2f})",
        f"that of QMIX falls from {qmix.max():.0f} % to {qmix.iloc[-1]:.0f} %",
    )
    assert curves["iql"]["greedy/rate_mbps"].max() < 44.46 - 2.0


def test_iql_at_its_defaults_collapses_alone_too() -> None:
    runs = [REPOSITORY / "runs" / "reference" / "alone" / "iql" / f"seed-{seed}" for seed in range(3)]
    best = [pd.read_csv(run / "progress.csv")["greedy/success_percent"].max() for run in runs]
    says("docs/results.md", f"comes to {best[0]:.0f}, {best[1]:.0f} and {best[2]:.0f} % on the way, in three seeds")
    assert not any(pd.read_csv(run / "evaluation.csv")["arrived"].any() for run in runs)
    settings = [
        load_recipe(REPOSITORY / "runs" / f"{name}.yaml").methods["iql"].settings for name in ("alone", "defaults")
    ]
    assert settings[0] == settings[1]


def test_what_updates_in_bfloat16_change() -> None:
    def effect(table: str, name: str, decimals: int) -> str:
        value, low, high = (
            kept(f"bfloat16/{table}", f"{name}{end}")["mappo-bfloat16"] for end in ("", "_low", "_high")
        )
        return f"{value:.{decimals}f} [{low:.{decimals}f}, {high:.{decimals}f}]"

    assert kept("bfloat16/effects", "success_percent")["mappo-bfloat16"] == 0.0
    says(
        "docs/speed.md",
        f"J̄ differs by {effect('effects', 'reward', 3)}, the utility by {effect('effects', 'utility_mbps', 2)} Mbps",
        f"mean success during training by {effect('learning_effects', 'mean_success_percent', 1)} points",
    )


def test_what_lies_one_step_beyond_the_edges_of_the_search() -> None:
    trainings = read_trainings(REPOSITORY / "runs" / "tuning_edges.csv")
    settings = trainings["settings"].map(json.loads)

    def mean(method: str, **own: float | str) -> str:
        same = settings.map(lambda one: own.items() <= one.items()) & (trainings["method"] == method)
        assert same.sum() == 3, own
        return f"{trainings.loc[same, 'reward'].mean():.3f}"

    says(
        "docs/results.md",
        f"a gamma of 0.15 has a J̄ of {mean('mappo', gamma=0.15)} with V(o, x) and of "
        f"{mean('mappo-state', gamma=0.15, learning_rate='lin_1.6e-2')} with V(x)",
        f"of lin_3.2e-2 has {mean('mappo-state', gamma=0.3, learning_rate='lin_3.2e-2')} with V(x)",
        f"IQL has {mean('iql', target_update_interval=25600, exploration_fraction=0.02)} with a target interval of "
        f"25,600 and {mean('iql', target_update_interval=12800, exploration_fraction=0.005)} with less exploration",
        f"QMIX {mean('qmix', target_update_interval=12)} with a target interval of 12",
    )


def test_how_much_other_missions_move_differences() -> None:
    methods = (*LEARNERS, "shortest-path")
    folder = REPOSITORY / "runs" / "reference" / "paper"
    rows = {key: pd.concat(map(pd.read_csv, sorted(folder.glob(f"{key}/seed-*/evaluation.csv")))) for key in methods}
    shown = []
    for name in ("reward", "utility_mbps"):
        by_mission = pd.DataFrame({key: own.groupby("episode")[name].mean() for key, own in rows.items()})
        missions = np.sqrt(len(by_mission))
        errors = {
            (one, two): float(np.std(by_mission[one] - by_mission[two], ddof=1) / missions)
            for one in methods
            for two in methods
        }
        learners = max(error for pair, error in errors.items() if "shortest-path" not in pair)
        shown.append((learners, max(errors.values())))
    (reward, reward_straight), (utility, utility_straight) = shown
    says(
        "docs/limits.md",
        f"up to {reward:.3f} in J̄ and {utility:.2f} Mbps in utility between two learners, and of {reward_straight:.3f} "
        f"and {utility_straight:.2f} Mbps between a learner and straight flight",
    )
