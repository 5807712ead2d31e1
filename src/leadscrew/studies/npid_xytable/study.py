"""The study ``npid_xytable``: nonlinear PID of an XY table under cutting forces, its stability, its harmonics."""

from __future__ import annotations

from pathlib import Path

from leadscrew.studies.evaluating import evaluation_of
from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
from leadscrew.studies.npid_xytable.runs import build
from leadscrew.studies.npid_xytable.scenarios import SCENARIOS
from leadscrew.studies.study import Study

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
    evaluate=evaluation_of("npid_xytable"),
    folder=Path(__file__).parent,
    summary=(
        "A gain that grows with the error: with the error in mm, as printed, it never leaves 1; in um it cuts the "
        "harmonics by half and chatters, because the slope of its curve, not its gain, decides on stability. A linear "
        "PID with integral action beats it on all fifteen rows of Table II."
    ),
)
