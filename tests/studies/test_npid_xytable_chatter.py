"""The chatter of the nonlinear PID: another simulation of it, and a second way to its threshold."""

import math

import numpy as np
import pytest

from leadscrew.controllers._npid import npid
from leadscrew.controllers._npid import slope as slope_of
from leadscrew.disturbances._kicked_load import KickedLoadParams, kicked_load
from leadscrew.references._step import step
from leadscrew.studies.npid_xytable import chatter as c
from leadscrew.studies.npid_xytable import laws
from leadscrew.studies.npid_xytable.cutting import load_volts
from leadscrew.studies.npid_xytable.experiments import chatter_rows
from tests.controllers.xy_loop import xy_loop
from tests.studies.npid_lab import lab


@pytest.mark.slow
def test_the_axis_in_steps_of_25_us_chatters_alike():
    loop = xy_loop(npid, step(target=0.0), disturbance=kicked_load(size=1.32e-3 * 5.0, kick=5e-3))
    tail = 1e3 * loop.run(c.RUN_S, record="true_error")["true_error"][-1000:]
    assert np.ptp(tail) == pytest.approx(c.by_load(lab())[c.LOADS_UM.index(5.0)].peak_to_peak_um, rel=1e-3)


def test_the_curve_is_that_of_the_block():
    for e in (-7e-3, -1e-3, 0.4e-3, 2.9e-3, 3.1e-3):
        assert float(laws.curve(e)) == pytest.approx(npid(kp=1.0, ki=0.0, kd=0.0).step(
            npid(kp=1.0, ki=0.0, kd=0.0).params, npid.state, e, 0.0, 5e-4)[1], rel=1e-14)  # fmt: skip
        assert float(laws.slope(1e3 * e)) == pytest.approx(slope_of(npid.params, e), rel=1e-14)


def test_the_steepest_slope_of_the_curve_is_the_one_just_below_its_end():
    e, h = 3e-3, 1e-9
    assert float(laws.slope(1e3 * e)) == pytest.approx((laws.curve(e) - laws.curve(e - h)) / h, rel=1e-5)


@pytest.mark.slow
def test_the_threshold_is_where_a_pole_of_the_loop_closed_with_the_slope_leaves_the_unit_circle():
    at_um = np.linspace(1.86, 1.92, 41)
    carried_um = 1e3 * laws.curve(1e-3 * at_um) + at_um / laws.STATIC_GAIN
    keys = {"disturbance.size": load_volts(carried_um), "controller.ki": np.zeros(41)}
    loud = c.measured(lab(), keys, seconds=12.0).peak_to_peak_um > c.QUIET_UM
    first = int(np.argmax(loud))
    quiet_um, loud_um = at_um[first - 1], at_um[first]
    largest = [
        np.abs(c.linear(lab()).closed_poles(float(laws.slope(e)))).max() for e in (quiet_um - 0.01, loud_um + 0.01)
    ]
    assert largest[0] < 1.0 < largest[1]


def test_on_the_way_down_it_starts_to_chatter_later_than_it_ended_on_the_way_up():
    found = c.edges_um(lab())
    assert found["up_ends"] > found["down_starts"] + 5.0
    assert found["down_starts"] == pytest.approx(3.0 * math.cosh(1.5), abs=0.1)


def test_a_load_that_comes_and_goes():
    p = KickedLoadParams(size=1.0, rate=2.0, turn_s=3.0, kick=0.5, kick_hz=0.25, kick_s=2.0)
    by_hand = {0.0: 1.0, 1.0: 1.0 + 2.0 + 0.5, 2.0: 5.0, 3.0: 7.0, 5.0: 3.0, 7.0: 1.0}
    assert [kicked_load.step(p, t) for t in by_hand] == pytest.approx(list(by_hand.values()), rel=1e-12)


@pytest.mark.slow
def test_the_balance_is_right_to_a_percent_in_every_row_and_one_term_in_all_but_the_first():
    loud = [row for row in chatter_rows(lab()).values() if row.peak_to_peak_um > c.QUIET_UM]
    assert len(loud) == 13
    for many, most in ((True, 1.0), (False, 12.0)):
        off = [100.0 * abs(c.predicted_um(lab(), row, many) / row.peak_to_peak_um - 1.0) for row in loud]
        assert max(off) < most and max(off[1:]) < 10.0


@pytest.mark.slow
def test_chatter_under_12_um_needs_a_kick_and_under_10_um_needs_none():
    loads, kicks = [2.5, 3.0, 10.0, 12.0, 12.0], [0.0, 0.0, 0.0, 0.0, 1e-3]
    size = c.measured(
        lab(), {"disturbance.size": load_volts(loads), "disturbance.kick": np.array(kicks)}
    ).peak_to_peak_um
    assert size[0] < c.QUIET_UM < size[1]
    assert size[2] > 5.0 and size[3] < 0.01 and size[4] > 5.0
