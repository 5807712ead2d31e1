"""Look-ahead: late torque and late sensors taken out of the command."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.controllers._look_ahead import look_ahead
from leadscrew.controllers._pd_dob import pd_dob
from leadscrew.controllers._sliding.super_twisting import super_twisting
from leadscrew.kernel.block import controller
from leadscrew.plants._ballscrew_stage import ballscrew_stage
from leadscrew.references._motion import Motion
from leadscrew.sensors._filtered_ruler import filtered_ruler
from leadscrew.util.errors import BlockError
from tests.controllers.stage_loop import errors_um, stage_loop

DT = 2.5e-4


class Gain(NamedTuple):
    gain: float = 1.0


class Seen(NamedTuple):
    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0


@controller(Gain(), Seen())
def error_only(p, s, command, feedback, dt):
    """Remembers the command that it sees; gives the error that it sees."""
    return Seen(command.position, command.velocity, command.acceleration), p.gain * (command.position - feedback)


def moving(t, a=30.0, v=2.0):
    return Motion(v * t + 0.5 * a * t * t, v + a * t, a)


def test_the_inner_law_sees_the_command_of_the_time_when_its_torque_acts():
    block = look_ahead(error_only, actuation_delay_s=3e-4)
    p, now = block.prepare(block.params, DT), moving(0.1)
    s, e = block.step(p, block.state, now, now.position - 1e-4, DT)
    assert tuple(s) == pytest.approx(tuple(moving(0.1003)), rel=1e-12)
    assert e == pytest.approx(1e-4, rel=1e-9)  # the error of now


def test_a_perfectly_followed_command_shows_no_error_through_a_filter():
    """Filtered by ``1 / (tau s + 1)`` an accelerated motion is ``x - tau v + tau^2 a`` once the filter has settled."""
    tau, block = (
        1.0 / (2.0 * math.pi * 1000.0),
        look_ahead(error_only, measurement_delay_s=1.0 / (2.0 * math.pi * 1000.0)),
    )
    p, now = block.prepare(block.params, DT), moving(0.1)
    late = now.position - tau * now.velocity + tau**2 * now.acceleration
    _, e = block.step(p, block.state, now, late, DT)
    assert abs(now.position - late) > 5e-4 and abs(e) < 1e-15


@pytest.mark.slow
def test_without_lags_it_is_the_inner_controller():
    plain = stage_loop(pd_dob, "fast").run(0.1, record=("output", "actual"))
    ahead = stage_loop(look_ahead(pd_dob), "fast").run(0.1, record=("output", "actual"))
    assert all(np.array_equal(plain[column], ahead[column]) for column in plain.signals)


def through(sensor, block):
    """The fast sine, read by a sensor."""
    loop = stage_loop(block, "fast")
    loop.blocks["sensor"] = sensor
    return loop


@pytest.mark.slow
def test_it_takes_away_the_error_of_a_filtered_scale():
    """1 kHz late at 3.9 rad/s is 1 um of the table."""
    sensor = filtered_ruler(resolution_mm=1e-5 / 1.5923)
    block = look_ahead(pd_dob, measurement_delay_s=1.0 / (2.0 * math.pi * 1000.0))
    plain, ahead = (errors_um(through(sensor, b).run(2.0)) for b in (pd_dob, block))
    assert plain[1] == pytest.approx(0.707, rel=0.02) and ahead[1] < 0.1 * plain[1]


def test_the_parameters_are_those_of_the_inner_controller():
    block = look_ahead(pd_dob(kp=123.0), name="mine")
    loop = stage_loop(block, "fast", plant=ballscrew_stage).using({"controller.inner.hat.coulomb": 6.0})
    assert block.name == "mine" and block.params.inner.kp == 123.0
    assert loop.parameters["controller.inner.hat.coulomb"] == 6.0


def test_from_rest_the_first_output_after_an_align_is_the_last_one_before():
    block, here = look_ahead(pd_dob, actuation_delay_s=DT, measurement_delay_s=1e-4), Motion(0.2, 0.0, 0.0)
    p = block.prepare(block.params, DT)
    _, u = block.step(p, block.align(p, here, 0.2 + 3e-5, 4.0), here, 0.2 + 3e-5, DT)
    assert u == pytest.approx(4.0, abs=1e-9)


@pytest.mark.sweep
@pytest.mark.parametrize("inner", [pd_dob, super_twisting])
def test_all_engines_give_the_same_bits(inner):
    loop = stage_loop(look_ahead(inner, actuation_delay_s=DT, measurement_delay_s=1e-4), "fast", encoder_mm=1e-5)
    fast, plain = (loop.run(0.02, record=("output", "actual"), engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[column], plain[column]) for column in plain.signals)


def test_what_is_not_a_sampled_controller_of_a_motion_is_refused():
    with pytest.raises(BlockError, match=r"look_ahead\(ballscrew_stage\)"):
        look_ahead(ballscrew_stage)
