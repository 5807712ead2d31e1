"""Laws that every norm keeps, and values at corners that formulas tend to get wrong."""

import itertools

import numpy as np
import pytest

from leadscrew.fuzzy import norms
from leadscrew.fuzzy.system import HEDGES, S_NORMS, T_NORMS

GRID = [0.0, 1e-17, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0 - 2**-53, 1.0]


def test_every_norm_and_hedge_of_the_data_model_is_there():
    assert (*norms.T,) == T_NORMS
    assert (*norms.S,) == S_NORMS
    assert (*norms.HEDGES,) == HEDGES


@pytest.mark.parametrize("name", T_NORMS)
def test_a_t_norm(name):
    t = norms.T[name]
    for a, b in itertools.product(GRID, GRID):
        assert t(a, b) == pytest.approx(t(b, a), abs=1e-15)
        assert -1e-15 <= t(a, b) <= min(a, b) + 1e-15
        assert t(a, 1.0) == pytest.approx(a, abs=1e-15)
        assert t(a, 0.0) == 0.0


@pytest.mark.parametrize("name", S_NORMS)
def test_an_s_norm(name):
    s = norms.S[name]
    for a, b in itertools.product(GRID, GRID):
        assert s(a, b) == pytest.approx(s(b, a), abs=1e-15)
        assert s(a, b) >= max(a, b) - 2e-16 or name == "normalized_sum"
        assert s(a, 0.0) == a
        assert s(a, b) <= 1.0 + 1e-15 or name == "unbounded_sum"
        assert np.isfinite(s(a, b))


def test_duals_by_de_morgan():
    pairs = zip(T_NORMS, ("maximum", "algebraic_sum", "bounded_sum", "drastic_sum", "einstein_sum", "hamacher_sum",
                          "nilpotent_maximum"), strict=True)  # fmt: skip
    for t, s in pairs:
        for a, b in itertools.product([0.0, 0.25, 0.375, 0.5, 0.875, 1.0], repeat=2):
            assert norms.S[s](a, b) == pytest.approx(1.0 - norms.T[t](1.0 - a, 1.0 - b), abs=1e-15), (t, a, b)


def test_hamachers_sum_does_not_cancel_next_to_one():
    a, b = 1.0, 1.0 - 2**-53
    assert norms.hamacher_sum(a, b) == 1.0
    assert (a + b - 2 * a * b) / (1 - a * b) != 1.0 or a * b == 1.0


@pytest.mark.parametrize("name", HEDGES)
def test_a_hedge_stays_within_bounds_and_is_monotonic(name):
    values = [norms.HEDGES[name](x) for x in np.linspace(0, 1, 101)]
    assert all(0.0 <= v <= 1.0 for v in values)
    steps = np.diff(values)
    assert (steps <= 0).all() if name == "not" else (steps >= 0).all()
    assert norms.HEDGES[name](0.5) == {"any": 1.0, "very": 0.25, "somewhat": 0.5**0.5}.get(name, 0.5)
