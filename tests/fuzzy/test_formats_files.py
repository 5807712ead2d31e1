"""Files that others wrote, what is said of them, and what is refused when a system is written."""

import dataclasses
import math
from xml.etree import ElementTree

import pytest

from leadscrew.fuzzy import formats
from leadscrew.fuzzy.formats import fcl, fis, fll, fml
from leadscrew.fuzzy.system import And, Input, Is, Or, Output, Rule, RuleBlock, System, Term
from leadscrew.util.errors import DataError
from tests.fuzzy.formats_systems import shared
from tests.fuzzy.test_formats_broken import FML

A, B = Term("a", "triangle", (0.0, 0.0, 1.0)), Term("b", "triangle", (0.0, 1.0, 1.0))
X, Y = Input("x", 0.0, 1.0, (A, B)), Output("y", 0.0, 1.0, (A, B))
RULE = Rule(Is("x", "a"), (Is("y", "b"),))
SMALL = System("small", (X,), (Y,), (RuleBlock((RULE,)),))
SUGENO = Output("y", 0.0, 1.0, (Term("b", "constant", (1.0,)),), aggregation=None, defuzzifier="weighted_average")


def test_the_tipper_of_matlab():
    tipper = formats.read(shared("data/fuzzy/tipper.fis"))
    service, food = tipper.inputs
    (tip,) = tipper.outputs
    assert tipper.name == "tipper"
    assert tipper.notes == ()
    assert service.terms[0] == Term("poor", "gaussian", (0.0, 1.5))
    assert food.terms[1] == Term("delicious", "trapezoid", (7.0, 9.0, 10.0, 12.0))
    assert (tip.low, tip.high, tip.integration, tip.resolution) == (0.0, 30.0, "trapezoid", 100)
    assert tipper.rules == (
        Rule(Or(Is("service", "poor"), Is("food", "rancid")), (Is("tip", "cheap"),)),
        Rule(Is("service", "good"), (Is("tip", "average"),)),
        Rule(Or(Is("service", "excellent"), Is("food", "delicious")), (Is("tip", "generous"),)),
    )


def test_the_tipper_of_ieee_1855():
    tipper = formats.read(shared("data/fuzzy/tipper.xml"))
    food, service = tipper.inputs
    assert food.terms == (Term("rancid", "ramp", (5.5, 0.0)), Term("delicious", "ramp", (5.5, 10.0)))
    assert service.term("poor") == Term("poor", "gaussian_product", (-math.inf, 2.0, 0.0, 2.0))
    assert service.term("excellent") == Term("excellent", "gaussian_product", (10.0, 2.0, math.inf, 2.0))
    assert tipper.rules[0].antecedent == Or(Is("food", "rancid"), Is("service", "poor", ("very",)))
    assert tipper.outputs[0].default == 0.0
    assert tipper.outputs[0].unit == ""
    assert tipper.notes == ("left and right name the flank: a right set falls (FML before the standard)",)


def test_left_and_right_follow_the_name_space_of_a_markup_file():
    text = shared("data/fuzzy/tipper.xml").read_text()
    standard = text.replace("<fuzzySystem ", '<fuzzySystem xmlns="http://www.ieee1855.org" ')
    assert fml.loads(standard).inputs[0].terms[0] == Term("rancid", "ramp", (0.0, 5.5))
    assert fml.loads(standard, right_rises=False) == fml.loads(text)


def test_the_container_crane_names_a_term_that_it_does_not_have():
    path = shared("data/fuzzy/container_crane.fcl")
    with pytest.raises(
        DataError, match=r"container_crane.fcl:43:65: power has no term 'pos_big'; did you mean pos_high"
    ):
        formats.read(path)
    crane = formats.read(path, leave_out_unknown=True)
    assert len(crane.rules) == 5
    assert crane.notes[-1].endswith(
        "the rule is left out: if distance is far and angle is neg_small then power is pos_big"
    )
    assert crane.outputs[0].defuzzifier == "weighted_average"
    assert crane.outputs[0].term("neg_high") == Term("neg_high", "constant", (-27.0,))
    assert crane.inputs[0].term("too_far") == Term("too_far", "ramp", (0.0, -5.0))


def same(system: System) -> System:
    """Without what formats name differently: the name of a block, a norm that no rule uses, the rule of a sum."""
    blocks = [dataclasses.replace(b, name="", disjunction=None) for b in system.blocks]
    outputs = [dataclasses.replace(o, integration="midpoint") for o in system.outputs]
    return dataclasses.replace(system, blocks=tuple(blocks), outputs=tuple(outputs))


@pytest.mark.parametrize(
    "files", [("mamdani49.fis", "mamdani49.fll", "mamdani49.fcl"), ("sugeno49.fis", "sugeno49.fll")]
)
def test_one_system_in_several_formats_is_one_system(files):
    systems = [formats.read(shared(f"prototypes/fuzzy/{name}")) for name in files]
    assert len(systems[0].rules) == 49
    for other in systems[1:]:
        assert same(other) == same(systems[0])


def test_a_file_with_another_suffix_is_known_by_its_beginning(tmp_path):
    for format in formats.WRITTEN:
        path = tmp_path / f"{format}.txt"
        path.write_text(formats.dumps(SMALL, format))
        assert formats.read(path).name == "small"
    (tmp_path / "no.txt").write_text("hello\n")
    with pytest.raises(
        DataError, match=r"no.txt:1:1: expected a fuzzy system in one of the formats fis, fll, fcl, fml"
    ):
        formats.read(tmp_path / "no.txt")


def test_a_latin_1_file_is_read_and_said_to_be_one(tmp_path):
    path = tmp_path / "latin.fis"
    path.write_bytes(fis.dumps(dataclasses.replace(SMALL, name="Größe")).encode("latin-1"))
    found = formats.read(path)
    assert found.name == "Größe"
    assert found.notes[0] == "the file is not UTF-8: read as Latin-1"


@pytest.mark.parametrize(
    ("declared", "written"),
    [
        ("windows-1251", "cp1251"),
        ("ISO-8859-15", "iso8859-15"),
        ("UTF-16", "utf-16"),
        ("UTF-8", "utf-8-sig"),
        ("", "utf-8"),
    ],
)
def test_names_of_an_xml_file_are_read_in_the_encoding_that_it_declares(tmp_path, declared, written):
    name = "Шаг" if "1251" in declared else "Größe €"
    first = f'<?xml version="1.0" encoding="{declared}"?>\n' if declared else ""
    (tmp_path / "a.xml").write_bytes((first + FML.replace('name="s"', f'name="{name}"', 1)).encode(written))
    found = formats.read(tmp_path / "a.xml")
    # The XML parser of Python is the independent reader.
    assert found.name == name == ElementTree.parse(tmp_path / "a.xml").getroot().get("name")
    assert not any("Latin-1" in note for note in found.notes)


def test_upper_case_comments_weights_not_or_and_several_blocks_of_fcl():
    system = fcl.loads("""
        (* IEC comment *) FUNCTION_BLOCK two /* C comment */
        VAR_INPUT X : REAL (0.0 .. 10.0); Z : REAL; RANGE := (-1 .. 1); END_VAR // one more
        VAR_OUTPUT Y : REAL; END_VAR
        FUZZIFY X TERM low := trian 0 1 2; TERM high := GBELL 2 3 5; TERM c := COSINE 2 5; END_FUZZIFY
        FUZZIFY Z TERM low := sigm -3 0.5; TERM high := gauss 1 0.2; END_FUZZIFY
        RULEBLOCK one AND : PROD; ACCU : BSUM; ACT : PROD;
            RULE 1 : IF NOT X IS low OR (z IS NOT HIGH AND X IS c) THEN Y IS a, Y IS b WITH 0.5;
        END_RULEBLOCK
        RULEBLOCK ENABLED : FALSE; RULE first : IF X IS low THEN Y IS a END_RULEBLOCK
        DEFUZZIFY Y TERM a := (0, 0) (1, 1) (2, 0); TERM b := (1, 0.2) (2, 0.8); METHOD : COG; RANGE := (0 .. 2);
            DEFAULT := NC; END_DEFUZZIFY
        END_FUNCTION_BLOCK""")
    x, z = system.inputs
    (y,) = system.outputs
    assert (x.low, x.high, z.low, z.high) == (0.0, 10.0, -1.0, 1.0)
    assert x.terms == (
        Term("low", "triangle", (0.0, 1.0, 2.0)),
        Term("high", "bell", (5.0, 2.0, 3.0)),
        Term("c", "cosine", (5.0, 4.0)),
    )
    assert z.terms == (Term("low", "sigmoid", (0.5, -3.0)), Term("high", "gaussian", (1.0, 0.2)))
    assert (y.aggregation, y.lock_previous, y.default) == ("bounded_sum", True, pytest.approx(math.nan, nan_ok=True))
    assert y.terms[1] == Term("b", "discrete", (1.0, 0.2, 2.0, 0.8))
    one, two = system.blocks
    assert (one.name, one.conjunction, one.disjunction, one.implication) == (
        "one",
        "algebraic_product",
        "algebraic_sum",
        "algebraic_product",
    )
    either = Or(Is("X", "low", ("not",)), And(Is("Z", "high", ("not",)), Is("X", "c")))
    assert one.rules == (Rule(either, (Is("Y", "a"), Is("Y", "b")), 0.5),)
    assert (two.name, two.enabled, two.implication) == ("", False, "minimum")
    assert system.notes == (
        "rule block one has no OR: algebraic_sum, which De Morgan's law pairs with its AND",
        "rule block has no ACT: MIN",
    )


def test_a_takagi_sugeno_output_of_fcl_and_a_universe_from_its_terms():
    system = fcl.loads("""FUNCTION_BLOCK
        VAR_INPUT x : REAL; END_VAR VAR_OUTPUT y : REAL; END_VAR
        FUZZIFY x TERM a := (1, 0) (3, 1); TERM s := 2; TERM t := SINGLETONS (2.5, 0.5); END_FUZZIFY
        DEFUZZIFY y TERM a := Linear 2 1; TERM b := -3; END_DEFUZZIFY
        END_FUNCTION_BLOCK""")
    assert system.inputs[0].terms[1:] == (Term("s", "singleton", (2.0,)), Term("t", "singleton", (2.5,), 0.5))
    assert (system.inputs[0].low, system.inputs[0].high) == (1.0, 3.0)
    assert (system.outputs[0].low, system.outputs[0].high) == (-3.0, 7.0)
    assert system.outputs[0].terms == (Term("a", "linear", (2.0, 1.0)), Term("b", "constant", (-3.0,)))
    assert system.notes == (
        "x has no RANGE: 1 to 3, from its terms",
        "y has no METHOD: COGS",
        "y has no RANGE: -3 to 7, from its terms",
    )


def test_what_fuzzylite_does_with_a_fll_file_is_done():
    system = fll.loads("""# by hand
Engine: two words # and a comment
InputVariable: in one
  range: 0 1
  term: a Linear 1
  term: d Discrete 0 0 1 1 0.5
OutputVariable: y
  accumulation: Maximum
  defuzzifier: Centroid
  term: a Triangle -inf 0 1 0.5
RuleBlock:
  activation: Minimum
  rule: if inone is any then y is a
RuleBlock: late
  activation: First
""")
    assert system.name == "two words"
    assert system.inputs[0].terms == (
        Term("a", "linear", (1.0, 0.0)),
        Term("d", "discrete", (0.0, 0.0, 1.0, 1.0), 0.5),
    )
    assert system.outputs[0].terms == (Term("a", "triangle", (-math.inf, 0.0, 1.0), 0.5),)
    assert (system.outputs[0].aggregation, system.outputs[0].resolution) == ("maximum", 100)
    assert (system.blocks[0].implication, system.blocks[0].activation) == ("minimum", "general")
    assert system.blocks[1].activation_parameters == ("1", "0.0")
    assert system.notes == (
        "line 3: 'in one' is called inone, as in fuzzylite",
        "line 5: the numbers that a does not have are 0, as in fuzzylite",
        "output y: no resolution: 100 as in fuzzylite 6 (pyfuzzylite 8 takes 1000)",
        "line 12: activation Minimum (fuzzylite 5) is taken as the implication",
    )


FIS = fis.dumps(SMALL).partition("\n")[2]


def test_what_stands_in_a_fis_file_is_read():
    text = FIS.replace(
        "NumMFs=2\nMF1='a':'trimf',[0.0 0.0 1.0]", "NumMFs=2\nMF1 = 'it''s' : 'linzmf' , [0, 0.5] % edge", 1
    )
    text = text.replace("MF2='b':'trimf',[0.0 1.0 1.0]\n\n", "MF2='it''s':'dsigmf',[8 0.2 9 0.7]\n\n", 1)
    text = text.replace("1, 2 (1) : 1", "  -2.20 , 2 (.5) : 2  # very").replace("NumRules=1", "NumRules=2")
    system = fis.loads(text + "1, 0 (1) : 1\n")
    assert system.inputs[0].terms == (
        Term("it''s", "ramp", (0.5, 0.0)),
        Term("it''s_", "sigmoid_difference", (0.2, 8.0, 9.0, 0.7)),
    )
    assert system.rules == (Rule(Is("x", "it''s_", ("not", "very")), (Is("y", "b"),), 0.5),)
    assert system.notes == (
        "variable x: a second term \"it''s\" is called it''s_",
        "line 30: a rule that concludes nothing is left out",
    )


def test_aggregation_of_takagi_sugeno_is_said_not_to_count_in_fis():
    system = fis.dumps(dataclasses.replace(SMALL, outputs=(SUGENO,), blocks=(RuleBlock((), implication=None),)))
    assert fis.loads(system).notes == ()
    old = fis.loads(system.replace("AggMethod='sum'", "AggMethod='max'"))
    assert old.outputs[0].aggregation is None
    assert old.notes == ("AggMethod is not used with wtaver and wtsum (as in MATLAB; Octave uses it)",)


MARKUP = """<?xml version="1.0"?>
<fuzzySystem xmlns="http://www.ieee1855.org" name="m">
 <knowledgeBase>
  <fuzzyVariable name="x" domainleft="0" domainright="2" scale="mm">
   <fuzzyTerm name="a" complement="true"><triangularShape param1="0" param2="1" param3="2"/></fuzzyTerm>
   <fuzzyTerm name="b"><pointSetShape><point x="0" y="0"/><point x="2" y="1"/></pointSetShape></fuzzyTerm>
  </fuzzyVariable>
  <tskVariable name="y" type="output" combination="WA">
   <tskTerm name="c" order="1"><tskValue>5</tskValue><tskValue>-1</tskValue></tskTerm>
   <tskTerm name="d" order="0"><tskValue>7</tskValue></tskTerm>
  </tskVariable>
 </knowledgeBase>
 <tskRuleBase name="r" andMethod="MIN">
  <tskRule name="1" connector="and" andMethod="PROD" weight="0.5">
   <antecedent>
    <clause modifier="very"><variable>x</variable><term>a</term></clause>
    <clause><variable>x</variable><term>b</term></clause>
   </antecedent>
   <tskConsequent><tskThen><tskClause><variable>y</variable><term>c</term></tskClause></tskThen></tskConsequent>
  </tskRule>
  <tskRule name="2">
   <antecedent><clause><variable>x</variable><term>b</term></clause></antecedent>
   <tskConsequent><tskThen><tskClause><variable>y</variable><term>d</term></tskClause></tskThen></tskConsequent>
  </tskRule>
 </tskRuleBase>
</fuzzySystem>
"""


def test_complements_constants_and_norms_of_single_rules_of_markup():
    system = fml.loads(MARKUP)
    assert system.inputs[0].unit == "mm"
    assert system.outputs[0].terms == (Term("c", "linear", (-1.0, 5.0)), Term("d", "constant", (7.0,)))
    assert (system.outputs[0].low, system.outputs[0].high) == (3.0, 7.0)
    assert system.rules[0] == Rule(And(Is("x", "a", ("very", "not")), Is("x", "b")), (Is("y", "c"),), 0.5)
    assert [b.conjunction for b in system.blocks] == ["algebraic_product", "minimum"]
    assert system.notes == (
        "x, term a is a complement: its rules say 'not a'",
        "term c: its first number is the constant, the others belong to the inputs in order",
        "y has no domain: 3 to 7, from its terms",
        "rule base r: its rules differ in their norms: 2 blocks",
    )
