"""Claims that are held to flights of their own: what an actor reads, and what hovering gives."""

from lawn_sb3.paper.claims.claim import Condition, Finding, claim
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import combine, holds_if
from lawn_sb3.paper.printed_values import TABLE_II
from lawn_sb3.paper.roles import FORMS
from lawn_sb3.paper.standard_error import RULED_OUT_Z, standard_error


@claim(
    place=495,
    section="IV-B, V-A, Algorithm 1",
    text="At execution each UAV acts on its local observation, with no critic and no communication.",
    measure="actions that change when the global state is replaced by noise, trained models of one seed",
    headline=True,
    owed_to="by construction",
)
def no_communication(evidence: Evidence) -> Finding:
    """Whether trained actors act on o_i alone: with noise for the global state the actions must not change."""
    figures, actions = [], 0
    held: list[Condition] = []
    for role in (*FORMS, "qmix", "iql"):
        key, draws = evidence.key(role), evidence.check("state_noise")
        if key not in draws:
            raise CannotTellError(f"needs the trained model of {evidence.label(role)}")
        changed, actions = int(draws[key].sum()), int(draws["actions"].sum())
        figures.append(f"{evidence.label(role)}: {changed:,}")
        held.append(holds_if(changed == 0))
    return Finding(
        combine(held),
        f"actions changed by noise in x, of {actions:,} each: {'; '.join(figures)}",
        "No action may change. That o_i itself holds the loads {n_b} of all cells, which the GBSs would have to "
        "broadcast, is not counted as communication here.",
    )


@claim(
    place=720,
    section="V-B",
    text="IQL's rate of 44.5 Mbps is an artefact of UAVs that hover near their start close to lightly loaded GBSs.",
    measure="corrected rate where the printed share of UAVs flies straight and all others hover where they start, "
    "within three standard errors; beside it that of UAVs which seek, within one slot of their start, the voxel where "
    "the link and the loads seen there promise most, and J̄ of both",
)
def iql_rate_artefact(evidence: Evidence) -> Finding:
    """Whether UAVs that hover at their start have the printed rate; our own IQL is told beside, and decides nothing."""
    printed = TABLE_II["IQL"]
    rows = evidence.check("hovering")
    stays, seeks = (rows[rows["seeks"] == seeks].groupby("episode")["rate_mbps"].mean() for seeks in (0, 1))
    rewards = rows.groupby("seeks")["reward"].mean()
    error, seek_error = standard_error(stays), standard_error(seeks)
    away = float(stays.mean()) - printed.rate_mbps
    explained = abs(away) <= RULED_OUT_Z * error
    sought = abs(float(seeks.mean()) - printed.rate_mbps) <= RULED_OUT_Z * seek_error
    return Finding(
        combine([holds_if(explained)]),
        f"R̂ {stays.mean():.1f} ± {error:.1f} Mbps (one standard error; paper {printed.rate_mbps:g}) where "
        f"{printed.success_percent:g} % of the UAVs fly straight, and all others hover where they start; "
        f"{seeks.mean():.1f} ± {seek_error:.1f} Mbps where they first seek the best voxel within one slot; J̄ "
        f"{rewards[0]:.2f} and {rewards[1]:.2f} (paper {printed.reward:g})",
        "Hovering near the start, without deliberate optimisation, has to give the printed rate, within three standard "
        f"errors: {'it does' if explained else f'it is {abs(away):.1f} Mbps off'}; UAVs that look for the best link "
        f"and loads nearby {'do' if sought else 'do not'} come to it"
        + _own_rate(evidence, printed.rate_mbps - RULED_OUT_Z * error),
    )


def _own_rate(evidence: Evidence, at_least_mbps: float) -> str:
    """End of a sentence: whether our own runs of IQL show the rate that is explained."""
    if "iql" not in evidence.roles:
        return "."
    rate, success = (float(evidence.scores("iql", name).mean()) for name in ("rate_mbps", "success_percent"))
    shown = "shows the rate" if rate >= at_least_mbps else "does not show it"
    return f"; our own {evidence.label('iql')} {shown}: R̂ {rate:.1f} Mbps, success {success:.1f} %."
