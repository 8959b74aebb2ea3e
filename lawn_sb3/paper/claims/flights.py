"""Claims that are held to flights of their own: what an actor reads, and what hovering gives."""

from lawn_sb3.paper.claims.claim import Finding, claim
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import combine
from lawn_sb3.paper.printed_values import TABLE_II
from lawn_sb3.paper.roles import FORMS
from lawn_sb3.paper.standard_error import RULED_OUT_Z, standard_error


@claim(
    place=495,
    section="IV-B, V-A, Algorithm 1",
    text="At execution each UAV acts on its local observation, with no critic and no communication.",
    measure="actions that change when the global state is replaced by noise, trained models of one seed; holds by "
    "construction",
    headline=True,
)
def no_communication(evidence: Evidence) -> Finding:
    """Whether trained actors act on o_i alone: with noise for the global state the actions must not change."""
    figures, held, actions = [], [], 0
    for role in (*FORMS, "qmix", "iql"):
        key, draws = evidence.key(role), evidence.check("state_noise")
        if key not in draws:
            raise CannotTellError(f"needs the trained model of {evidence.label(role)}")
        changed, actions = int(draws[key].sum()), int(draws["actions"].sum())
        figures.append(f"{evidence.label(role)}: {changed:,}")
        held.append(changed == 0)
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
    measure="corrected rate where the printed share of UAVs flies straight and all others hover within one slot of "
    "their origin, where the link and the loads seen at the start promise most; three standard errors",
)
def iql_rate_artefact(evidence: Evidence) -> Finding:
    """Whether UAVs that hover can have the printed rate; what our own IQL has is told beside, and decides nothing."""
    printed = TABLE_II["IQL"]
    rates = evidence.check("hovering").groupby("episode")["rate_mbps"].mean()
    error = standard_error(rates)
    short = printed.rate_mbps - float(rates.mean())
    explained = short <= RULED_OUT_Z * error
    return Finding(
        "reproduced" if explained else "not reproduced",
        f"R̂ {rates.mean():.1f} ± {error:.1f} Mbps (one standard error; paper {printed.rate_mbps:g}) where "
        f"{printed.success_percent:g} % of the UAVs fly straight, and all others hover within one slot of their "
        "origin, where link and loads, as seen at the start, promise most",
        "Hovering near the start has to give the printed rate, within three standard errors: "
        + ("it can, so the explanation is possible" if explained else f"it falls short by {short:.1f} Mbps")
        + _own_rate(evidence, printed.rate_mbps - RULED_OUT_Z * error),
    )


def _own_rate(evidence: Evidence, at_least_mbps: float) -> str:
    """End of a sentence: whether our own runs of IQL show the rate that is explained."""
    if "iql" not in evidence.roles:
        return "."
    rate, success = (float(evidence.scores("iql", name).mean()) for name in ("rate_mbps", "success_percent"))
    shown = "shows the rate" if rate >= at_least_mbps else "does not show it"
    return f"; our own {evidence.label('iql')} {shown}: R̂ {rate:.1f} Mbps, success {success:.1f} %."
