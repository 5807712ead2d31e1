"""Broken files are refused with file, line, column and what was expected."""

from xml.sax.saxutils import escape

import pytest

from leadscrew.fuzzy import formats
from leadscrew.fuzzy.block import function
from leadscrew.util.errors import DataError

FIS = """[System]
Name='s'
Type='mamdani'
NumInputs=1
NumOutputs=1
NumRules=1
AndMethod='min'
OrMethod='max'
ImpMethod='min'
AggMethod='max'
DefuzzMethod='centroid'

[Input1]
Name='x'
Range=[0 1]
NumMFs=2
MF1='a':'trimf',[0 0 1]
MF2='b':'trimf',[0 1 1]

[Output1]
Name='y'
Range=[0 1]
NumMFs=1
MF1='c':'trimf',[0 0.5 1]

[Rules]
1, 1 (1) : 1
"""
FLL = """Engine: s
InputVariable: x
  enabled: true
  range: 0.0 1.0
  term: a Triangle 0.0 0.0 1.0
  term: b Linear 1.0 2.0
OutputVariable: y
  range: 0.0 1.0
  aggregation: Maximum
  defuzzifier: Centroid 100
  default: nan
  term: c Triangle 0.0 0.5 1.0
RuleBlock: r
  conjunction: Minimum
  activation: Threshold > 0.5
  rule: if x is a then y is c with 0.5
"""
FCL = """FUNCTION_BLOCK s
VAR_INPUT
  x: REAL;
END_VAR
VAR_OUTPUT
  y: REAL;
END_VAR
FUZZIFY x
  RANGE := (0 .. 1);
  TERM a := (0, 0) (1, 1);
END_FUZZIFY
DEFUZZIFY y
  TERM c := Triangle 0 0.5 1;
  METHOD : COG;
  ACCU : MAX;
  DEFAULT := nan;
END_DEFUZZIFY
RULEBLOCK r
  AND : MIN;
  RULE 1 : IF x IS a THEN y IS c;
END_RULEBLOCK
END_FUNCTION_BLOCK
"""
FML = """<fuzzySystem name="s">
<knowledgeBase>
<fuzzyVariable name="x" domainleft="0" domainright="1" type="input">
<fuzzyTerm name="a"><triangularShape param1="0" param2="0" param3="1"/></fuzzyTerm>
</fuzzyVariable>
<fuzzyVariable name="y" domainleft="0" domainright="1" type="output" defuzzifier="COG">
<fuzzyTerm name="c"><triangularShape param1="0" param2="0" param3="1"/></fuzzyTerm>
</fuzzyVariable>
</knowledgeBase>
<mamdaniRuleBase name="r" andMethod="MIN">
<rule name="1" connector="and" weight="1.0">
<antecedent><clause><variable>x</variable><term>a</term></clause></antecedent>
<consequent><then><clause><variable>y</variable><term>c</term></clause></then></consequent>
</rule>
</mamdaniRuleBase>
</fuzzySystem>
"""
WHOLE = {"fis": FIS, "fll": FLL, "fcl": FCL, "fml": FML}

CASES = [
    ("fis", FIS, "", "1:1: expected a section [System]"),
    ("fis", "[System]", "[Sistem]", "1:1: expected [System], [Input1], [Output1] or [Rules], found '[Sistem]'"),
    ("fis", "[System]", "[System", "1:8: expected ']' after the name of a section"),
    ("fis", "[System]", "Name='t'\n[System]", "1:1: expected a section such as [System]"),
    ("fis", "Name='s'", "Name=s", "2:6: expected Name='...', found 's'"),
    ("fis", "Name='s'", "  hello", "2:3: expected NAME=VALUE, found 'hello'"),
    ("fis", "Name='s'", "Name='s'\nName='s'", "3:1: a second Name= in [System]"),
    ("fis", "NumInputs=1", "NumInputs=2", "4:11: expected NumInputs=1, the number there is, found '2'"),
    ("fis", "NumRules=1", "NumRules=49", "6:10: expected NumRules=1"),
    ("fis", "AndMethod='min'", "AndMethod='mn'", "7:11: expected a AndMethod; did you mean min?, found 'mn'"),
    ("fis", "[Input1]", "[Input2]", "13:1: expected [Input1], found [Input2]"),
    ("fis", "Name='x'", "Name=''", "14:6: expected a name of [Input1]"),
    ("fis", "Range=[0 1]", "Range=[1 0]", "15:7: variable x: universe [1.0, 0.0]"),
    ("fis", "Range=[0 1]", "Range=[0 one]", "15:10: expected a number, found 'one'"),
    ("fis", "Range=[0 1]", "Range=[0 1 2]", "15:7: expected Range=[LOW HIGH]"),
    ("fis", "Range=[0 1]\n", "", "13:1: expected Range= in [Input1]"),
    ("fis", "NumMFs=2", "NumMFs=3", "16:8: expected NumMFs=2"),
    ("fis", "'trimf',[0 0 1]", "'trimf',[0 0]", "17:18: expected 3 numbers for trimf, found 2"),
    ("fis", "'trimf',[0 0 1]", "'trimff',[0 0 1]", "17:10: expected a membership function; did you mean trimf"),
    ("fis", "'trimf',[0 0 1]", "'trimf',[0 0 1", "17:5: expected 'NAME':'KIND',[NUMBERS]"),
    ("fis", "'trimf',[0 0 1]", "'linear',[1]", "17:19: expected 2 numbers for linear (one for each input"),
    ("fis", "MF2='b'", "MF3='b'", "18:1: expected MF2=, found MF3="),
    ("fis", "Name='y'", "Name='x'", "21:6: a second variable 'x'"),
    ("fis", "1, 1 (1) : 1", "1 1 (1) : 1", "27:1: expected INPUTS, OUTPUTS (WEIGHT) : 1 or 2"),
    ("fis", "1, 1 (1) : 1", "1 2, 1 (1) : 1", "27:1: expected 1 numbers, one for each input, found 2"),
    ("fis", "1, 1 (1) : 1", "3, 1 (1) : 1", "27:1: expected a term of x (1 to 2), found 3"),
    ("fis", "1, 1 (1) : 1", "1.25, 1 (1) : 1", "27:1: expected a hedge (.05, .20, .30, .40 or .99), found 1.25"),
    ("fis", "1, 1 (1) : 1", "0, 1 (1) : 1", "27:1: expected a term of some input: all are 0"),
    ("fis", "1, 1 (1) : 1", "1, 1 (2) : 1", "27:7: expected a weight from 0 to 1, found '2'"),
    ("fis", "1, 1 (1) : 1", "1, 1 (1) : 3", "27:12: expected 1 (and) or 2 (or), found '3'"),
    ("fll", FLL, "", "1:1: expected Engine:"),
    ("fll", "Engine: s", "  hello", "1:3: expected 'key: value', found 'hello'"),
    ("fll", "Engine: s", "enabled: true", "1:1: expected Engine:, found 'enabled: true'"),
    ("fll", "InputVariable: x", "Engine: t", "2:1: expected Engine: once, on top"),
    ("fll", "InputVariable: x", "InputVariable: ?", "2:16: expected a name, found '?'"),
    ("fll", "OutputVariable: y", "OutputVariable: x", "7:17: a second variable 'x'"),
    ("fll", "  enabled: true", "  enabbled: true", "3:3: expected a key of InputVariable; did you mean enabled?"),
    ("fll", "  enabled: true", "  enabled: yes", "3:12: expected enabled: true or false, found 'yes'"),
    ("fll", "  enabled: true", "  enabled: true\n  enabled: true", "4:3: a second enabled:"),
    ("fll", "range: 0.0 1.0", "range: 0.0", "4:10: expected range: LOW HIGH, found '0.0'"),
    ("fll", "range: 0.0 1.0", "range: 1.0 0.0", "4:10: variable x: universe [1.0, 0.0]"),
    ("fll", "range: 0.0 1.0", "range: 0.0 nan", "4:10: variable x: universe [0.0, nan]"),
    ("fll", "a Triangle 0.0 0.0 1.0", "a", "5:9: expected term: NAME CLASS NUMBERS, found 'a'"),
    ("fll", "a Triangle 0.0 0.0 1.0", "a Triangel 0.0 0.0 1.0", "5:11: term a: there is no 'Triangel'; did you mean"),
    ("fll", "a Triangle 0.0 0.0 1.0", "a Triangle 0.0 1.0", "5:11: term a: a triangle takes 3 numbers (a, b, c)"),
    ("fll", "a Triangle 0.0 0.0 1.0", "a Triangle 0.0 0,0 1.0", "5:24: expected a number, found '0,0'"),
    ("fll", "a Triangle 0.0 0.0 1.0", "a Discrete 1 0 0 1", "5:11: term a: a discrete set takes x and y in turn"),
    ("fll", "a Triangle 0.0 0.0 1.0", "a Function x^2", "5:11: term a: a Function is a formula"),
    ("fll", "a Triangle 0.0 0.0 1.0", "b Triangle 0.0 0.0 1.0", "4:10: variable x: two terms are called 'b'"),
    ("fll", "b Linear 1.0 2.0", "b Linear 1.0 2.0 3.0", "6:17: expected at most 2 numbers (one for each"),
    ("fll", "Maximum", "Maximun", "9:16: expected a norm for aggregation; did you mean Maximum"),
    ("fll", "Maximum", "Minimum", "9:16: expected a norm for aggregation"),
    ("fll", "Centroid 100", "Centroid many", "10:16: expected Centroid and a whole number of cells"),
    ("fll", "Centroid 100", "Centroid 0", "10:16: output y: resolution = 0: allowed are 1 to 100000"),
    ("fll", "Centroid 100", "none", "10:16: expected a defuzzifier"),
    ("fll", "Centroid 100", "WeightedSum TakagiSugeno", "10:16: expected TakagiSugeno with terms that are Constant"),
    ("fll", "Centroid 100", "WeightedSum Tsukamoto", "10:16: expected Tsukamoto with terms that rise or fall only"),
    ("fll", "Centroid 100\n", "WeightedSum Tsukamoto\n  term: d Ramp 0.0 1.0\n", "10:16: expected Tsukamoto with"),
    ("fll", "Centroid 100\n", "WeightedSum TakagiSugeno\n  term: d Constant 1\n", "10:16: expected TakagiSugeno with"),
    ("fll", "default: nan", "default: none", "11:12: expected default: NUMBER, found 'none'"),
    ("fll", "Threshold > 0.5", "Threshold 0.5", "15:15: expected Threshold >= 0.0 (or other numbers)"),
    ("fll", "y is c", "y is d", "16:29: y has no term 'd'; known: c"),
    ("fll", "x is a", "(x is a", "16:20: expected ')', found 'then'"),
    ("fcl", FCL, "", "1:1: expected 'function_block', found the end"),
    ("fcl", "END_FUNCTION_BLOCK", "", "23:1: expected 'var_input'"),
    ("fcl", "END_RULEBLOCK\n", "", "22:1: expected 'end_ruleblock', found the end"),
    ("fcl", "FUNCTION_BLOCK s", "(* FUNCTION_BLOCK s", "1:1: expected *) to close the comment"),
    ("fcl", "x: REAL;", "x REAL;", "3:5: expected ':', found 'REAL'"),
    ("fcl", "x: REAL;", "x: REAL;\n  x: REAL;", "4:3: a second variable 'x'"),
    ("fcl", "FUZZIFY x", "FUZZIFY z", "8:9: expected a variable of VAR_INPUT; known: x, found 'z'"),
    ("fcl", "(0 .. 1)", "(1 .. 0)", "9:12: expected a range whose low end is below its high, found 1.0 .. 0.0"),
    ("fcl", "(0 .. 1)", "(0 , 1)", "9:15: expected '..', found ','"),
    ("fcl", "(0, 0) (1, 1);", "(0, 0) (1, 1)", "11:1: expected '(' or ';', found 'END_FUZZIFY'"),
    ("fcl", "(0, 0) (1, 1);", "(0, 0) (v, 1);", "10:21: expected a number, found 'v'"),
    ("fcl", "(0, 0) (1, 1);", "(0, 0);", "10:13: term a: a discrete set takes x and y in turn"),
    ("fcl", "(0, 0) (1, 1);", "FUNCTION x * 2;", "10:13: a FUNCTION is a formula"),
    ("fcl", "Triangle 0 0.5 1", "Triangel 0 0.5 1", "13:13: expected a shape; did you mean Triangle"),
    ("fcl", "Triangle 0 0.5 1", "trian 0 0.5", "13:13: expected 3 numbers, found 2"),
    ("fcl", "Triangle 0 0.5 1", "SINGLETONS (0, 1) (1, 1)", "13:13: expected one point: more singletons than one"),
    ("fcl", "COG;", "COX;", "14:12: expected a METHOD; did you mean"),
    ("fcl", "MAX;", "MIN;", "15:10: expected an ACCU"),
    ("fcl", "DEFAULT := nan;", "DEFAULT := x;", "16:14: expected a number, found 'x'"),
    ("fcl", "  AND : MIN;", "  AND : MAX;", "19:9: expected a norm for AND"),
    ("fcl", "x IS a", "x IS b", "20:20: x has no term 'b'; known: a"),
    ("fcl", "IF x IS a", "IF NOT (x IS a OR x IS a)", "20:15: 'not' stands before one proposition only"),
    ("fcl", "y IS c;", "y IS c WITH 2;", "20:39: expected a weight from 0 to 1, found '2'"),
    ("fcl", "END_FUNCTION_BLOCK", "END_FUNCTION_BLOCK FUNCTION_BLOCK", "22:20: expected the end, after one"),
    ("fml", FML, "", "1:1: expected XML: no element found"),
    ("fml", "</fuzzySystem>", "", "17:1: expected XML: no element found"),
    ("fml", "</rule>", "</role>", "14:3: expected XML: mismatched tag"),
    ("fml", "<fuzzySystem", "<!DOCTYPE a [<!ENTITY b 'c'>]><fuzzySystem", "1:13: expected XML without a document type"),
    ("fml", "domainleft=\"0\" ", "", "3:1: expected the attribute domainleft of <fuzzyVariable>"),
    ("fml", "domainleft=\"0\" ", "domainleft=\"zero\" ", "3:1: expected a number as domainleft, found 'zero'"),
    ("fml", "domainright=\"1\" ", "domainright=\"0\" ", "3:1: variable x: universe [0.0, 0.0]"),
    ("fml", "name=\"y\"", "name=\"x\"", "6:1: a second variable 'x'"),
    ("fml", "triangularShape param1", "customShape param1", "4:1: expected one shape such as <triangularShape>"),
    ("fml", "param3=\"1\"/>", "/>", "4:21: expected the attribute param3 of <triangularShape>"),
    ("fml", "defuzzifier=\"COG\"", "defuzzifier=\"custom_1\"", "6:1: expected defuzzifier; known: COG, COA, LM"),
    ("fml", "mamdaniRuleBase", "anYaRuleBase", "10:1: expected a rule base of Mamdani, TSK or Tsukamoto"),
    ("fml", "weight=\"1.0\"", "weight=\"1.5\"", "11:1: a rule's weight = 1.5: allowed is 0 to 1"),
    ("fml", "<clause><variable>x", "<clause modifier='slightly'><variable>x", "12:13: expected a modifier"),
    ("fml", "<term>a</term>", "<term>b</term>", "11:1: x has no term 'b'"),
    ("fml", "</then>", "</then><else/>", "13:79: an ELSE part has no counterpart here"),
]  # fmt: skip


@pytest.mark.parametrize(("format", "old", "new", "said"), CASES, ids=[f"{c[0]}: {c[3]}" for c in CASES])
def test_a_broken_file_is_refused_with_its_place(format, old, new, said):
    text = WHOLE[format]
    count = -1 if format == "fml" and "RuleBase" in old else 1
    assert old in text
    with pytest.raises(DataError) as error:
        formats.loads(text.replace(old, new, count), format, "FILE")
    assert str(error.value).startswith(f"FILE:{said}")


@pytest.mark.parametrize("format", WHOLE)
def test_the_files_that_were_broken_are_whole(format):
    assert len(formats.loads(WHOLE[format], format).rules) == 1


@pytest.mark.parametrize("encoding", ["ISO-8859-1", "foo"])
def test_a_text_is_read_whatever_encoding_it_declares(encoding):
    text = f'<?xml version="1.0" encoding="{encoding}"?>\n' + FML.replace('name="s"', 'name="größe"', 1)
    assert formats.loads(text, "fml").name == "größe"


RAN = 'raise SystemExit("a name of the file ran as Python")\ndef rest(p, x):\n    '
CODE = (f'z"""\n    return 0.0\n{RAN}"""', f"z\n    pass\n{RAN}0", 'z""" + exit() + """', "z\\", "z\u2028exit()")


@pytest.mark.parametrize("code", CODE, ids=range(len(CODE)))
@pytest.mark.parametrize("name", ["s", "x", "y", "a", "c"])
def test_a_name_in_a_file_never_becomes_code(name, code):
    written = escape(code, {'"': "&quot;", "\n": "&#10;"})
    text = FML.replace(f'name="{name}"', f'name="{written}"').replace(f">{name}<", f">{written}<")
    assert written in text
    here, plain = (function(formats.loads(t, "fml")) for t in (text, FML))
    assert here(0.25) == plain(0.25)
