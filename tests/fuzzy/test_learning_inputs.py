"""Rules from data with any number of inputs: known systems come back, and what data does not say is said."""

import itertools
import json

import numpy as np
import pytest

from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.from_data import to_system
from leadscrew.fuzzy.grids import even, partition
from leadscrew.fuzzy.learning import learn_rules
from leadscrew.fuzzy.partition import Partition
from leadscrew.util.errors import ValueRefused

from .systems import LABELS, sugeno

SEVEN = Partition(tuple(np.linspace(-1, 1, 7).tolist()), LABELS)
THREE = even(-1.0, 1.0, 3)


def table_of(system):
    """Consequents by antecedents of a system whose rules are conjunctions."""
    return {tuple(p.term for p in rule.propositions()): rule.consequents[0].term for rule in system.rules}


@pytest.mark.parametrize("where", ["centres", "anywhere"])
def test_a_system_of_49_rules_comes_back_from_samples_of_itself(where):
    given = sugeno()
    grid = np.array(list(itertools.product(SEVEN.centres, repeat=2)))
    points = grid if where == "centres" else np.random.default_rng(5).uniform(-1.0, 1.0, (4000, 2))
    samples = np.column_stack([points, compiled(given).many(points)])
    learned = learn_rules(samples, (SEVEN, SEVEN), SEVEN, names=("e", "de", "u"))
    assert learned.covered == learned.total == 49 and list(learned.uncovered()) == []
    back = to_system(learned)
    assert table_of(back) == table_of(given)
    inside = np.random.default_rng(6).uniform(-1.0, 1.0, (500, 2))
    assert compiled(back).many(inside) == pytest.approx(compiled(given).many(inside), abs=1e-12)


def test_a_table_of_three_inputs_comes_back():
    rng = np.random.default_rng(7)
    inputs, output = (even(-1.0, 1.0, 3), even(0.0, 10.0, 4), partition([-2.0, 0.0, 1.0])), even(-5.0, 5.0, 6)
    table = rng.integers(0, 6, (3, 4, 3))
    samples = [
        [*(p.centres[i] for p, i in zip(inputs, at, strict=True)), output.centres[k]] for at, k in np.ndenumerate(table)
    ]
    rng.shuffle(samples)
    learned = learn_rules(samples, inputs, output)
    assert {at: cell.winner.output for at, cell in learned.cells.items()} == dict(np.ndenumerate(table))
    assert all(cell.winner.strength == 1.0 for cell in learned.cells.values())
    assert learned.agreement(np.array(output.centres)[table]) == (36, [])


def test_one_input_is_enough():
    learned = learn_rules([(-0.9, 1.0), (0.1, 0.1), (0.8, -0.9)], (THREE,), THREE)
    assert [learned.say(cell.winner) for cell in learned.cells.values()] == [
        "N -> P (0.900)", "ZE -> ZE (0.810)", "P -> N (0.720)",
    ]  # fmt: skip


def test_conflicts_are_counted_as_by_hand():
    # N: P 0.9 * 0.8 = 0.72 and 0.6 * 1 = 0.6, ZE 1 * 0.9 = 0.9 wins; ZE: one voice only; P: a draw.
    data = [(-0.9, 0.8), (-0.6, 1.0), (-1.0, 0.1), (0.0, 0.0), (0.2, 0.2), (0.9, 1.0), (0.9, -1.0)]
    learned = learn_rules(data, (THREE,), THREE, names=("x", "y"))
    n, ze, p = (learned.cells[i,] for i in range(3))
    assert sorted(learned.conflicts) == [(0,), (2,)]
    assert (n.winner.output, n.winner.count, n.count) == (1, 1, 3) and n.winner.strength == pytest.approx(0.9)
    assert [(r.output, r.count, pytest.approx(r.strength)) for r in n.losers] == [(2, 2, 0.72)]
    assert not ze.losers and ze.count == 2
    assert p.drawn and p.winner.sample == 5 and not n.drawn
    text = learned.report()
    assert "3 of 3 cells covered (100.0 %), 2 in conflict" in text
    assert "N   ZE  0.900     1 of 3   P (0.720, 2)" in text
    assert "a draw, the earlier sample wins" in text


def test_a_samples_weight_can_turn_a_conflict():
    data = [(-1.0, 1.0), (-0.9, 0.0)]
    assert learn_rules(data, (THREE,), THREE).cells[0,].winner.output == 2
    weighted = learn_rules(data, (THREE,), THREE, weights=[0.5, 1.0])
    assert weighted.cells[0,].winner.output == 1 and weighted.weighted
    assert weighted.cells[0,].losers[0].strength == 0.5


def test_cells_without_data_are_named_and_long_lists_are_cut():
    learned = learn_rules([(-1.0, -1.0, 0.0)], (THREE, THREE), THREE, names=("a", "b", "y"))
    assert learned.covered == 1 and len(list(learned.uncovered())) == 8
    assert "no sample covers (N, ZE), (N, P) and 6 more" in learned.report(most=2)
    assert "no sample covers (N, ZE), (N, P), (ZE, N), (ZE, ZE), (ZE, P), (P, N), (P, ZE), (P, P)" in learned.report()
    assert ["P", "P"] in learned.as_dict()["uncovered"]
    many = learn_rules([(c, c) for c in SEVEN.centres], (SEVEN,), SEVEN)
    assert "... and 5 more rules" in many.report(most=2)


def test_samples_outside_a_universe_are_counted_and_held_at_its_end():
    learned = learn_rules([(-1.2, 1.0), (1.5, 0.0), (0.0, -3.0)], (THREE,), THREE, names=("x", "y"))
    assert {n: (o.count, o.farthest) for n, o in learned.outside.items()} == {"x": (2, 1.5), "y": (1, -3.0)}
    assert [c.winner.strength for c in learned.cells.values()] == [1.0, 1.0, 1.0]
    assert "2 samples lie outside the universe of x, [-1, 1], the farthest at 1.5: held at its end" in learned.report()


def test_the_report_as_plain_data_is_json():
    learned = learn_rules([(-1.2, 1.0), (-0.9, 0.0), (0.5, 0.3)], (THREE,), THREE, names=("x", "y"))
    plain = json.loads(json.dumps(learned.as_dict(), allow_nan=False))
    assert plain["dropped"] == [2] and plain["cells"] == 3 and plain["covered"] == 1
    assert plain["rules"][0]["sets"] == ["N"] and plain["rules"][0]["output"] == "P"
    assert plain["rules"][0]["beat"][0] == {"output": "ZE", "strength": 0.9, "samples": 1, "sample": 1}


@pytest.mark.parametrize(
    ("samples", "said"),
    [
        ([(0.0, 1.0), (float("nan"), 0.0)], r"row 1 \(from 0\): x1 = nan"),
        ([(0.0, float("inf"))], r"row 0 \(from 0\): y = inf"),
        ([(0.0, 1.0, 2.0)], r"shape \(1, 3\): expected rows of 2 numbers"),
        ([(0.0, 1.0), (1.0,)], "expected rows of 2 numbers"),
        ([("a", "b")], "expected rows of 2 numbers"),
        (3.0, "expected rows of 2 numbers"),
    ],
)
def test_samples_that_are_none_are_refused_with_their_row(samples, said):
    with pytest.raises(ValueRefused, match=said):
        learn_rules(samples, (THREE,), THREE)


def test_weights_names_and_numbers_that_do_not_fit_are_refused():
    data = [(0.1, 1.0), (0.9, 1.0)]
    for weights, said in [([1.0], "shape"), ([1.0, 0.0], "row 1"), ([2.0, 1.0], "row 0"), ([np.nan, 1.0], "row 0")]:
        with pytest.raises(ValueRefused, match=said):
            learn_rules(data, (THREE,), THREE, weights=weights)
    with pytest.raises(ValueRefused, match="names"):
        learn_rules(data, (THREE,), THREE, names=("x", "x"))
    with pytest.raises(ValueRefused, match="numbers"):
        learn_rules(data, (THREE,), THREE, numbers=[1])
    with pytest.raises(ValueRefused, match="at least one input"):
        learn_rules(data, (), THREE)


def test_samples_may_come_from_a_generator_and_keep_their_numbers():
    learned = learn_rules((row for row in [(0.9, 1.0), (0.5, 1.0)]), (THREE,), THREE, numbers=[7, 9])
    assert learned.cells[2,].winner.sample == 7 and learned.dropped == (9,)
