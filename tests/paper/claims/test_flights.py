"""Claims that are held to flights of their own: what an actor reads, and what hovering gives."""

import pandas as pd
import pytest

from lawn_sb3.paper.claims import Finding
from lawn_sb3.paper.claims.evidence import CannotTellError
from lawn_sb3.paper.claims.flights import iql_rate_artefact, no_communication
from lawn_sb3.paper.roles import FORMS
from tests.handmade import evidence, flown, flown_by_seed

ACTORS = (*FORMS, "qmix", "iql")


def noise(**draws: list[int]) -> pd.DataFrame:
    """Two draws of noise with 200 actions each, of which so many changed; none of those not named."""
    return pd.DataFrame({"draw": [0, 1], "actions": 200, **dict.fromkeys(ACTORS, 0), **draws})


def changed(**draws: list[int]) -> Finding:
    return no_communication(evidence(*(flown(role, 0) for role in ACTORS), state_noise=noise(**draws)))


def test_no_action_may_change_with_the_global_state() -> None:
    same = changed()
    assert same.verdict == "reproduced"
    assert same.figure == "actions changed by noise in x, of 400 each: MAPPO: 0; MAPPO-O: 0; QMIX: 0; IQL: 0"
    other = changed(qmix=[0, 3])
    assert other.verdict == "partly"
    assert "QMIX: 3" in other.figure
    assert changed(**{role: [1, 0] for role in ACTORS}).verdict == "contradicted"


def test_without_its_model_an_actor_cannot_be_told() -> None:
    flights = [flown(role, 0) for role in ACTORS]
    with pytest.raises(CannotTellError, match="algo iql"):
        no_communication(evidence(*flights[:-1], state_noise=noise()))
    with pytest.raises(CannotTellError, match="needs the trained model of IQL"):
        no_communication(evidence(*flights, state_noise=noise().drop(columns="iql")))
    with pytest.raises(CannotTellError, match="it was not kept"):
        no_communication(evidence(*flights, state_noise="needs the trained model of IQL: it was not kept"))


def hovered(mean_mbps: float, *own: pd.DataFrame, seeking_mbps: float = 44.5) -> Finding:
    """200 missions at the mean +- 1 Mbps: three errors of the difference to 200 others are 3 sqrt(2 / 200) = 0.3."""
    rows = [flown("hover", 0, rate_mbps=[mean - 1, mean + 1] * 100) for mean in (mean_mbps, seeking_mbps)]
    for seeks, own_rows in enumerate(rows):
        own_rows["seeks"] = seeks
    return iql_rate_artefact(evidence(*own, hovering=pd.concat(rows)))


def test_hovering_explains_the_printed_rate_if_it_gives_it() -> None:
    found = hovered(44.2)  # the paper prints 44.46
    assert found.verdict == "reproduced"
    assert found.figure.startswith("R̂ 44.2 ± 0.1 Mbps (one standard error; paper 44.46) where 25.6 % of the UAVs fly")
    assert found.why.endswith("it does; UAVs that look for the best link and loads nearby do come to it.")
    short = hovered(44.1, seeking_mbps=40.0)
    assert short.verdict == "contradicted"
    assert "40.0 ± 0.1 Mbps where they first seek the best voxel within one slot; J̄ 0.00 and 0.00 (paper -1.96)" in (
        short.figure
    )
    assert short.why.endswith(
        "it is 0.4 Mbps off; UAVs that look for the best link and loads nearby do not come to it."
    )


@pytest.mark.parametrize(
    ("rate", "arrived", "told"),
    [
        (37.0, True, "; our own IQL does not show it: R̂ 37.0 Mbps, success 100.0 %."),
        (50.0, False, "; our own IQL shows the rate: R̂ 50.0 Mbps, success 0.0 %."),
    ],
)
def test_whether_our_own_runs_show_the_rate_is_told_and_decides_nothing(rate: float, arrived: bool, told: str) -> None:
    found = hovered(44.2, flown_by_seed("iql", rate_mbps=[[rate]] * 2, arrived=[[arrived]] * 2))
    assert found.verdict == "reproduced"
    assert found.why.endswith(told)
