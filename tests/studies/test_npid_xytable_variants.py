"""The law of the paper and its variants: measures against other ways of finding the same."""

import math

import numpy as np
import pytest
from scipy import stats

from leadscrew.analysis.stability.margins import margins
from leadscrew.controllers._npid import npid
from leadscrew.controllers._npid_after import npid_after
from leadscrew.references._eased_sine import eased_sine
from leadscrew.references._step import step
from leadscrew.studies.npid_xytable.cutting import load_volts, sines, swing_um
from leadscrew.studies.npid_xytable.laws import straight_fit
from leadscrew.studies.npid_xytable.rejection import opened
from leadscrew.studies.npid_xytable.tunings import table_pid
from tests.controllers.xy_loop import xy_loop
from tests.studies.npid_lab import lab


def test_the_straight_line_through_the_gain_is_scipys():
    x, k, line, r2 = straight_fit()
    found = stats.linregress(x, np.cosh(0.5 * x))
    assert k == pytest.approx(np.cosh(0.5 * x), rel=1e-14) and r2 == pytest.approx(found.rvalue**2, rel=1e-12)
    assert line == pytest.approx(found.intercept + found.slope * x, rel=1e-12)


def test_the_integral_of_table_1_takes_1600_seconds():
    """Slowest pole of the closed loop of Table I and equation (1), by python-control."""
    import control

    loop = control.tf([0.006805, 1.32, 0.000825], [1.0, 0.0]) * control.tf([69380.0], [1.0, 144.8, 166.3])
    slow = max(control.feedback(loop, 1).poles().real)
    assert slow == pytest.approx(-6.24e-4, abs=5e-7)


@pytest.mark.slow
@pytest.mark.parametrize(("block", "most", "calm"), [(npid, 6.35, 21.8), (npid_after, 3.06, 0.67)])
def test_the_place_of_the_gain_decides_on_chatter_on_another_simulation_too(block, most, calm):
    """The study's plant, exact at once, and the plain one in 25 us steps."""
    _, peak, change = sines(lab(), block, "sine_1mm", {"reference.amplitude": np.array([1.0])})
    run = xy_loop(block, eased_sine(amplitude=1.0, frequency=0.7)).run(12.0, record=("true_error", "output"))
    stepped = 1e3 * np.abs(run["true_error"][4000:]).max(), 1e3 * np.diff(run["output"][4000:]).std()
    assert (peak[0], change[0]) == pytest.approx((most, calm), rel=0.005)
    assert stepped == pytest.approx((most, calm), rel=0.005)


@pytest.mark.slow
def test_a_constant_load_is_counted_as_the_error_that_it_leaves_under_the_pid():
    """5 um, less the share of the spring, a0 / (b Kp) = 0.1816 %, and what the slow integral took in 3 s."""
    held = (
        lab()
        .loop("paper.pid", "constant_load")
        .batch(3.0, {"disturbance.first.amplitude": load_volts(np.array([5.0]))}, record="true_error")
    )
    expected = 5.0 / (1.0 + 166.3 / (69380.0 * 1.32)) * math.exp(-6.24e-4 * 3.0)
    assert 1e3 * abs(held["true_error"][0, -1]) == pytest.approx(expected, rel=1e-4)
    loud = swing_um(lab(), npid, {"disturbance.first.amplitude": load_volts(np.array([2.5, 5.0]))})
    assert loud[0] < 1e-3 and loud[1] == pytest.approx(4.89, abs=0.05)


@pytest.mark.parametrize(("lag", "expected"), [(0.5e-3, 2.04), pytest.param(1e-3, 1.81, marks=pytest.mark.slow)])
def test_a_lag_of_the_derivative_eats_the_gain_margin_in_the_time_domain_too(lag, expected):
    """At 1 % less gain than the margin a push dies away, at 1 % more it grows."""
    found = margins(opened(table_pid(filter_s=lag))).gm
    assert found == pytest.approx(expected, abs=0.005)
    for factor, grows in ((0.99, False), (1.01, True)):
        k = factor * found
        block = table_pid(kp=k * 1.32, ki=0.0, kd=k * 0.006805, filter_s=lag)
        run = xy_loop(block, step(target=1e-3)).run(2.0, record="actual")
        early, late = (np.ptp(run["actual"][a:b]) for a, b in ((1000, 1400), (3600, 4000)))
        assert (late > early) == grows
