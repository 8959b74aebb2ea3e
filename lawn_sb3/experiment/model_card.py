"""``README.md``: the card of a trained model, for whoever is handed the folder of its run."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.experiment.policy_places import is_installed
from lawn_sb3.experiment.run_directory.files import CONFIG_FILE, TENSORS_FILE
from lawn_sb3.scenario import PRESETS, Scenario

CARD = """\
---
library_name: stable-baselines3
tags: [reinforcement-learning, multi-agent]
---

# {label}, seed {seed}

{algo} with the policy `{policy}`, trained by lawn-sb3 {version} for {env_steps:,} env steps (slots of one game).

- Game: {game}
- Settings: all in `{config}`

## Results

{actions} actions on the {episodes} test episodes of seed {evaluation_seed}, means over {missions} missions:

| J̄ | U (Mbps) | T̄ (slots) | Success (%) |
|:--|:--|:--|:--|
| {reward:.2f} | {utility_mbps:.1f} | {makespan_slots:.1f} | {success_percent:.1f} |

J̄ is the reward that a UAV collects in a mission, U its utility, T̄ the slots until the last UAV of an episode is done,
success the share of UAVs that arrive.

## Make it again

```
{command}
```

Other runs may come with it. A recipe or a scenario file that it names is not in this folder; `{config}` says all that
the run depends on.

## Fly it

`DIR` is this folder{needs}:

```
lawn-sb3 evaluate --run DIR --episodes {episodes} --seed {evaluation_seed}{options}
lawn-sb3 verify DIR{trust}
```

## Read the weights

```python
from safetensors.torch import load_file

for name, tensor in load_file("{tensors}").items():
    print(name, tuple(tensor.shape))
```

{holds} Names are those of the policy's `state_dict`.

## Versions

{versions}
"""
"""What a card says, with what differs from run to run in braces."""


def model_card(cell: Cell, record: Mapping[str, Any], flown: pd.DataFrame) -> str:
    """Write the card of a finished training; it holds no times.

    :param cell: what was trained
    :param record: where the run comes from, and ``trained_env_steps``
    :param flown: the rows of its evaluation
    :return: the card, in Markdown
    """
    method, chosen = cell.method, cell.evaluation
    assert method.policy is not None
    trust = "" if is_installed(method.policy) else f" --trust {method.policy}"
    versions = {**record["versions"], "Python": record["python"]}
    card = CARD.format(
        label=method.label,
        seed=cell.seed,
        algo=method.algo,
        policy=method.policy,
        version=versions["lawn-sb3"],
        env_steps=record["trained_env_steps"],
        game=_game(cell.scenario),
        config=CONFIG_FILE,
        actions="Greedy" if chosen.deterministic else "Sampled",
        episodes=chosen.episodes,
        evaluation_seed=chosen.seed,
        missions=len(flown),
        command=record["command"],
        needs="; the policy is its author's, and not in it" if trust else "",
        options=("" if chosen.deterministic else " --sample") + trust,
        trust=trust,
        tensors=TENSORS_FILE,
        holds=_holds(cell),
        versions=f"{', '.join(f'{name} {version}' for name, version in versions.items())}; commit {record['commit']}",
        **summarize(flown),
    )
    return card.encode(errors="replace").decode()  # the name of a folder need not be Unicode


def _game(scenario: Scenario) -> str:
    """The name of a game, and what was set in it."""
    if scenario.name in PRESETS:
        return scenario.title
    return f"{scenario.name}, which is {scenario.changed(name='paper').title}"


def _holds(cell: Cell) -> str:
    """What the tensors of a method are."""
    if cell.method.algo == "qmix":
        return "`q_net` is the network that acts, the same for all UAVs, `mixer` mixes their values in training."
    if cell.method.algo != "iql":
        return "They are those of actor and critic."
    if cell.method.settings.get("share_parameters"):
        return "`learners.0` is the network of all UAVs."
    return "`learners.K` is the network of UAV K, from 0."
