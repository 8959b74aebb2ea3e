"""One cell: a method with one seed on one game, what its result depends on, and where its run goes."""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lawn_sb3.experiment.policy_digest import policy_digest
from lawn_sb3.experiment.recipe import Evaluation, Method, Recipe
from lawn_sb3.scenario import Scenario

RESULTS_SINCE = "0.1.0"
"""The last version of the kit that changed a byte of what every run leaves; raised with such a change and only then."""
LEARNERS_SINCE = {"mappo": "0.2.0", "iql": "0.2.0", "qmix": "0.2.0"}
"""The same of the runs of an algorithm, where only those have changed since.

0.2.0 leaves missions that end before the first deadline out of SB3's own ``rollout/`` columns of ``progress.csv``. No
report reads these, so runs made before count as finished too; a checkpoint made before is not gone on from."""
NOT_IN_RESULTS = ("label", "paper_row", "baseline")
"""Fields of a method that change nothing in what its runs leave."""


@dataclass(frozen=True)
class Cell:
    """One (method, seed) of a recipe.

    :param key: name of the method in the recipe
    :param method: the method
    :param seed: the seed
    :param scenario: the game
    :param evaluation: how it is scored
    :param directory: where its run goes
    :param variant: the recipe's name for the changed game, if it has several
    :param regret: whether regrets are worked out, in training too
    """

    key: str
    method: Method
    seed: int
    scenario: Scenario
    evaluation: Evaluation
    directory: Path
    variant: str = ""
    regret: bool = False

    @property
    def title(self) -> str:
        """What messages call it."""
        return f"{self.variant + ' ' if self.variant else ''}{self.key} seed {self.seed}"

    def configuration(self) -> dict[str, Any]:
        """All that the run depends on, ready for YAML."""
        return {"key": self.key, **self._parts(exclude_defaults=False), "version": self._version}

    def fingerprint(self) -> str:
        """Hash of what the result depends on: labels do not count, nor do fields that keep their default value."""
        return self._fingerprint(self._version)

    def fingerprints(self) -> set[str]:
        """Those of finished runs that count: of this version, and of earlier ones that no report tells apart."""
        return {self.fingerprint(), self._fingerprint(RESULTS_SINCE)}

    @property
    def _version(self) -> str:
        return LEARNERS_SINCE.get(self.method.algo or "", RESULTS_SINCE)

    def _fingerprint(self, version: str) -> str:
        parts = {**self._parts(exclude_defaults=True), "version": version}
        for name in NOT_IN_RESULTS:
            parts["method"].pop(name, None)
        return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]

    def _parts(self, exclude_defaults: bool) -> dict[str, Any]:
        models = {"method": self.method, "scenario": self.scenario, "evaluation": self.evaluation}
        policy = self.method.policy
        return {
            "policy_file": None if policy is None else policy_digest(policy),  # an edited policy is another one
            "seed": self.seed,
            **{name: one.model_dump(mode="json", exclude_defaults=exclude_defaults) for name, one in models.items()},
        }


def cells(recipe: Recipe, root: Path) -> list[Cell]:
    """The cells of a recipe, seed by seed, so that an early stop leaves all methods comparable.

    :param recipe: the recipe
    :param root: the folder of its runs
    :return: one cell for each method, seed and variant
    """
    games = {name: variant.game() for name, variant in recipe.split().items()}
    return [
        Cell(
            key,
            method,
            seed,
            scenario,
            recipe.evaluation,
            root / variant / key / f"seed-{seed}",
            variant,
            recipe.regret,
        )
        for seed in recipe.seeds
        for variant, scenario in games.items()
        for key, method in recipe.methods.items()
    ]
