"""Claims about the first mode of the screw: who stays stable on it, what a notch is worth; simulation agrees."""

from __future__ import annotations

import math
from collections.abc import Iterator

from leadscrew.controllers.pid import pid
from leadscrew.plants.xy_table_two_mass import XYTableTwoMassParams
from leadscrew.report.claim import Claim
from leadscrew.studies.npid_xytable.calibration import PERIOD_S
from leadscrew.studies.npid_xytable.runs import Loops
from leadscrew.studies.npid_xytable.saying import said, word
from leadscrew.studies.npid_xytable.two_mass import (
    LINEAR,
    MODES_HZ,
    NPID_SLOPE,
    SIMULATED_S,
    USUAL,
    TwoMassMap,
    judged,
)

SOURCE = "equation (1)"
CLEAR = 5.0
"""Grown or faded by e^5 and more in the simulated time: no doubt what a simulation has to show."""
FAR_UM = 20.0
"""No stable loop of these has a larger error."""


def two_mass_claims(loops: Loops, found: TwoMassMap | None = None) -> list[Claim]:
    """All of them; ``found`` keeps what pictures need too."""
    found = found or TwoMassMap(loops)
    return [*_rigid(), *_stability(found), *_notch(found), *_npid(), *_simulation(found)]


def _rigid() -> Iterator[Claim]:
    stiff = judged(pid, XYTableTwoMassParams(mode_hz=2e4, mode_damping=0.5))
    yield said(
        "mode_rigid_limit", SOURCE, "Ms of Table I's PID on two masses with a mode at 20 kHz", stiff.ms, "", 1.87,
        "equation (1) on one mass: 1.87 in L*", tolerance=0.005,
    )  # fmt: skip


def _side(at_table: bool) -> str:
    return "table" if at_table else "motor"


def _stability(found: TwoMassMap) -> Iterator[Claim]:
    for name in LINEAR:
        for at_table in (True, False):
            cells = {hz: found.cells[name, at_table, hz].plain for hz in MODES_HZ[:USUAL]}
            stable = [hz for hz, cell in cells.items() if cell.stable]
            listed = ", ".join(
                f"{hz:g} Hz {cell.ms:.2f}" if cell.stable else f"{hz:g} Hz -" for hz, cell in cells.items()
            )
            yield said(
                f"mode_stable_{name.split('.')[-1]}_{_side(at_table)}", SOURCE, f"modes of 40 to 150 Hz on which "
                f"{name} is "
                f"stable, feedback from the {_side(at_table)}, of {USUAL}", len(stable), "", None,
                f"Ms (- unstable): {listed}; half of the mass at the table, 3 % of damping", kind="report",
            )  # fmt: skip
    alone = [found.cells[name, True, hz].plain.stable for name in LINEAR for hz in MODES_HZ[:USUAL]]
    yield said(
        "mode_scale_needs_more", SOURCE, "cases of four PIDs (Table I, 2.265 times it, Ms 1.59, Ms 1.85) that are "
        "stable with a scale at the table on a mode of 40 to 150 Hz, no notch", sum(alone), "", 0, "the margins of a "
        "rigid axis say nothing here: every tuning was made on equation (1), which has no mode",
    )  # fmt: skip


def _notch(found: TwoMassMap) -> Iterator[Claim]:
    for at_table in (True, False):
        rows = {hz: found.speeds[at_table, hz] for hz in MODES_HZ[:USUAL]}
        better = [hz for hz, (without, behind) in rows.items() if behind > without]
        listed = ", ".join(f"{hz:g} Hz {a:.2f} / {b:.2f}" for hz, (a, b) in rows.items())
        yield said(
            f"mode_notch_helps_{_side(at_table)}", SOURCE, f"modes of 40 to 150 Hz on which a notch lets "
            "ours.pid_ms_159 be "
            f"faster within Ms 2, feedback from the {_side(at_table)}, of {USUAL}", len(better), "", None,
            f"share of its speed without / with the notch (half the mode wide, 0.1 deep): {listed}", kind="report",
        )  # fmt: skip
    gains = [found.speeds[True, hz] for hz in MODES_HZ[:USUAL]]
    yield said(
        "mode_notch_gain_table", SOURCE, "least gain of speed by the notch, scale at the table", min(b / a for a,
        b in gains),
        "", 1.1, f"up to {max(b / a for a, b in gains):.2f}-fold; a mode at 40 Hz still leaves {gains[0][1]:.2f} of "
        "the "
        "speed", sense=">=",
    )  # fmt: skip
    low = found.speeds[False, MODES_HZ[0]]
    yield said(
        "mode_notch_harms_motor", SOURCE, "a notch at 40 Hz makes the loop with a motor encoder slower",
        word(low[1] < low[0]),
        "", "yes", f"share of speed {low[0]:.2f} without, {low[1]:.2f} with it: seen from the motor the mode keeps its "
        "phase, and the notch only adds lag", sense="yes/no",
    )  # fmt: skip


def _npid() -> Iterator[Claim]:
    for hz in (60.0, 100.0, 150.0):
        axis = XYTableTwoMassParams(mode_hz=hz, at_table=False)
        low, high = 1.0, NPID_SLOPE
        for _ in range(20):
            middle = 0.5 * (low + high)
            gained = pid(**{key: middle * getattr(pid.params, key) for key in ("kp", "ki", "kd")})
            low, high = (middle, high) if judged(gained, axis).stable else (low, middle)
        yield said(
            f"mode_npid_slope_{hz:g}", SOURCE, f"largest local gain under which NPID's PID is stable, mode of {hz:g} "
            "Hz seen "
            "from the motor", low, "", None, f"its slope goes up to {NPID_SLOPE:.2f}; 2.51 on the rigid axis: chatter "
            "starts at smaller errors", kind="report",
        )  # fmt: skip


def _simulation(found: TwoMassMap) -> Iterator[Claim]:
    right = clear = 0
    for key, rms in found.simulated.items():
        radius = found.cells[key].plain.radius
        if abs(math.log(radius)) * SIMULATED_S / PERIOD_S > CLEAR or radius < 1.0:
            clear += 1
            right += (rms < FAR_UM) == (radius < 1.0)
    yield said(
        "mode_simulation_agrees", SOURCE, "loops on two masses whose simulation is what the closed-loop poles say",
        right, "",
        clear, f"of {len(found.simulated)} under the lines of 1,000 1/min with the amplifier's limit, 25 us steps; "
        "left out "
        "are those that need more than 10 s to show it",
    )  # fmt: skip
    plain = [found.simulated[n, False, 100.0] for n in ("ours.pid_ms_159", "ours.pid_ms_185")]
    yield said(
        "mode_error_unchanged", SOURCE, "rms error of ours.pid_ms_185 on a mode of 100 Hz seen from the motor",
        plain[1], "um",
        None, f"without following error; ours.pid_ms_159 {plain[0]:.3f} um: where the loop is stable, a mode does "
        "not change "
        "the errors at 2 to 8 Hz", kind="report",
    )  # fmt: skip
