"""Fig. 3: the distribution of the utility over all UAVs."""

from lawn_sb3.paper.comparable import printed_rows
from lawn_sb3.report.cdf import distributions, panels_text
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.results.results import Results

XLABEL, YLABEL = "utility $U_i$ of a UAV (Mbps); 0 for a failed mission", "$F(u) = \\Pr(U_i \\leq u)$"


def section(results: Results) -> Section:
    """Fig. 3 of all methods; a line is all seeds together, its band their range."""
    figure = distributions(results, results.episodes, "utility_mbps", XLABEL, YLABEL)
    return Section("Fig. 3: utility", {"fig3_utility_cdf": Picture(figure, _caption(results))})


def _caption(results: Results) -> str:
    in_paper = printed_rows(results.recipe)
    return (
        "Share of the UAVs whose utility is at most u: all UAVs of all test episodes and seeds; bands: range over "
        f"seeds. {panels_text(results, results.episodes)}"
        + ("The paper shows this figure without numbers that could be marked here." if in_paper else "")
    ).strip()
