"""Inference by the active rules against the sum over all rules, and on the axis where the paper's table is linear."""

import numpy as np
import pytest

from leadscrew.controllers._vud.universe import CENTRES, TABLE_2
from leadscrew.fuzzy.inference import infer, rule_base
from leadscrew.fuzzy.partition import Partition
from leadscrew.util.errors import ValueRefused


def all_rules(first, second, table, x, y):
    mu = Partition(tuple(first), ("",) * len(first)).memberships(x)
    nu = Partition(tuple(second), ("",) * len(second)).memberships(y)
    weights = np.outer(mu, nu)
    return float((weights * table).sum() / weights.sum())


def test_four_active_rules_give_what_all_36_give():
    rules = rule_base(CENTRES, CENTRES, TABLE_2)
    points = np.random.default_rng(1).uniform(-1.3, 1.3, (400, 2))
    for x, y in [*points, *((c, d) for c in CENTRES for d in CENTRES)]:
        assert infer(rules, x, y) == pytest.approx(all_rules(CENTRES, CENTRES, TABLE_2, x, y), abs=1e-14)


def test_uneven_tables_of_different_sizes_work_too():
    rng = np.random.default_rng(2)
    first, second = np.sort(rng.uniform(-5, 5, 3)), np.sort(rng.uniform(0, 9, 8))
    table = rng.normal(size=(3, 8))
    rules = rule_base(first, second, table)
    for x, y in rng.uniform(-6, 10, (200, 2)):
        assert infer(rules, x, y) == pytest.approx(all_rules(first, second, table, x, y), abs=1e-13)


def test_without_a_zero_set_the_papers_table_is_still_smooth_through_zero():
    rules = rule_base(CENTRES, CENTRES, TABLE_2)
    for x, y in np.random.default_rng(3).uniform(-0.33, 0.33, (50, 2)):
        assert infer(rules, x, y) == pytest.approx(-(0.505 / 0.33) * x - (0.172 / 0.33) * y, abs=1e-14)


def test_a_table_that_does_not_fit_its_sets_is_refused():
    with pytest.raises(ValueRefused, match=r"\(6, 5\).*6 by 6"):
        rule_base(CENTRES, CENTRES, TABLE_2[:, :5])
