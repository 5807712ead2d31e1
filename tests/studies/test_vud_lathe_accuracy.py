"""Sensor and controller two by two, and the axes that are off: what a drawn axis does, checked one by one."""

import numpy as np
import pytest

from leadscrew.studies.vud_lathe import accuracy, robustness
from leadscrew.studies.vud_lathe.claims_robustness import _digits
from leadscrew.studies.vud_lathe.runs import STEPS, Loops


@pytest.fixture(scope="module")
def loops():
    return Loops()


def test_every_controller_meets_the_same_axes():
    first, again = accuracy.axes(), accuracy.axes()
    assert all(np.array_equal(first[k], again[k]) for k in first)
    worse = accuracy.axes(23.0)
    assert np.allclose(worse["plant.lead_error"], first["plant.lead_error"] * 23.0 / 12.0)
    assert np.array_equal(worse["plant.backlash_mm"], first["plant.backlash_mm"])


def test_the_draws_stay_inside_what_is_said_of_them():
    drawn = accuracy.axes()
    for key, (low, high) in (accuracy.RANGES | accuracy.RULER_RANGES).items():
        assert len(drawn[key]) == accuracy.DRAWS
        assert low <= drawn[key].min() and drawn[key].max() <= high


def test_an_axis_behind_the_encoder_is_off_by_its_screw_which_a_hand_can_work_out(loops):
    """At rest at the count of -170 mm the table is off by lead, warmth, half the play and the cyclic error."""
    drawn = {k: v[:12] for k, v in accuracy.axes().items() if k.startswith("plant.")}
    batch = loops.batch("ours.pd", STEPS[1], drawn, machine="screw", sensor="encoder", record="actual.position")
    found = batch.signals["actual.position"][:, -1] + 170.0
    scale = drawn["plant.lead_error"] + 11.7e-6 * drawn["plant.warming_K"]
    cyclic = drawn["plant.cyclic_error_mm"] * np.sin(2.0 * np.pi * -170.0 / 10.0)
    by_hand = -170.0 * scale + cyclic
    assert np.all(np.abs(found - by_hand) <= 0.5 * drawn["plant.backlash_mm"] + 0.001 + 2e-6)


@pytest.mark.slow
def test_an_axis_without_faults_keeps_within_half_a_count_of_the_grating(loops):
    clean = {k: np.zeros(2) for k in (*accuracy.RANGES, *accuracy.RULER_RANGES)}
    done = loops.batch("corrected.vud_beta_e", STEPS[0], clean, machine="screw", sensor="grating")
    plain = loops.run("corrected.vud_beta_e", STEPS[0]).metrics["error_after_2s"]
    assert done.metrics["error_after_2s"] == pytest.approx([plain, plain], abs=1e-9)


@pytest.mark.slow
def test_later_errors_are_never_larger(loops):
    early, late = (
        accuracy.errors_um(loops, "corrected.vud_beta_e", STEPS[1], "grating", after_s=t) for t in (2.0, 2.5)
    )
    assert np.all(late <= early) and late.max() < early.max()


@pytest.mark.slow
def test_a_dead_zone_that_the_controller_knows_exactly_costs_nothing_much(loops):
    without = robustness.friction_sweep(loops, STEPS[0], integral=False, share=0.0)
    exact = robustness.friction_sweep(loops, STEPS[0], integral=False, share=1.0)
    assert exact["error_after_2s"].max() < 0.1 * without["error_after_2s"].max()


def test_the_digits_of_a_printed_number_make_its_tolerance():
    assert _digits(0.07) == pytest.approx(0.0051)
    assert _digits(16.6) == pytest.approx(0.051)
    assert _digits(322.0) == pytest.approx(0.51)


def test_the_spread_is_the_error_that_95_of_100_axes_stay_below_and_the_largest():
    assert accuracy.spread(np.arange(201.0)) == (190.0, 200.0)
