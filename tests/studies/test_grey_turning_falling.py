"""Figures 9 and 10 of the paper: the overshoot is the entry's, the depth's falls are dips."""

import numpy as np
import pytest
from turning_runs import reproduction

from leadscrew.studies.grey_turning.figures_falling import falling_pictures
from tests.studies.whole import claims_of, together

pytestmark = together("grey_turning")


@pytest.fixture(scope="module")
def found():
    return reproduction()


@pytest.fixture(scope="module")
def claims():
    return claims_of("grey_turning")


def test_the_largest_force_comes_before_the_depth_changes(found):
    for name in ("s9_tfc", "s9_b"):
        assert (found.fall[name].y.argmax(axis=1) < 100).all()


def test_every_fall_of_the_depth_lowers_the_force_first(found):
    for name in ("s9_tfc", "s9_b", "s6_tfc", "s6_b"):
        mean = found.fall[name].y.mean(axis=0)
        for k in (100, 200, 300, 400):
            assert mean[k + 10] < mean[k] - 5.0


def test_between_the_falls_the_feed_is_what_equation_1_asks_for(found):
    feed = found.fall["s9_b"].feed
    for depth, until in ((1.0, 2.0), (0.8, 4.0), (0.6, 6.0), (0.4, 8.0)):
        asked = 1200.0 * (150.0 / (2256.3 * depth)) ** (1.0 / 0.77)
        k = round(until / 0.02)
        assert feed[:, k - 20 : k].mean() == pytest.approx(asked, rel=0.02)


def test_at_the_last_depth_the_feed_cannot_give_the_force(claims):
    limit = 2256.3 * 0.2 * (150.0 / 1200.0) ** 0.77
    assert claims["falling_to_02_force"].measured == pytest.approx(limit, rel=5e-3)


def test_what_the_paper_says_of_the_falling_depth_is_judged_from_the_numbers(claims):
    beyond = claims["falling_no_overshoot"]
    assert beyond.verdict == "not reproduced" and beyond.kind == "report"
    assert beyond.measured > 2.2 and beyond.reason.startswith("above the digest's 2.2 %")
    assert claims["falling_steady_late"].verdict == "not reproduced"
    assert claims["falling_overshoot_tfc"].basis == "fitted to this number"


def test_a_depth_that_falls_at_once_takes_nearly_its_share_of_the_force(claims):
    for depth, share in ((8, -20.0), (6, -25.0), (4, -100.0 / 3.0)):
        assert claims[f"falling_ideal_dip_{depth}"].measured == pytest.approx(share, abs=2.0)


def test_the_error_by_window_shows_where_the_papers_ratio_holds(found):
    t, b = (found.long[f"s9_{law}"] for law in ("tfc", "b"))
    ratio = {w: b.steady(w).mean() / t.steady(w).mean() for w in ((1.5, 2.0), (3.0, 4.0))}
    assert ratio[1.5, 2.0] < 0.6 < 0.8 < ratio[3.0, 4.0] < 1.2


def test_pictures_of_figures_9_and_10_have_the_papers_length(found):
    drawn = {p.name: p.draw() for p in falling_pictures(found.loops, found)}
    force, feed = drawn["fig9_tfc_falling_depth"].axes
    assert force.get_xlim() == feed.get_xlim() == (0.0, 8.0)
    assert max(np.max(line.get_ydata()) for line in force.lines) > 200.0
