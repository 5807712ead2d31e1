"""The slope-limited NPID and the one with its gain behind the PID: worked numbers, slopes, chatter, limits, bits."""

import math

import numpy as np
import pytest

from leadscrew.controllers import _npid as cosh
from leadscrew.controllers import _npid_after as behind
from leadscrew.controllers import _npid_slope as limited
from leadscrew.controllers._npid import npid
from leadscrew.controllers._npid_after import npid_after
from leadscrew.controllers._npid_slope import npid_slope
from leadscrew.references._sine import sine
from leadscrew.references._step import step
from leadscrew.studies.npid_xytable.tunings import table_pid
from leadscrew.util.errors import ValueRefused
from tests.controllers.test_npid import push
from tests.controllers.xy_loop import PERIOD, outputs, xy_loop

UM = 1e-3
ERRORS = np.random.default_rng(5).normal(scale=3.0 * UM, size=300)
ZEROS = np.zeros(300)


def test_at_es_the_curve_and_its_slope_are_those_worked_by_hand():
    """With k = 2.2 and e = es = 0.5 um: f = es (1 + 1.2 (1 - pi / 4)), f' = 1 + 1.2 / 2."""
    p = npid_slope.params
    assert limited.curve(p, -0.5 * UM) == pytest.approx(-0.5 * UM * (1.0 + 1.2 * (1.0 - math.pi / 4.0)), rel=1e-14)
    assert limited.slope(p, -0.5 * UM) == pytest.approx(1.6, rel=1e-14) and limited.slope(p, 0.0) == 1.0
    assert limited.slope(p, 1.0) == pytest.approx(2.2, rel=1e-6) and limited.curve(p, 0.0) == 0.0


@pytest.mark.parametrize(
    ("law", "p"),
    [
        (limited, npid_slope.params),
        (cosh, npid.params),
        (cosh, npid.params._replace(clip_error=True)),
        (cosh, npid.params._replace(error_unit_per_mm=1.0)),
        (behind, npid_after.params),
    ],
)
def test_the_slope_of_every_law_is_the_derivative_of_its_curve(law, p):
    h = 1e-6 * UM
    for e in (*ERRORS[:100].tolist(), 2.9 * UM, -3.1 * UM, 2.0, -4.0):
        measured = (law.curve(p, e + h) - law.curve(p, e - h)) / (2.0 * h)
        assert law.slope(p, e) == pytest.approx(measured, rel=2e-5, abs=2e-5)


def test_no_error_sees_more_than_k():
    p = npid_slope.params._replace(k=1.7)
    errors = np.concatenate([ERRORS, 1e6 * ERRORS, 1e-9 * ERRORS]).tolist()
    assert all(1.0 <= limited.slope(p, e) <= 1.7 for e in errors)
    assert all(1.0 - 1e-12 <= limited.curve(p, e) / e <= 1.7 for e in errors)


def test_it_is_the_pid_of_the_curve():
    p = npid_slope.params
    scaled = [limited.curve(p, e) for e in ERRORS.tolist()]
    assert outputs(npid_slope, ERRORS, ZEROS) == outputs(table_pid, scaled, ZEROS)


def test_with_k_1_or_alpha_0_both_are_the_plain_pid():
    assert outputs(npid_slope(k=1.0), ERRORS, ZEROS) == outputs(table_pid, ERRORS, ZEROS)
    assert outputs(npid_after(alpha=0.0), ERRORS, ZEROS) == outputs(table_pid, ERRORS, ZEROS)


def test_behind_the_pid_the_gain_multiplies_its_output():
    plain = outputs(table_pid(ki=90.0), ERRORS, ZEROS)
    expected = [math.cosh(0.5 * min(abs(e) / UM, 3.0)) * u for e, u in zip(ERRORS.tolist(), plain, strict=True)]
    assert outputs(npid_after(ki=90.0), ERRORS, ZEROS) == pytest.approx(expected, rel=1e-14)


def test_behind_the_pid_the_limit_is_one_of_the_voltage_and_holds_the_integral():
    block = npid_after(ki=100.0, lower=-5.0, upper=5.0)
    s = block.state
    for _ in range(400):
        s, u = block.step(block.params, s, 1.0, 0.0, PERIOD)
    gain = math.cosh(1.5)
    assert u == pytest.approx(5.0, rel=1e-14)
    assert 5.0 - gain * 100.0 * PERIOD < gain * (1.32 + 100.0 * s.integral) <= 5.0


def tails_um(block, sizes_um):
    """The last half second of the error under constant loads."""
    loop = xy_loop(block, step(target=0.0), disturbance=push)
    return (
        loop.batch(6.0, {"disturbance.size_um": np.array(sizes_um)}, record="true_error")["true_error"][:, -1000:] / UM
    )


@pytest.mark.slow
def test_where_the_cosh_chatters_the_limited_slope_is_quiet():
    """The cosh: 2.3 to 8 um peak to peak at 3 to 10 um (test_npid). What is left is the drift of the slow integral."""
    n = np.arange(1000.0)
    for tail in tails_um(npid_slope(es_um=0.3), [3.0, 5.0, 10.0, 30.0]):
        assert np.ptp(tail) < 0.005 and np.ptp(tail - np.polyval(np.polyfit(n, tail, 1), n)) < 2e-5


def test_with_the_gain_behind_the_chatter_is_nearly_gone():
    swings = np.ptp(tails_um(npid_after, [5.0, 6.0, 7.0, 10.0]), axis=1)
    assert swings == pytest.approx([0.0, 0.9, 0.6, 0.0], abs=0.06)


@pytest.mark.parametrize("block", [npid_slope, npid_after])
def test_the_first_output_after_an_align_is_the_last_one_before(block):
    block = block(ki=5.0)
    s = block.align(block.params, 1.0, 1.0 + 2.5 * UM, 0.7)
    _, u = block.step(block.params, s, 1.0, 1.0 + 2.5 * UM, PERIOD)
    assert u == pytest.approx(0.7, abs=1e-13)


@pytest.mark.sweep
@pytest.mark.parametrize(
    "block", [npid_slope(lower=-0.02, upper=0.02), npid_after(lower=-0.02, upper=0.02, anti_windup=2)]
)
def test_all_engines_give_the_same_bits(block):
    loop = xy_loop(block, sine(amplitude=4.0, frequency=3.0))
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.2, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


def test_a_gain_below_1_and_a_knee_of_0_are_refused():
    with pytest.raises(ValueRefused, match=r"k = 0.9"):
        npid_slope(k=0.9)
    with pytest.raises(ValueRefused, match=r"es_um = 0"):
        npid_slope(es_um=0.0)
