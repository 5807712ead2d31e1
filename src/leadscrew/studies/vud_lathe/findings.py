"""What the study found, in words around the numbers that it measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from leadscrew.controllers.vud.universe import TABLE_2
from leadscrew.fuzzy.learning import LearnedRules
from leadscrew.report.claim import Claim
from leadscrew.studies.vud_lathe.accuracy import DRAWS
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
        f"Sensor or controller: on {DRAWS} drawn axes at -170 mm the old controller's error after 2 s is "
        f"{measured['spread_original_encoder_m170']:.1f} um behind the encoder and "
        f"{measured['spread_original_grating_m170']:.1f} um on the grating (95 % below); the new one's "
        f"{measured['spread_beta_e_encoder_m170']:.1f} um and {measured['spread_beta_e_grating_m170']:.2f} um. Neither "
        f"the sensor nor the controller reaches 2 um alone; with both, so does a plain PD "
        f"({measured['spread_pd_grating_m170']:.2f} um).",
        f"The shortest possible time to within 2 um is {measured['bound_linear_m50']:.3f} and "
        f"{measured['bound_linear_m170']:.3f} s. Behind an observer that undoes the lags, with Table 2 as printed, "
        f"ours.vud_fast needs {measured['fast_2um_m50']:.3f} and {measured['fast_2um_m170']:.3f} s; constant universes "
        f"in its place {measured['fast_constant_m50']:.3f} and {measured['fast_constant_m170']:.3f} s: the speed is "
        "the observer's.",
        f"With 7.5 A, 258.7 mm/s and a PWM of 1,000 counts the corrected law stops "
        f"{measured['limited_vud_beta_e_error_m50']:.1f} and {measured['limited_vud_beta_e_error_m170']:.1f} um short: "
        "where it asks for less than half a count, the motor stands.",
        f"The paper's +-2 um is what is left after 2 s at two targets, each approached once from one side. By ISO 230-2"
        f" the simulated axis has a bidirectional accuracy of {measured['iso_a_encoder']:.1f} um behind the encoder "
        f"and {measured['iso_a_grating']:.2f} um on the grating.",
    ]
