"""The study ``vud_lathe``: fuzzy positioning of a lathe's X axis on a variable universe of discourse."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from leadscrew.studies.study import Study, StudyResult
from leadscrew.studies.vud_lathe.controllers import CONTROLLERS
from leadscrew.studies.vud_lathe.runs import build
from leadscrew.studies.vud_lathe.scenarios import SCENARIOS

RUNNING = 0.4
"""Share of the time that the runs take, before the claims are judged."""


def evaluate(progress: Callable[[str, float], None] = lambda what, done: None) -> StudyResult:
    """Runs every loop that the claims and figures need, and judges the claims."""
    from leadscrew.studies.vud_lathe.claims import topics
    from leadscrew.studies.vud_lathe.findings import findings
    from leadscrew.studies.vud_lathe.pictures import all_pictures
    from leadscrew.studies.vud_lathe.results import results
    from leadscrew.studies.vud_lathe.rules import learn

    found = results(lambda what, done: progress(what, RUNNING * done))
    judged = topics(found, lambda what, done: progress(what, RUNNING + (1.0 - RUNNING) * done))
    progress("figures", 1.0)
    return StudyResult.of(
        judged, all_pictures(found), found.runs, lambda claims: findings(claims, found.runs, learn(found.moves))
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
    evaluate=evaluate,
    folder=Path(__file__).parent,
    summary=(
        "Rules from four moves of the old servo, contracted universes, a grating ruler: -50 and -170 mm within 2 um. "
        "The rules can be rebuilt, the printed law creeps, one changed equation meets every number, and the accuracy "
        "is the grating's."
    ),
)
