"""The limited axis of the study: its bound by a second search, and where its PWM timer lets a controller stand."""

import math

import numpy as np
import pytest
from scipy.optimize import linprog, minimize_scalar

from leadscrew.plants._lathe_servo_limited import LatheLimitedParams, chain_matrices, lathe_servo_limited
from leadscrew.plants._linear import hold_matrices
from leadscrew.studies.vud_lathe import limits as r
from leadscrew.studies.vud_lathe.scenarios import STEPS
from tests.studies.lathe_lab import lab

SHORT = STEPS["m50"].scenario
PREPARED = lathe_servo_limited.prepare(lathe_servo_limited.params, 1e-3)
TRANSITION, DRIVE = (m[..., :4] for m in hold_matrices(*chain_matrices(LatheLimitedParams()), 1e-3))
TRANSITION = TRANSITION[:4]


def driven(duties, state):
    for u in duties:
        state = lathe_servo_limited.step(PREPARED, state, -u, 1e-3)
    return state


def best_tail(state, distance, periods, hold=12):
    """Least possible largest error from ``periods`` on, by a dense programme over the duties alone."""
    n = periods + hold
    powers = [DRIVE]
    for _ in range(n):
        powers.append(TRANSITION @ powers[-1])
    free = [np.array(state[:4])]
    for _ in range(n):
        free.append(TRANSITION @ free[-1])

    def rows(at, output):
        return np.array([[powers[k - 1 - j][output] if j < k else 0.0 for j in range(n)] for k in at])

    at = range(periods, n + 1)
    x, ones = rows(at, 3), np.ones((hold + 1, 1))
    away = distance - np.array([free[k][3] for k in at])
    current, ampere = rows(range(1, n + 1), 1), np.array([z[1] for z in free[1:]])
    none = np.zeros((n, 1))
    found = linprog(
        np.append(np.zeros(n), 1.0),
        np.vstack([np.c_[x, -ones], np.c_[-x, -ones], np.c_[current, none], np.c_[-current, none]]),
        np.concatenate([away, -away, 7.5 - ampere, 7.5 + ampere]),
        np.c_[np.vstack([rows([n], output) for output in range(3)]), np.zeros(3)], -free[n][:3],
        [(-1.0, 1.0)] * n + [(0.0, None)], method="highs",
    )  # fmt: skip
    return found.x[-1] if found.status == 0 else 9.0


@pytest.mark.slow
@pytest.mark.parametrize(("distance", "fewest"), [(50.0, 214), (170.0, 678)])
def test_the_axis_with_its_limits_acting_is_not_faster_than_the_bound(distance, fewest):
    """The plant itself at full duty up to a switch that is searched for, then braking, then a programme for the rest.

    At the switch the speed is held at its limit and the current still pushes outward, which the bound does not know.
    """
    least = {}
    for periods in (fewest - 1, fewest):
        found = []
        for switch in range(periods - 15, periods - 12):
            head = driven(np.ones(switch), lathe_servo_limited.state)

            def error(duty, head=head, left=periods - switch - 3):
                return best_tail(driven([duty, -1.0, -1.0], head), distance, left)

            found += [
                minimize_scalar(error, bounds=(low, low + 0.5), method="bounded", options={"xatol": 1e-5}).fun
                for low in (-1.0, -0.5, 0.0, 0.5)
            ]
        least[periods] = min(found)
    assert least[fewest - 1] > 0.002 > least[fewest]
    assert r.bound(lab(), distance, True).periods == fewest


@pytest.mark.slow
@pytest.mark.parametrize("controller", ["paper.vud", "corrected.vud_beta_e", "corrected.vud_beta_e_half"])
def test_a_controller_stands_inside_its_own_dead_zone(controller):
    """At rest for the last half second, and no farther than the law's quiet zone and half a count of the grating."""
    run = r.tried_on(lab(), controller, SHORT, "limited")
    position = run["actual.position"][-500:]
    assert np.ptp(position) < 1e-6
    away = 1000.0 * abs(run["command"][-1] - position[-1])
    assert 2.0 < away <= r.standing_um(controller, 0.5e-3) + 0.3125


def test_a_quiet_zone_is_where_the_pd_law_says():
    """0.0005 of duty at 47.6/190 a millimetre is 1.996 um: three counts of 0.625 um, and not four."""
    assert r.standing_um("ours.pd", 0.5e-3) == pytest.approx(1.875)
    assert r.standing_um("ours.pd", 4.5e-3) == pytest.approx(0.625 * math.floor(4.5e-3 * 190e3 / 47.6 / 0.625))
