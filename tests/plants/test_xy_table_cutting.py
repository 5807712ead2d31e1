"""The axis with dead time and spindle lines against the stepped axis with a delay line, SciPy, and its own phasor."""

import numpy as np
import pytest

from leadscrew.disturbances._five_sines import five_sines
from leadscrew.disturbances._sine_load import sine_load
from leadscrew.kernel.loop import Loop
from leadscrew.plants._xy_table import xy_table
from leadscrew.plants._xy_table_cutting import xy_table_cutting
from leadscrew.references._sine import sine
from leadscrew.references._step import step
from leadscrew.studies.npid_xytable.tunings import TUNINGS, table_pid
from leadscrew.util.errors import LeadscrewError

PERIOD = 5e-4


def loop(plant, controller=table_pid, **more):
    return Loop(reference=sine(amplitude=1.0, frequency=0.7), controller=controller, plant=plant, period=PERIOD,
                metrics={}, **more)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("late_us", [0, 25, 475, 500, 775, 1000, 1475, 2000])
def test_its_dead_time_is_that_of_a_delay_line_in_small_steps(late_us):
    law = TUNINGS["corrected.npid_um"] if late_us < 800 else table_pid
    load = sine_load(amplitude=0.01, frequency=3.0)
    mine = loop(xy_table_cutting(dead_time_s=1e-6 * late_us), law, disturbance=load).run(0.4, record="actual")
    stepped = loop(xy_table, law, disturbance=load, substeps=20, computation_delay=1e-6 * late_us)
    assert mine["actual"] == pytest.approx(stepped.run(0.4, record="actual")["actual"], abs=1e-11)


@pytest.mark.slow
def test_its_lines_are_those_of_the_differential_equation():
    from scipy.integrate import solve_ivp

    # 24,000 rpm, three teeth: 1,200 Hz, above half of the sampling frequency.
    lines = {"spindle_hz": 400.0, "spindle_v": 0.4, "spindle_phase": 0.3}
    lines |= {"teeth": 3, "tooth_v": 2.0, "tooth_phase": 1.1}
    axis = Loop(reference=step(target=0.0), controller=table_pid(kp=0.0, ki=0.0, kd=0.0),
                plant=xy_table_cutting(**lines),period=PERIOD, metrics={})  # fmt: skip
    seen = axis.run(0.1, record="actual")

    def rate(t, x):
        d = 0.4 * np.sin(800.0 * np.pi * t + 0.3) + 2.0 * np.sin(2400.0 * np.pi * t + 1.1)
        return x[1], 69380.0 * d - 144.8 * x[1] - 166.3 * x[0]

    truth = solve_ivp(rate, (0.0, 0.1), (0.0, 0.0), t_eval=seen.time, method="DOP853", rtol=1e-11, atol=1e-13)
    assert seen["actual"] == pytest.approx(truth.y[0], abs=1e-9)


def test_a_dead_time_of_more_than_four_periods_is_refused():
    with pytest.raises(LeadscrewError, match=r"dead_time_s = 0.0021.*at most 4 periods, here 0.002 s"):
        loop(xy_table_cutting(dead_time_s=2.1e-3)).run(0.01)


def test_five_sines_are_their_sum():
    lines = five_sines.params
    p = lines._replace(first=lines.first._replace(amplitude=1.0, phase=0.4), fifth=lines.fifth._replace(amplitude=0.5))
    at = 0.123
    wanted = np.sin(2.0 * np.pi * 2.1 * at + 0.4) + 0.5 * np.sin(2.0 * np.pi * 7.7 * at)
    assert five_sines.step(p, at) == pytest.approx(wanted, rel=1e-14)
