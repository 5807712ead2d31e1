"""Learned feed-forward: hand-worked voltages, friction that it takes away, what it learns, and what it cannot know."""

import numpy as np
import pytest

from leadscrew.controllers._inverse_feed_forward import inverse_feed_forward
from leadscrew.controllers._learned_feed_forward import learned_feed_forward
from leadscrew.kernel.loop import Loop
from leadscrew.plants._xy_table_lugre import LEVELS
from leadscrew.references._eased_sine import eased_sine_motion
from leadscrew.references._motion import Motion
from leadscrew.studies.npid_xytable.tunings import INVERSE, TUNINGS, table_pid
from leadscrew.util.errors import BlockError, ValueRefused
from tests.controllers.table_axis import rms_um, tried

RETUNED = TUNINGS["ours.pid_ms_185"]
SILENT = table_pid(kp=0.0, ki=0.0, kd=0.0)
HIGH = {"friction_mv": 150.0, "presliding_um": 10.0}


def rough(controller, amplitude=15.0, **plant):
    """15 mm at 0.7 Hz against 150 mV of friction."""
    return Loop(
        reference=eased_sine_motion(amplitude=amplitude, frequency=0.7),
        controller=controller,
        plant=LEVELS["high"](**plant),
        period=0.5e-3,
        substeps=20,
        computation_delay=0.775e-3,
        metrics={},
    )


def test_in_steady_motion_it_adds_the_models_voltage_and_coulomb_friction():
    """At 50 mm/s and 3 mm at the middle of the period that the output holds; friction 20 mV."""
    block = learned_feed_forward(SILENT, rate=0.0)
    here = Motion(3.0 - 50.0 * 1.025e-3, 50.0, 0.0)
    u = tried(block, [here] * 200, [0.0] * 200)[-1]
    assert u == pytest.approx((144.8 * 50.0 + 166.3 * 3.0) / 69380.0 + 0.020, abs=1e-9)


def test_without_friction_and_learning_it_is_the_inverse_plant():
    path = [Motion(np.sin(x), 40.0 * np.cos(x), -1600.0 * np.sin(x)) for x in 0.02 * np.arange(400)]
    known = tried(inverse_feed_forward(table_pid, **INVERSE), path, [0.0] * 400)
    mine = tried(learned_feed_forward(table_pid, friction_mv=0.0, rate=0.0), path, [0.0] * 400)
    np.testing.assert_allclose(mine, known, rtol=0, atol=1e-12)


def test_a_known_axis_reverses_within_30_nm_against_150_mv_of_friction():
    """The retuned PID leaves 76 um there."""
    run = rough(learned_feed_forward(RETUNED, rate=0.0, **HIGH)).run(10.0)
    assert np.abs(1e3 * run["true_error"][-8000:]).max() < 0.03


@pytest.mark.parametrize(("name", "value", "key", "share"), [
    ("friction_mv", 180.0, "friction", 0.2), ("friction_mv", 120.0, "friction", -0.2),
    ("damping", 1.1 * 144.8, "viscous", 0.1), ("gain", 69380.0 / 0.9, "viscous", -0.1),
])  # fmt: skip
def test_the_shares_become_what_the_axis_is(name, value, key, share):
    run = rough(learned_feed_forward(RETUNED, **HIGH), **{name: value}).run(20.0, record=("controller",), every=20)
    assert run[f"controller.shares.{key}"][-1] == pytest.approx(share, abs=0.02)


@pytest.mark.slow
def test_friction_that_is_20_percent_off_is_learned_away():
    fixed = rms_um(rough(learned_feed_forward(RETUNED, rate=0.0, **HIGH), friction_mv=180.0).run(30.0))
    learned = rms_um(rough(learned_feed_forward(RETUNED, **HIGH), friction_mv=180.0).run(30.0))
    assert fixed > 2.0 and learned < 0.15


def test_a_presliding_travel_that_is_double_is_not():
    """A limit that the docstring states."""
    twice = {**HIGH, "presliding_um": 20.0}
    assert rms_um(rough(learned_feed_forward(RETUNED, **twice)).run(30.0)) > 1.0


def test_the_first_output_after_an_align_is_the_last_one_before():
    block, here = learned_feed_forward(RETUNED), Motion(0.3, 7.0, -5.0)
    s = block.align(block.params, here, 0.29, 1.5)
    _, u = block.step(block.prepare(block.params, 5e-4), s, here, 0.29, 5e-4)
    assert u == pytest.approx(1.5, abs=1e-9)


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    loop = rough(learned_feed_forward(table_pid))
    fast, plain = (loop.run(0.1, record=("output", "actual"), engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


def test_a_law_of_motions_and_values_out_of_range_are_refused():
    with pytest.raises(BlockError, match=r"learned_feed_forward\(pid_ff\): needs a controller of a position"):
        learned_feed_forward(inverse_feed_forward(table_pid, **INVERSE))
    with pytest.raises(ValueRefused, match=r"presliding_um = 0"):
        learned_feed_forward(table_pid, presliding_um=0.0)
