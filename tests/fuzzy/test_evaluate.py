"""Evaluation: the same bits on every engine, one point or many; closed forms against sums; the edges."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from leadscrew.fuzzy import evaluate
from leadscrew.fuzzy.engine import engine
from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.inference import infer, rule_base
from leadscrew.fuzzy.system import And, Input, Is, Or, Output, Rule, RuleBlock, System, Term
from leadscrew.util.errors import NameUnknown, ValueRefused
from tests.budget import in_every_run
from tests.fuzzy.oracle import generator
from tests.fuzzy.systems import LABELS, full_rules, mamdani, sugeno, triangles, with_block, with_output
from tests.kernel.test_engines import same
from tests.tools import runnable

RNG = np.random.default_rng(5)
POINTS = RNG.uniform(-1.4, 1.4, (300, 2))


def one_input(sets, *rules, low=0.0, high=1.0, **output) -> System:
    x = Input("x", low, high, tuple(sets))
    return System("one", (x,), (Output("u", 0.0, 1.0, **output),), (RuleBlock(tuple(rules)),))


BITS = {f"seed {s}": generator.system(s) for s in range(2000, 2010)} | {
    "exact": mamdani(integration="exact"),
    "exact scaled": with_block(mamdani(integration="exact"), implication="algebraic_product"),
    "exact general": with_output(
        mamdani(integration="exact"), terms=(*triangles(LABELS, -1, 1), Term("r", "rectangle", (0.1, 0.2)))
    ),
    "trapezoid": mamdani(integration="trapezoid"),
    "table": sugeno(),
    "bisector of lines": mamdani(integration="trapezoid", defuzzifier="bisector"),
}  # fmt: skip


MORE = {f"seed {s}" for s in range(2001, 2010)}
NAMES = [pytest.param(name, marks=pytest.mark.slow if name in MORE else ()) for name in BITS]


def points_of(system, count=37):
    return generator.points(system, count, 11)


@pytest.mark.parametrize("name", NAMES)
def test_python_and_machine_code_give_the_same_bits(name):
    system = BITS[name]
    points = points_of(system)
    expected = compiled(system, "python").many(points)
    assert same(compiled(system).many(points), expected)
    assert np.ptp(expected[np.isfinite(expected)]) > 0 or len(set(expected[np.isfinite(expected)])) <= 1


@pytest.mark.parametrize("name", NAMES)
def test_c_gives_the_same_bits(name):
    runnable("c")
    system = BITS[name]
    points = points_of(system)
    assert same(compiled(system, "c").many(points), compiled(system).many(points))


@pytest.mark.parametrize("name", NAMES)
def test_many_points_are_what_single_points_are(name):
    made = compiled(BITS[name])
    points = points_of(BITS[name])
    many = made.many(points).reshape(len(points), -1)
    made.restart()
    for point, expected in zip(points, many, strict=True):
        found = made.scalar(*point)
        assert same(np.atleast_1d(np.array(found)), expected)


def test_two_threads_give_what_one_gives():
    made = compiled(mamdani())
    points = RNG.uniform(-1, 1, (1000, 2))
    assert same(made.many(points, threads=2), made.many(points))


def test_named_arrays_go_together():
    made = compiled(mamdani())
    grid = made.many(e=np.linspace(-1, 1, 5)[:, None], de=np.linspace(-1, 1, 7)[None, :])
    assert grid.shape == (5, 7)
    assert grid[3, 2] == made.scalar(0.5, np.linspace(-1, 1, 7)[2]) == made(e=0.5, de=np.linspace(-1, 1, 7)[2])["u"]


# ---- closed forms
@pytest.mark.slow
@pytest.mark.parametrize("implication", ["minimum", "algebraic_product"])
def test_the_exact_centroid_is_what_finer_and_finer_sums_tend_to(implication):
    system = with_block(mamdani(integration="exact"), implication=implication)
    points = POINTS[(np.abs(POINTS) < 1.3).all(axis=1)]
    exact = compiled(system).many(points)
    errors = [
        np.abs(compiled(with_output(system, integration="midpoint", resolution=n)).many(points) - exact).max()
        for n in (200, 2000, 20000)
    ]
    assert errors[0] < 1e-3 and errors[1] < errors[0] / 20 and errors[2] < 3e-8


@pytest.mark.slow
@pytest.mark.parametrize("implication", ["minimum", "algebraic_product"])
def test_both_ways_to_the_exact_centroid_agree(implication):
    fast = with_block(mamdani(integration="exact"), implication=implication)
    terms = (*fast.outputs[0].terms, Term("unused", "rectangle", (0.1, 0.2)))
    slow = with_output(fast, terms=terms)
    assert "u" in engine(fast).traits.cut and "u" not in engine(slow).traits.cut
    np.testing.assert_allclose(compiled(slow).many(POINTS), compiled(fast).many(POINTS), atol=2e-15)


@pytest.mark.parametrize("seed", in_every_run(range(24), range(2)))
def test_the_exact_centroid_of_any_straight_sets(seed):
    rng = np.random.default_rng(seed)
    shapes = ("triangle", "trapezoid", "ramp", "rectangle", "binary", "discrete")
    terms = tuple(generator.term(rng, f"u{i}", str(rng.choice(shapes)), 0.0, 1.0) for i in range(rng.integers(1, 6)))
    sets = (Term("A", "ramp", (1.0, 0.0)), Term("B", "ramp", (0.0, 1.0)), Term("C", "triangle", (0.0, 0.3, 1.0)))
    rules = tuple(
        Rule(Is("x", "ABC"[i % 3], ("very", "somewhat")[: i % 2]), (Is("u", t.name),), float(rng.uniform(0.3, 1)))
        for i, t in enumerate(terms)
    )
    system = one_input(sets, *rules, terms=terms, integration="exact")
    system = with_block(system, implication=("minimum", "algebraic_product")[seed % 2])
    points = rng.uniform(0.01, 0.99, (20, 1))
    exact = compiled(system, "python").many(points)
    fine = compiled(with_output(system, integration="midpoint", resolution=20011), "llvm").many(points)
    np.testing.assert_allclose(exact, fine, atol=2e-4)
    assert np.isfinite(exact).any() or np.isnan(fine).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ends", "fast"),
    [((-math.inf, math.inf), True), ((-1.0, 1.0), True), ((-4 / 3, 4 / 3), True), ((-1.2, 1.2), False)],
)
def test_outer_sets_of_a_partition(ends, fast):
    """Shoulders, peaks at the ends of the universe, feet at its ends, feet beyond its ends."""
    c = np.linspace(-1, 1, 7).tolist()
    feet = [ends[0] if math.isinf(ends[0]) else -4 / 3, *c, ends[1] if math.isinf(ends[1]) else 4 / 3]
    low, high = (-1.5, 1.5) if math.isinf(ends[0]) else ends
    terms = tuple(Term(n, "triangle", tuple(feet[i : i + 3])) for i, n in enumerate(LABELS))
    system = with_output(mamdani(), terms=terms, low=low, high=high, integration="exact")
    assert ("u" in engine(system).traits.cut) is fast
    fine = compiled(with_output(system, integration="midpoint", resolution=30000)).many(POINTS)
    np.testing.assert_allclose(compiled(system).many(POINTS), fine, atol=1e-7)


# ---- the active-rules path
def general(system: System) -> System:
    """The same system, kept from the active-rules path by a weight that is next to 1."""
    block = system.blocks[0]
    rules = (*block.rules[:-1], replace(block.rules[-1], weight=1.0 - 1e-15))
    return with_block(system, rules=rules)


@pytest.mark.parametrize("inputs", [1, 2, 3])
@pytest.mark.parametrize("shoulders", [True, False])
def test_a_table_is_what_all_its_rules_give(inputs, shoulders):
    rng = np.random.default_rng(inputs)
    made = []
    for k in range(inputs):
        c = np.sort(rng.uniform(-1, 1, 3 + k)).tolist()
        feet = [-math.inf if shoulders else -1.3, *c, math.inf if shoulders else 1.2]
        made.append(
            Input(f"x{k}", -1, 1, tuple(Term(f"t{i}", "triangle", tuple(feet[i : i + 3])) for i in range(len(c))))
        )
    ways = list(itertools.product(*(v.terms for v in made)))
    constants = tuple(Term(f"c{i}", "constant", (float(rng.normal()),)) for i in range(len(ways)))
    rules = []
    for i, way in enumerate(ways):
        node = Is("x0", way[0].name)
        for k in range(1, inputs):
            node = And(Is(f"x{k}", way[k].name), node) if k == 2 else And(node, Is(f"x{k}", way[k].name))
        rules.append(Rule(node, (Is("u", f"c{i}"),)))
    out = Output("u", -9, 9, constants, aggregation=None, defuzzifier="weighted_average", default=7.0)
    order = rng.permutation(len(rules))
    block = RuleBlock(tuple(rules[i] for i in order), conjunction="algebraic_product", implication=None)
    system = System("table", tuple(made), (out,), (block,))
    assert engine(system).traits.tabled == {"u"}
    assert engine(general(system)).traits.tabled == frozenset()
    points = rng.uniform(-1.5, 1.5, (400, inputs))
    fast, slow = compiled(system).many(points), compiled(general(system)).many(points)
    np.testing.assert_allclose(fast, slow, atol=1e-13)
    assert (fast == 7.0).any() != shoulders


def test_two_inputs_take_the_rule_base_of_the_lathe_with_its_bits():
    from leadscrew.controllers._vud.universe import CENTRES, TABLE_2

    names = [f"s{i}" for i in range(6)]
    feet = [-math.inf, *CENTRES, math.inf]
    terms = tuple(Term(n, "triangle", tuple(feet[i : i + 3])) for i, n in enumerate(names))
    e, ec = Input("e", -1, 1, terms), Input("ec", -1, 1, terms)
    constants = tuple(Term(f"c{i}{j}", "constant", (TABLE_2[i, j],)) for i in range(6) for j in range(6))
    rules = full_rules(e, ec, lambda i, j: f"c{i}{j}")
    out = Output("u", -1, 1, constants, aggregation=None, defuzzifier="weighted_average")
    block = RuleBlock(rules, conjunction="algebraic_product", implication=None)
    made = compiled(System("lathe", (e, ec), (out,), (block,)))
    base = rule_base(CENTRES, CENTRES, TABLE_2)
    for x, y in RNG.uniform(-1.3, 1.3, (300, 2)):
        assert made.scalar(x, y) == infer(base, x, y)


# ---- edges
def test_nan_in_gives_nan_out_and_not_the_default():
    made = compiled(mamdani(default=0.5))
    assert math.isnan(made.scalar(math.nan, 0.1)) and math.isnan(made.scalar(0.1, math.nan))
    table = compiled(sugeno(default=0.5))
    assert math.isnan(table.scalar(math.nan, 0.1))


@pytest.mark.slow
def test_where_no_rule_fires_the_default_is_given():
    for system in (mamdani(default=0.25), sugeno(default=0.25), mamdani(default=0.25, integration="exact")):
        assert compiled(system).scalar(5.0, 0.0) == 0.25
    assert math.isnan(compiled(mamdani()).scalar(5.0, 0.0))
    assert compiled(mamdani(default=9.0, lock_range=True)).scalar(5.0, 0.0) == 4 / 3


def test_the_last_output_stays_where_it_is_locked():
    made = compiled(sugeno(lock_previous=True, default=0.25))
    assert made.scalar(5.0, 0.0) == 0.25
    kept = made.scalar(0.5, 0.5)
    assert kept != 0.25 and made.scalar(5.0, 0.0) == kept
    made.restart()
    assert made.scalar(5.0, 0.0) == 0.25
    assert made.many([[5.0, 0.0], [0.5, 0.5], [5.0, 0.0]]).tolist() == [0.25, kept, kept]


def test_inputs_are_held_inside_their_universe_where_they_are_locked_to_it():
    made = sugeno()
    locked = replace(made, inputs=tuple(replace(v, lock_range=True) for v in made.inputs))
    assert compiled(locked).scalar(5.0, 0.2) == compiled(made).scalar(1.0, 0.2)
    held = replace(mamdani(), inputs=locked.inputs)
    assert compiled(held).scalar(-5.0, 0.2) == compiled(mamdani()).scalar(-1.0, 0.2)


def test_a_set_outside_the_universe_has_no_centre():
    system = one_input([Term("A", "ramp", (0.0, 1.0))], Rule(Is("x", "A"), (Is("u", "far"),)),
                       terms=(Term("far", "triangle", (5.0, 6.0, 7.0)),), default=0.5)  # fmt: skip
    assert math.isnan(compiled(system).scalar(0.5))


def test_infinite_inputs_are_far_away():
    sets = [Term("A", "ramp", (0.0, 1.0)), Term("B", "triangle", (-math.inf, 0.0, 1.0))]
    system = one_input(sets, Rule(Is("x", "A"), (Is("u", "one"),)), Rule(Is("x", "B"), (Is("u", "two"),)),
                       terms=(Term("one", "constant", (1.0,)), Term("two", "constant", (2.0,))),
                       defuzzifier="weighted_average")  # fmt: skip
    assert compiled(system).scalar(math.inf) == 1.0
    assert compiled(system).scalar(-math.inf) == 2.0


def test_bisector_and_maxima_of_the_trapezoid_rule():
    """A rectangle from 0 to 0.5 at 1 and from 0.5 to 1 at 0.25, whose numbers are plain."""
    sets = [Term("A", "rectangle", (0.0, 2.0))]
    terms = (Term("left", "rectangle", (0.0, 0.5)), Term("right", "rectangle", (0.5, 1.0)))
    rules = (Rule(Is("x", "A"), (Is("u", "left"),)), Rule(Is("x", "A"), (Is("u", "right"),), 0.25))
    found = {
        name: compiled(one_input(sets, *rules, terms=terms, defuzzifier=name, integration="trapezoid", resolution=1000))
        .scalar(0.5)
        for name in ("bisector", "smallest_of_maximum", "mean_of_maximum", "largest_of_maximum", "centroid")
    }  # fmt: skip
    assert found["smallest_of_maximum"] == 0.0 and found["largest_of_maximum"] == 0.5
    assert found["mean_of_maximum"] == pytest.approx(0.25)
    assert found["bisector"] == pytest.approx(0.3125, abs=1e-3)
    assert found["centroid"] == pytest.approx((0.5 * 0.25 + 0.125 * 0.75) / 0.625, abs=1e-3)


def test_height_takes_the_peaks():
    system = with_output(mamdani(), defuzzifier="height")
    rule = compiled(system)
    assert rule.scalar(0.0, 1 / 3) == pytest.approx(1 / 3)
    weights = np.array([0.5, 0.5])
    assert rule.scalar(1 / 6, 0.0) == pytest.approx((weights * [0.0, 1 / 3]).sum())


def test_a_disabled_output_is_nan_and_a_disabled_input_makes_no_rule_fire():
    assert math.isnan(compiled(with_output(mamdani(default=0.1), enabled=False)).scalar(0.0, 0.0))
    system = mamdani(default=0.1)
    off = replace(system, inputs=(replace(system.inputs[0], enabled=False), system.inputs[1]))
    assert compiled(off).scalar(0.0, 0.0) == 0.1


# ---- refusals
@pytest.mark.parametrize(
    ("system", "said"),
    [
        (with_block(mamdani(), conjunction=None), "needs a conjunction, and the block has none"),
        (with_block(mamdani(), implication=None), "needs an implication, and the block has none"),
        (with_output(mamdani(), aggregation=None), "needs an aggregation"),
        (with_output(sugeno(), defuzzifier="centroid", aggregation="maximum"), "implication"),
        (with_output(mamdani(), integration="exact", aggregation="algebraic_sum"), "aggregation maximum"),
        (with_output(mamdani(), integration="exact", defuzzifier="bisector"), "is there for the centroid"),
        (with_output(mamdani(), high=math.inf), "finite universe"),
        (with_block(mamdani(), activation="threshold", activation_parameters=("~", "1")), "needs a comparison"),
        (with_block(mamdani(), activation="first", activation_parameters=("two",)), "'two' is not a number"),
    ],
)
def test_what_cannot_be_evaluated_is_refused_in_a_sentence(system, said):
    with pytest.raises(ValueRefused, match=said):
        compiled(system)


def test_wrong_inputs_are_refused():
    made = compiled(mamdani())
    with pytest.raises(ValueRefused, match="1 values for the inputs e, de"):
        made.scalar(0.1)
    with pytest.raises(NameUnknown, match=r"no input 'ed'; did you mean"):
        made(e=0.1, ed=0.1)
    with pytest.raises(ValueRefused, match="no value for the input de"):
        made(e=0.1)
    with pytest.raises(ValueRefused, match="one row a point and the columns e, de"):
        made.many([[1.0, 2.0, 3.0]])
    with pytest.raises(ValueRefused, match="engine = 'fortran'"):
        compiled(mamdani(), "fortran")


def test_names_that_python_does_not_take():
    x = Input("class", 0.0, 1.0, (Term("A", "ramp", (0.0, 1.0)),))
    y = Input("Größe 1", 0.0, 1.0, (Term("A", "ramp", (1.0, 0.0)),))
    out = Output("p", 0.0, 1.0, (Term("c", "constant", (3.0,)),), defuzzifier="weighted_sum")
    rule = Rule(Or(Is("class", "A"), Is("Größe 1", "A")), (Is("p", "c"),))
    made = compiled(System('a "quoted"\nname', (x, y), (out,), (RuleBlock((rule,)),)))
    assert made.scalar(0.25, 0.5) == 1.5


def test_lanes_are_a_whole_number_of_points():
    made = compiled(mamdani())
    for count in (0, 1, evaluate.LANES - 1, evaluate.LANES, evaluate.LANES + 1):
        points = POINTS[:count]
        assert same(made.many(points), np.array([made.scalar(*p) for p in points]).reshape(count))
