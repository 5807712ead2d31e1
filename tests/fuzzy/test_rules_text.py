"""Rules as people write them."""

import pytest

from leadscrew.fuzzy.rules_text import Names, parse, rule_text, table
from leadscrew.fuzzy.system import And, Input, Is, Or, Output, Rule, System, Term
from leadscrew.util.errors import DataError

CHEAP = (Is("tip", "cheap"),)
LEVELS = tuple(Term(name, "triangle", (k - 1.0, k, k + 1.0)) for k, name in enumerate(("low", "mid", "high")))
GAINS = System(
    "gains",
    (Input("e", -1.0, 1.0, LEVELS), Input("de", -1.0, 1.0, LEVELS)),
    (Output("u", -1.0, 1.0, LEVELS),),
    (),
)


def test_and_binds_closer_than_or():
    a, b, c = Is("a", "x"), Is("b", "x"), Is("c", "x")
    assert parse("if a is x or b is x and c is x then tip is cheap").antecedent == Or(a, And(b, c))
    assert parse("if (a is x or b is x) and c is x then tip is cheap").antecedent == And(Or(a, b), c)
    assert parse("if a is x and b is x or c is x then tip is cheap").antecedent == Or(And(a, b), c)


def test_connectives_of_one_kind_go_from_left_to_right():
    a, b, c = Is("a", "x"), Is("b", "x"), Is("c", "x")
    assert parse("if a is x and b is x and c is x then tip is cheap").antecedent == And(And(a, b), c)
    right = Rule(And(a, And(b, c)), CHEAP)
    assert rule_text(right) == "if a is x and (b is x and c is x) then tip is cheap"
    assert parse(rule_text(right)) == right


def test_the_rule_of_the_docs():
    rule = parse("if service is poor or (food is very rancid and x is not any) then tip is cheap and y is z with 0.5")
    assert rule == Rule(
        Or(Is("service", "poor"), And(Is("food", "rancid", ("very",)), Is("x", "", ("not", "any")))),
        (Is("tip", "cheap"), Is("y", "z")),
        0.5,
    )
    assert parse(rule_text(rule)) == rule


@pytest.mark.parametrize(
    "text",
    [
        "IF e IS NOT low THEN u IS high WITH 0.25;",
        "If NOT e is low Then u is high With .25",
        "if not (e is low) then u is high with 2.5e-1",
        'if "e" is not \'low\' then "u" is "high" with 0.25',
    ],
)
def test_keywords_in_any_case_and_not_before_or_after(text):
    assert parse(text, GAINS) == Rule(Is("e", "low", ("not",)), (Is("u", "high"),), 0.25)


def test_names_that_are_no_words_stand_in_quotes():
    rule = Rule(Is("cutting force", "not", ("very",)), (Is('5" tool', "(a)"),))
    assert rule_text(rule) == 'if "cutting force" is very "not" then "5"" tool" is "(a)"'
    assert parse(rule_text(rule)) == rule


def test_consequents_with_commas_as_jfuzzylogic_writes_them():
    assert parse("if a is x then b is y, c is z").consequents == (Is("b", "y"), Is("c", "z"))


@pytest.mark.parametrize(
    ("text", "where", "sentence"),
    [
        ("e is low then u is high", "1:1", "expected 'if', found 'e'"),
        ("if e low then u is high", "1:6", "expected 'is', found 'low'"),
        ("if e is then u is high", "1:9", "expected a term, found 'then'"),
        ("if e is very then u is high", "1:14", "expected a term, found 'then'"),
        ("if e is low u is high", "1:13", "expected 'then', found 'u'"),
        ("if (e is low then u is high", "1:14", "expected ')', found 'then'"),
        ("if e is low) then u is high", "1:12", "expected 'then', found ')'"),
        ("if e is low and then u is high", "1:17", "expected a variable, found 'then'"),
        ("if e is low then", "1:17", "expected an output, found the end"),
        ("if e is low then u is any", "1:26", "expected a term, found the end"),
        ("if e is low then u is high or u is low", "1:28", "expected 'and', 'with' or the end of the rule, found 'or'"),
        ("if e is low then u is high with", "1:32", "expected a weight from 0 to 1, found the end"),
        ("if e is low then u is high with 1.5", "1:33", "expected a weight from 0 to 1, found '1.5'"),
        ("if e is low then u is high with 0_1", "1:33", "expected a weight from 0 to 1, found '0_1'"),
        ("if e is low\n  then u is 'high", "2:13", "expected the quote ' to be closed"),
        ("if not (e is low or de is low) then u is high", "1:4", "'not' stands before one proposition only"),
        ("if e is lov then u is high", "1:9", "e has no term 'lov'; did you mean low?"),
        ("if ee is low then u is high", "1:4", "there is no variable 'ee'; did you mean e"),
        ("if e is low then de is high", "1:18", "there is no output 'de'"),
        ("if " + "(" * 100 + "e is low", "1:65", "more than 60 parentheses inside each other"),
        ("if " + " and ".join(["e is low"] * 300) + " then u is high", "1:3254", "more than 250 propositions"),
    ],
)
def test_what_is_no_rule_is_refused_with_its_place(text, where, sentence):
    with pytest.raises(DataError) as error:
        parse(text, GAINS, where="rules")
    assert str(error.value).startswith(f"rules:{where}: {sentence}")


def test_a_name_in_other_letters_is_found_where_case_does_not_count():
    names = Names.of(GAINS.inputs, GAINS.outputs, any_case=True)
    assert parse("if E is LOW then U is High", names) == Rule(Is("e", "low"), (Is("u", "high"),))
    with pytest.raises(DataError, match="1:4: there is no variable 'E'"):
        parse("if E is LOW then U is High", GAINS)


def test_a_table_is_its_rules():
    text = """
        e\\de  low   mid   high
        low   low   low   mid
        mid   low   -     high
        high  mid   high  high
    """
    rules = table(text, "e", "de", "u", GAINS)
    assert len(rules) == 8
    assert rules[1] == parse("if e is low and de is mid then u is low")
    assert rules[3] == parse("if e is mid and de is low then u is low")
    assert table(text.replace("e\\de", "    "), "e", "de", "u") == rules


@pytest.mark.parametrize(
    ("text", "where", "sentence"),
    [
        ("low mid", "1:1", "expected a line of terms of de and one line for each term of e"),
        ("low mid\nlow low low\nmid low", "3:5", "expected 2 cells after 'mid', found 1"),
        ("low mid\nlow low low\nmid low low low", "3:13", "expected 2 cells after 'mid', found 3"),
        ("low low\nlow low low", "1:5", "'low' is repeated"),
        ("low mid\nlow low low\nlow mid mid", "3:1", "'low' is repeated"),
        ("low mid\nlow low lov", "2:9", "u has no term 'lov'; did you mean low?"),
        ("low mit\nlow low low", "1:5", "de has no term 'mit'; did you mean mid?"),
    ],
)
def test_a_broken_table_is_refused_with_its_place(text, where, sentence):
    with pytest.raises(DataError) as error:
        table(text, "e", "de", "u", GAINS, where="gains.txt")
    assert str(error.value) == f"gains.txt:{where}: {sentence}"
