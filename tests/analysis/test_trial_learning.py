"""Learning from pass to pass: the table that a controller plays, and its update."""

import math

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from leadscrew.controllers._feed_forward_table import feed_forward_table
from leadscrew.controllers._pd_dob import pd_dob
from leadscrew.controllers._sliding.super_twisting import super_twisting
from leadscrew.controllers._trial_learning import last_period, smoothed, taught
from leadscrew.plants._ballscrew_stage import ballscrew_stage
from leadscrew.references._motion import Motion
from leadscrew.util.errors import BlockError, DataError, ValueRefused
from tests.controllers.stage_loop import stage_loop

DT = 2.5e-4
REST = Motion(0.0, 0.0, 0.0)


def added(block, count):
    """What a controller puts out, sample by sample, while there is no error at rest."""
    p, s, out = block.prepare(block.params, DT), block.state, []
    for _ in range(count):
        s, u = block.step(p, s, REST, 0.0, DT)
        out.append(u)
    return out


# ---- the table
def test_the_table_is_played_value_by_value_and_starts_again_after_the_period():
    silent = pd_dob(friction=False, observer_rate=0.0)
    assert added(feed_forward_table(silent, (1.0, 2.0, 4.0), 3 * DT), 7) == pytest.approx([1, 2, 4, 1, 2, 4, 1])


def test_between_the_values_is_a_straight_line_also_from_the_last_to_the_first():
    silent = pd_dob(friction=False, observer_rate=0.0)
    out = added(feed_forward_table(silent, (1.0, 2.0), 4 * DT), 6)
    assert out == pytest.approx([1.0, 1.5, 2.0, 1.5, 1.0, 1.5], rel=1e-12)


@pytest.mark.slow
def test_a_table_of_zeros_is_the_inner_controller():
    plain = stage_loop(pd_dob, "fast").run(0.1, record=("output", "actual"))
    tabled = stage_loop(feed_forward_table(pd_dob, np.zeros(7)), "fast").run(0.1, record=("output", "actual"))
    assert all(np.array_equal(plain[column], tabled[column]) for column in plain.signals)


@pytest.mark.slow
def test_an_observer_takes_the_table_for_known_friction():
    """Half a newton metre more friction known to the table is half a newton metre less in the observer."""
    loops = [stage_loop(feed_forward_table(pd_dob, (u,)), "fast") for u in (0.0, 0.5)]
    free, fed = (loop.run(0.2, record="controller.inner.load")["controller.inner.load"][400:] for loop in loops)
    assert np.mean(free - fed) == pytest.approx(0.5, rel=0.01)


def test_from_rest_the_first_output_after_an_align_is_the_last_one_before():
    block = feed_forward_table(pd_dob, (0.7, -0.3), 1.0)
    p, here = block.prepare(block.params, DT), Motion(0.2, 0.0, 0.0)
    _, u = block.step(p, block.align(p, here, 0.2 + 3e-5, 4.0), here, 0.2 + 3e-5, DT)
    assert u == pytest.approx(4.0, abs=1e-9)


@pytest.mark.sweep
@pytest.mark.parametrize("inner", [pd_dob, super_twisting])
def test_all_engines_give_the_same_bits(inner):
    loop = stage_loop(feed_forward_table(inner, (0.3, -0.2, 0.1), 0.0071), "fast", encoder_mm=1e-5)
    fast, plain = (loop.run(0.02, record=("output", "actual"), engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[column], plain[column]) for column in plain.signals)


def test_what_cannot_be_a_table_or_has_none_is_refused():
    for table in ((), [[1.0, 2.0]], (1.0, math.nan)):
        with pytest.raises(ValueRefused, match="expected finite numbers in one row"):
            feed_forward_table(pd_dob, table)
    with pytest.raises(ValueRefused, match="period_s"):
        feed_forward_table(pd_dob, (1.0,)).using(period_s=0.0)
    with pytest.raises(BlockError, match=r"feed_forward_table\(ballscrew_stage\)"):
        feed_forward_table(ballscrew_stage)


# ---- the update
def test_the_filter_is_scipys_periodic_gaussian():
    row = np.random.default_rng(1).normal(size=50)
    for width in (0.7, 2.0, 5.0):
        reach = math.ceil(4.0 * width)
        theirs = gaussian_filter1d(row, width, mode="wrap", radius=reach)
        assert smoothed(row, width) == pytest.approx(theirs, abs=1e-12)
    assert np.array_equal(smoothed(row, 0.0), row)


def test_what_was_missing_later_is_fed_earlier_by_the_lead():
    missing = np.zeros(20)
    missing[10] = 1.0
    table = taught(np.full(20, 3.0), missing, lead=4, gain=0.7, width=0.0)
    assert table[6] == pytest.approx(3.7) and np.delete(table, 6) == pytest.approx(3.0)
    assert np.argmax(taught(np.zeros(20), missing, lead=4, width=2.0)) == 6
    assert np.argmax(taught(np.zeros(20), np.roll(missing, -9), lead=4)) == 17  # round the end


def test_of_a_known_disturbance_each_pass_leaves_what_the_gain_leaves():
    """A loop that shows all of what is missing two samples late: 0.3 to the power of the passes stays."""
    wanted = np.sin(2.0 * np.pi * np.arange(400) / 400.0)
    table = np.zeros(400)
    for _ in range(5):
        table = taught(table, np.roll(wanted - table, 2), lead=2, gain=0.7, width=0.0)
    assert np.abs(wanted - table).max() == pytest.approx(0.3**5, rel=1e-9)


def test_the_last_period_lands_at_the_places_of_the_table():
    t = np.arange(1300) * 1e-3  # 1.3 s of a period of 1 s
    place = last_period(t, np.sin(2.0 * np.pi * t), 1.0, 250)
    assert place == pytest.approx(np.sin(2.0 * np.pi * np.arange(250) / 250.0), abs=1e-5)
    late = last_period(t, t, 1.0, 1000)  # the first 0.3 s of the table are the second time round
    assert late[:300] == pytest.approx(1.0 + t[:300]) and late[300:] == pytest.approx(t[300:1000])


def test_records_and_settings_that_make_no_table_are_refused():
    with pytest.raises(DataError, match="rows of one length"):
        taught(np.zeros(3), np.zeros(4))
    with pytest.raises(DataError, match="diverged"):
        taught(np.zeros(3), np.array([0.0, math.inf, 0.0]))
    with pytest.raises(ValueRefused, match="lead = 9"):
        taught(np.zeros(8), np.zeros(8), lead=9)
    with pytest.raises(ValueRefused, match="gain = 3"):
        taught(np.zeros(8), np.zeros(8), gain=3)
    with pytest.raises(ValueRefused, match="width = -1"):
        taught(np.zeros(8), np.zeros(8), width=-1)
    with pytest.raises(DataError, match="expected a period of 2 s"):
        last_period(np.arange(10) * 0.1, np.zeros(10), 2.0, 20)
    with pytest.raises(DataError, match="expected two samples each"):
        last_period(np.arange(10), np.zeros(9), 2.0, 20)
