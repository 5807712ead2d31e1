"""Partitions from data: universes, quantiles, and the number of sets from curvature and accuracy."""

import numpy as np
import pytest

from leadscrew.fuzzy.curvature import estimate_curvature
from leadscrew.fuzzy.grids import even, grid_from_curvature, labels, quantile, universe
from leadscrew.studies.vud_lathe import laws as rules
from leadscrew.studies.vud_lathe.laws import moves
from leadscrew.util.errors import ValueRefused

SQUARE = [(-1.0, 1.0), (-1.0, 1.0)]


def points(count=2000, inputs=2, seed=0):
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (count, inputs))


def cubic(x):
    """Largest second derivatives 1.96 and 1.35, as equations (8) and (9) have them."""
    return -x[:, 0] + 1.96 / 6 * x[:, 0] ** 3 - 0.4 * x[:, 1] + 1.35 / 6 * x[:, 1] ** 3


def test_a_polynomials_curvature_is_found_exactly():
    x = points()
    found = estimate_curvature(x, cubic(x), SQUARE, method="polynomial", percentile=100.0)
    assert found.values == pytest.approx((1.96, 1.35), rel=2e-3) and found.condition < 2.0
    assert max(found.error) < 1e-12


@pytest.mark.parametrize("method", ["polynomial", "local"])
def test_a_quadratics_curvature_is_its_coefficients_in_scaled_inputs(method):
    # x1 in [0, 4]: scaled by 2, so d2f/ds2 = 4 * 2 * 0.5 = 4; x2 in [-1, 1]: 2 * 3 = 6; x1 x2 bends neither.
    x = points() * [2.0, 1.0] + [2.0, 0.0]
    y = 0.5 * x[:, 0] ** 2 + 3.0 * x[:, 1] ** 2 + 2.0 * x[:, 0] * x[:, 1]
    found = estimate_curvature(x, y, [(0.0, 4.0), (-1.0, 1.0)], method=method, degree=2)
    assert found.values == pytest.approx((4.0, 6.0), abs=1e-9)


def test_the_derivatives_are_those_of_finite_differences():
    x = points(400, 3)
    y = np.prod(x, axis=1) + x[:, 0] ** 3 * x[:, 1] - x[:, 2] ** 2 * x[:, 0]
    found = estimate_curvature(x, y, [(-1.0, 1.0)] * 3, method="polynomial", degree=4, percentile=100.0)
    expected = [np.abs(6.0 * x[:, 0] * x[:, 1]).max(), 0.0, np.abs(2.0 * x[:, 0]).max()]
    assert found.values == pytest.approx(expected, abs=1e-9)


def test_local_fits_are_near_and_below_and_noise_shows_in_the_error():
    x = points()
    quiet = estimate_curvature(x, cubic(x), SQUARE, bandwidth=0.2)
    assert 1.6 < quiet.values[0] < 1.96 and 1.1 < quiet.values[1] < 1.35
    noisy = estimate_curvature(x, cubic(x) + 0.005 * points(2000, 1, 1)[:, 0], SQUARE, bandwidth=0.1)
    assert noisy.error[0] > 10.0 * quiet.error[0] and "+-" in str(noisy)


def test_one_step_response_cannot_tell_its_inputs_apart():
    t = np.linspace(0.0, 3.0, 400)
    e, de = -np.exp(-t), np.exp(-t)
    for method in ("polynomial", "local"):
        with pytest.raises(ValueRefused, match="condition number"):
            estimate_curvature(np.column_stack([e, de]), e**2, SQUARE, method=method)


@pytest.mark.parametrize("options", [{"method": "polynomial", "degree": d} for d in (2, 3, 5)] + [{"bandwidth": 0.3}])
def test_table_1_does_not_carry_the_papers_curvatures(options):
    samples = np.array(rules.samples(moves()))
    with pytest.raises(ValueRefused, match="condition number"):
        estimate_curvature(samples[:, :2], samples[:, 2], SQUARE, **options)


def test_too_few_samples_are_refused():
    x = points(11)
    with pytest.raises(ValueRefused, match="11 samples for the 6 terms"):
        estimate_curvature(x, cubic(x), SQUARE, method="polynomial", degree=2)
    with pytest.raises(ValueRefused, match="of 11 points 11 have fewer than 12 samples"):
        estimate_curvature(x, cubic(x), SQUARE)


@pytest.mark.parametrize(
    "options", [{"method": "guess"}, {"degree": 1}, {"bandwidth": 0.0}, {"percentile": 0.0}, {"percentile": 101.0}]
)
def test_options_without_a_meaning_are_refused(options):
    with pytest.raises(ValueRefused, match=next(iter(options))):
        estimate_curvature(points(), cubic(points()), SQUARE, **options)


def test_arrays_that_do_not_fit_are_refused():
    with pytest.raises(ValueRefused, match="shape"):
        estimate_curvature(points(20, 3), np.zeros(20), SQUARE)
    with pytest.raises(ValueRefused, match="finite"):
        estimate_curvature(points(20), np.full(20, np.nan), SQUARE)


@pytest.mark.parametrize(("reading", "sets"), [("half", 3), ("full", 6), ("intervals", 6)])
def test_the_papers_number_of_sets_follows_from_data_under_each_reading(reading, sets):
    x = points()
    grid = grid_from_curvature(x, cubic(x), SQUARE, 0.05, reading, method="polynomial", percentile=100.0)
    assert grid.sets == sets and grid.count == (3, 6, 5) and grid.needed == 7
    assert grid.bound == pytest.approx({3: 0.41, 6: 0.066}[sets], rel=0.02)
    assert f"read as {reading}: {sets} sets" in grid.report() and grid.as_dict()["needed"] == 7
    assert grid.partitions[0] == even(-1.0, 1.0, sets)


def test_the_guarantee_holds_for_the_function_itself():
    x = points()
    grid = grid_from_curvature(x, cubic(x), SQUARE, 0.02, "full", method="polynomial", percentile=100.0)
    knots = np.array(grid.partitions[0].centres)
    mu, nu = (grid.partitions[k].memberships(x[:, k]) for k in (0, 1))
    table = cubic(np.stack(np.meshgrid(knots, knots, indexing="ij"), -1).reshape(-1, 2)).reshape(len(knots), -1)
    error = np.abs(np.einsum("mi,ij,mj->m", mu, table, nu) - cubic(x)).max()
    assert error <= grid.bound < 1.2 * 0.02


def test_no_reading_is_preferred_and_absurd_accuracies_are_refused():
    x = points()
    with pytest.raises(ValueRefused, match="half, full, intervals"):
        grid_from_curvature(x, cubic(x), SQUARE, 0.05, "paper")
    with pytest.raises(ValueRefused, match="allowed are up to 999"):
        grid_from_curvature(x, cubic(x), SQUARE, 1e-9, "full")
    flat = grid_from_curvature(x, x[:, 0], SQUARE, 0.1, "half")
    assert flat.sets == 2
    fine = grid_from_curvature(x, cubic(x), SQUARE, 1e-6, "half")
    assert fine.needed is None and "more than 999" in fine.report()


def test_universes_are_ranges_percentiles_or_symmetric():
    x = [-1.0, 0.0, 1.0, 2.0, 100.0]
    assert universe(x) == (-1.0, 100.0) and universe(x, (25.0, 75.0)) == (0.0, 2.0)
    assert universe(x, symmetric=True) == (-100.0, 100.0)
    for bad, said in [([1.0, 1.0], "x: is always 1"), ([], "finite"), ([np.nan], "finite")]:
        with pytest.raises(ValueRefused, match=said):
            universe(bad, name="x")
    with pytest.raises(ValueRefused, match="rising"):
        universe(x, (80.0, 20.0))


def test_quantile_sets_have_as_many_samples_between_their_centres():
    x = np.random.default_rng(2).exponential(size=6000)
    p = quantile(x, 7, 0.0, float(x.max()))
    assert np.ptp(np.histogram(x, p.centres)[0]) <= 2
    assert p.labels == ("S1", "S2", "S3", "S4", "S5", "S6", "S7")
    assert len(quantile([0.0] * 50 + [1.0, 2.0], 7, 0.0, 2.0)) < 7


def test_sets_about_zero_have_the_usual_names():
    assert labels([-1.0, 0.0, 1.0]) == ("N", "ZE", "P") and even(-2.0, 2.0, 6).labels == rules.LABELS
    assert even(0.0, 1.0, 3).labels == ("S1", "S2", "S3") and len(set(even(-1.0, 1.0, 11).labels)) == 11
    assert even(-0.3, 0.3, 7).centres[3] == 0.0
    with pytest.raises(ValueRefused, match="sets = 1"):
        even(0.0, 1.0, 1)
