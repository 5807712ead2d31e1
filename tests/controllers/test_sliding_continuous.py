"""The laws without sampling: against SciPy's Radau on the equations written out again, and against known errors."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.controllers._sliding.continuous import (
    csmc_ideal,
    fsmc_ideal,
    in_motion,
    seen_in_mm,
    smc_ideal,
    smc_integral_ideal,
)
from leadscrew.friction.lugre import HAT, LuGre, steady_bristle
from leadscrew.kernel.loop import Loop
from leadscrew.plants._ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD, ballscrew_stage
from leadscrew.references._sine import sine_motion
from leadscrew.util.errors import BlockError

UM = 1e3
START = 1.0 * 2.0 * math.pi / TRAVEL_MM_PER_RAD


def loop_of(block, **more):
    """On sin 2 pi t mm, in motion at the start."""
    plant = seen_in_mm(ballscrew_stage).starting(speed=START, bristle=steady_bristle(LuGre(), START))
    parts = {"sample": 1e-3, "metrics": {}, "rtol": 1e-7, "atol": 1e-12} | more
    return Loop(reference=sine_motion(), controller=in_motion(block, START), plant=plant, period=None, **parts)


def g(v, v_s):
    return 6.24 + 3.12 * math.exp(-((v / v_s) ** 2))


def lugre(s0, s1, s2, v_s, v, z):
    rate = v - abs(v) * z * s0 / g(v, v_s)
    return rate, s0 * z + s1 * rate + s2 * v


def radau_error(friction_from, seconds):
    """Error of the conventional law in um at every millisecond, by Radau, with f_hat from the same speeds."""
    w, amplitude, lam, phi, eta = 2.0 * math.pi, 1.0 / TRAVEL_MM_PER_RAD, 150.0, 0.1, 120.0

    def rates(t, x):
        angle, v, z, believed = x
        e, target_v = angle - amplitude * math.sin(w * t), amplitude * w * math.cos(w * t)
        dz, friction = lugre(1e5, math.sqrt(1e5), 0.4, 1e-3, v, z)
        driving = target_v if friction_from == 1 else v
        dz_hat, f_hat = lugre(2e5, 2.0 * math.sqrt(1e5) * (friction_from != 2), 1.2, 5e-3, driving, believed)
        gain = (g(v, 5e-3) + abs(v)) / INERTIA + eta
        s = v - target_v + lam * e
        u = -w * w * amplitude * math.sin(w * t) - lam * (v - target_v) - gain * min(1.0, max(-1.0, s / phi))
        return [v, (f_hat + INERTIA * u - friction) / INERTIA, dz, dz_hat]

    start = [0.0, START, steady_bristle(LuGre(), START), steady_bristle(HAT, START)]
    t = np.arange(0.0, seconds, 1e-3)
    angle = solve_ivp(rates, (0.0, seconds), start, "Radau", t, rtol=1e-8, atol=1e-13).y[0]
    return UM * (np.sin(w * t) - TRAVEL_MM_PER_RAD * angle)


@pytest.mark.slow
@pytest.mark.parametrize("friction_from", [1, 2])
def test_it_is_the_paper_s_equations_through_a_reversal(friction_from):
    run = loop_of(smc_ideal(friction_from=friction_from)).run(0.3, record="true_error")
    expected = radau_error(friction_from, 0.3)
    assert np.ptp(expected) > 0.3
    assert np.abs(UM * run["true_error"] - expected).max() < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("block", "largest"), [(smc_ideal, 0.327), (smc_integral_ideal, 0.084), (csmc_ideal, 0.164), (fsmc_ideal, 0.0528)]
)
def test_each_law_leaves_its_known_error(block, largest):
    error = UM * loop_of(block, sample=2e-4, rtol=1e-6).run(2.0, record="true_error")["true_error"][5000:]
    assert np.abs(error).max() == pytest.approx(largest, rel=0.01)


@pytest.mark.slow
def test_believed_friction_from_the_measured_speed_with_its_damping_runs_away():
    """The believed damping exceeds the true one by 316 N m s/rad: the torque grows until the bristles slip."""
    run = loop_of(smc_ideal(friction_from=3), sample=1e-5).run(0.3, record="output")
    assert np.abs(run["output"]).max() > 5000.0


@pytest.mark.slow
def test_without_believed_friction_the_boundary_layer_holds_it_at_the_price_of_an_error():
    """In steady sliding J K sat(s / phi) must be F, so e = phi / lam F / (J K); at the largest speed e' is small."""
    run = loop_of(smc_ideal(friction_from=0), rtol=1e-6).run(1.2, record="true_error")
    share = (6.24 + 0.4 * START) / (6.24 + START + 120.0 * INERTIA)
    assert UM * run["true_error"][1000] == pytest.approx(UM * TRAVEL_MM_PER_RAD * 0.1 / 150.0 * share, rel=0.005)


def test_a_law_without_sampling_in_a_sampled_loop_is_refused():
    with pytest.raises(BlockError, match="period=None"):
        Loop(reference=sine_motion(), controller=csmc_ideal, plant=seen_in_mm(ballscrew_stage), metrics={})
