"""The whole lathe in the study: every claim meets its target, and the accounts of the bars hold together."""

import math

import numpy as np
import pytest

from leadscrew.studies.grey_turning.claims_lathe import last_outside_s
from leadscrew.studies.grey_turning.lathe import stairs
from leadscrew.studies.grey_turning.removal import Account, Removal, roughness_um, steady


def test_dips_are_read_in_the_interval_behind_each_step():
    t = np.arange(0.0, 6.0, 0.02)
    force = np.where((t > 2.1) & (t < 2.2), 120.0, np.where((t > 4.1) & (t < 4.2), 165.0, 150.0))
    first, second = stairs(t, force, 2)
    assert first == pytest.approx((-20.0, 0.0)) and second == pytest.approx((0.0, 10.0))


def test_settling_is_the_last_sample_outside_the_band():
    assert last_outside_s(np.array([[0.0, 1.2, 0.99, 1.06, 1.0, 1.0]]), 1.0, 0.05, 0.02)[0] == pytest.approx(0.06)


def test_the_constant_feed_of_a_peak_lies_between_those_tried():
    """Peaks in proportion to the feed to the power 0.77, times inverse to it: then everything is a power law."""
    feeds = np.geomspace(33.0, 150.0, 6)
    tried = [Account(2400.0 / v, 2.0 * v, 10.0 * v**0.77, 0.0) for v in feeds]
    found = steady(tried, 10.0 * 60.0**0.77)
    assert found.feed_same_peak == pytest.approx(60.0) and found.time_same_peak_s == pytest.approx(40.0)
    assert steady(tried, 1e6).feed_same_peak == pytest.approx(150.0)


def test_theoretical_roughness_of_a_worked_example():
    assert roughness_um(120.0, 1200.0) == pytest.approx(1000.0 * 0.1**2 / 6.4)


@pytest.mark.slow
def test_the_volume_of_a_bar_is_removed_whatever_the_controller():
    found = Removal().accounts("falling")
    volume = math.pi * 50.0 * 10.0 * (1.0 + 0.8 + 0.6 + 0.4)
    for name, account in found.items():
        assert account.rate * account.time_s == pytest.approx(volume, rel=0.005), name
