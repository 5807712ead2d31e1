"""Sensor and controller two by two, and the axes that are off: what a drawn axis does, checked one by one."""

import numpy as np
import pytest

from leadscrew.studies.vud_lathe import axes
from leadscrew.studies.vud_lathe.scenarios import STEPS
from tests.studies.lathe_lab import lab

SHORT, LONG = (step.scenario for step in STEPS.values())


def test_every_controller_meets_the_same_axes():
    first, again = axes.drawn_axes(), axes.drawn_axes()
    assert all(np.array_equal(first[k], again[k]) for k in first)
    worse = axes.drawn_axes(23.0)
    assert np.allclose(worse["plant.lead_error"], first["plant.lead_error"] * 23.0 / 12.0)
    assert np.array_equal(worse["plant.backlash_mm"], first["plant.backlash_mm"])


def test_the_draws_stay_inside_what_is_said_of_them():
    drawn = axes.drawn_axes()
    for key, (low, high) in (axes.SCREW | axes.RULER).items():
        assert len(drawn[key]) == axes.DRAWS
        assert low <= drawn[key].min() and drawn[key].max() <= high


def test_an_axis_behind_the_encoder_is_off_by_its_screw_which_a_hand_can_work_out():
    """At rest at the count of -170 mm the table is off by lead, warmth, half the play and the cyclic error."""
    drawn = {k: v[:12] for k, v in axes.drawn_axes().items() if k.startswith("plant.")}
    batch = lab().batch("ours.pd", LONG, drawn, machine="screw", sensor="encoder", record="actual.position")
    found = batch.signals["actual.position"][:, -1] + 170.0
    scale = drawn["plant.lead_error"] + 11.7e-6 * drawn["plant.warming_K"]
    cyclic = drawn["plant.cyclic_error_mm"] * np.sin(2.0 * np.pi * -170.0 / 10.0)
    by_hand = -170.0 * scale + cyclic
    assert np.all(np.abs(found - by_hand) <= 0.5 * drawn["plant.backlash_mm"] + 0.001 + 2e-6)


@pytest.mark.slow
def test_an_axis_without_faults_keeps_within_half_a_count_of_the_grating():
    clean = {k: np.zeros(2) for k in (*axes.SCREW, *axes.RULER)}
    done = lab().batch("corrected.vud_beta_e", SHORT, clean, machine="screw", sensor="grating")
    plain = lab().run("corrected.vud_beta_e", SHORT).metrics["error_after_2s"]
    assert done.metrics["error_after_2s"] == pytest.approx([plain, plain], abs=1e-9)


@pytest.mark.slow
def test_later_errors_are_never_larger():
    early, late = (axes.errors_um(lab(), "corrected.vud_beta_e", LONG, "grating", after_s=t) for t in (2.0, 2.5))
    assert np.all(late <= early) and late.max() < early.max()


@pytest.mark.slow
def test_a_dead_zone_that_the_controller_knows_exactly_costs_nothing_much():
    without = axes.friction_sweep(lab(), SHORT, integral=False, share=0.0)
    exact = axes.friction_sweep(lab(), SHORT, integral=False, share=1.0)
    assert exact["error_after_2s"].max() < 0.1 * without["error_after_2s"].max()


def test_the_spread_is_the_error_that_95_of_100_axes_stay_below_and_the_largest():
    assert axes.spread(np.arange(201.0)) == (190.0, 200.0)
