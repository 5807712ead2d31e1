"""Explanations: the worked example of the lathe paper, and shares that sum to one."""

import math

import numpy as np
import pytest

from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.explanation import explain
from leadscrew.fuzzy.system import Input, Output, RuleBlock, System, Term
from leadscrew.util.errors import NameUnknown, ValueRefused
from tests.fuzzy.oracle import generator
from tests.fuzzy.systems import full_rules, mamdani, sugeno

LABELS = ("NB", "NM", "NS", "PS", "PM", "PB")


def contracted(name: str, centres) -> Input:
    feet = [-math.inf, *centres, math.inf]
    return Input(name, -1, 1, tuple(Term(n, "triangle", tuple(feet[i : i + 3])) for i, n in enumerate(LABELS)))


def lathe() -> System:
    """The rules of the lathe on the universes that section V of the paper prints for e = -0.25, ec = 0.12."""
    from leadscrew.controllers._vud.universe import TABLE_2

    e = contracted("e", [-0.2873, -0.1925, -0.0948, 0.0948, 0.1925, 0.2873])
    ec = contracted("ec", [-0.1485, -0.0995, -0.0490, 0.0490, 0.0995, 0.1485])
    values = {f"v{i}": v for i, v in enumerate(sorted(set(TABLE_2.ravel().tolist())))}
    names = {v: k for k, v in values.items()}
    rules = full_rules(e, ec, lambda i, j: names[TABLE_2[i, j]])
    terms = tuple(Term(k, "constant", (v,)) for k, v in values.items())
    out = Output("u", -1, 1, terms, aggregation=None, defuzzifier="weighted_average")
    return System("lathe", (e, ec), (out,), (RuleBlock(rules, conjunction="algebraic_product", implication=None),))


def test_the_worked_example_of_the_lathe():
    found = explain(lathe(), {"e": -0.25, "ec": 0.12})
    assert len(found.rules) == 4 and found.total == 36
    e, ec = {"NB": 0.6065, "NM": 0.3935}, {"PM": 0.5816, "PB": 0.4184}
    for rule in found.rules:
        (_, mu), (_, nu) = rule.memberships.items()
        a, b = (key.split()[-1] for key in rule.memberships)
        assert (mu, nu) == (pytest.approx(e[a], abs=5e-5), pytest.approx(ec[b], abs=5e-5))
        assert rule.strength == pytest.approx(e[a] * ec[b], abs=1e-4)
        assert rule.shares[0].part == pytest.approx(rule.strength, abs=1e-12)
        assert rule.shares[0].value == 0.677
    assert {tuple(k.split()[-1] for k in r.memberships) for r in found.rules} == {
        ("NB", "PM"), ("NB", "PB"), ("NM", "PM"), ("NM", "PB")
    }  # fmt: skip
    assert found.outputs["u"] == pytest.approx(0.677)
    said = str(found)
    assert "4 of 36 rules fire:" in said
    assert "if e is NB and ec is PM then u is v" in said and "e is NB: 0.606" in said


@pytest.mark.parametrize("system", [mamdani(), mamdani(integration="exact"), sugeno()], ids=["sum", "exact", "table"])
def test_outputs_are_those_of_the_system_and_shares_sum_to_one(system):
    made = compiled(system)
    for point in np.random.default_rng(1).uniform(-0.9, 0.9, (10, 2)):
        found = explain(system, dict(zip(("e", "de"), point, strict=True)))
        assert found.outputs["u"] == made.scalar(*point)
        assert sum(s.part for r in found.rules for s in r.shares) == pytest.approx(1.0)
        assert all(r.strength > 0 for r in found.rules)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3000, 3030))
def test_any_system_can_be_explained(seed):
    system = generator.system(seed)
    made = compiled(system, "python")
    for point in generator.points(system, 3, seed):
        found = explain(system, dict(zip(made.inputs, point, strict=True)))
        made.restart()
        expected = made.scalar(*point)
        expected = expected if isinstance(expected, tuple) else (expected,)
        np.testing.assert_array_equal(list(found.outputs.values()), expected)
        for output in system.outputs:
            parts = [s.part for r in found.rules for s in r.shares if s.output == output.name]
            assert not parts or math.isnan(parts[0]) or sum(parts) == pytest.approx(1.0)
        assert str(found) and found.as_dict()["total"] == len(system.rules)


def test_a_point_where_no_rule_fires():
    assert str(explain(mamdani(default=0.5), {"e": 9.0, "de": 0.0})).endswith("No rule of 49 fires.")


def test_wrong_inputs_are_refused():
    with pytest.raises(NameUnknown, match="no input 'x'"):
        explain(mamdani(), {"e": 0.1, "x": 0.1})
    with pytest.raises(ValueRefused, match="no value for the input de"):
        explain(mamdani(), {"e": 0.1})
