"""Delay of the self-organising network: the linear loop, its roots, and the simulated loop against a second writing."""

import numpy as np
import pytest

from leadscrew.studies.sofnn_tangent.claims_delay import DIGEST_MAP, gap, kind_of
from leadscrew.studies.sofnn_tangent.delay import AXIS_KEEP, RULE_SLOPE, TABLE_SLOPE, kalman_gain, radius, tooth_gain
from leadscrew.studies.sofnn_tangent.online import STRAIGHT, TABLE, deviations, loop_of
from leadscrew.studies.sofnn_tangent.runs import Loops
from tests.studies.whole import claims_of


@pytest.fixture(scope="module")
def loops():
    return Loops()


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


def test_slopes_at_rest_are_those_of_the_printed_table_and_of_the_trained_rules():
    assert TABLE_SLOPE == 1.0
    assert pytest.approx(2.038709 / 2.0, abs=1e-6) == RULE_SLOPE


@pytest.mark.parametrize(
    ("assumed", "late", "k_e", "kappa"),
    [
        (6, 4, 6 / 90, 0.8541),
        (6, 14, 6 / 90, 0.8541),
        (12, 4, 6 / 90, 0.8541),
        (4, 4, 6 / 90, 1.0),
        (8, 2, 0.2, 0.8541),
    ],
)
def test_the_largest_root_is_the_growth_of_the_loop_stepped_in_time(assumed, late, k_e, kappa):
    found = radius(assumed, late, k_e, kappa=kappa)
    assert growth(assumed, late, k_e, kappa) == pytest.approx(found, abs=1e-3)


def test_the_largest_root_of_the_accumulating_form_is_its_growth():
    found = radius(6, 7, 6 / 45, kg=0.7, accumulate=True)
    assert growth(6, 7, 6 / 45, kalman_gain(), True, 0.7) == pytest.approx(found, abs=1e-3)


def test_a_comb_whose_loop_gain_is_below_one_at_its_teeth_settles_with_any_delay():
    assert tooth_gain(6, 6 / 90) < 1.0
    assert max(radius(6, m, 6 / 90) for m in range(40)) < 1.0


def test_replaced_at_once_as_printed_the_comb_is_unstable_for_most_delays():
    unstable = [m for m in range(25) if radius(6, m, 6 / 90, kappa=1.0) >= 1.0]
    assert len(unstable) > 15 and 5 not in unstable


def test_what_a_late_rms_is_called():
    assert [kind_of(v) for v in (0.04, 0.31, 1.0, 7.8)] == ["settles", "swings", "swings", "breaks"]
    assert {kind_of(v) for v in DIGEST_MAP.values()} == {"settles", "swings", "breaks"}


@pytest.mark.slow
@pytest.mark.parametrize(("assumed", "late"), [(8, 6), (6, 4), (12, 12), (4, 2)])
def test_a_step_with_a_wrong_delay_is_that_of_the_second_writing(loops, assumed, late):
    from tangent_oracle import Control, cut

    from leadscrew.neural.inference_net import W0

    samples, at = 300, 50
    texture = np.where(np.arange(samples) >= at, -5.0, 0.0)
    line = np.zeros(samples)
    control = Control(k_e=0.4, delay=assumed)
    expected = cut(line, line, control, W0, texture=texture, sensor_delay=late, bias=0.0, waiting=1).e
    changes = {
        "controller.k_e": 0.4,
        "controller.delay": assumed,
        "sensor.trailing_s": late * 0.01,
        "disturbance.step_at": at * 0.01,
    }
    found = deviations(loop_of(loops, TABLE, "step", changes).start(), samples)
    assert found == pytest.approx(expected, abs=1e-6)


@pytest.mark.slow
def test_near_rest_the_simulated_network_decays_as_the_largest_root_says(loops):
    changes = {**STRAIGHT, "disturbance.step": -0.02, "disturbance.step_at": 0.0, "controller.delay": 6}
    changes["sensor.trailing_s"] = 0.02
    e = np.abs(deviations(loop_of(loops, TABLE, "step", changes).start(), 1800))
    rate = (e[1500:1800].max() / e[700:1000].max()) ** (1.0 / 800.0)
    assert rate == pytest.approx(radius(6, 2, 6 / 90), abs=2e-3)


@pytest.mark.slow
@pytest.mark.xdist_group("whole sofnn_tangent")
def test_claims_on_the_delay():
    claims = claims_of("sofnn_tangent")
    assert claims["stored_boundary_high"].measured < claims["stored_boundary"].measured
    four, six = claims["delay_24_wave"], claims["delay_24_wave_6"]
    assert "m_c = 4" in four.statement and "m_c = 6" in six.statement
    assert four.measured <= 0.85 < six.measured  # with the digest's own m_c it is missed


def test_a_limit_may_lie_anywhere_between_the_values_that_it_parts():
    assert gap([(0.1, 0.3), (0.2, 0.0)], 0.25) == (0.2, 0.3)
