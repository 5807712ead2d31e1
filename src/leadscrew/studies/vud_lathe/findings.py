"""What the study found, in words around the numbers that it measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from leadscrew.controllers.vud.universe import TABLE_2
from leadscrew.fuzzy.learning import LearnedRules
from leadscrew.report.claim import Claim
from leadscrew.studies.vud_lathe.runs import STEPS


def findings(claims: Sequence[Claim], runs: Mapping[str, Any], rules: LearnedRules) -> list[str]:
    """The findings for the report, one sentence or two each."""
    measured = {c.id.removeprefix("vud_lathe."): c.measured for c in claims}
    missing = TABLE_2.size - rules.covered
    misfits = sorted(float(v) for k, v in measured.items() if k.startswith("gain_fit_") and v is not None)
    long, short = misfits[:2], misfits[2:]
    ours, vud = ([runs[f"{s}/{c}"].metrics["settling_2um"] for s in STEPS] for c in ("ours.pd", "corrected.vud_beta_e"))
    errors = [1000.0 * runs[f"{s}/ours.pd"].metrics["error_after_2s"] for s in STEPS]
    lost = [f"{rules.say(c.winner)} beats {rules.say(c.losers[0])}" for c in rules.conflicts.values()]
    return [
        f"Taken literally, (21) creeps at {measured['printed_creep']:.2f} mm/s: the paper's moves do not follow from "
        "it. Changing (19) alone gives them.",
        f"{missing} of the {TABLE_2.size} rules of Table 2 are not in Table 1. The half of the table that brakes a "
        "growing error is expert knowledge.",
        f"A plain PD on the same grating is within 2 um after {ours[0]:.2f} and {ours[1]:.2f} s, where the corrected "
        f"VUD needs {vud[0]:.2f} and {vud[1]:.2f} s; its error then stays within {max(errors):.2f} um. On this plant, "
        "which has no friction, nothing here needs a fuzzy controller.",
        f"The plant is rebuilt from Table 1. One linear gain fits the long moves to {max(long):.1f} % and the short "
        f"ones to {max(short):.1f} %.",
        "Rules in conflict: " + "; ".join(lost) + ".",
    ]
