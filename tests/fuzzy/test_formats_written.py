"""What is written: whole files, and what a format cannot express is refused or noted."""

import dataclasses
import math

import pytest

from leadscrew.fuzzy import formats
from leadscrew.fuzzy.formats import fis, fld, fll
from leadscrew.fuzzy.system import And, Input, Is, Or, Output, Rule, RuleBlock, System, Term
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

A, B = Term("a", "triangle", (0.0, 0.0, 1.0)), Term("b", "triangle", (0.0, 1.0, 1.0))
X, Y = Input("x", 0.0, 1.0, (A, B)), Output("y", 0.0, 1.0, (A, B))
RULE = Rule(Is("x", "a"), (Is("y", "b"),))
SMALL = System("small", (X,), (Y,), (RuleBlock((RULE,)),))


def with_input(*terms: Term, **changes) -> System:
    return dataclasses.replace(SMALL, inputs=(dataclasses.replace(X, terms=(A, B, *terms), **changes),))


def with_block(*rules: Rule, **changes) -> System:
    return dataclasses.replace(SMALL, blocks=(RuleBlock(rules, **changes),))


def with_output(**changes) -> System:
    return dataclasses.replace(SMALL, outputs=(dataclasses.replace(Y, **changes),))


def test_a_written_file_is_whole_and_alone_in_its_folder(tmp_path):
    path = tmp_path / "new" / "small.fll"
    assert formats.write(SMALL, path) == ()
    assert formats.read(path) == SMALL
    before = path.read_text()
    with pytest.raises(ValueRefused):
        formats.write(with_output(defuzzifier="height"), path)
    assert path.read_text() == before
    assert [p.name for p in path.parent.iterdir()] == ["small.fll"]


def test_files_that_cannot_be_read_or_written(tmp_path):
    with pytest.raises(DataError, match=r"none.fis: cannot be read \(No such file"):
        formats.read(tmp_path / "none.fis")
    (tmp_path / "binary.fis").write_bytes(b"[System]\0")
    with pytest.raises(DataError, match=r"binary.fis:1:1: expected text, found binary data"):
        formats.read(tmp_path / "binary.fis")
    with pytest.raises(DataError, match=r"cannot be written"):
        formats.write(SMALL, tmp_path / "binary.fis" / "small.fll")
    with pytest.raises(ValueRefused, match=r"\.xml: systems are written as \.fis, \.fll, \.fcl"):
        formats.write(SMALL, tmp_path / "small.xml")
    with pytest.raises(NameUnknown, match="no format 'flll' is written; did you mean fll"):
        formats.dumps(SMALL, "flll")


def test_other_programs_are_told_apart_from_leadscrew_in_the_rule_of_integration():
    notes: list[str] = []
    text = fis.dumps(SMALL, notes)
    assert "% leadscrew: integration of y: midpoint, resolution 100" in text
    assert notes == [
        "output y: its rule of integration (midpoint, 100) stands in a comment that Leadscrew reads; "
        "other programs take their own"
    ]
    assert fis.loads(text).outputs[0].integration == "midpoint"
    with pytest.raises(DataError, match=r"text.fis:1:29: there is no output 'z'"):
        fis.loads(text.replace("of y", "of z"))


TWO = dataclasses.replace(Y, name="y2", defuzzifier="bisector")
OR = Rule(Or(Is("x", "a"), Is("x", "b")), (Is("y", "b"),))


@pytest.mark.parametrize(
    ("format", "system", "what"),
    [
        ("fis", with_output(default=0.5), "output y: a default of 0.5 where no rule fires"),
        ("fis", with_output(lock_previous=True), "output y: that the last value stays where no rule fires"),
        ("fis", with_output(lock_range=True), "y: lock_range = True"),
        ("fis", with_input(enabled=False), "x: enabled = False"),
        ("fis", with_output(aggregation=None), "the aggregation none"),
        ("fis", with_output(defuzzifier="height", aggregation=None), "the defuzzifier height"),
        ("fis", with_output(defuzzifier="weighted_sum"), "output y: aggregation maximum with weighted_sum"),
        ("fis", dataclasses.replace(SMALL, outputs=(Y, TWO)), "outputs that differ in their defuzzifier"),
        ("fis", dataclasses.replace(SMALL, outputs=(), blocks=()), "a system without outputs"),
        ("fis", with_block(RULE, activation="highest"), "rule block '': activation highest"),
        ("fis", with_block(OR), "a rule that names x twice"),
        ("fis", with_block(OR, disjunction=None), "rules that need a disjunction in a block that has none"),
        ("fis", with_block(Rule(And(Is("x", "a"), OR.antecedent), RULE.consequents)), "a rule with both"),
        ("fis", with_block(Rule(Is("y", "a"), RULE.consequents)), "a rule that asks for y, which is no input"),
        ("fis", with_block(Rule(Is("x", "a", ("seldom",)), RULE.consequents)), "'x is seldom a'"),
        ("fis", with_block(Rule(Is("x", "", ("any",)), RULE.consequents)), "'x is any'"),
        ("fis", with_input(Term("c", "singleton", (0.5,))), "x, term c: a singleton"),
        ("fis", with_input(Term("c", "spike", (0.5, 1.0), 0.5)), "x, term c: a height of 0.5"),
        ("fis", with_input(Term("it's", "ramp", (0.0, 1.0))), "a term's name \"it's\""),
        (
            "fis",
            dataclasses.replace(SMALL, blocks=(RuleBlock((RULE,)), RuleBlock((RULE,), conjunction="einstein_product"))),
            "rule blocks that differ in their conjunction",
        ),
        ("fll", with_output(defuzzifier="height"), "output y: the defuzzifier height"),
        ("fll", with_input(Term("c", "singleton", (0.5,))), "x, term c: a singleton"),
        ("fll", with_block(Rule(Is("x", "a"), (Is("y", "", ("any",)),))), "a rule that concludes 'y is any'"),
        ("fcl", with_input(lock_range=True), "input x: that it is held inside its universe"),
        ("fcl", with_block(RULE, activation="first"), "rule block '': activation first"),
        ("fcl", with_output(defuzzifier="height"), "output y: the defuzzifier height"),
        ("fcl", with_output(terms=(A, B, Term("c", "constant", (0.5,)))), "y, term c: a constant"),
        ("fcl", with_input(Term("c", "singleton", (0.5,), 0.5)), "x, term c: a singleton"),
    ],
)  # fmt: skip
def test_what_a_format_cannot_express_is_refused(format, system, what):
    with pytest.raises(ValueRefused) as error:
        formats.dumps(system, format)
    assert str(error.value).startswith(f"a .{format} file cannot express {what}")


def test_what_changes_no_output_is_noted():
    off = dataclasses.replace(RULE, enabled=False)
    system = dataclasses.replace(
        SMALL, inputs=(dataclasses.replace(X, name="x y", unit="mm", doc="a # b"),), doc="small",
        blocks=(RuleBlock((dataclasses.replace(RULE, antecedent=Is("x y", "a", ("any", "very"))),), "one"),
                RuleBlock((dataclasses.replace(off, antecedent=Is("x y", "a")),))),
    )  # fmt: skip
    notes: list[str] = []
    found = fll.loads(fll.dumps(system, notes))
    assert notes == [
        "1 rule switched off: not written",
        "x y is any very a: what follows 'any' is not written",
        "variable 'x y' is called x_y in the file",
        "units are not written: x_y in mm",
        "'a # b' is written as 'a b'",
    ]
    assert found.inputs[0].name == "x_y"
    assert found.rules == (Rule(Is("x_y", "", ("any",)), RULE.consequents),)


def test_a_table_of_values_is_that_of_fuzzylite():
    two = dataclasses.replace(SMALL, inputs=(X, dataclasses.replace(X, name="z", low=-1.0)))
    text = fld.dumps(two, lambda point: (point[0] - point[1],), values=9)
    assert text.splitlines()[:4] == ["x z y", "0.0 -1.0 1.0", "0.0 0.0 0.0", "0.0 1.0 -1.0"]
    assert len(text.splitlines()) == 10
    assert fld.dumps(two, lambda point: (point[0] - point[1],), values=3, each=True) == text


@pytest.mark.parametrize(
    ("system", "values", "sentence"),
    [
        (SMALL, 1, "a grid of 1 values over 1 inputs: allowed are 2 values or more"),
        (SMALL, 10**9, "a grid of 1000000000 values over 1 inputs"),
        (with_input(high=math.inf), 9, "input x: universe [0.0, inf]: a grid needs ends"),
        (dataclasses.replace(SMALL, inputs=(dataclasses.replace(X, name="x y"),), blocks=()), 9, "a .fld file cannot"),
    ],
)  # fmt: skip
def test_a_table_that_cannot_be_is_refused(system, values, sentence):
    with pytest.raises(ValueRefused) as error:
        fld.dumps(system, lambda point: point, values=values)
    assert str(error.value).startswith(sentence)
