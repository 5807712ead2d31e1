"""Systems built in Python: the usual kinds with their norms, and the doors of a system."""

import math
import pickle

import numpy as np
import pytest

from leadscrew import fuzzy
from leadscrew.util.errors import DataError, ValueRefused

TABLE = """
     N   Z   P
NB   NB  NB  NS
NS   NB  NS  ZE
ZE   NS  ZE  PS
PS   ZE  PS  PB
PB   PS  PB  -
"""
E = fuzzy.Input("e", -1, 1, fuzzy.triangles("NB NS ZE PS PB", -1, 1))
DE = fuzzy.Input("de", -1, 1, fuzzy.triangles("N Z P", -1, 1))
SETS = fuzzy.Output("u", -1.5, 1.5, fuzzy.triangles("NB NS ZE PS PB", -1, 1, shoulders=False))
NUMBERS = fuzzy.Output("u", -1.5, 1.5, fuzzy.constants({"NB": -1, "NS": -0.5, "ZE": 0, "PS": 0.5, "PB": 1}))


def cut_and_added(degrees, scale):
    """Centroid of the triangles at -1, -0.5, ... 1 under degrees, by a fine sum: nothing of ours in it."""
    x = np.linspace(-1.5, 1.5, 3_000_001)
    best = np.zeros_like(x)
    for peak, d in degrees.items():
        mu = np.maximum(0.0, 1.0 - np.abs(x - peak) / 0.5)
        best = np.maximum(best, d * mu if scale else np.minimum(d, mu))
    return float((x * best).sum() / best.sum())


def test_a_table_of_rules_by_hand():
    # e = 0.3: ZE 0.4, PS 0.6; de = -0.2: N 0.2, Z 0.8
    cut = {-0.5: min(0.4, 0.2), 0.0: max(min(0.4, 0.8), min(0.6, 0.2)), 0.5: min(0.6, 0.8)}
    scaled = {-0.5: 0.4 * 0.2, 0.0: max(0.4 * 0.8, 0.6 * 0.2), 0.5: 0.6 * 0.8}
    assert fuzzy.mamdani("m", [E, DE], SETS, TABLE)(e=0.3, de=-0.2)["u"] == pytest.approx(
        cut_and_added(cut, False), abs=1e-9
    )
    assert fuzzy.larsen("l", [E, DE], SETS, TABLE)(e=0.3, de=-0.2)["u"] == pytest.approx(
        cut_and_added(scaled, True), abs=1e-9
    )
    mean = 0.08 * -0.5 + 0.32 * 0.0 + 0.12 * 0.0 + 0.48 * 0.5
    assert fuzzy.takagi_sugeno("t", [E, DE], NUMBERS, TABLE)(e=0.3, de=-0.2)["u"] == pytest.approx(mean, abs=1e-15)


def test_a_cell_without_a_rule_has_none():
    made = fuzzy.takagi_sugeno("t", [E, DE], NUMBERS, TABLE)
    assert len(made.rules) == 14
    assert math.isnan(made(e=1.0, de=1.0)["u"])


def test_first_order_and_tsukamoto_by_hand():
    lines = fuzzy.Output("u", -9, 9, fuzzy.linear({"low": (1, 2, 3), "high": (-1, 0, 5)}))
    made = fuzzy.takagi_sugeno("t", [E, DE], lines, ["if e is NS then u is low", "if e is ZE then u is high"])
    assert made(e=-0.1, de=0.5)["u"] == pytest.approx(0.2 * (-0.1 + 1.0 + 3.0) + 0.8 * (0.1 + 5.0), abs=1e-14)
    ramps = fuzzy.Output("u", 0, 1, (fuzzy.Term("lo", "ramp", (1, 0)), fuzzy.Term("hi", "ramp", (0, 1))))
    text = "# two rules\nif e is ZE then u is lo\nif e is PS then u is hi with 0.5"
    w, v = 0.4, 0.3
    expected = (w * (1 - w) + v * v) / (w + v)
    assert fuzzy.tsukamoto("k", E, ramps, text)(e=0.3)["u"] == pytest.approx(expected, abs=1e-14)


def test_the_centroid_is_sampled_where_a_set_is_curved():
    bell = fuzzy.Output("u", -1, 1, (fuzzy.Term("A", "gaussian", (0.0, 0.2)), fuzzy.Term("B", "triangle", (0, 0.5, 1))))
    rules = ["if e is NS then u is A", "if e is PS then u is B"]
    assert fuzzy.mamdani("m", E, bell, rules).outputs[0].integration == "midpoint"
    assert fuzzy.mamdani("m", [E, DE], SETS, TABLE).outputs[0].integration == "exact"
    assert fuzzy.mamdani("m", [E, DE], SETS, TABLE, integration="trapezoid").outputs[0].integration == "trapezoid"


def test_what_is_wrong_is_said_with_its_place():
    with pytest.raises(DataError, match=r"rules:5:10: u has no term 'ZX'; did you mean ZE"):
        fuzzy.mamdani("m", [E, DE], SETS, TABLE.replace("NS  ZE  PS", "NS  ZX  PS"))
    with pytest.raises(DataError, match="rules:2:6: expected"):
        fuzzy.mamdani("m", [E, DE], SETS, "if e is NB then u is NB\nif e as NB then u is NB")
    with pytest.raises(ValueRefused, match="NB is a triangle; Tsukamoto's sets"):
        fuzzy.tsukamoto("k", [E, DE], SETS, TABLE)
    with pytest.raises(ValueRefused, match="two sets or more"):
        fuzzy.triangles("A", 0, 1)
    with pytest.raises(ValueRefused, match="3 rising numbers"):
        fuzzy.triangles("A B C", 0, 1, centres=[0, 0, 1])


def test_uneven_sets_and_shoulders():
    a, b, c = fuzzy.triangles("A B C", 0, 10, centres=[0, 2, 10])
    assert b.parameters == (0.0, 2.0, 10.0)
    assert a.parameters == (-math.inf, 0.0, 2.0) and c.parameters == (2.0, 10.0, math.inf)
    a, _, c = fuzzy.triangles("A B C", 0, 10, centres=[0, 2, 10], shoulders=False)
    assert a.parameters == (-2.0, 0.0, 2.0) and c.parameters == (2.0, 10.0, 18.0)


def test_the_doors_of_a_system():
    made = fuzzy.mamdani("m", [E, DE], SETS, TABLE)
    one = made(e=0.3, de=-0.2)["u"]
    assert made.many(e=[0.3, 0.3], de=-0.2).tolist() == [one, one]
    assert str(made.explain(e=0.3, de=-0.2)) == str(made.explain({"e": 0.3, "de": -0.2}))
    copy = pickle.loads(pickle.dumps(made))
    assert copy == made and copy(e=0.3, de=-0.2)["u"] == one
    assert hash(copy) == hash(made)
