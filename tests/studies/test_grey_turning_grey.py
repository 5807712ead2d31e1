"""Grey models in the study: its claims hold, and what they stand on is checked with SciPy and by hand."""

import numpy as np
import pytest
from scipy.signal import lfilter

from leadscrew.studies.grey_turning.claims_grey import grey_claims
from leadscrew.studies.grey_turning.one_step import closed_loops, errors, on_the_load_cell
from leadscrew.studies.grey_turning.runs import Loops


@pytest.fixture(scope="module")
def loops():
    return Loops()


@pytest.fixture(scope="module")
def claims(loops):
    return {c.id.removeprefix("grey_turning."): c for c in grey_claims(loops)}


@pytest.mark.slow
def test_every_required_claim_is_met_and_no_verdict_is_given_where_the_paper_says_nothing(claims):
    missed = [k for k, c in claims.items() if c.kind == "required" and not c.passed]
    assert missed == []
    for claim in claims.values():
        assert (claim.paper is None) == (claim.verdict == "cannot be checked"), claim.id
        assert claim.reason and claim.statement


@pytest.mark.slow
def test_the_printed_equation_is_not_reproduced_and_the_corrected_one_is(claims):
    assert claims["grey_sign_printed"].verdict == "not reproduced"
    assert claims["grey_sign_corrected"].verdict == "reproduced with change"
    assert claims["grey_sign_printed"].measured == pytest.approx(-claims["grey_sign_corrected"].measured, rel=1e-13)


def test_the_cell_filters_as_scipy_does():
    force = 30.0 + 2.0 * 0.02 * np.arange(4000) + 40.0 * np.sin(2.0 * np.pi * 3.0 * 0.02 * np.arange(4000))
    seen = on_the_load_cell(level=30.0, slope=2.0, size=40.0, frequency=3.0)
    # The force that a period applies is measured at its end.
    expected = lfilter([0.2], [1.0, -0.8], np.concatenate(([0.0], force[:-1])))
    assert seen == pytest.approx(expected, abs=1e-9)


@pytest.mark.slow
def test_errors_of_the_last_value_and_of_two_points_are_plain_differences(loops):
    forces = closed_loops(loops, "corrected.tfc_sbn", "plant_n", 4)
    assert np.ptp(forces, axis=0).max() > 0.1
    found = errors(forces)
    step = np.diff(forces, axis=1)
    at = 0.02 * np.arange(1, forces.shape[1])
    expected = np.sqrt(np.mean(step[:, at < 0.8] ** 2, axis=1))
    assert found["last"].transient == pytest.approx(expected, rel=1e-9)
    twice = np.diff(step, axis=1)[:, at[1:] >= 1.0]
    assert found["two_point"].steady == pytest.approx(np.sqrt(np.mean(twice**2, axis=1)), rel=1e-9)
