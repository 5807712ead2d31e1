"""The chatter of the nonlinear PID: another simulation of it, a second way to its threshold, and every claim."""

import math

import numpy as np
import pytest

from leadscrew.controllers.npid import npid
from leadscrew.controllers.npid import slope as slope_of
from leadscrew.disturbances.kicked_load import KickedLoadParams, kicked_load
from leadscrew.references.step import step
from leadscrew.studies.npid_xytable import chatter as c
from leadscrew.studies.npid_xytable import chatter_theory as th
from leadscrew.studies.npid_xytable.claims_chatter import errors_of
from leadscrew.studies.npid_xytable.figures_chatter import chatter_pictures
from leadscrew.studies.npid_xytable.runs import Loops
from tests.controllers.xy_loop import xy_loop
from tests.studies.whole import claims_of


@pytest.fixture(scope="module")
def loops():
    return Loops()


@pytest.fixture(scope="module")
def rows(loops):
    return c.rows_for(loops)


@pytest.mark.slow
@pytest.mark.xdist_group("whole npid_xytable")
def test_the_digest_has_ten_loads_and_six_chatter():
    begin = "chatter_size_"
    loud = [name for name, x in claims_of("npid_xytable").items() if name.startswith(begin) and x.measured > 0.1]
    assert loud == [begin + load for load in ("3", "4", "5", "7", "10", "12")]


@pytest.mark.slow
def test_the_axis_in_steps_of_25_us_chatters_alike(rows):
    loop = xy_loop(npid, step(target=0.0), disturbance=kicked_load(size=1.32e-3 * 5.0, kick=5e-3))
    tail = 1e3 * loop.run(c.RUN_S, record="true_error")["true_error"][-1000:]
    assert np.ptp(tail) == pytest.approx(rows.table.peak_to_peak_um[c.LOADS_UM.index(5.0)], rel=1e-3)


def test_the_curve_is_that_of_the_block():
    for e in (-7e-3, -1e-3, 0.4e-3, 2.9e-3, 3.1e-3):
        assert float(th.curve(e)) == pytest.approx(npid(kp=1.0, ki=0.0, kd=0.0).step(
            npid(kp=1.0, ki=0.0, kd=0.0).params, npid.state, e, 0.0, 5e-4)[1], rel=1e-14)  # fmt: skip
        assert float(th.slope(1e3 * e)) == pytest.approx(slope_of(npid.params, e), rel=1e-14)


def test_the_steepest_slope_of_the_curve_is_the_one_just_below_its_end():
    e, h = 3e-3, 1e-9
    assert float(th.slope(1e3 * e)) == pytest.approx((th.curve(e) - th.curve(e - h)) / h, rel=1e-5)


def test_rest_under_a_load_by_hand():
    # phi(e) + e/550.7 = 2 um: e = 1.5276 um gives 1.5276 cosh(0.7638) + 0.0028
    e = float(th.at_rest_um(2.0)[0])
    assert e * math.cosh(0.5 * e) + e / (1.32 * 69380.0 / 166.3) == pytest.approx(2.0, rel=1e-12)
    assert th.load_of(e) == pytest.approx(2.0, rel=1e-12)


@pytest.mark.slow
def test_the_threshold_is_where_a_pole_of_the_loop_closed_with_the_slope_leaves_the_unit_circle(rows):
    quiet, loud, quiet_um, loud_um = rows.threshold
    largest = [np.abs(th.linear().closed_poles(float(th.slope(e)))).max() for e in (quiet_um - 0.01, loud_um + 0.01)]
    assert largest[0] < 1.0 < largest[1] and loud / quiet - 1.0 < 2e-3


def test_on_the_way_down_it_starts_to_chatter_later_than_it_ended_on_the_way_up(rows):
    found = rows.edges
    assert found["up_ends"] > found["down_starts"] + 5.0
    assert found["down_starts"] == pytest.approx(3.0 * math.cosh(1.5), abs=0.1)


@pytest.mark.slow
def test_the_balance_is_right_to_a_percent_in_every_row_and_one_term_in_all_but_the_first(rows):
    assert len(rows.rows) == 13
    off = {many: np.abs([errors_of(r, many) for r in rows.rows]) for many in (True, False)}
    assert off[True].max() < 1.0
    assert off[False][1:].max() < 10.0 and 10.0 < off[False][0, 0] < 12.0


def test_a_load_that_comes_and_goes():
    p = KickedLoadParams(size=1.0, rate=2.0, turn_s=3.0, kick=0.5, kick_hz=0.25, kick_s=2.0)
    by_hand = {0.0: 1.0, 1.0: 1.0 + 2.0 + 0.5, 2.0: 5.0, 3.0: 7.0, 5.0: 3.0, 7.0: 1.0}
    assert [kicked_load.step(p, t) for t in by_hand] == pytest.approx(list(by_hand.values()), rel=1e-12)


@pytest.mark.slow
def test_the_pictures_have_units_on_their_axes(loops):
    found = chatter_pictures(loops)
    assert len({p.name for p in found}) == 4
    for picture in found:
        figure = picture.draw()
        assert any("(um)" in a.get_xlabel() or "(ms)" in a.get_xlabel() for a in figure.axes), picture.name
