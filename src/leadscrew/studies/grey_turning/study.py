"""The study ``grey_turning``: constant cutting force in turning with a grey-prediction fuzzy controller."""

from __future__ import annotations

from pathlib import Path

from leadscrew.studies.evaluating import evaluation_of
from leadscrew.studies.grey_turning.controllers import CONTROLLERS
from leadscrew.studies.grey_turning.runs import build
from leadscrew.studies.grey_turning.scenarios import SCENARIOS
from leadscrew.studies.study import Study

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
    evaluate=evaluation_of("grey_turning"),
    folder=Path(__file__).parent,
    summary=(
        "A grey model of five samples predicts the force for a fuzzy controller. Near the set-point the model is a "
        "fixed filter and the controller a PI: prediction rescues factors that are badly scaled, and hardly a well "
        "tuned loop. A controller that inverts the power law of the cut and knows the programmed depth beats both."
    ),
)
