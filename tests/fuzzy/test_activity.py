"""How strongly rules fire at many points, and how a run used them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from leadscrew.fuzzy.engine import engine
from leadscrew.fuzzy.explanation import activity, explain, usage
from leadscrew.fuzzy.system import And, Input, Is, Or, Output, Rule, RuleBlock, System, Term
from leadscrew.util.errors import ValueRefused
from tests.fuzzy.systems import LABELS, mamdani, sugeno, triangles, with_block

RNG = np.random.default_rng(7)
NEAR, FAR = Term("near", "ramp", (4.0, 0.0)), Term("far", "ramp", (6.0, 10.0))
GAP = Input("gap", 0.0, 10.0, (NEAR, FAR))
FEED = Output(
    "feed",
    0.0,
    1.0,
    (Term("slow", "constant", (0.1,)), Term("fast", "constant", (1.0,))),
    aggregation=None,
    defuzzifier="weighted_average",
)
RULES = (
    Rule(Is("gap", "near"), (Is("feed", "slow"),)),
    Rule(Is("gap", "far"), (Is("feed", "fast"),), weight=0.5),
    Rule(Is("gap", "far", ("very",)), (Is("feed", "fast"),), enabled=False),
)
FEEDER = System("feeder", (GAP,), (FEED,), (RuleBlock(RULES),))


def hedged() -> System:
    """Or, hedges, weights, three inputs, one of them named like a function of the written text."""
    names = ("fires", "activity", "x")
    ins = tuple(Input(n, -1.0, 1.0, triangles(LABELS[:3], -1.0, 1.0)) for n in names)
    u = Output("u", -1.0, 1.0, triangles(LABELS[:3], -1.0, 1.0))
    rules = (
        Rule(Or(And(Is("fires", "NB"), Is("activity", "NM", ("not",))), Is("x", "NS")), (Is("u", "NB"),), 0.25),
        Rule(And(Is("fires", "NS", ("very",)), Is("x", "NM", ("somewhat",))), (Is("u", "NS"),)),
        Rule(Is("activity", "", ("any",)), (Is("u", "NM"),), 0.125),
    )
    return System("hedged", ins, (u,), (RuleBlock(rules),))


@pytest.mark.slow
@pytest.mark.parametrize(
    "system",
    [
        mamdani(),
        sugeno(),
        hedged(),
        with_block(mamdani(), activation="highest", activation_parameters=("2",)),
        with_block(
            mamdani(), conjunction="hamacher_product", activation="threshold", activation_parameters=(">", "0.2")
        ),
    ],
    ids=["mamdani", "sugeno", "hedged", "highest", "threshold"],
)
def test_strengths_are_those_of_the_plain_function_bit_by_bit(system):
    points = RNG.uniform(-1.3, 1.3, (60, len(system.inputs)))
    found, made = activity(system, points), engine(system)
    assert found.shape == (60, len(system.rules))
    for row, point in zip(found, points, strict=True):
        plain = made.space["firing"](made.plan, *map(np.float64, point))[0]
        assert row.tolist() == [float(w) for w in plain]


def test_strengths_are_what_explain_says():
    system = hedged()
    point = dict(zip((v.name for v in system.inputs), (0.3, -0.2, 0.8), strict=True))
    said = {rule.number: rule.strength for rule in explain(system, point).rules}
    row = activity(system, [list(point.values())])[0]
    assert {i + 1: w for i, w in enumerate(row.tolist()) if w > 0.0} == said


@pytest.mark.slow
def test_ten_thousand_points_of_343_rules_are_worked_out():
    ins = tuple(Input(n, -1.0, 1.0, triangles(LABELS, -1.0, 1.0)) for n in "abc")
    u = Output("u", -1.0, 1.0, triangles(LABELS, -1.0, 1.0))
    rules = tuple(
        Rule(And(And(Is("a", a), Is("b", b)), Is("c", c)), (Is("u", b),))
        for a in LABELS
        for b in LABELS
        for c in LABELS
    )
    system = System("cube", ins, (u,), (RuleBlock(rules, conjunction="algebraic_product"),))
    found = activity(system, RNG.uniform(-1.0, 1.0, (10_000, 3)))
    assert found.shape == (10_000, 343)
    assert np.allclose(found.sum(axis=1), 1.0)
    assert ((found > 0.0).sum(axis=1) <= 8).all()


def test_rules_that_are_switched_off_have_zeros_in_their_own_column():
    found = activity(FEEDER, [[0.0], [5.0], [10.0]])
    assert found.tolist() == [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.5, 0.0]]
    assert activity(engine(FEEDER), [[0.0]]).tolist() == [[1.0, 0.0, 0.0]]
    assert activity(with_block(FEEDER, enabled=False), [[0.0]]).tolist() == [[0.0, 0.0, 0.0]]
    assert activity(FEEDER, np.empty((0, 1))).shape == (0, 3)


def test_an_input_that_is_locked_is_held_inside():
    locked = replace(FEEDER, inputs=(replace(GAP, lock_range=True, terms=(Term("near", "triangle", (0, 0, 4)), FAR)),))
    assert activity(locked, [[-3.0]])[0, 0] == 1.0


def test_points_of_another_shape_are_refused():
    with pytest.raises(ValueRefused, match=r"points of shape \(3,\): .* the columns gap"):
        activity(FEEDER, [1.0, 2.0, 3.0])
    with pytest.raises(ValueRefused, match="the columns e, de"):
        activity(mamdani(), [[1.0, 2.0, 3.0]])


def test_usage_counts_time_not_rows():
    time = [0.0, 1.0, 1.5, 3.5]
    strengths = activity(FEEDER, [[0.0], [2.0], [5.0], [10.0]])
    near, far, off = usage(FEEDER, time, strengths)
    # rows last 1, 0.5, 2 and, like the one before, 2 seconds
    assert (near.number, near.text, near.seconds) == (1, "if gap is near then feed is slow", 1.5)
    assert near.part == pytest.approx(1.5 / 5.5)
    assert near.mean == pytest.approx((1.0 * 1.0 + 0.5 * 0.5) / 1.5)
    assert (near.strongest, near.at) == (1.0, 0.0)
    assert (far.seconds, far.mean, far.strongest, far.at) == (2.0, 0.5, 0.5, 3.5)
    assert (off.seconds, off.part, off.strongest, off.enabled) == (0.0, 0.0, 0.0, False)
    assert math.isnan(off.mean) and math.isnan(off.at)


def test_times_must_rise_and_fit():
    strengths = np.zeros((3, 3))
    with pytest.raises(ValueRefused, match=r"row 3 \(1\) does not rise"):
        usage(FEEDER, [0.0, 1.0, 1.0], strengths)
    with pytest.raises(ValueRefused, match="row 2"):
        usage(FEEDER, [0.0, math.nan, 1.0], strengths)
    with pytest.raises(ValueRefused, match="one for each of 3 points"):
        usage(FEEDER, [0.0, 1.0], strengths)
