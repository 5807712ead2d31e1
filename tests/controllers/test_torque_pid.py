"""The PID of a torque drive: periods worked by hand, and what it does on the stage."""

import numpy as np
import pytest

from leadscrew.controllers._torque_pid import torque_pid
from leadscrew.references._motion import Motion
from tests.controllers.drive_loop import pid
from tests.controllers.stage_loop import errors_um, stage_loop

DT = 2.5e-4
GAINS = torque_pid(kp=300.0, ki=50_000.0, kd=0.9, filter_s=8e-5)


def test_two_periods_worked_by_hand():
    block = torque_pid(kp=100.0, ki=2000.0, kd=0.5, filter_s=0.0, travel_per_rad=2.0)
    s, u = block.step(block.params, block.state, Motion(4e-4, 1.0, 7.0), 0.0, DT)
    assert u == pytest.approx(100.0 * 2e-4 + 2000.0 * 2e-4 * DT + 0.5 * 2e-4 / DT)
    _, u = block.step(block.params, s, Motion(6e-4, 1.0, 7.0), 0.0, DT)
    assert u == pytest.approx(100.0 * 3e-4 + 2000.0 * 5e-4 * DT + 0.5 * 1e-4 / DT)


@pytest.mark.slow
def test_without_a_friction_model_reversals_leave_micrometres():
    run = stage_loop(GAINS, "fast", encoder_mm=1e-5).run(4.0, record="true_error")
    assert 2.0 < errors_um(run)[0] < 40.0


def test_from_rest_the_first_output_after_an_align_is_the_last_one_before():
    here = Motion(0.2, 0.0, 0.0)
    s = torque_pid.align(GAINS.params, here, 0.2 + 3e-5, 4.0)
    _, u = torque_pid.step(GAINS.params, s, here, 0.2 + 3e-5, DT)
    assert u == pytest.approx(4.0, abs=1e-9)


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    fast, plain = (pid().run(0.02, record=("output", "actual"), engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[column], plain[column]) for column in plain.signals)
