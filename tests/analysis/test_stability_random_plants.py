"""Random third-order plants with delay: limits of the gain and proved sectors against simulation and python-control."""

import numpy as np
import pytest

from leadscrew.analysis.stability.margins import margins
from tests.analysis import random_plants as r

pytestmark = pytest.mark.slow

FEW = 3
NUMBERS = [FEW, pytest.param(r.COUNT, marks=pytest.mark.slow)]


@pytest.mark.parametrize("count", NUMBERS)
def test_the_nyquist_limit_is_where_the_simulation_begins_to_grow(count):
    for gap in r.gaps(count):
        assert gap.simulated == pytest.approx(gap.nyquist, rel=0.01)


@pytest.mark.parametrize("count", NUMBERS)
def test_nothing_inside_a_proved_sector_goes_unstable(count):
    found = r.inside(count)
    laws = len(r.VARYING | r.STATIC) * 2 + len(r.MONOTONE) * 2 + len(r.FALLING)
    assert found.trials == count * r.STARTS * laws and laws == 24
    assert found.worst < 0.97, found.where  # a gain just below a limit decays slowly; a limit cycle has 1
    assert found.apart < 0.7


@pytest.mark.parametrize("count", NUMBERS)
def test_what_is_proved_stays_below_what_is_true_and_the_table_says_by_how_much(count):
    for gap in r.gaps(count):
        assert 0.0 < gap.circle < gap.switching <= gap.nyquist * (1.0 + 1e-5)
        assert gap.circle < gap.tsypkin < gap.nyquist
        assert gap.circle < gap.jury_lee < gap.nyquist
        assert gap.low < gap.shifted < gap.nyquist
        assert gap.circle < gap.shifted
    table = r.gap_table(count).splitlines()
    assert len(table) == count + 2 and "proved/true" in table[0]


def test_the_laws_keep_to_the_sector_and_to_the_slopes_that_their_criterion_asks_for():
    e = np.concatenate([-np.geomspace(1e-3, 1e3, 100_001)[::-1], np.geomspace(1e-3, 1e3, 100_001)])
    falling = []
    for name, law in (r.STATIC | r.MONOTONE | r.FALLING).items():
        v = law(e, np.array(2.0), 0)
        assert ((v * e >= -1e-12) & (np.abs(v) <= 2.0 * np.abs(e) * (1.0 + 1e-12))).all(), name
        slopes = np.diff(v) / np.diff(e)
        if name in r.MONOTONE:
            assert slopes.min() > -1e-9 and slopes.max() < 2.0 * (1.0 + 1e-9), name
        if name in r.FALLING:
            assert slopes.max() < 2.0 * r.STEEP * (1.0 + 1e-6), name
            falling.append(slopes.min() < -0.8)
    assert falling == [True, True]


def test_at_the_bound_of_jury_and_lee_the_sector_and_the_slopes_are_proved():
    from leadscrew.analysis.stability.criteria import ask

    for plant, gap in zip(r.random_plants(FEW), r.gaps(FEW), strict=True):
        second = ask("jury-lee", r.loop_of(plant), 0.0, slope=r.STEEP * gap.nyquist)  # on a grid, by itself
        assert second.limit is not None
        assert gap.jury_lee == pytest.approx(second.limit, rel=2e-3) and gap.jury_lee <= second.limit * (1.0 + 1e-6)


def test_the_trials_do_grow_outside_so_that_they_could_have_failed():
    plants = r.random_plants(FEW)
    nyquist = np.array([gap.nyquist for gap in r.gaps(FEW)])
    assert (r.growth(r.stepped(plants, r.straight, 1.1 * nyquist)) > 1.5).all()
    assert (r.growth(r.stepped(plants, r.dead_zone, 1.2 * nyquist)) > 1.0).any()
    assert (r.growth(r.stepped(plants, r.hump, 1.2 * nyquist, periods=r.LONG)) > 0.999).all()  # a limit cycle stays


@pytest.mark.slow
def test_a_switching_gain_breaks_what_a_fixed_one_does_not_in_simulation_too():
    plants = r.random_plants()
    worst = min(range(len(plants)), key=lambda i: r.gaps()[i].switching / r.gaps()[i].nyquist)
    gap = r.gaps()[worst]
    assert gap.switching < 0.7 * gap.nyquist
    pairs = [(low, high) for low in range(1, 15) for high in range(1, 15)]
    grown = [r.growth(r.stepped([plants[worst]], r.switching(*p), np.array([1.02 * gap.switching])))[0] for p in pairs]
    assert max(grown) > 1.0


@pytest.mark.filterwarnings("ignore:stability_margins", "ignore:Badly conditioned")
@pytest.mark.parametrize("count", NUMBERS)
def test_python_control_agrees_on_margins_and_the_nyquist_curve(count):
    from control import stability_margins

    for plant in r.random_plants(count):
        loop = r.loop_of(plant)
        theirs = loop.to_control()
        gain, phase, distance, *_ = stability_margins(theirs)
        ours = margins(loop)
        assert loop.gain_limit() == pytest.approx(gain, rel=1e-6)
        if np.isfinite(phase):
            assert ours.pm_deg == pytest.approx(phase, abs=1e-3)
        assert 1.0 / ours.ms == pytest.approx(distance, rel=1e-4)
        w = np.geomspace(0.1, 300.0, 50)
        np.testing.assert_allclose(loop.response(w), theirs(np.exp(1j * w * r.PERIOD_S)), rtol=1e-8)


def test_the_plants_are_of_order_three_with_one_to_four_periods_of_delay():
    plants = r.random_plants()
    assert len(plants) >= 20
    assert {p.delay for p in plants} == {1, 2, 3, 4}
    for plant in plants:
        poles = np.linalg.eigvals(plant.continuous[0])
        assert len(poles) == 3 and (poles.real < 0.0).all()
    for plant in plants[:FEW]:
        assert len(r.loop_of(plant).a) == 3 + plant.delay
