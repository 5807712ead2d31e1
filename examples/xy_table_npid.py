"""Nonlinear PID on an axis of the XY table: a sine of 1 mm under the sampled loop of a servo drive.

Run it, and export its controller:

    leadscrew simulate examples/xy_table_npid.py:loop --duration 2
    leadscrew export examples/xy_table_npid.py:loop --duration 2 --target hal --out npid_hal
"""

from leadscrew import Loop, study
from leadscrew.kernel.metrics import max_error, rms_error
from leadscrew.plants import xy_table
from leadscrew.references import sine

PERIOD = 0.5e-3
"""2 kHz, s."""

DELAY = 0.775e-3
"""From the sample to the voltage at the motor, s: the printed model of the table has no dead time, its plots have."""


def loop():
    """The loop: the gain grows with the error in um."""
    return Loop(
        reference=sine(amplitude=1.0, frequency=0.7),
        controller=study("npid_xytable").controllers["corrected.npid_um"],
        plant=xy_table,
        period=PERIOD,
        substeps=20,
        computation_delay=DELAY,
        metrics={"rms_error": rms_error, "max_error": max_error},
    )
