"""The least time of a position step against hand formulas, and against switching times found by another method."""

import math

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import fsolve

from leadscrew.analysis.single_lag import single_lag_time
from leadscrew.analysis.time_optimal import StateLimit, fastest_move
from leadscrew.util.errors import ValueRefused

MASS = (np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([0.0, 1.0]))
"""Position and speed of a mass of 1 kg under a force of at most 1 N."""


def lathe(lags=(0.0008, 0.0015, 0.017), speed=289.0):
    """The chain of the paper, positive duty towards positive x."""
    a, b = np.zeros((4, 4)), np.array([speed / lags[0], 0.0, 0.0, 0.0])
    for i, lag in enumerate(lags):
        a[i, i] = -1.0 / lag
        if i:
            a[i, i - 1] = 1.0 / lag
    a[3, 2] = 1.0
    return a, b


def test_a_mass_takes_twice_the_root_of_the_way():
    """Half the way at +1 N, half at -1 N: 2 s for 1 m, and one period less cannot do it."""
    move = fastest_move(*MASS, position=[1.0, 0.0], distance=1.0, band=1e-6, period=0.01, hold=5)
    assert move.periods == 200 and move.time_s == pytest.approx(2.0)
    assert move.duty[:99] == pytest.approx(1.0) and move.duty[101:199] == pytest.approx(-1.0)
    assert move.largest_error <= 1e-6 < move.one_less


def test_a_mass_with_a_speed_limit_takes_the_trapezoid():
    """D/V + V/a = 1/0.5 + 0.5/1 = 2.5 s."""
    limit = StateLimit(1, 0.5)
    move = fastest_move(*MASS, position=[1.0, 0.0], distance=1.0, band=1e-6, period=0.01, limits=[limit], hold=5)
    assert move.periods == 250


def test_a_wide_band_saves_the_time_to_cross_it():
    """Within 10 mm and at rest from there on is a way of 0.99 m, and the rest of the braking inside the band."""
    narrow = fastest_move(*MASS, position=[1.0, 0.0], distance=1.0, band=1e-6, period=0.01)
    wide = fastest_move(*MASS, position=[1.0, 0.0], distance=1.0, band=0.01, period=0.01)
    assert wide.periods < narrow.periods - 5


@pytest.mark.parametrize("distance", [50.0, 170.0])
def test_switching_times_of_the_lathes_chain_agree(distance):
    """Full duty with three reversals, whose instants SciPy solves for rest at the target: sampled, a period more.

    A band of 2 um lets the last micrometres of the way go: it is entered a period or two before the axis could rest.
    """
    a, b = lathe()
    joined = np.zeros((5, 5))
    joined[:4, :4], joined[:4, 4] = a, b

    def missed(times):
        z = np.zeros(5)
        for duty, seconds in zip((1.0, -1.0, 1.0, -1.0), times, strict=True):
            z[4] = duty
            z = expm(joined * seconds) @ z
        return [z[0] / 289.0, z[1] / 289.0, z[2] / 289.0, z[3] - distance]

    times, _, solved, _ = fsolve(missed, [distance / 289.0 + 0.012, 0.0135, 0.0015, 0.0004], full_output=True)
    assert solved == 1 and (times > 0.0).all()
    rest, band = (fastest_move(a, b, [0.0, 0.0, 0.0, 1.0], distance, size) for size in (1e-6, 0.002))
    assert -0.5e-3 < rest.time_s - times.sum() < 1.5e-3  # in the last half millisecond the axis moves nanometres
    assert 1 <= rest.periods - band.periods <= 3
    assert abs(single_lag_time(distance, 289.0, 0.0193) - times.sum()) < 1.5e-3


def test_where_the_search_begins_does_not_matter():
    a, b = lathe()
    found = {
        fastest_move(a, b, [0.0, 0.0, 0.0, 1.0], 20.0, 0.002, near_s=near).periods for near in (None, 0.05, 0.095, 0.12)
    }
    assert len(found) == 1


def test_the_sequence_does_what_it_says():
    a, b = lathe()
    move = fastest_move(a, b, [0.0, 0.0, 0.0, 1.0], 50.0, 0.002)
    joined = np.zeros((5, 5))
    joined[:4, :4], joined[:4, 4] = a, b
    step, z, x = expm(joined * 1e-3), np.zeros(5), []
    for duty in np.concatenate([move.duty, np.zeros(500)]):
        z[4] = duty
        z = step @ z
        x.append(z[3])
    assert abs(move.duty).max() <= 1.0 + 1e-9
    assert abs(np.array(x[move.periods - 1 :]) - 50.0).max() == pytest.approx(move.largest_error, abs=1e-6)
    assert abs(x[move.periods - 2] - 50.0) > 0.002


def test_one_lag_takes_the_way_over_the_speed_and_two_ln_2():
    assert single_lag_time(170.0, 289.0, 0.0193) == pytest.approx(170.0 / 289.0 + 2 * 0.0193 * math.log(2.0), abs=1e-9)
    assert single_lag_time(1.0, 1.0, 1e-6) == pytest.approx(1.0, abs=2e-6)


@pytest.mark.slow
def test_one_lag_is_the_limit_of_many_periods():
    """Speed and position alone, a period of 0.1 ms: the programme finds the formula, with and without a top speed."""
    a, b = np.array([[-1 / 0.02, 0.0], [1.0, 0.0]]), np.array([100.0 / 0.02, 0.0])
    for top, limits in ((math.inf, ()), (60.0, (StateLimit(0, 60.0),))):
        move = fastest_move(a, b, [0.0, 1.0], 4.0, 1e-5, period=1e-4, limits=limits)
        assert move.time_s == pytest.approx(single_lag_time(4.0, 100.0, 0.02, top), abs=2e-4)


def test_a_top_speed_that_is_never_reached_costs_nothing():
    assert single_lag_time(0.5, 100.0, 0.02, 99.0) == single_lag_time(0.5, 100.0, 0.02)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: single_lag_time(0.0, 1.0, 1.0), "distance"),
        (lambda: single_lag_time(1.0, 1.0, -1.0), "lag"),
        (lambda: fastest_move(*MASS, [1.0, 0.0], distance=-1.0, band=1.0), "distance"),
        (lambda: fastest_move(*MASS, [1.0, 0.0], distance=1.0, band=0.0), "band"),
    ],
)
def test_what_is_no_move_is_refused(call, says):
    with pytest.raises(ValueRefused, match=says):
        call()
