"""The study ``npid_xytable``: nonlinear PID of an XY table under cutting forces, its stability, its harmonics."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
from leadscrew.studies.npid_xytable.runs import build
from leadscrew.studies.npid_xytable.scenarios import SCENARIOS
from leadscrew.studies.study import Study, StudyResult


def evaluate(progress: Callable[[str, float], None] = lambda what, done: None) -> StudyResult:
    """Runs every loop that the claims and figures need, and judges the claims."""
    from leadscrew.studies.npid_xytable.claims import topics
    from leadscrew.studies.npid_xytable.findings import findings
    from leadscrew.studies.npid_xytable.pictures import all_pictures
    from leadscrew.studies.npid_xytable.results import Results

    found = Results()
    judged = topics(found, progress)
    progress("figures", 1.0)
    return StudyResult.of(judged, all_pictures(found), found.loops.runs, findings)


STUDY = Study(
    name="npid_xytable",
    title="Nonlinear PID of an XY table under cutting forces, with its stability and its harmonics",
    paper=(
        "L. Abdullah, Z. Jamaludin, J. Jamaludin, M.R. Salleh, B. Abu Bakar, M.N. Maslan, T.H. Chiew, N.A. Rafan: "
        "Design and Analysis of Self-tuned Nonlinear PID Controller for XY Table Ballscrew Drive System. Universiti "
        "Teknikal Malaysia Melaka."
    ),
    controllers=CONTROLLERS,
    scenarios=SCENARIOS,
    build=build,
    evaluate=evaluate,
    folder=Path(__file__).parent,
    summary=(
        "A gain that grows with the error: with the error in mm, as printed, it never leaves 1; in um it cuts the "
        "harmonics by half and chatters, because the slope of its curve, not its gain, decides on stability. A linear "
        "PID with integral action beats it on all fifteen rows of Table II."
    ),
)
