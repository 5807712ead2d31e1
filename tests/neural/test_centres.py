"""Centres that learn: slopes against differences, order kept whatever is asked for, training against SciPy."""

import numpy as np
import pytest

from leadscrew.fuzzy.inference import Axis
from leadscrew.neural.centres import best_centres, centre_slope, put_in_order, train_centres
from leadscrew.neural.inference_net import CENTRES, CHINESE_RULES, fired, initial_rules, network_output, regressors
from leadscrew.neural.samples import reasoning_samples, train_rules
from leadscrew.util.errors import ValueRefused


def test_slopes_are_those_of_the_output():
    rng = np.random.default_rng(1)
    weights = rng.normal(size=49)

    def output(first, second, e, ec):
        axes = (Axis(c, 1.0 / np.diff(c)) for c in (first, second))
        return network_output(weights, fired(*axes, e, ec))

    for e, ec in rng.uniform(-5.9, 5.9, (30, 2)):
        first, second = (CENTRES + np.concatenate([[0], rng.uniform(-0.5, 0.5, 5), [0]]) for _ in range(2))
        at = fired(Axis(first, 1.0 / np.diff(first)), Axis(second, 1.0 / np.diff(second)), e, ec)
        table = weights.reshape(7, 7)[at.j : at.j + 2, at.i : at.i + 2]
        by_mu = np.array([1.0 - at.nu, at.nu]) @ (table[:, 1] - table[:, 0])
        by_nu = np.array([1.0 - at.mu, at.mu]) @ (table[1] - table[0])
        widths = first[at.i + 1] - first[at.i], second[at.j + 1] - second[at.j]
        found = centre_slope(at, by_mu, by_nu, *widths)
        for which, index, slope in (
            (0, at.i, found.e_lower), (0, at.i + 1, found.e_upper),
            (1, at.j, found.ec_lower), (1, at.j + 1, found.ec_upper),
        ):  # fmt: skip
            if index in (0, 6):
                assert slope == 0.0  # the outer centres are fixed
                continue
            moved = [[first.copy(), second.copy()] for _ in range(2)]
            moved[0][which][index] += 1e-6
            moved[1][which][index] -= 1e-6
            difference = (output(*moved[0], e, ec) - output(*moved[1], e, ec)) / 2e-6
            assert slope == pytest.approx(difference, abs=1e-7)


def test_centres_are_put_in_order_and_no_further():
    for seed in range(200):
        rng = np.random.default_rng(seed)
        centres = np.concatenate([[-6.0], rng.normal(size=5) * 10.0 ** rng.uniform(-1, 3), [6.0]])
        put_in_order(centres, 0.4)
        assert (np.diff(centres) >= 0.4 - 1e-12).all() and centres[0] == -6.0 and centres[6] == 6.0
        again = centres.copy()
        put_in_order(again, 0.4)
        assert again == pytest.approx(centres, abs=1e-12)
    even = CENTRES.copy()
    put_in_order(even, 0.4)
    assert (even == CENTRES).all()


def test_training_keeps_the_universe_covered():
    found = train_centres(reasoning_samples(CHINESE_RULES), passes=2, p0_centres=1.0)
    points = np.linspace(-8.0, 8.0, 201)
    h = regressors(points, points[::-1], found.centres_e, found.centres_ec)
    assert np.abs(h.sum(axis=1) - 1.0).max() < 1e-12 and (np.diff(found.centres_e) > 0.39).all()


@pytest.mark.slow
def test_ten_passes_give_the_known_number_for_the_default_rules():
    assert train_centres(reasoning_samples(initial_rules())).rmse == pytest.approx(0.1705, abs=5e-5)


@pytest.mark.slow
@pytest.mark.parametrize(("rules", "known", "gain"), [(None, 0.1702, 0.0), (CHINESE_RULES, 0.149, 4.9)])
def test_centres_are_worth_less_than_five_percent(rules, known, gain):
    samples = reasoning_samples(rules)
    best, alone, ekf = best_centres(samples), train_rules(samples).least, train_centres(samples).rmse
    assert best.rmse <= alone and best.rmse <= ekf
    assert 100.0 * (1.0 - best.rmse / alone) == pytest.approx(gain, abs=0.1)
    assert best.rmse == pytest.approx(known, abs=6e-4)


@pytest.mark.parametrize("given", [{"gap": 0.0}, {"gap": 2.5}, {"p0_centres": 0.0}, {"passes": 0}])
def test_bad_numbers_are_refused(given):
    with pytest.raises(ValueRefused, match="train_centres"):
        train_centres(reasoning_samples(), **given)
