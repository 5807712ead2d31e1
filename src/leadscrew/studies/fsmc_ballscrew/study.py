"""The study ``fsmc_ballscrew``: three sliding-mode controllers of a ball-screw stage, judged by the double ball bar."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.runs import build
from leadscrew.studies.fsmc_ballscrew.scenarios import SCENARIOS
from leadscrew.studies.study import Study, StudyResult


def evaluate(progress: Callable[[str, float], None] = lambda what, done: None) -> StudyResult:
    """Runs every loop that the claims and figures need, and judges the claims."""
    from leadscrew.studies.fsmc_ballscrew.claims import topics
    from leadscrew.studies.fsmc_ballscrew.findings import findings
    from leadscrew.studies.fsmc_ballscrew.pictures import all_pictures
    from leadscrew.studies.fsmc_ballscrew.results import Results

    found = Results()
    judged = topics(found, progress)
    progress("figures", 1.0)
    return StudyResult.of(judged, all_pictures(found), found.loops.runs, findings)


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
    evaluate=evaluate,
    folder=Path(__file__).parent,
    summary=(
        "Conventional, complementary and fuzzy sliding mode against friction a thousand times the inertia: the order "
        "of the three is reproduced, in continuous time; the printed gains ask for 200 kHz, and at 4 kHz a scheduled "
        "PD with a disturbance observer beats all three."
    ),
)
