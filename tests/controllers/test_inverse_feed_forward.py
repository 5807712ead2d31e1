"""Inverse-plant feed-forward: hand-worked voltages, the following error that it takes away, and what is left."""

import numpy as np
import pytest

from leadscrew.controllers._inverse_feed_forward import inverse_feed_forward
from leadscrew.controllers._npid import npid
from leadscrew.controllers._pd_dob import pd_dob
from leadscrew.plants._xy_table import xy_table
from leadscrew.references._motion import Motion
from leadscrew.studies.npid_xytable.tunings import INVERSE, TUNINGS, table_pid
from leadscrew.util.errors import BlockError, ValueRefused
from tests.controllers.table_axis import lines_um, rms_um, table_axis, tried


def test_the_voltage_is_the_models_by_hand():
    """From r = 2, r' = 30, r'' = 400 after 10 ms without jerk: r = 2.32, r' = 34, r'' = 400."""
    block = inverse_feed_forward(table_pid(kp=0.0, ki=0.0, kd=0.0), share=0.9, **INVERSE | {"ahead_s": 0.01})
    (u,) = tried(block, [Motion(2.0, 30.0, 400.0)], [0.0])
    assert u == pytest.approx(0.9 * (400.0 + 144.8 * 34.0 + 166.3 * 2.32) / 69380.0, rel=1e-12)


def test_the_inner_law_sees_the_commanded_position():
    block, here = inverse_feed_forward(table_pid, share=0.0, **INVERSE), Motion(0.3, 7.0, -5.0)
    assert tried(block, [here, here], [0.1, 0.25]) == tried(table_pid, [0.3, 0.3], [0.1, 0.25])


def test_a_wrapped_loop_with_another_gain_is_not_compiled_again():
    """A new class of prepared parameters would need a new program."""
    plans = [
        b.prepare(b.params, 5e-4)
        for b in (inverse_feed_forward(table_pid, **INVERSE), inverse_feed_forward(table_pid(kp=1.0), **INVERSE))
    ]
    assert type(plans[0]) is type(plans[1])


@pytest.mark.parametrize("late", [0.775e-3, *(pytest.param(x, marks=pytest.mark.slow) for x in (0.0, 1.5e-3))])
def test_a_known_plant_follows_a_sine_within_5_nm(late):
    """Without it the printed gains leave 7.1 um."""
    block = inverse_feed_forward(table_pid, **INVERSE | {"ahead_s": late + 0.25e-3})
    run = table_axis(block, dead_time_s=late).run(20.0)
    assert lines_um(run, [0.7])[0] < 5e-3 and rms_um(table_axis(table_pid, dead_time_s=late).run(20.0)) > 5.0


def test_a_share_of_90_percent_leaves_a_tenth_of_the_following_error():
    whole, rest = (
        lines_um(table_axis(block).run(20.0), [0.7])[0]
        for block in (table_pid, inverse_feed_forward(table_pid, share=0.9, **INVERSE))
    )
    assert rest == pytest.approx(0.1 * whole, rel=2e-3)


def test_a_wrong_gain_of_the_model_leaves_the_error_of_that_part():
    """Of a plant that is 25 % stronger than believed: a quarter too much voltage, seen by the loop as -0.25 of it."""
    strong = 1.25 * 69380.0
    whole = lines_um(table_axis(table_pid, gain=strong).run(20.0), [0.7])[0]
    rest = lines_um(table_axis(inverse_feed_forward(table_pid, **INVERSE), gain=strong).run(20.0), [0.7])[0]
    assert rest == pytest.approx(0.25 * whole, rel=5e-3)


def test_it_goes_around_a_law_of_motions_too():
    block, here = inverse_feed_forward(pd_dob, gain=1.0, damping=0.0, stiffness=0.0, ahead_s=0.0), Motion(0.1, 2.0, 3.0)
    assert tried(block, [here], [0.1]) == [tried(pd_dob, [here], [0.1])[0] + 3.0]


def test_the_parameters_are_those_of_the_inner_controller():
    loop = table_axis(inverse_feed_forward(npid(alpha=0.3), name="mine", **INVERSE)).using(
        {"controller.inner.e_max": 2.0}
    )
    assert loop.parameters["controller.inner.alpha"] == 0.3 and loop.parameters["controller.inner.e_max"] == 2.0
    assert loop.blocks["controller"].name == "mine" and loop.parameters["controller.gain"] == 69380.0


@pytest.mark.parametrize("inner", [TUNINGS["ours.pid_ms_159"], pd_dob])
def test_the_first_output_after_an_align_is_the_last_one_before(inner):
    block, here = inverse_feed_forward(inner, **INVERSE), Motion(0.3, 0.0, 0.0)
    p = block.params if block.prepare is None else block.prepare(block.params, 5e-4)
    _, u = block.step(p, block.align(p, here, 0.29, 1.5), here, 0.29, 5e-4)
    assert u == pytest.approx(1.5, abs=1e-9)


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    loop = table_axis(inverse_feed_forward(npid, share=0.9, **INVERSE))
    fast, plain = (loop.run(0.2, record=("output", "actual"), engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


def test_what_is_no_controller_and_gains_of_nothing_are_refused():
    with pytest.raises(BlockError, match=r"inverse_feed_forward\(xy_table\): needs a sampled controller"):
        inverse_feed_forward(xy_table, **INVERSE)
    with pytest.raises(ValueRefused, match=r"gain = 0"):
        inverse_feed_forward(table_pid, **INVERSE)(gain=0.0)
