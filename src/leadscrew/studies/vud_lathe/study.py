"""The study ``vud_lathe``: fuzzy positioning of a lathe's X axis on a variable universe of discourse."""

from __future__ import annotations

from pathlib import Path

from leadscrew.studies.results import contents_of
from leadscrew.studies.vud_lathe.controllers import CONTROLLERS
from leadscrew.studies.vud_lathe.scenarios import SCENARIOS, build
from leadscrew.study_data import Assumption, Study

ASSUMED = (
    Assumption(
        "factor (19) of `corrected.vud_beta_e`",
        "1.5 (|e|^0.6 + 0.0001) in place of |ρ|^0.9 + 0.0001",
        "The printed factor creeps. Gain and exponent are the best of a search over 600 pairs on this plant; many "
        "pairs of that grid meet 2 µm.",
    ),
    Assumption(
        "gain of the axis",
        "289 mm/s at full duty",
        "The paper prints no speed. Output-error fit of the four moves of Table 1 with the lags (2) and (3); one "
        "by one the moves ask for 286 to 341 mm/s.",
    ),
    Assumption(
        "law of the original servo",
        "duty = −sgn(e) 0.929 |e|^0.618",
        "The paper prints its moves and no equation. The two constants are fitted to the errors of Table 1; its "
        "duties were left out and judge the fit.",
    ),
    Assumption(
        "rules that Table 1 does not give",
        "symmetry, monotony, and one level more where the error grows",
        "Chosen so that the completion gives Table 2. Table 1 covers 8 of its 36 cells; the damping half of the "
        "table is expert knowledge.",
    ),
    Assumption(
        "screw of the axis",
        "12 µm in 300 mm (ISO 3408 grade 3), play up to 6 µm, up to 3 K too warm",
        "The paper gives no screw. With this grade 95 % of the axes are within the 10 µm that the paper says of "
        "it; with grades 5 and 7 it is not.",
    ),
    Assumption(
        "grating ruler",
        "0.15 and 0.08 µm of residual interpolation error, 50 nm of noise",
        "Usual values of an adjusted ruler. Its scale, Abbe and mounting errors are left out.",
    ),
    Assumption(
        "unit of ec",
        "25.87 mm in 0.1 s",
        "Printed as mm/s. The ways of Table 1 fit the sums of its ec only if 25.87 mm is the change in 0.1 s.",
    ),
    Assumption(
        "sign of ec in Table 1", "turned for r = 50 and r = 190", "Printed positive there, while the error falls."
    ),
    Assumption(
        "limits of the motor",
        "7.5 A, 258.7 mm/s, a PWM of 1,000 counts",
        "Current and speed are the paper's numbers; where they act, and the resolution of the PWM, are chosen.",
    ),
)

STUDY = Study(
    name="vud_lathe",
    title="Positioning of a lathe axis by fuzzy control on a variable universe of discourse",
    paper=(
        "Z. Long, Y. Yuan, Y. Xu, S. Du: High-accuracy positioning of lathe servo system using fuzzy controllers based "
        "on variable universe of discourse. International Journal on Smart Sensing and Intelligent Systems 7 (2014)."
    ),
    controllers=CONTROLLERS,
    scenarios=SCENARIOS,
    build=build,
    folder=Path(__file__).parent,
    contents=contents_of(*(f"leadscrew.studies.vud_lathe.{part}" for part in ("claims", "experiments", "figures"))),
    summary=(
        "Rules from four moves of the old servo, contracted universes, a grating ruler: -50 and -170 mm within 2 um. "
        "The rules can be rebuilt, the printed law creeps, one changed equation meets every number, and the accuracy "
        "is the grating's."
    ),
    record=("controller.e", "controller.ec", "controller.alpha_e", "controller.alpha_ec", "controller.beta", "plant"),
    assumed=ASSUMED,
    method=(
        "The axis is the chain (2) and (3) with an integrator whose gain is fitted to Table 1, and the grating reader "
        "(4), both exact for a duty held over the 1 ms of a period. Positions are counted in 0.625 µm (grating) or "
        "1 µm (encoder). Errors are those of the true position, not of the count.",
        "Printed columns follow the paper's equations and numbers to the letter. Notes say what a corrected column "
        "changes; of the controller it is (19): its input, exponent and gain.",
    ),
    limits=(
        "All results are for a simulated axis. Nothing here is evidence about the authors' machine.",
        "With a PWM of 1,000 counts the corrected law stops short and misses the 2 µm: see the shortest times.",
        "The plant has no friction; experiments with a dead zone show what friction would cost.",
        "One linear gain fits the long moves of Table 1 well and the short ones badly: see the gain of the axis.",
    ),
)
