"""Steps that fill cells without data: tables worked by hand, and monotone values by a second method."""

import itertools

import numpy as np
import pytest
from scipy.optimize import isotonic_regression

from leadscrew.fuzzy.fill import STEPS, before, complete, isotonic, nearest_set, violations
from leadscrew.fuzzy.grids import even, partition
from leadscrew.fuzzy.learning import learn_rules
from leadscrew.studies.vud_lathe import laws as rules
from leadscrew.studies.vud_lathe.laws import moves
from leadscrew.util.errors import NameUnknown, ValueRefused

FIVE = even(-1.0, 1.0, 5)
THREE = even(-1.0, 1.0, 3)


def learned_from(cells, sizes, sets=5, repeat=None):
    """Rules that data at the centres of cells gives; ``repeat`` cells have as many samples."""
    inputs, output = [even(-1.0, 1.0, n) for n in sizes], even(-1.0, 1.0, sets)
    samples = [
        (*(p.centres[i] for p, i in zip(inputs, at, strict=True)), output.centres[k])
        for at, k in cells.items()
        for _ in range((repeat or {}).get(at, 1))
    ]
    return learn_rules(samples, inputs, output)


# ---- monotone values
def by_sets(values, weights, comes):
    """The monotone fit by its min-max formula over all upper and lower sets: right, and only for a few points."""
    n = len(values)
    masks = [np.array(m, dtype=bool) for m in itertools.product((0, 1), repeat=n)]
    upper = [m for m in masks if not (m[:, None] & comes & ~m[None, :]).any()]
    lower = [~m for m in upper]

    def mean(part):
        return np.average(values[part], weights=weights[part]) if part.any() else np.inf

    return np.array(
        [max(min(mean(u & low) for low in lower if low[i]) for u in upper if u[i]) for i in range(n)]
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(12))
def test_monotone_values_are_those_of_the_min_max_formula(seed):
    rng = np.random.default_rng(seed)
    grid = np.array(list(itertools.product(range(3), repeat=2)))
    points = grid[rng.permutation(9)[: rng.integers(4, 8)]]
    values, weights = rng.normal(size=len(points)), rng.uniform(0.2, 5.0, len(points))
    ways = np.array([[1, 1], [1, -1], [-1, 0]][seed % 3])
    fitted = isotonic(points, values, weights, ways)
    assert fitted == pytest.approx(by_sets(values, weights, before(points, points, ways)), abs=1e-9)
    assert len(violations(points, fitted, ways)) == 0


@pytest.mark.parametrize("way", [1, -1])
def test_on_a_line_they_are_scipys_isotonic_regression(way):
    rng = np.random.default_rng(20)
    values, weights = np.sort(rng.normal(size=80)) + rng.normal(size=80), rng.uniform(0.1, 3.0, 80)
    fitted = isotonic(np.arange(80)[:, None], values, weights, np.array([way]))
    expected = isotonic_regression(values, weights=weights, increasing=way > 0).x
    assert fitted == pytest.approx(expected, abs=1e-9)


def test_a_whole_noisy_table_of_400_cells_becomes_monotone():
    rng = np.random.default_rng(21)
    points = np.array(list(itertools.product(range(20), repeat=2)))
    values = points.sum(axis=1) + 2.0 * rng.normal(size=400)
    fitted = isotonic(points, values, np.ones(400), np.array([1, 1]))
    assert len(violations(points, fitted, np.array([1, 1]))) == 0
    assert fitted.mean() == pytest.approx(values.mean())
    # Of the projection on a cone, the rest is orthogonal to it.
    assert (values - fitted) @ fitted == pytest.approx(0.0, abs=1e-6)


# ---- steps on tables worked by hand
def test_nothing_is_filled_unless_asked_for():
    done = complete(learned_from({(0,): 4}, (5,)))
    assert done.outputs == {(0,): 4} and done.sources == {(0,): "data"} and done.missing == 4
    assert done.report() == "4 of 5 cells have no rule"


def test_antisymmetric_mirrors_and_names_what_contradicts_it():
    #        N   ZE  P              N   ZE  P
    #   N    4   .   1   becomes    4   .   1    (N, P) -> 1 wants (P, N) -> 3, but data says 2
    #   ZE   .   .   .              .   2   .    zero is its own mirror
    #   P    2   .   .              2   .   0
    done = complete(learned_from({(0, 0): 4, (0, 2): 1, (2, 0): 2}, (3, 3)), ["antisymmetric"])
    assert done.outputs == {(0, 0): 4, (0, 2): 1, (1, 1): 2, (2, 0): 2, (2, 2): 0}
    (step,) = done.steps
    assert step.filled == {(1, 1): 2, (2, 2): 0} and not step.changed
    assert step.note == "data contradicts symmetry at (N, P)"
    assert [at for at, source in done.sources.items() if source == "antisymmetric"] == [(1, 1), (2, 2)]
    assert "antisymmetric: 2 cells filled: (ZE, ZE) -> ZE, (P, P) -> NB" in done.report()


def test_antisymmetric_needs_centres_about_zero():
    p = partition([0.0, 1.0, 2.0])
    with pytest.raises(ValueRefused, match=r"centres of x1 \(0, 1, 2\) are not symmetric about zero"):
        complete(learn_rules([(0.0, 0.0)], (p,), THREE), ["antisymmetric"])


def test_monotone_fills_a_row_between_what_is_known():
    # 4 . . . 0 falling: the middle of 4 and 0 everywhere between; beyond the ends the extreme stands in.
    done = complete(learned_from({(1,): 4, (5,): 0}, (7,)), ["monotone"], {"x1": -1})
    assert [done.outputs[i,] for i in range(7)] == [4, 4, 2, 2, 2, 0, 0]


def test_monotone_fills_a_table_from_two_sides():
    #        0   1   2              0   1   2
    #   0    0   .   .   becomes    0   1   2     rising in both: (0, 1) and (1, 0) lie between 0 and 2,
    #   1    .   2   .              1   2   3     (0, 2) and (2, 0) between 0 and 4, (1, 2) between 2 and 4
    #   2    .   .   4              2   3   4
    done = complete(learned_from({(0, 0): 0, (1, 1): 2, (2, 2): 4}, (3, 3)), ["monotone"], {"x1": 1, "x2": 1})
    assert [[done.outputs[i, j] for j in range(3)] for i in range(3)] == [[0, 1, 2], [1, 2, 3], [2, 3, 4]]
    assert done.missing == 0 and len(done.steps[0].filled) == 6


def test_monotone_leaves_data_as_it_is_and_names_what_contradicts_it():
    # 0 3 1 . rising: 3 samples of the 3 and one of the 1 make the fit 0 2.5 2.5; of sets 2 and 3, 2 is the middle.
    learned = learned_from({(0,): 0, (1,): 3, (2,): 1}, (4,), repeat={(1,): 3})
    done = complete(learned, ["monotone"], {"x1": 1})
    assert [done.outputs[i,] for i in range(4)] == [0, 3, 1, 2]
    assert done.steps[0].note == "data contradicts monotonicity at (NS), (PS)"


def test_monotone_leaves_cells_empty_that_it_cannot_compare():
    done = complete(learned_from({(0, 0): 0, (0, 2): 2}, (2, 3)), ["monotone"], {"x2": 1})
    assert sorted(done.outputs) == [(0, 0), (0, 1), (0, 2)] and done.missing == 3


@pytest.mark.parametrize("seed", range(6))
def test_a_monotone_fill_is_monotone_and_keeps_symmetry(seed):
    rng = np.random.default_rng(seed)
    whole = {at: min(6, max(0, sum(at) - 3)) for at in itertools.product(range(7), range(7))}
    seen = [at for at in whole if rng.random() < 0.25]
    both = {p: whole[p] for at in seen for p in (at, (6 - at[0], 6 - at[1]))}
    done = complete(learned_from(both, (7, 7), sets=7), ["monotone"], {"x1": 1, "x2": 1})
    cells, values = np.array(list(done.outputs)), np.array(list(done.outputs.values()))
    assert len(violations(cells, values, np.array([1, 1]))) == 0
    assert all(done.outputs[at] == 6 - done.outputs[6 - at[0], 6 - at[1]] for at in done.outputs)


def test_nearest_copies_and_prefers_the_middle_where_two_are_as_near():
    done = complete(learned_from({(0,): 0, (2,): 3, (6,): 4}, (7,)), ["nearest"])
    # Cell 1: sets 0 and 3 as near, 3 lies nearer to the middle; cell 4: 3 against 4.
    assert [done.outputs[i,] for i in range(7)] == [0, 3, 3, 3, 3, 4, 4]


def test_nearest_measures_between_centres_not_between_numbers():
    uneven = partition([0.0, 0.8, 1.0])
    learned = learn_rules([(0.0, -1.0), (1.0, 1.0)], (uneven,), THREE)
    assert complete(learned, ["nearest"]).outputs[1,] == 2


def test_steps_follow_one_another_and_each_names_its_cells():
    done = complete(learned_from({(0, 0): 4, (1, 1): 3}, (5, 5)), ["antisymmetric", "monotone"], {"x1": -1, "x2": -1})
    assert [len(s.filled) for s in done.steps] == [3, 20] and done.missing == 0
    assert sorted(set(done.sources.values())) == ["antisymmetric", "data", "monotone"]
    assert [s["step"] for s in done.as_dict()["steps"]] == ["antisymmetric", "monotone"]


def test_three_inputs_are_filled_too():
    learned = learned_from({(0, 0, 0): 0, (2, 2, 2): 4}, (3, 3, 3))
    for steps in (["nearest"], ["monotone"], ["antisymmetric", "nearest"]):
        assert complete(learned, steps, {"x1": 1, "x2": 1, "x3": 1}).missing == 0


@pytest.mark.parametrize(("step", "equal"), [("servo", 24), ("servo_growth", 36)])
def test_the_lathes_procedure_is_a_step_that_says_what_it_overrules(step, equal):
    learned = rules.learn(moves())
    done = complete(learned, [step])
    levels = np.concatenate([-np.array(rules.MAGNITUDES[::-1]), rules.MAGNITUDES])
    table = np.array([[levels[done.outputs[i, j]] for j in range(6)] for i in range(6)])
    assert int(np.isclose(table, rules.TABLE_2).sum()) == equal
    assert sorted(done.steps[0].changed) == [(2, 4), (3, 1)] and len(done.steps[0].filled) == 28
    assert "(NS, PM)" in done.steps[0].note and "2 rules from before overruled" in done.report()


def test_the_nearest_set_of_a_value_between_two_is_the_one_towards_the_middle():
    assert [nearest_set(FIVE, v) for v in (-0.75, 0.75, 0.1, 9.0)] == [1, 3, 2, 4]
    assert nearest_set(even(-1.0, 1.0, 4), 0.0) == 1


def test_what_cannot_be_completed_is_refused():
    learned = learned_from({(0,): 0}, (5,))
    with pytest.raises(NameUnknown, match="monotone"):
        complete(learned, ["monoton"])
    with pytest.raises(NameUnknown, match="no input 'q'"):
        complete(learned, ["monotone"], {"q": 1})
    with pytest.raises(ValueRefused, match="allowed are 1"):
        complete(learned, ["monotone"], {"x1": 2})
    with pytest.raises(ValueRefused, match="needs a direction"):
        complete(learned, ["monotone"])
    with pytest.raises(ValueRefused, match="two inputs"):
        complete(learned, ["servo"])
    for step in STEPS:
        with pytest.raises(ValueRefused, match="at least one learned rule"):
            complete(learn_rules([], (FIVE,), FIVE), [step])
    wide = learn_rules([(0.1,) * 9], (FIVE,) * 8, FIVE)
    with pytest.raises(ValueRefused, match="390625 cells"):
        complete(wide, ["nearest"])
