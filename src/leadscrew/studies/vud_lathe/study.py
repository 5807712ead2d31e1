"""The study ``vud_lathe``: fuzzy positioning of a lathe's X axis on a variable universe of discourse."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from leadscrew.controllers.vud.universe import contraction
from leadscrew.studies.study import Study, StudyResult
from leadscrew.studies.vud_lathe.runs import CONTROLLERS, Loops, build, simulate, sweep_gain
from leadscrew.studies.vud_lathe.scenarios import SCENARIOS


def evaluate(progress: Callable[[str, float], None] = lambda what, done: None) -> StudyResult:
    """Runs every loop that the claims and figures need, and judges the claims."""
    from leadscrew.studies.vud_lathe.claims import all_claims
    from leadscrew.studies.vud_lathe.figures import pictures
    from leadscrew.studies.vud_lathe.findings import findings
    from leadscrew.studies.vud_lathe.rules import SETS, learn
    from leadscrew.studies.vud_lathe.tables import moves

    found = moves()
    loops = Loops()
    runs = simulate(progress, loops)
    sweep = sweep_gain("corrected.vud_beta_e", "fig11b_step_m170", loops)
    claims = all_claims(runs, sweep, found)
    example = tuple(SETS.contracted(contraction(x, 0.9, 1e-4, 1.0)) for x in (-0.25, 0.12))
    notes = findings(claims, runs, learn(found))
    return StudyResult(claims, pictures(runs, found, (example[0], example[1])), runs, notes)


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
    evaluate=evaluate,
    folder=Path(__file__).parent,
    summary=(
        "Rules from four moves of the old servo, contracted universes, a grating ruler: -50 and -170 mm within 2 um. "
        "The rules can be rebuilt, the printed law creeps, one changed equation meets every number."
    ),
)
