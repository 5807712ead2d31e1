"""The lathe of the study against a second program of it, and the numbers of its digest."""

import math

import numpy as np
import pytest
from turning_oracle import Fuzzy, Lathe, grey, run
from turning_runs import reproduction

from leadscrew.studies.grey_turning.claims_plant import open_response, plant_claims
from leadscrew.studies.grey_turning.figures_process import process_pictures

ON_THE_RING = 1171.875
"""Spindle speed at which a step of 1 ms is five of the 256 places a revolution: interpolation is then exact."""
S9 = (28.0, 15.4, 0.0214)


@pytest.fixture(scope="module")
def loops():
    return reproduction().loops


@pytest.fixture(scope="module")
def claims(loops):
    return plant_claims(loops, reproduction())


def both(loops, name, fuzzy, rpm, lathe=None, machine="plant_f"):
    """Filtered force of our loop and of the other program, without noise."""
    changes = {"plant.spindle_rpm": rpm, "plant.runout": 0.01}
    ours = loops.get(name, "noise_free", machine=machine, changes=changes).run(1.5, record=("feedback",))["feedback"]
    return ours, run(fuzzy, 1.5, Lathe(rpm=rpm, **(lathe or {})))["y"]


@pytest.mark.slow
@pytest.mark.parametrize(("law", "reading"), [("tfc", ""), ("gpfc_b", "B"), ("gpfc_a", "A")])
def test_a_second_program_of_the_loop_gives_the_same_force(loops, law, reading):
    ours, theirs = both(loops, f"corrected.{law}_s9", Fuzzy(S9, reading), ON_THE_RING)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-8)


def test_between_the_places_of_the_surface_the_force_is_right_to_twenty_millionths(loops):
    ours, theirs = both(loops, "corrected.tfc_s9", Fuzzy(S9), 1200.0)
    off = np.abs(ours - theirs).max()
    assert 1e-8 < off < 2e-5 * 150.0


@pytest.mark.slow
def test_the_slow_plant_is_that_of_the_second_program(loops):
    ours, theirs = both(
        loops, "corrected.tfc_edge_n", Fuzzy((6.2, 0.96, 0.0029)), ON_THE_RING, {"rate": 20.0, "dead_time_s": 0.02},
        "plant_n",
    )  # fmt: skip
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-8)


def test_the_force_that_settles_is_equation_1s(loops):
    steady = 2256.3 * (35.5 / 1200.0) ** 0.77
    assert steady == pytest.approx(150.0, abs=0.01)
    force = open_response(loops, seconds=1.0)
    assert force[-1] == pytest.approx(steady, rel=1e-6)


def test_the_second_program_predicts_an_exact_growth_of_a_tenth_as_the_vectors_say():
    assert grey([100.0, 110.0, 121.0, 133.1, 146.41]) == pytest.approx(160.8769087394, rel=1e-10)
    assert grey([5.0, 1.0, -1.0, 1.0, -1.0]) is None


@pytest.mark.slow
def test_the_digests_numbers_of_the_plant_are_met(claims):
    assert [(c.id, c.measured, c.target) for c in claims if not c.passed] == []
    assert len(claims) > 15 and all(math.isfinite(c.measured) for c in claims)


@pytest.mark.slow
def test_pictures_of_the_process_can_be_drawn(loops):
    for picture in process_pictures(loops):
        assert picture.draw().axes and picture.caption
