"""The study ``grey_turning``: constant cutting force in turning with a grey-prediction fuzzy controller."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from leadscrew.studies.grey_turning.controllers import CONTROLLERS
from leadscrew.studies.grey_turning.runs import build
from leadscrew.studies.grey_turning.scenarios import SCENARIOS
from leadscrew.studies.study import Study, StudyResult


def evaluate(progress: Callable[[str, float], None] = lambda what, done: None) -> StudyResult:
    """Runs every loop that the claims and figures need, and judges the claims."""
    from leadscrew.studies.grey_turning.claims import topics
    from leadscrew.studies.grey_turning.findings import findings
    from leadscrew.studies.grey_turning.pictures import all_pictures
    from leadscrew.studies.grey_turning.results import Results

    found = Results()
    judged = topics(found, progress)
    progress("figures", 1.0)
    return StudyResult.of(judged, all_pictures(found), found.loops.runs, findings)


STUDY = Study(
    name="grey_turning",
    title="Constant cutting force in turning with a grey-prediction fuzzy controller",
    paper=(
        "Grey-prediction fuzzy control of constant turning force on a retrofitted old lathe (OLRTS). The text that we "
        "have names no authors; equations (2) to (8), Table 1 and the figures are missing in it."
    ),
    controllers=CONTROLLERS,
    scenarios=SCENARIOS,
    build=build,
    evaluate=evaluate,
    folder=Path(__file__).parent,
    summary=(
        "A grey model of five samples predicts the force for a fuzzy controller. Near the set-point the model is a "
        "fixed filter and the controller a PI: prediction rescues factors that are badly scaled, and hardly a well "
        "tuned loop. A controller that inverts the power law of the cut and knows the programmed depth beats both."
    ),
)
