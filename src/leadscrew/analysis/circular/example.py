"""A made ball-bar file: nothing of it was measured, and its first lines say how it was made."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

from leadscrew.analysis.circular.instrument import BallBar, read_by
from leadscrew.analysis.circular.machine_errors import AxisErrors, MachineErrors, circle_with

RADIUS_MM, FEED_MM_MIN = 100.0, 1000.0
FAULTS = MachineErrors(
    x=AxisErrors(lag_um=42.0, scale_ppm=-18.0, backlash_plus_um=3.0, backlash_minus_um=3.0,
                 cyclic_um=0.6, lead_mm=10.0),
    y=AxisErrors(lag_um=40.0, scale_ppm=-12.0, stick_um=2.4, stick_rise_deg=1.0, stick_decay_deg=2.0),
    squareness_urad=-25.0,
)  # fmt: skip
BAR = BallBar(centring_x_um=4.0, centring_y_um=-6.0)
SCATTER_UM = 0.05


def example() -> str:
    """The file."""
    head = (
        "# A made example, not a measurement: radius 100 mm, feed 1,000 mm/min, both directions.\n"
        "# Faults: squareness -25 urad; scale X -18 ppm, Y -12 ppm; X lags 42 um, Y 40 um; play of 3 um in X;\n"
        "#   cyclic error of 0.6 um in X with a lead of 10 mm; stick motion of 2.4 um in Y (rise 1, decay 2 degrees).\n"
        "# Read by a ball bar model: centring (4, -6) um, balls out of round by 0.05 um, scatter 0.05, step 0.1 um.\n"
        "angle_deg,deviation_um,direction\n"
    )
    test = read_by(BAR._replace(resolution_um=0.0), circle_with(FAULTS, RADIUS_MM, feed_mm_min=FEED_MM_MIN))
    lines, count = [], 0
    for turn in test.turns:
        degrees = np.degrees(turn.angle)
        for at, deviation in zip(degrees, turn.deviation_um(RADIUS_MM), strict=True):
            count += 1
            scatter = NormalDist(0.0, SCATTER_UM).inv_cdf((0.5 + 0.6180339887498949 * count) % 1.0)
            lines.append(f"{round(at, 1) + 0.0:g},{round(deviation + scatter, 1) + 0.0:g},{turn.direction}\n")
    return head + "".join(lines)
