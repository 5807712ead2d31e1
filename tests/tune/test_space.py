"""Distributions against SciPy, and what a space refuses."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from leadscrew.kernel.parameters import ParameterSpec
from leadscrew.tune.space import CUT, Choice, Normal, Range, Space, cube, distribution
from leadscrew.util.errors import NameUnknown, ValueRefused

U = np.linspace(0.0, 1.0, 1001)
THEIRS = {
    "2:5": stats.uniform(2, 3),
    "0.001:10:log": stats.loguniform(1e-3, 10),
    "normal:3:0.5": stats.truncnorm(-CUT, CUT, 3, 0.5),
    "-3:4:int": stats.randint(-3, 5),
}


@pytest.mark.parametrize("text", THEIRS)
def test_quantiles_are_those_of_scipy(text):
    ours = distribution(text).quantile(U[1:-1] + 1e-9)
    assert np.allclose(ours, THEIRS[text].ppf(U[1:-1] + 1e-9), rtol=1e-9)


def test_the_lognormal_is_a_normal_in_the_logarithm():
    ours = distribution("lognormal:2:1.5").quantile(U)
    assert np.allclose(np.log(ours), stats.truncnorm(-CUT, CUT, np.log(2), np.log(1.5)).ppf(U), rtol=1e-9)
    assert distribution("lognormal:2:1.5").quantile(np.array([0.5]))[0] == pytest.approx(2.0)


@pytest.mark.parametrize("text", [*THEIRS, "lognormal:2:1.5", "1|3|10"])
def test_values_stay_within_the_ends_and_go_back_to_where_they_came_from(text):
    d = distribution(text)
    values = d.quantile(U)
    assert values.min() >= d.ends[0] - 1e-12 and values.max() <= d.ends[1] + 1e-12
    back = d.quantile(np.array([d.unit(float(x)) for x in values]))
    assert np.allclose(back, values, rtol=1e-6)
    assert str(distribution(str(d))) == str(d)


def test_whole_numbers_and_choices_come_equally_often():
    for d, n in ((Range(1, 4, whole=True), 4), (Choice((1.0, 3.0, 10.0)), 3)):
        _, counts = np.unique(d.quantile((np.arange(1200) + 0.5) / 1200), return_counts=True)
        assert counts.tolist() == [1200 // n] * n


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("5:2", "the range 5:2 is empty"),
        ("2:2", "is empty"),
        ("nan:2", "is empty"),
        ("-1:2:log", "above 0"),
        ("1.5:3:int", "whole"),
        ("normal:1:0", "deviation must be above 0"),
        ("lognormal:1:1", "factor must be above 1"),
        ("lognormal:-1:2", "median"),
        ("1|1", "none twice"),
        ("fast", "expected LOW:HIGH"),
        ("1:2:3", "expected LOW:HIGH"),
        ("normal:1", "expected LOW:HIGH"),
    ],
)
def test_what_is_no_distribution_is_refused_in_one_sentence(text, words):
    with pytest.raises(ValueRefused, match=words) as said:
        Space.of([f"a.b={text}"])
    assert str(said.value).startswith("a.b: ") and "\n" not in str(said.value)


def test_a_space_knows_what_may_vary():
    sheet = {k: ParameterSpec(k, t, 1, above=0.0) for k, t in (("a", "float"), ("n", "int"), ("flag", "bool"))}
    Space.of({"a": (1, 2), "n": "1:3:int"}).checked(sheet, "--over")
    for over, words in (({"b": "1:2"}, "no parameter"), ({"flag": "0:1"}, "only numbers"), ({"n": "1:3"}, "int"),
                        ({"a": "-1:1"}, "allowed range"), ({"a": "normal:1:1"}, "allowed range")):  # fmt: skip
        with pytest.raises((ValueRefused, NameUnknown), match=words):
            Space.of(over).checked(sheet, "--over")
    with pytest.raises(ValueRefused, match="given twice"):
        Space.of(["a=1:2", "a=1:3"])


def test_sampling_fills_every_stratum():
    lhs = cube(500, 3, 7)
    assert all(sorted((lhs[:, i] * 500).astype(int)) == list(range(500)) for i in range(3))
    sobol = cube(256, 3, 7, "sobol")
    assert all(sorted((sobol[:, i] * 256).astype(int)) == list(range(256)) for i in range(3))
    drawn = cube(20_000, 2, 7, "random")
    assert stats.kstest(drawn[:, 0], "uniform").pvalue > 1e-3
    assert len(cube(100, 2, 7, "sobol")) == 100 and cube(5, 0, 1).shape == (5, 0)
    for method in ("lhs", "sobol", "random"):
        assert np.array_equal(cube(64, 2, 7, method), cube(64, 2, 7, method))
        assert not np.array_equal(cube(64, 2, 7, method), cube(64, 2, 8, method))
    with pytest.raises(NameUnknown, match="lhs"):
        cube(5, 1, 0, "lsh")


def test_a_normal_ends_at_four_deviations():
    assert Normal(1.0, 0.5).ends == (-1.0, 3.0)
    assert Normal(2.0, 1.5, log=True).ends == (2.0 * 1.5**-4, 2.0 * 1.5**4)
