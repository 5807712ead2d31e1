"""What claims and pictures call laws and scenarios, and how a row about a sentence of the paper is made."""

from __future__ import annotations

import math
from collections.abc import Mapping

from leadscrew.report.claim import Claim, Group, Kind, Sense, Verdict

KEY = {
    "corrected.smc": "smc", "paper.smc": "smc_integral", "paper.csmc": "csmc", "corrected.fsmc": "fsmc",
    "paper.fsmc": "fsmc_printed",
}  # fmt: skip
SAID = {
    "corrected.smc": "conventional sliding mode", "paper.smc": "sliding mode with the printed integral surface",
    "paper.csmc": "complementary sliding mode", "corrected.fsmc": "fuzzy sliding mode, rules along s + s_c",
    "paper.fsmc": "fuzzy sliding mode, printed rules",
}  # fmt: skip
WAY = {
    "step_raw": "a bare step of 1 mm", "step_quintic": "1 mm in 50 ms", "sine_slow": "0.01 sin t mm",
    "sine_wide": "5 sin t mm", "sine_fast": "sin 2 pi t mm",
}  # fmt: skip
FIGURE = {
    "step_raw": "Figure 11", "step_quintic": "Figure 11", "sine_slow": "Figure 12", "sine_wide": "Figure 13",
    "sine_fast": "Figure 14",
}  # fmt: skip

GOOD: Mapping[str, Verdict] = {"as printed": "reproduced", "as corrected": "reproduced with change"}


def whose(law: str) -> Group:
    """The group of a law's claims."""
    return "as printed" if law.startswith("paper.") else "as corrected"


def near(target: float) -> float:
    """The digest's tolerance in um: 2 %, and 1 nm below 50 nm."""
    return 0.001 if target < 0.05 else 0.02 * target


UNSAID = "the paper prints no number and its figure is not in the text"


def unsaid(
    name: str,
    law: str,
    scenario: str,
    statement: str,
    measured: float | str,
    unit: str,
    target: float | str | None,
    tolerance: float = 0.0,
    sense: Sense = "=",
    reason: str = UNSAID,
    kind: Kind = "required",
) -> Claim:
    """A claim about a number that the paper does not give."""
    value = measured if isinstance(measured, str) else float(measured)
    return Claim(
        f"fsmc_ballscrew.{name}", FIGURE[scenario], whose(law), "printed plant", statement, None, value, unit, sense,
        target, tolerance, kind, "cannot be checked", reason,
    )  # fmt: skip


def said(
    name: str,
    source: str,
    group: Group,
    statement: str,
    paper: float | str,
    measured: float | str,
    unit: str,
    sense: Sense,
    target: float | str | None,
    tolerance: float,
    holds: bool,
    reason: str,
    kind: Kind = "required",
) -> Claim:
    """A claim about a sentence of the paper; ``holds``: whether the sentence does."""
    value = measured if isinstance(measured, str) else float(measured)
    return Claim(
        f"fsmc_ballscrew.paper_{name}", source, group, "printed plant", statement, paper, value, unit, sense, target,
        tolerance, kind, GOOD[group] if holds else "not reproduced", reason,
    )  # fmt: skip


def listed(values: Mapping[str, float], unit: str) -> str:
    """Values by name, for a reason."""
    return ", ".join(f"{name} {value:.3g}" for name, value in values.items()) + f" {unit}"


def worst_first(values: dict[str, float]) -> str:
    """The names in the order of their values, the largest first; a value that is not finite is the largest."""
    return " > ".join(sorted(values, key=lambda k: values[k] if math.isfinite(values[k]) else math.inf, reverse=True))
