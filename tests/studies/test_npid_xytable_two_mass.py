"""The XY table on two masses: the study's margins against the analysis of the loop that runs."""

import pytest

from leadscrew.analysis.stability.loop import sampled_loop
from leadscrew.analysis.stability.margins import margins
from leadscrew.kernel.loop import Loop
from leadscrew.plants._xy_table_two_mass import XYTableTwoMassParams, xy_table_two_mass
from leadscrew.references._sine import sine
from leadscrew.studies.npid_xytable.tunings import TUNINGS, table_pid
from leadscrew.studies.npid_xytable.two_mass import Axis, judged, notched, slowed

RETUNED = TUNINGS["ours.pid_ms_159"]


@pytest.mark.parametrize(
    ("controller", "hz", "at_table"),
    [(RETUNED, 80.0, False), (notched(RETUNED, 150.0), 150.0, False), (slowed(RETUNED, 0.3), 120.0, True)],
)
def test_ms_is_that_of_the_loop_that_runs(controller, hz, at_table):
    """By the steps themselves, delays in 25 us steps, on the analysis's own grid."""
    plant = xy_table_two_mass(mode_hz=hz, at_table=at_table)
    loop = Loop(
        reference=sine(amplitude=1.0, frequency=0.7), controller=controller, plant=plant, period=0.5e-3, substeps=20,
        computation_delay=0.775e-3, metrics={},
    )  # fmt: skip
    assert judged(controller, Axis(plant.params)).ms == pytest.approx(margins(sampled_loop(loop)).ms, rel=2e-3)


def test_without_a_mode_it_is_the_rigid_loop():
    """L*: Ms 1.87, gain margin 2.51."""
    stiff = Axis(XYTableTwoMassParams(mode_hz=5e4, mode_damping=0.5))
    assert judged(table_pid, stiff).ms == pytest.approx(1.869, abs=2e-3)
    gained = [
        table_pid(**{key: k * getattr(table_pid.params, key) for key in ("kp", "ki", "kd")}) for k in (2.500, 2.515)
    ]
    assert [judged(block, stiff).stable for block in gained] == [True, False]
