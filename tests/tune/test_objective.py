"""Goals and constraints: their texts, their statistics, and what a failed run is worth."""

from __future__ import annotations

import math

import numpy as np
import pytest

from leadscrew.tune.measure import Samples
from leadscrew.tune.objective import Constraint, Goal, constraint, contradiction, goal, score
from leadscrew.util.errors import NameUnknown, ValueRefused

NAN = math.nan


def samples(values, lost=None, metric="m", scenarios=("a", "b")):
    """Runs of ``values[scenario][run]``."""
    table = np.array(values, dtype=float)
    away = np.full(table.shape, NAN) if lost is None else np.array(lost, dtype=float)
    return Samples(
        {"k": np.arange(table.shape[1])},
        {s: {metric: row} for s, row in zip(scenarios, table, strict=True)},
        dict(zip(scenarios, away, strict=True)),
    )


@pytest.mark.parametrize(
    ("text", "metric", "statistic", "scenario"),
    [
        ("m", "m", "worst", ""),
        ("mean:m", "m", "mean", ""),
        (" p95:m @ a ", "m", "p95", "a"),
        ("median:m", "m", "median", ""),
    ],
)
def test_goals_are_read(text, metric, statistic, scenario):
    assert goal(text) == Goal(metric, statistic, scenario)
    assert goal(str(goal(text))) == goal(text)


def test_constraints_are_read():
    assert constraint("m<=0.02") == Constraint("m", "worst", "", True, 0.02)
    assert constraint("p95:m@a >= -1e3") == Constraint("m", "p95", "a", False, -1000.0)
    assert str(constraint("m@a<=0.979")) == "worst:m@a<=0.979"


@pytest.mark.parametrize(
    ("read", "text", "words"),
    [
        (goal, "", "expected METRIC"),
        (goal, "m<=1", "expected METRIC"),
        (goal, "a:b:c", "expected METRIC"),
        (goal, "best:m", "there is no statistic 'best'; known: worst, mean"),
        (goal, "p100:m", "there is no statistic 'p100'"),
        (constraint, "m<1", "expected METRIC<=VALUE"),
        (constraint, "<=1", "expected METRIC<=VALUE"),
        (constraint, "m<=fast", "'fast' is not a number"),
        (constraint, "m<=nan", "finite"),
        (constraint, "m<=inf", "finite"),
    ],
)
def test_what_is_no_goal_is_refused(read, text, words):
    with pytest.raises((ValueRefused, NameUnknown)) as error:
        read(text)
    assert words in str(error.value)


def test_statistics_go_over_plants_and_scenarios():
    # Two settings on three plants in two scenarios.
    runs = samples([[1, 2, 3, 10, 20, 30], [4, 5, 6, 40, 50, 60]])
    found = score(runs, 3, [goal("m"), goal("mean:m"), goal("median:m"), goal("m@a"), goal("p50:m@b")], [])
    assert found.goals.tolist() == [[6, 3.5, 3.5, 3, 5], [60, 35, 35, 30, 50]]
    assert found.failed.tolist() == [0, 0] and found.violation.tolist() == [0, 0]


def test_a_constraint_from_below_looks_at_the_smallest():
    found = score(samples([[1, 2, 3]], scenarios=("a",)), 3, [goal("m")], [constraint("m>=2"), constraint("p90:m>=2")])
    assert found.bounded[0].tolist() == pytest.approx([1.0, 1.2])
    assert (found.violations[0, 1:] > 0).all()


def test_a_bound_is_met_on_the_bound():
    c = constraint("m<=0.979")
    assert c.met(979 * 0.001) and c.met(0.979 * (1 + 1e-15)) and not c.met(0.98) and not c.met(NAN)


def test_a_failed_run_keeps_neither_an_upper_nor_a_lower_bound():
    kept = [constraint("m<=1e9"), constraint("m>=-1e9")]
    found = score(samples([[1.0, NAN]], scenarios=("a",)), 2, [goal("m")], kept)
    assert found.bounded[0].tolist() == [math.inf, -math.inf]
    assert not any(c.met(x) for c, x in zip(kept, found.bounded[0], strict=True))


def test_failed_runs_are_infinitely_bad_and_still_have_a_slope():
    # Settings: well; misses the bound by far; one run fails; two runs fail; two fail and the rest is worse.
    runs = samples([[1, 1, 1e9, 1e9, 1, NAN, 1, NAN, 1, NAN], [1, 1, 1, 1, 1, 1, 1, NAN, 1e9, NAN]])
    found = score(runs, 2, [goal("m")], [constraint("m<=2")])
    assert found.failed.tolist() == [0, 0, 1, 2, 2]
    assert np.isinf(found.goals[2:, 0]).all() and np.isinf(found.bounded[2:, 0]).all()
    assert np.isfinite(found.objectives).all() and np.isfinite(found.violations).all()
    assert (np.diff(found.violation) > 0).all(), "each setting is worse than the one before it"


def test_a_diverged_run_counts_as_failed_even_where_its_metric_has_a_value():
    runs = samples([[1.0, 1.0], [1.0, 1.0]], lost=[[NAN, 0.3], [NAN, NAN]])
    found = score(runs, 1, [goal("m")], [])
    assert found.goals[:, 0].tolist() == [1.0, math.inf]
    assert found.diverged.tolist() == [0, 1] and found.violation[0] == 0.0 < found.violation[1]


def test_nothing_judged_is_worth_a_finite_number():
    found = score(samples([[NAN, NAN]], scenarios=("a",)), 2, [goal("m")], [constraint("mean:m<=0")])
    assert np.isfinite(found.objectives).all() and np.isfinite(found.violations).all()


def test_contradictions_are_seen():
    a, b = constraint("m<=1"), constraint("m>=2")
    assert contradiction([a, b]) == "worst:m<=1 and worst:m>=2 contradict each other: nothing can keep both"
    assert contradiction([a, constraint("m>=1")]) == ""
    assert contradiction([a, constraint("m@a>=2")]) == "" and contradiction([a, constraint("mean:m>=2")]) == ""
