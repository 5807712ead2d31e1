"""Claims of ``grey_turning`` about the force law, and the published facts behind them."""

import numpy as np
import pytest

from leadscrew.identify.cutting_force import fit_forces
from leadscrew.identify.cutting_force_table import read_force_table
from leadscrew.studies.grey_turning import force_facts
from leadscrew.studies.grey_turning.claims_force_law import force_law_claims
from leadscrew.studies.grey_turning.entry import PERIOD_S, entries, reading_noise
from leadscrew.studies.grey_turning.figures_force_law import entry_figure, fits_figure
from tests.docs.snippets import ROOT


@pytest.fixture(scope="module")
def entered():
    """The simulated entries, by the law of the four feeds."""
    return entries(fit_forces(force_facts.cuts(force_facts.FEED_SERIES)).law)


@pytest.fixture(scope="module")
def claims(entered):
    """By what stands behind the study's name."""
    return {c.id.partition(".")[2]: c for c in force_law_claims(entered=entered)}


@pytest.mark.slow
def test_every_claim_meets_its_target(claims):
    assert [name for name, c in claims.items() if c.passed is False] == []
    assert all(c.reason and c.source for c in claims.values()) and len(claims) > 30


def test_the_facts_are_those_of_the_example_file():
    table = read_force_table(ROOT / "examples" / "turning_forces.csv")
    facts = force_facts.cuts(force_facts.DISTINCT)
    measured = read_force_table(ROOT / "examples" / "turning_forces.csv", columns={"feed": "measured feed"})
    for name in ("feed", "depth", "force"):
        np.testing.assert_array_equal(getattr(table, name), getattr(facts, name))
    np.testing.assert_array_equal(measured.feed, force_facts.cuts(force_facts.DISTINCT, measured=True).feed)


def test_the_published_r2_is_one_of_the_specific_force_by_scipy_too(claims):
    from scipy.stats import linregress

    feed, force = np.array(force_facts.MEASURED_FEED[:4]), np.array(force_facts.FORCE[:4])
    line = linregress(np.log(feed), np.log(force / feed))
    assert claims["force_fit_published_r2"].measured == pytest.approx(line.rvalue**2, rel=1e-12)
    assert claims["force_fit_published_kc11"].measured == pytest.approx(np.exp(line.intercept), rel=1e-12)
    assert claims["force_fit_published_exponent"].measured == pytest.approx(-line.slope, rel=1e-12)


def test_errors_of_both_laws_are_of_the_same_eight_cuts(claims):
    f, a, force = (np.array(x) for x in (force_facts.FEED, force_facts.DEPTH, force_facts.FORCE))
    published = 1609.5 * a * f**0.864
    assert claims["force_fit_error"].target == pytest.approx(100.0 * np.sqrt(np.mean((force / published - 1.0) ** 2)))
    assert "published R2 0.932" in claims["force_fit_error"].reason


def test_the_chip_builds_up_over_one_revolution_as_the_way_of_the_tool_says(entered):
    """Rigid and at a constant feed the chip grows in proportion to time until the first turn is done."""
    turn = 60.0 / force_facts.ENTRY.spindle_rpm
    half = entered.none.force[round(0.5 * turn / PERIOD_S)] / entered.none.level
    law = fit_forces(force_facts.cuts(force_facts.FEED_SERIES)).law
    assert half == pytest.approx(0.5**law.exponent, abs=0.05)


def test_scatter_is_of_noise_and_runout_and_does_not_depend_on_the_entry(entered):
    for run in (entered.even, entered.sudden, entered.none):
        settled = run.time >= 1.0
        assert run.level == pytest.approx(723.0, abs=1.0) and run.scatter == pytest.approx(26.6, abs=0.6)
        assert run.force[settled].std() == pytest.approx(7.23 / np.sqrt(2.0), rel=0.05)
        assert (run.raw - run.force)[settled].std() == pytest.approx(reading_noise(), rel=0.03)


@pytest.mark.slow
def test_pictures_are_drawn_from_the_same_runs(entered):
    assert len(fits_figure().axes) == 3
    left, right = entry_figure(entered).axes
    assert left.get_ylabel() == "main cutting force (N)" and "79 %" in right.get_title()
