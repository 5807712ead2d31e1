"""Friction of sixty drawn axes from one log each: the truth lies in the intervals, the fit in the right valley."""

import math

import numpy as np
import pytest

from leadscrew.friction.lugre import LuGre
from leadscrew.identify.friction import Residuals, _distinct, _instants, _Problem, fit_friction
from leadscrew.identify.friction_record import Piece, Record, checked, pieces, sliding
from tests.budget import some
from tests.identify.friction_axes import AXES, axis_log, drawn
from tests.identify.friction_records import record

SLOW_STRIBECK = (("plant.friction.stribeck_speed", 0.004),)


def problem_of(log):
    checked_log = checked(*log)
    slide = sliding(checked_log)
    return _Problem(checked_log, slide, slide.inertia, _distinct(checked_log, pieces(checked_log, slide)))


def point(axis):
    """Where the truth lies in the coordinates of the fit."""
    above = axis["static"] - axis["coulomb"]
    return np.log([axis["stiffness"], axis["damping"] / axis["stiffness"], above, axis["stribeck_speed"]])


@pytest.mark.slow
def test_a_stage_with_four_times_the_stribeck_speed_is_not_given_another_friction():
    """v_s = 0.004 rad/s was reported as 0.0027 with a standard error of 0.00002, F_S = 9.36 N m as 9.73."""
    log = record("test", SLOW_STRIBECK)
    fit, true = fit_friction(*log), LuGre(stribeck_speed=0.004)
    for name, value in true._asdict().items():
        off = getattr(fit.friction, name) - value
        assert abs(off) < 3.0 * fit.standard_error[name] and abs(off) < 0.03 * value, name
    assert all(fit.identifiable.values()) and fit.consistent
    # the friction that was reported leaves what no scale makes
    wrong = true._replace(stiffness=94986.3, damping=326.297, static=9.73003, stribeck_speed=0.00270497)
    residuals = Residuals.of(problem_of(log).by_piece(point(wrong._asdict())))
    assert not residuals.consistent and "times" in residuals.why_not


@pytest.mark.slow
def test_intervals_of_drawn_axes_hold_the_truth_and_few_of_the_parameters_are_not_identifiable():
    """Nine of ten intervals of 95 % hold the truth; on three of four axes v_s and F_S are identifiable."""
    inside = dict.fromkeys((*LuGre._fields, "inertia"), 0)
    intervals, identifiable = dict(inside), dict(inside)
    axes = some(range(AXES), 10)
    for k in axes:
        axis = drawn(k)
        fit = fit_friction(*axis_log(axis))
        for name, value in (*fit.friction._asdict().items(), ("inertia", fit.inertia)):
            if fit.identifiable.get(name, True):
                identifiable[name] += 1
                inside[name] += abs(value - axis[name]) <= 1.96 * fit.standard_error[name]
                intervals[name] += 1
    spare = 0 if len(axes) == AXES else 1  # of six axes one may miss
    for name in inside:
        assert inside[name] >= 0.9 * intervals[name] - spare, name
        assert identifiable[name] >= 0.75 * len(axes), name


@pytest.mark.slow
@pytest.mark.parametrize("k", [2, 10])
def test_with_the_true_friction_a_slow_slip_leaves_the_rounding_of_the_scale(k):
    """Axis 2 was shaken loose by fed back rounding, 10 by coarse integration."""
    axis = drawn(k)
    problem = problem_of(axis_log(axis))
    slow = [p for p in problem.pieces if p.length > 4000]
    assert len(slow) == 2
    assert np.max(np.abs(problem._group(point(axis)[None], slow))) < 2.0


def test_residuals_are_judged_by_size_and_colour():
    """By hand: a constant c counts c^2 (1 + 2 (5 + 4 + 3 + 2 + 1) / 6) = 6 c^2 at low frequency."""
    constant = Residuals.of({0.0: np.full(100_000, 0.7)})
    assert constant.rms == pytest.approx(0.7) and constant.slow == pytest.approx(6.0 * 0.49, rel=1e-3)
    assert "not white" in constant.why_not
    alternating = Residuals.of({0.0: np.resize([1.0, -1.0], 100_000)})
    assert alternating.consistent and alternating.slow == pytest.approx(0.0, abs=1e-3)


def test_white_noise_passes_and_twice_the_noise_and_wandering_noise_do_not():
    """300 samples in ten pieces, a hundred times: at most one false alarm, and no alarm missed."""
    random = np.random.default_rng(7)
    alarms = {"white": 0, "twice": 0, "wandering": 0}
    for _ in range(100):
        white = random.standard_normal((10, 30))
        wander = np.empty_like(white)
        wander[:, 0] = white[:, 0]
        for i in range(1, 30):  # unit variance, correlation 0.9 to the next
            wander[:, i] = 0.9 * wander[:, i - 1] + math.sqrt(0.19) * white[:, i]
        for name, r in (("white", white), ("twice", 2.0 * white), ("wandering", wander)):
            alarms[name] += not Residuals.of(dict(enumerate(r))).consistent
    assert alarms["white"] <= 1 and alarms["twice"] == 100 and alarms["wandering"] == 100


def test_one_piece_that_does_not_fit_is_named_among_many_that_do():
    random = np.random.default_rng(3)
    parts = {0.1 * i: random.standard_normal(60) for i in range(20)}
    parts[0.5] = 2.2 * random.standard_normal(60)
    assert "around the standstill at 0.5 s" in Residuals.of(parts).why_not


def reading(speed, n=400, noise=0.0):
    """Counts of a scale that moves ``speed`` counts a sample from 0.3, and the true position."""
    true = 0.3 + speed * np.arange(n)
    return np.floor(true + noise * np.random.default_rng(1).standard_normal(n) + 0.5), true


@pytest.mark.parametrize("speed", [0.013, 0.11, 0.7, 3.3])
def test_the_mean_of_two_readings_is_as_near_to_the_truth_as_its_weight_says(speed):
    y, true = reading(speed)
    steps, weight = _instants(Record(1e-3, np.zeros(400), y, 1.0, 1.0 / math.sqrt(12.0)), Piece(0, 400, 0, 0, 0))
    left = 0.5 * (y[steps] + y[steps + 1] - true[steps] - true[steps + 1])
    assert np.all(np.diff(steps) > 1)
    assert np.max(np.abs(left)) <= min(speed, 1.0) / 2.0 + 1e-9
    assert np.sqrt(np.mean((left * weight) ** 2)) < 1.2


def test_a_stroke_that_repeats_another_count_by_count_counts_once():
    """Its rounding is the same error again: seven copies made the damping look 2.6 times as well known."""
    wave = np.sin(np.arange(100) / 16.0)
    y = np.floor(np.concatenate([wave, -wave, wave, 1.03 * wave]) * 200.0 + 0.5)
    log = Record(1e-3, np.zeros(len(y)), y, 1.0, 0.3)
    strokes = [Piece(100 * i, 100, 0.0, speed, y[100 * i]) for i, speed in enumerate((12.5, -12.5, 12.5, 12.9))]
    assert _distinct(log, strokes) == [strokes[0], strokes[3]]
