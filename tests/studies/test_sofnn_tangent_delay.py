"""Delay of the self-organising network: the linear loop, its roots, and the simulated loop against a second writing."""

import numpy as np
import pytest

from leadscrew.studies.sofnn_tangent.cuts import STRAIGHT, TABLE, deviations
from leadscrew.studies.sofnn_tangent.delay import (
    AXIS_KEEP,
    K_E,
    RULE_SLOPE,
    TABLE_SLOPE,
    delay_map,
    kalman_gain,
    radius,
)
from tests.studies.tangent_lab import lab


def growth(assumed, late, k_e, kappa, accumulate=False, kg=1.0, gain=0.95, samples=3000):
    """Growth a sample of the linear loop, stepped equation by equation from a small start."""
    w, levels, x, d = np.zeros(samples), np.zeros(samples), np.zeros(samples), np.zeros(samples)
    x[0] = 1e-3
    for k in range(1, samples):
        x[k] = AXIS_KEEP * x[k - 1] + (1.0 - AXIS_KEEP) * d[k - 1]
        seen = gain * x[k - late] if k >= late else 0.0
        levels[k] = k_e * seen
        if accumulate:
            w[k] = w[k - 1] - kappa * TABLE_SLOPE * kg * levels[k]
        else:
            old = w[k - assumed] if k >= assumed else 0.0
            w[k] = (1.0 - kappa) * w[k - 1] + kappa * (old - TABLE_SLOPE * kg * levels[k])
        d[k] = 2.5 * (w[k] - RULE_SLOPE * levels[k])
    size = [np.abs(x[a : a + 300]).max() for a in (samples - 1300, samples - 300)]
    return (size[1] / size[0]) ** (1.0 / 1000.0)


def test_the_steady_gain_of_the_filter_is_where_its_covariance_comes_to_rest():
    p = 1.0
    for _ in range(200):
        p = p * 0.01 / (p + 0.01) + 0.05
    assert kalman_gain(0.01, 0.05) == pytest.approx(p / (p + 0.01), rel=1e-12)


CASES = [(6, 4, 6 / 90, 0.8541), (6, 14, 6 / 90, 0.8541), (12, 4, 6 / 90, 0.8541), (4, 4, 6 / 90, 1.0)]


@pytest.mark.parametrize("case", [*CASES, (8, 2, 0.2, 0.8541), (6, 7, 6 / 45, 0.8541, True, 0.7)])
def test_the_largest_root_is_the_growth_of_the_loop_stepped_in_time(case):
    assumed, late, k_e, kappa, *rest = case
    options = dict(zip(("accumulate", "kg"), rest, strict=False))
    assert growth(*case) == pytest.approx(radius(assumed, late, k_e, kappa=kappa, **options), abs=1e-3)


def test_replaced_at_once_as_printed_the_comb_is_unstable_for_most_delays():
    unstable = [m for m in range(25) if radius(6, m, 6 / 90, kappa=1.0) >= 1.0]
    assert len(unstable) > 15 and 5 not in unstable


@pytest.mark.slow
def test_near_rest_the_simulated_network_decays_as_the_largest_root_says():
    changes = {**STRAIGHT, "disturbance.step": -0.02, "disturbance.step_at": 0.0, "controller.delay": 6}
    changes["sensor.trailing_s"] = 0.02
    e = np.abs(deviations(lab().loop(TABLE, "step").using(changes).start(), 1800))
    rate = (e[1500:1800].max() / e[700:1000].max()) ** (1.0 / 800.0)
    assert rate == pytest.approx(radius(6, 2, 6 / 90), abs=2e-3)


@pytest.mark.slow
def test_roots_and_simulation_agree_at_the_printed_scales_and_less_with_more_gain():
    printed, six = (delay_map(lab(), K_E[name]) for name in ("6/90", "6/15"))
    assert printed.same >= 0.95 * printed.settled.size > six.same
