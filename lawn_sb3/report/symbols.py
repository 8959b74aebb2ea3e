"""The paper's symbols of the scenario's constants, as text and in LaTeX."""

from typing import NamedTuple

from lawn_sb3.report.table import latex_text


class Symbol(NamedTuple):
    """A symbol in both forms."""

    text: str
    latex: str


NO_SYMBOL = "–"
SYMBOLS = {
    "-": (NO_SYMBOL, "--"),
    "N": ("N", "$N$"),
    "W": ("W", "$W$"),
    "L": ("L", "$L$"),
    "M": ("M", "$M$"),
    "Delta_s": ("Δ_s", r"$\Delta_s$"),
    "h_min": ("h_min", r"$h_{\min}$"),
    "h_max": ("h_max", r"$h_{\max}$"),
    "v_max": ("v_max", r"$v_{\max}$"),
    "T_max": ("T_max", r"$T_{\max}$"),
    "g_b": ("g_b", r"$\mathbf{g}_b$"),
    "K_b": ("K_b", "$K_b$"),
    "Delta f": ("Δf", r"$\Delta f$"),
    "alpha": ("α", r"$\alpha$"),
    "P_tx": ("P_tx", r"$P_{\mathrm{tx}}$"),
    "beta_0": ("β_0", r"$\beta_0$"),
    "sigma^2": ("σ²", r"$\sigma^2$"),
    "beta": ("β", r"$\beta$"),
    "omega": ("ω", r"$\omega$"),
    "rho_col": ("ρ_col", r"$\rho_{\mathrm{col}}$"),
    "r_fail": ("r_fail", r"$r_{\mathrm{fail}}$"),
    "T-bar": ("T̄", r"$\bar{T}$"),
}
"""Symbols of the scenario's fields: as text and in LaTeX."""


def symbol_of(name: str) -> Symbol:
    """The symbol of a constant, by the name that its field gives it."""
    return Symbol(*SYMBOLS.get(name, (name, latex_text(name))))
