"""The study ``npid_xytable``: nonlinear PID of an XY table under cutting forces, its stability, its harmonics."""

from __future__ import annotations

from pathlib import Path

from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
from leadscrew.studies.npid_xytable.scenarios import SCENARIOS, build
from leadscrew.studies.results import contents_of
from leadscrew.study_data import Assumption, Study

ASSUMED = (
    Assumption(
        "unit of the error inside the gain",
        "µm in the corrected columns, mm in the printed ones",
        "The paper gives no unit of α and e_max. Its plant is in mm, where the gain never leaves 1; with µm Table I's "
        "e_max is about the following error at 1 mm.",
    ),
    Assumption(
        "where e_max clips",
        "inside the gain only",
        "Read to the letter the error itself is clipped; with e in µm the axis then loses a sine of 2 mm.",
    ),
    Assumption(
        "sampling",
        "2 kHz, backward difference, integral by sums",
        "The paper gives no discrete form. Kp / Ki of 1600 s would make sense as a gain a sample at 2 kHz.",
    ),
    Assumption(
        "dead time",
        "0.775 ms sampled (loop L*), 1.2888 ms in continuous time",
        "Solved for, so that the plot crosses at −0.4. The printed plant never crosses the negative real axis.",
    ),
    Assumption(
        "motion",
        "a sine of 0.7 Hz and 1 mm",
        "The lines of Table II are the odd multiples of 0.70 Hz. The amplitude is ours.",
    ),
    Assumption(
        "forces",
        "five lines, 0.3 to 1.8 mV at the plant's input",
        "Calibrated so that Table I's PID has its column of Table II; their phases are random.",
    ),
    Assumption(
        "phases of the scenarios `fitted_*`",
        "fifteen phases and an amplitude of 0.4212 mm",
        "Fitted to the NPID column by least squares from many starts.",
    ),
    Assumption(
        "spindle",
        "1 mV of runout, 2 mV at two teeth (four where its speed is swept)",
        "The paper names spindle speeds and neither cutter nor forces.",
    ),
    Assumption(
        "encoder",
        "0.5 µm with 0.1 µm of noise",
        "The paper names no sensor; its amplitudes have 0.1 nm as their last digit.",
    ),
    Assumption(
        "friction",
        "LuGre, 2.6, 20 and 150 mV with 2, 5 and 10 µm of presliding",
        "The paper names friction and gives no number: what Table II would need, little, and what is usual.",
    ),
    Assumption("amplifier", "±10 V", "Where a loop is unstable its limit decides on the size of the error."),
    Assumption(
        "dead zone of the drive",
        "20 mV of every output",
        "The paper recommends a compensator and names no dead zone.",
    ),
    Assumption(
        "robustness box",
        "gain and damping ±20 %, dead time 0.70 and 0.85 ms",
        "Usual doubts about an identified axis.",
    ),
)

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
    folder=Path(__file__).parent,
    contents=contents_of(*(f"leadscrew.studies.npid_xytable.{part}" for part in ("claims", "experiments", "figures"))),
    summary=(
        "A gain that grows with the error: with the error in mm, as printed, it never leaves 1; in µm it reduces "
        "the harmonics and chatters, because the slope of its curve, not its gain, decides on stability. A linear PID "
        "with integral action leaves less at the lines of Table II, and tuned by the same search it is the law to "
        "take where the drive may be as active at work."
    ),
    card=("mean_reduction", "adjusts_its_gain", "popov_from_zero"),
    assumed=ASSUMED,
    method=(
        "The axis is (1), exact for a voltage held over 0.5 ms, with a dead time. Forces act at its input as five "
        "lines at the odd harmonics of the motion, sized so that Table I's PID has the amplitudes of Table II. Errors "
        "are those of the true position; their amplitudes are fitted by least squares to the last 10 s of 20 s.",
        "Printed columns have the error in mm inside the gain and no dead time. Notes say what a corrected column "
        "changes: the unit of that error, or a dead time.",
    ),
    limits=(
        "All results are for a simulated linear axis. Nothing here is evidence about the authors' machine.",
        "The PID column is calibrated and cannot be tested; what NPID makes of it depends on the phases of the forces "
        "and on the amplitude of the motion, which the paper does not give.",
        "A mode of the screw can make a loop unstable that reads a scale at the table: see the mode of the screw.",
        "Proofs hold for the sampled linear axis and its dead time, each plant of the box by itself.",
    ),
)
