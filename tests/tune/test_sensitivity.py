"""Rank correlations against SciPy and by hand, Sobol indices on a function whose indices are known."""

from __future__ import annotations

import builtins
import sys

import numpy as np
import pytest
from scipy import stats

from leadscrew.tune import sensitivity
from leadscrew.tune.sensitivity import fisher, rank_correlations
from leadscrew.util.errors import LeadscrewError, ValueRefused


def drawn(n=400, seed=1):
    rng = np.random.default_rng(seed)
    return {k: rng.random(n) for k in "abc"}, rng


def test_rank_correlation_is_spearmans():
    x, rng = drawn()
    values = np.exp(3 * x["a"]) - x["b"] + 0.5 * rng.standard_normal(400)
    values[::7] = np.nan
    known = ~np.isnan(values)
    for row in rank_correlations(x, values):
        assert row.value == pytest.approx(stats.spearmanr(x[row.key][known], values[known]).statistic, abs=1e-12)
        assert row.low < row.value < row.high and row.runs == known.sum()


def test_partial_rank_correlation_is_that_of_the_residuals():
    x, rng = drawn()
    x["c"] = x["a"] + 0.3 * x["c"]
    values = x["a"] + 2 * x["b"] ** 3 + 0.1 * rng.standard_normal(400)
    ranks = {k: stats.rankdata(v) for k, v in (*x.items(), ("y", values))}
    for row in rank_correlations(x, values):
        others = np.column_stack([np.ones(400), *(ranks[k] for k in x if k != row.key)])
        left = [ranks[k] - others @ np.linalg.lstsq(others, ranks[k], rcond=None)[0] for k in (row.key, "y")]
        assert row.partial == pytest.approx(np.corrcoef(*left)[0, 1], abs=1e-9)
    found = {r.key: r for r in rank_correlations(x, values)}
    assert found["c"].value > 0.2 and abs(found["c"].partial) < 0.15


def test_the_interval_holds_the_true_correlation_95_times_in_100():
    rng = np.random.default_rng(5)
    rho = 0.6
    true = 6 / np.pi * np.arcsin(rho / 2)
    held = 0
    for _ in range(600):
        a, b = rng.multivariate_normal([0, 0], [[1, rho], [rho, 1]], 60).T
        (row,) = rank_correlations({"a": a}, b)
        held += row.low <= true <= row.high
    assert 0.925 <= held / 600 <= 0.975


def test_the_interval_of_a_partial_correlation_allows_for_the_parameters_taken_out():
    """Of 20 runs ten other parameters leave 20 - 10 - 3 = 7 degrees of freedom (Bonett and Wright, 2000, eq. 5)."""
    rng = np.random.default_rng(6)
    row = rank_correlations({str(k): rng.random(20) for k in range(11)}, rng.random(20))[0]
    half = 1.959964 * np.sqrt((1.0 + 0.5 * row.partial**2) / 7.0)
    ends = np.arctanh([row.partial_low, row.partial_high])
    assert ends == pytest.approx(np.arctanh(row.partial) + np.array([-half, half]), rel=1e-6)


def test_what_does_not_vary_has_no_correlation():
    x, _ = drawn()
    assert all(np.isnan(r.value) for r in rank_correlations(x, np.ones(400)))
    (still, *_) = rank_correlations({"still": np.ones(400), **x}, x["a"])
    assert np.isnan(still.value)
    assert all(np.isnan(r.value) and r.runs == 0 for r in rank_correlations(x, np.full(400, np.nan)))
    (exact,) = rank_correlations({"a": x["a"]}, x["a"] ** 3)
    assert exact.value == pytest.approx(1.0)
    assert all(np.isnan(fisher(0.5, 3))) and rank_correlations({}, x["a"]) == []


def ishigami(unit):
    x = -np.pi + 2 * np.pi * unit
    return {("y", ""): np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])}


def test_sobol_indices_of_the_ishigami_function():
    rows = sensitivity.sobol(ishigami, ("x1", "x2", "x3"), 4096, seed=3)
    exact = {"x1": (0.3139, 0.5576), "x2": (0.4424, 0.4424), "x3": (0.0, 0.2437)}
    for row in rows:
        assert (row.first, row.total) == pytest.approx(exact[row.key], abs=0.02)
        assert abs(row.first - exact[row.key][0]) < 2 * row.first_width + 1e-3
    for seed in (0, 3):
        again = [sensitivity.sobol(ishigami, ("x1", "x2", "x3"), 64, seed) for _ in range(2)]
        assert again[0] == again[1]


def test_sobol_indices_need_every_value():
    values = np.arange(64 * 4, dtype=float)
    values[5] = np.nan
    rows = sensitivity.indices(values, ("a", "b"))
    assert all(np.isnan(r.first) and r.without == 1 for r in rows)
    assert all(np.isnan(r.total) and r.without == 0 for r in sensitivity.indices(np.ones(256), ("a", "b")))


def test_indices_with_intervals_wider_than_what_they_can_be_are_not_known():
    rng = np.random.default_rng(2)
    wild = rng.random(64 * 4)
    wild[5] = 1e6
    rows = sensitivity.indices(wild, ("a", "b"))
    assert any(r.total_width > 1.0 for r in rows)
    for r in rows:
        assert r.first_known == (r.first_width <= 1.0) and r.total_known == (r.total_width <= 1.0)
    row = rows[0]._replace(first_width=np.inf, total_width=np.nan)
    assert not row.first_known and not row.total_known
    assert all(r.first_known and r.total_known for r in sensitivity.sobol(ishigami, ("x1", "x2", "x3"), 256))


def test_sobol_refusals(monkeypatch):
    with pytest.raises(ValueRefused, match="powers of two, for example 1024"):
        sensitivity.points(3, 1000)
    with pytest.raises(ValueRefused, match="at least one parameter"):
        sensitivity.points(0, 64)
    real = builtins.__import__

    def without(name, *args, **kwargs):
        if name.startswith("SALib"):
            raise ImportError
        return real(name, *args, **kwargs)

    for name in [m for m in sys.modules if m.startswith("SALib")]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(LeadscrewError, match=r"pip install 'leadscrew\[tune\]'"):
        sensitivity.points(3, 64)
