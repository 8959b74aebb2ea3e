"""What ``make peers`` measures, and that its page shows what it left."""

import json
from typing import Any

import numpy as np
import pytest

from lawn_sb3.envs.observation import Floats32
from tests.docs.pages import PAGES, prose
from tests.peers import watch
from tests.peers.__main__ import PEERS, RESULT, table, train
from tests.peers.watch import Watch


def test_the_page_has_the_table_of_what_was_measured() -> None:
    results = json.loads(RESULT.read_text(encoding="utf-8"))
    assert table(results) in PAGES["docs/peers.md"]
    assert set(results) <= set(PEERS)
    for result in results.values():
        for package, version in result["versions"].items():
            assert package == "lawn-sb3" or f"{package} {version.partition('+')[0]}" in prose("docs/peers.md")


def test_the_first_look_that_is_high_enough_counts_and_looks_cost_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]

    def summarize(rows: Any) -> dict[str, float]:
        now[0] += 1_000.0  # what a look takes
        share = min(1.0, watched.trained / 3_072)
        return {"reward": share, "success_percent": 100.0 * share, "utility_mbps": 40.0 * share}

    monkeypatch.setattr("time.process_time", lambda: now[0])
    monkeypatch.setattr(watch, "evaluate", lambda *_: None)
    monkeypatch.setattr(watch, "summarize", summarize)

    def hover(o: Floats32) -> Any:
        return np.zeros(o.shape[:2], dtype=int)

    watched = Watch(4_096, "numpy")
    watched.begin(hover)
    for trained in range(512, 4_097, 512):
        now[0] += 2.0
        watched.step(trained, hover)
    result = watched.result(hover)
    assert [look["env_steps"] for look in result["looks"]] == [0, 1_024, 2_048, 3_072, 4_096]
    assert result["to_95_percent_success"] == {"env_steps": 3_072, "cpu_seconds": 12.0}
    assert result["to_99_percent_of_final_utility"] == {"env_steps": 3_072, "cpu_seconds": 12.0}
    assert (result["cpu_seconds"], result["env_steps_a_cpu_second"]) == (16.0, 256.0)


@pytest.mark.parametrize("name", ["ours", "sb3-ppo"])
def test_peers_that_need_no_other_environment_train_for_their_budget_and_learn(name: str) -> None:
    result = train(name, env_steps=2_048)
    assert result["env_steps"] == 2_048
    assert [look["env_steps"] for look in result["looks"]] == [0, 1_024, 2_048]
    assert result["looks"][-1]["reward"] > result["looks"][0]["reward"]
    assert table({name: result}).count("\n") == 2
