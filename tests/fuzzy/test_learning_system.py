"""Learned rules as a system that evaluates, partitions as inputs and back, and where each rule comes from."""

import math

import numpy as np
import pytest

from leadscrew.fuzzy import formats
from leadscrew.fuzzy.engine import engine
from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.fill import complete
from leadscrew.fuzzy.from_data import to_system
from leadscrew.fuzzy.grids import even, partition
from leadscrew.fuzzy.learning import learn_rules
from leadscrew.fuzzy.partition import Partition
from leadscrew.fuzzy.system import Input, Term
from leadscrew.studies.vud_lathe import laws as rules
from leadscrew.studies.vud_lathe.laws import moves
from leadscrew.util.errors import ValueRefused

UNEVEN = partition([-1.0, -0.2, 0.5, 2.0])


def random_rules(sizes, cells=1.0, seed=1):
    rng = np.random.default_rng(seed)
    inputs, output = [even(-1.0, 1.0, n) for n in sizes], even(-3.0, 3.0, 5)
    corners = np.stack(np.meshgrid(*(p.centres for p in inputs), indexing="ij"), axis=-1).reshape(-1, len(sizes))
    kept = corners[rng.permutation(len(corners))[: round(cells * len(corners))]]
    return learn_rules(np.column_stack([kept, rng.choice(output.centres, len(kept))]), inputs, output)


def by_hand(learned, x, weights=None):
    """The mean of the concluded centres, by all rules."""
    above = below = 0.0
    for at, cell in learned.cells.items():
        degree = math.prod(p.memberships(v)[i] for p, v, i in zip(learned.inputs, x, at, strict=True))
        degree *= 1.0 if weights is None else weights[at]
        above += degree * learned.output.centres[cell.winner.output]
        below += degree
    return above / below if below > 0.0 else math.nan


@pytest.mark.parametrize("sizes", [(4,), (3, 5), (3, 4, 2), (2, 3, 2, 2)])
@pytest.mark.parametrize("conclude", ["centres", "sets"])
def test_a_full_table_gives_the_sum_over_all_rules_also_outside(sizes, conclude):
    learned = random_rules(sizes)
    system = to_system(learned, conclude=conclude)
    assert bool(engine(system).traits.tabled) == (len(sizes) <= 3)
    points = np.random.default_rng(2).uniform(-1.3, 1.3, (60, len(sizes)))
    assert compiled(system).many(points) == pytest.approx([by_hand(learned, x) for x in points], abs=1e-12)


def test_where_no_rule_fires_the_output_is_the_default():
    learned = random_rules((5, 5), cells=0.4)
    points = np.random.default_rng(3).uniform(-1.0, 1.0, (200, 2))
    expected = np.array([by_hand(learned, x) for x in points])
    assert np.isnan(expected).any()
    assert compiled(to_system(learned)).many(points) == pytest.approx(expected, abs=1e-12, nan_ok=True)
    filled = compiled(to_system(learned, default=7.0)).many(points)
    assert filled == pytest.approx(np.where(np.isnan(expected), 7.0, expected), abs=1e-12)


def test_strengths_can_be_the_rules_weights():
    learned = rules.learn(moves())
    system = to_system(learned, weights="strength")
    strengths = {at: cell.winner.strength for at, cell in learned.cells.items()}
    assert [r.weight for r in system.rules] == list(strengths.values())
    for x in [(-0.9, 0.3), (-0.5, 0.6), (0.4, -0.5)]:
        assert compiled(system).scalar(*x) == pytest.approx(by_hand(learned, x, strengths), abs=1e-12)


def test_the_system_says_which_rules_are_data_and_which_were_filled_in():
    learned = rules.learn(moves())
    bare = to_system(learned)
    assert len(bare.rules) == 8 and bare.doc == "8 of 36 rules: 1-8 from data (Wang and Mendel)"
    assert bare.notes[-1] == "28 cells have no rule"
    assert bare.notes[0] == "rule 1 (if e is NB and ec is PS then rho is PB): data, strength 0.404, 1 of 1 samples"
    full = to_system(complete(learned, ["servo_growth"]), weights="strength")
    assert len(full.rules) == 36 and "30 filled" not in full.doc and "filled by servo_growth" in full.doc
    assert sum("not data" in note for note in full.notes) == 30
    assert min(r.weight for r in full.rules) == min(c.winner.strength for c in learned.cells.values())


@pytest.mark.parametrize("format", ["fis", "fll", "fcl"])
def test_a_learned_system_goes_to_files_and_comes_back_the_same(format):
    system = to_system(random_rules((3, 5)), units={"x1": "mm"})
    assert system.inputs[0].unit == "mm"
    back = formats.loads(formats.dumps(system, format), format)
    points = np.random.default_rng(4).uniform(-1.5, 1.5, (40, 2))
    assert compiled(back).many(points).tolist() == compiled(system).many(points).tolist()


def test_choices_that_do_not_exist_are_refused():
    learned = random_rules((3,))
    with pytest.raises(ValueRefused, match="weights"):
        to_system(learned, weights="some")
    with pytest.raises(ValueRefused, match="conclude"):
        to_system(learned, conclude="some")
    with pytest.raises(ValueRefused, match="no rule was learned"):
        to_system(learn_rules([], (UNEVEN,), UNEVEN))
    twice = Partition((0.0, 1.0), ("A", "A"))
    with pytest.raises(ValueRefused, match="two terms"):
        to_system(learn_rules([(0.0, 0.0)], (twice,), UNEVEN))


def test_a_partition_is_an_input_and_comes_back():
    for p in (UNEVEN, even(0.0, 1.0, 2), rules.SETS):
        variable = p.as_input("x", "mm")
        assert (variable.unit, variable.low, variable.high) == ("mm", p.centres[0], p.centres[-1])
        assert Partition.from_input(variable) == p


def triangles(first, last, **more):
    middle = Term("M", "triangle", (0.0, 1.0, 2.0))
    return Input("x", 0.0, 2.0, (Term("L", "triangle", first), middle, Term("H", "triangle", last)), **more)


def test_terms_that_are_no_partition_are_refused_as_one():
    inf = math.inf
    assert Partition.from_input(triangles((-inf, 0.0, 1.0), (1.0, 2.0, inf))).centres == (0.0, 1.0, 2.0)
    assert len(Partition.from_input(triangles((-1.0, 0.0, 1.0), (1.0, 2.0, 3.0), lock_range=True))) == 3
    with pytest.raises(ValueRefused, match="fall to zero outside"):
        Partition.from_input(triangles((-1.0, 0.0, 1.0), (1.0, 2.0, 3.0)))
    with pytest.raises(ValueRefused, match="sum to one"):
        Partition.from_input(triangles((-inf, 0.0, 0.9), (1.0, 2.0, inf)))
