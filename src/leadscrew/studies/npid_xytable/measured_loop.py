"""What a log of the axis tells about its loop and its spindle: a swept command, and a speed that is not known."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.analysis.frequency_response import FrequencyResponse, loop_gain, measured_margins
from leadscrew.analysis.harmonics.measured import measure
from leadscrew.controllers.pid import pid
from leadscrew.plants.xy_table_cutting import xy_table_cutting
from leadscrew.references.chirp import log_chirp
from leadscrew.report.claim import Claim
from leadscrew.sensors.noisy_ruler import noisy_ruler
from leadscrew.studies.npid_xytable.calibration import BASE_HZ, ORDERS, PERIOD_S, responses
from leadscrew.studies.npid_xytable.runs import Loops
from leadscrew.studies.npid_xytable.saying import said

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SWEPT_S = 20.0
SEGMENT_S = 2.0
JUDGED_HZ = (10.0, 500.0)
"""Below, segments of 2 s leak; above, less and less comes back of the swept command."""
SHOWN_HZ = (2.0, 700.0)
GAIN_MARGIN, PHASE_MARGIN_DEG, MS = 2.510, 49.0, 1.87
"""Of L*, in the digest."""
SLIPS = (0.98, 1.02)
"""True spindle speed over the believed one."""


def measured_loop(loops: Loops) -> FrequencyResponse:
    """The gain of the broken loop L* under Table I's PID, from a swept command and an encoder of 0.5 um with noise."""
    from leadscrew.kernel.loop import Loop

    swept = (
        Loop(
            reference=log_chirp(amplitude=0.1, start_frequency=0.5, end_frequency=900.0, duration=SWEPT_S),
            controller=pid, plant=xy_table_cutting, sensor=noisy_ruler(resolution_mm=5e-4, noise_mm=1e-4),
            period=PERIOD_S, metrics={},
        )
    )  # fmt: skip
    run = swept.run(SWEPT_S, record=("command", "feedback"))
    command, feedback = run["command"], run["feedback"]
    return loop_gain(run.time, command - feedback, feedback, command, segment=SEGMENT_S).within(*SHOWN_HZ)


def exact(frequencies_hz: np.ndarray) -> np.ndarray:
    """The same in closed form: ``L = 1 / S - 1``."""
    return 1.0 / np.array([responses(float(f))[0] for f in frequencies_hz]) - 1.0


def measured_loop_claims(loops: Loops) -> Iterator[Claim]:
    """The loop from a log against the loop in closed form; the spindle's speed from the error alone."""
    found = measured_loop(loops)
    judged = found.within(*JUDGED_HZ)
    off = float(np.abs(judged.response / exact(judged.frequencies) - 1.0).max())
    m = measured_margins(found)
    how = (
        f"a swept command of 0.1 mm, {SWEPT_S:g} s, encoder of 0.5 um; coherence at least {judged.coherence.min():.4f} "
        f"from {JUDGED_HZ[0]:g} to {JUDGED_HZ[1]:g} Hz"
    )
    yield said(
        "measured_loop_off", "section II", "largest distance of the measured loop gain from the one in closed form",
        100.0 * off, "%", None, how, kind="report", group="as corrected",
    )  # fmt: skip
    for name, words, value, unit, target, tolerance in (
        ("gain_margin", "gain margin of the loop from a log", m.gain_margin, "", GAIN_MARGIN, 0.01 * GAIN_MARGIN),
        ("phase_margin", "phase margin of the loop from a log", m.phase_margin_deg, "deg", PHASE_MARGIN_DEG, 0.5),
        ("ms", "largest sensitivity of the loop from a log", m.sensitivity, "", MS, 0.02),
    ):
        yield said(
            f"measured_loop_{name}", "section II", words, float("nan") if value is None else value, unit, target,
            f"{how}; the dead time of 0.775 ms is in it", tolerance=tolerance, group="as corrected",
            paper=2.5 if name == "gain_margin" else None,
            verdict="reproduced with change" if name == "gain_margin" else "cannot be checked",
        )  # fmt: skip
    for slip in SLIPS:
        turning = slip * 1000.0
        run = loops.run(
            "paper.pid", "measured_1000", record=("true_error", "error"), changes={"plant.spindle_hz": turning / 60.0}
        )
        half = len(run.time) // 2
        lines = measure(run.time[half:], 1e3 * run["error"][half:], base=BASE_HZ, orders=ORDERS, spindle_rpm=1000.0,
                        teeth=2, fit_spindle=True)  # fmt: skip
        assert lines.spindle is not None
        low, high = (60.0 * f for f in lines.spindle.confidence())
        yield said(
            f"measured_spindle_{100.0 * slip:.0f}", "section III", f"spindle speed found in 10 s of error, believed "
            f"1000 1/min, truly {turning:g}", 60.0 * lines.spindle.frequency, "1/min", turning,
            f"95 % from {low:.3f} to {high:.3f} 1/min: runout and teeth of 1 and 2 mV tell it, read by an encoder of "
            "0.5 um", tolerance=0.1,
        )  # fmt: skip


def loop_figure(loops: Loops) -> Figure:
    """Gain and phase of the measured loop over those in closed form, with the coherence."""
    from leadscrew.report.frequency_response import picture
    from leadscrew.report.style import BLACK

    found = measured_loop(loops)
    figure = picture(found, "L*, from a swept command (solid) and in closed form (dotted)")
    known = exact(found.frequencies)
    gain, phase = figure.axes[:2]
    gain.plot(found.frequencies, np.abs(known), ":", color=BLACK, linewidth=1.6, label="closed form")
    phase.plot(found.frequencies, np.degrees(np.unwrap(np.angle(known))), ":", color=BLACK, linewidth=1.6)
    gain.legend(frameon=False, fontsize="small")
    return figure
