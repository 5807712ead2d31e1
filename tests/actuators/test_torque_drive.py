"""The torque drive against SciPy's solution of its lag, and its limit."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.actuators._torque_drive import TorqueDriveState, torque_drive
from leadscrew.controllers._pd_dob import pd_dob
from leadscrew.util.errors import ValueRefused
from tests.controllers.stage_loop import stage_loop

DT = 2.5e-4


def driven(wanted, **changes):
    block = torque_drive(**changes)
    p, s, applied = block.prepare(block.params, DT), block.state, []
    for w in wanted:
        s, u = block.step(p, s, w)
        applied.append(u)
    return np.array(applied), s


def test_the_plant_gets_the_momentum_of_a_first_order_lag():
    rng = np.random.default_rng(3)
    wanted = rng.uniform(-20.0, 20.0, 12)
    applied, s = driven(wanted, lag_s=3e-4)
    torque, momentum = 0.0, 0.0
    for w, mean in zip(wanted, applied, strict=True):
        done = solve_ivp(lambda t, x, w=w: [(w - x[0]) / 3e-4, x[0]], (0.0, DT), [torque, 0.0], rtol=1e-11, atol=1e-13)
        torque, momentum = done.y[:, -1]
        assert mean * DT == pytest.approx(momentum, rel=1e-8)
    assert s.torque == pytest.approx(torque, rel=1e-8)


def test_beyond_the_limit_the_motor_gives_the_limit():
    applied, _ = driven([50.0, -50.0, 3.0], max_torque=12.0, lag_s=0.0)
    assert applied.tolist() == [12.0, -12.0, 3.0]


def test_a_slow_drive_still_arrives():
    applied, _ = driven([10.0] * 200, lag_s=2e-3)
    assert applied[0] < 1.0 and applied[-1] == pytest.approx(10.0, rel=1e-9)


def test_a_torque_that_dies_away_ends_at_zero():
    _, s = driven([1.0] + [0.0] * 2000, lag_s=2e-4)
    assert s == TorqueDriveState(0.0)


def test_no_limit_at_all_is_refused():
    with pytest.raises(ValueRefused, match=r"max_torque = 0.0"):
        torque_drive(max_torque=0.0)


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    loop = stage_loop(pd_dob, "fast", actuator=torque_drive)
    fast, plain = (loop.run(0.02, record=("applied", "actual"), engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[column], plain[column]) for column in plain.signals)
    assert not np.array_equal(fast["applied"], loop.run(0.02, record="output")["output"])
