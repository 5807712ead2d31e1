"""The study ``fsmc_ballscrew``: three sliding-mode controllers of a ball-screw stage, judged by the double ball bar."""

from __future__ import annotations

from pathlib import Path

from leadscrew.studies.evaluating import evaluation_of
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.runs import build
from leadscrew.studies.fsmc_ballscrew.scenarios import SCENARIOS
from leadscrew.studies.study import Study

STUDY = Study(
    name="fsmc_ballscrew",
    title="Sliding-mode control of a ball-screw stage with LuGre friction, judged by the double ball bar",
    paper=(
        "M. Shams, M. Safdari: Fuzzy Sliding Mode Control of a Ball Screw Driven Stage. In: F. Casolo (ed.), Motion "
        "Control, InTech 2010, ISBN 978-953-7619-55-8."
    ),
    controllers=CONTROLLERS,
    scenarios=SCENARIOS,
    build=build,
    evaluate=evaluation_of("fsmc_ballscrew"),
    folder=Path(__file__).parent,
    summary=(
        "Conventional, complementary and fuzzy sliding mode against friction a thousand times the inertia: the order "
        "of the three is reproduced, in continuous time; the printed gains ask for 200 kHz, and at 4 kHz a scheduled "
        "PD with a disturbance observer beats all three."
    ),
)
