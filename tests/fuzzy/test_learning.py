"""Rules from data: the paper's own samples, conflicts, ties, and what the report says of them."""

import pytest

from leadscrew.controllers._vud.universe import TABLE_2
from leadscrew.fuzzy.fill import complete_rules
from leadscrew.fuzzy.learning import learn_rules
from leadscrew.fuzzy.partition import Partition
from leadscrew.studies.vud_lathe import laws as rules
from leadscrew.studies.vud_lathe.laws import moves
from leadscrew.util.errors import ValueRefused

SETS = rules.SETS


def cells(learned):
    labels = SETS.labels
    return {(labels[i], labels[j]): labels[c.winner.output] for (i, j), c in learned.cells.items()}


def test_one_sample_gives_the_papers_first_rule_and_strength():
    learned = learn_rules([(-0.932, 0.497, 1.0)], (SETS, SETS), SETS)
    assert cells(learned) == {("NB", "PS"): "PB"}
    assert learned.cells[0, 3].winner.strength == pytest.approx(0.40398, abs=1e-5)


def test_the_stronger_of_two_conflicting_rules_wins_and_the_loser_is_reported():
    learned = learn_rules([(-0.801, 0.965, 0.921), (-0.670, 0.956, 0.735)], (SETS, SETS), SETS)
    (cell,) = learned.conflicts.values()
    assert cells(learned) == {("NM", "PB"): "PM"}
    assert learned.say(cell.winner) == "NM, PB -> PM (0.696)"
    assert [learned.say(rule) for rule in cell.losers] == ["NM, PB -> PB (0.410)"]
    assert cell.count == 2 and cell.winner.sample == 1


def test_samples_between_two_sets_are_left_out_unless_asked_for():
    data = [(0.0, 0.5, 0.9), (-0.9, 0.9, 0.9)]
    assert learn_rules(data, (SETS, SETS), SETS).dropped == (0,)
    assert learn_rules(data, (SETS, SETS), SETS, ties="keep").covered == 2
    with pytest.raises(ValueRefused, match="ties"):
        learn_rules(data, (SETS, SETS), SETS, ties="guess")


def test_table_1_covers_eight_cells_of_which_six_agree_with_table_2():
    learned = rules.learn(moves())
    assert (learned.samples, len(learned.dropped), learned.covered) == (80, 21, 8)
    assert learned.agreement(TABLE_2) == (6, [(2, 4), (3, 1)])
    assert cells(learned) == {
        ("NB", "PS"): "PB", ("NM", "PB"): "PM", ("NS", "PS"): "PS", ("NS", "PM"): "PM",
        ("PS", "NS"): "NS", ("PS", "NM"): "NM", ("PM", "NB"): "NM", ("PB", "NS"): "NB",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("ties", "rate", "covered", "agree"),
    [("drop", "signed", 8, 6), ("keep", "signed", 9, 6), ("keep", "printed", 9, 5)],
)
def test_coverage_under_each_way_to_read_table_1(ties, rate, covered, agree):
    learned = rules.learn(moves(), ties, rate)
    assert (learned.covered, learned.agreement(TABLE_2)[0]) == (covered, agree)


def test_table_2_comes_back_whole_with_prior_knowledge_and_two_thirds_without():
    learned = rules.learn(moves())
    assert rules.equal_cells(rules.rebuild(learned)) == 36
    assert rules.equal_cells(rules.rebuild(learned, add_growth_level=False)) == 24


def test_completion_says_which_rules_it_kept_and_which_it_dropped():
    done = rules.rebuild(rules.learn(moves()))
    assert {at: seed.level for at, seed in done.seeds.items()} == {(0, 3): 3, (1, 5): 2, (2, 3): 1}
    assert {at: (seed.level, seed.count) for at, seed in done.dropped.items()} == {(2, 4): (2, 4)}
    assert done.seeds[2, 3].count == 47


def test_completion_refuses_partitions_without_two_equal_halves():
    three = Partition((-1.0, 0.0, 1.0), ("N", "Z", "P"))
    with pytest.raises(ValueRefused, match="even"):
        complete_rules(learn_rules([(0.9, 0.9, 0.9)], (three, three), three))
    with pytest.raises(ValueRefused, match="at least one"):
        complete_rules(learn_rules([], (SETS, SETS), SETS))
