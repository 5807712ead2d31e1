"""How large the disturbances have to be for the PID column of Table II: closed form, in the sampled loop L*.

The paper prints errors, no forces. With the disturbance ``d`` at the plant's input and the loop of the table's PID,
the amplitude of the error at a frequency is ``g d`` with

    g = abs(P_d / (1 + C P)),      C = kp + ki T z / (z - 1) + kd (z - 1) / (T z),      z = e^(j w T)

where ``P`` and ``P_d`` are the sampled plant seen from the controller's voltage (with its dead time) and from a held
disturbance (without). So ``amplitude / g`` makes the column by construction; what NPID does of it is then a prediction.
"""

from __future__ import annotations

import numpy as np

from leadscrew.plants._xy_table_cutting import hold, xy_table_cutting
from leadscrew.studies.npid_xytable.table2 import LINES_HZ
from leadscrew.studies.npid_xytable.tunings import table_pid

PERIOD_S = 5e-4
"""Control period: 2 kHz."""

DEAD_TIME_S = 0.775e-3
"""What the paper's stability plot needs in a loop of that period with a backward difference."""


def responses(frequency_hz: float, dead_time_s: float = DEAD_TIME_S) -> tuple[complex, complex]:
    """Of the loop of Table I's PID: error per command, and error per volt held at the plant's input (mm/V).

    ``error = command - position``; amplitude and angle against the command's or the disturbance's samples.
    """
    gains = table_pid.params
    axis = hold(xy_table_cutting.params._replace(dead_time_s=dead_time_s), PERIOD_S)
    z = np.exp(2j * np.pi * frequency_hz * PERIOD_S)
    transition = np.array([axis.from_position, axis.from_velocity]).T
    to_position = np.linalg.inv(z * np.eye(2) - transition)[0]
    sent = (axis.now, axis.sent, axis.sent2, axis.sent3, axis.sent4, axis.sent5)
    plant = sum(to_position @ np.array(part) * z**-late for late, part in enumerate(sent))
    law = gains.kp + gains.ki * PERIOD_S * z / (z - 1.0) + gains.kd * (1.0 - 1.0 / z) / PERIOD_S
    left = 1.0 / (1.0 + law * plant)
    return complex(left), complex(-left * (to_position @ np.array(axis.load)))


def gain_um_per_mv(frequency_hz: float) -> float:
    """``g`` of Table I's PID in L*: amplitude of the error at this frequency in um, for 1 mV at the plant's input."""
    return abs(responses(frequency_hz)[1])


def volts(amplitudes_um: tuple[float, ...]) -> tuple[float, ...]:
    """Amplitudes of the disturbance at :data:`LINES_HZ`, V, that make these errors under Table I's PID in L*."""
    return tuple(1e-3 * um / gain_um_per_mv(hz) for um, hz in zip(amplitudes_um, LINES_HZ, strict=True))
