"""Reads IEEE 1855 fuzzy markup language, ``.xml`` or ``.fml``.

Programs do not agree on what is left and right. With the standard's name space (as JFML writes it) a right linear or
right gaussian set is one at the right; in files without it (the older FML) the word names the flank, so a right linear
set falls. ``right_rises`` decides where that guess is wrong; what was taken stands in the notes of the system.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NoReturn
from xml.parsers import expat

from leadscrew.fuzzy.formats.extent import extent, hull
from leadscrew.fuzzy.formats.place import Source
from leadscrew.fuzzy.rules_text import Names, read_number
from leadscrew.fuzzy.system import (
    HEDGES,
    And,
    Antecedent,
    Input,
    Is,
    Or,
    Output,
    Rule,
    RuleBlock,
    System,
    Term,
    Variable,
)
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import ValueRefused

SHAPES = {
    "rightlinearshape": 2,
    "leftlinearshape": 2,
    "pishape": 2,
    "triangularshape": 3,
    "gaussianshape": 2,
    "rightgaussianshape": 2,
    "leftgaussianshape": 2,
    "trapezoidshape": 4,
    "trapezoidalshape": 4,
    "singletonshape": 1,
    "rectangularshape": 2,
    "zshape": 2,
    "sshape": 2,
    "pointsetshape": 0,
    "pointsetmonotonicshape": 0,
}
"""Names of elements in small letters, and how many parameters each has."""
_SAME = {
    "triangularshape": "triangle",
    "gaussianshape": "gaussian",
    "trapezoidshape": "trapezoid",
    "trapezoidalshape": "trapezoid",
    "singletonshape": "singleton",
    "rectangularshape": "rectangle",
    "zshape": "z_shape",
    "sshape": "s_shape",
    "pointsetshape": "discrete",
    "pointsetmonotonicshape": "discrete",
}


def term_of(name: str, key: str, numbers: list[float], right_rises: bool) -> tuple[Term, str]:
    """A term, and a sentence where programs do not agree on what is meant.

    Raises:
        ValueRefused: the numbers do not fit; or it is a piShape of the older FML.
    """
    if key in _SAME:
        return Term(name, _SAME[key], tuple(numbers)), ""
    a, b = numbers
    if key == "pishape":
        if not right_rises:
            raise ValueRefused(f"term {name}: programs do not agree on what the two numbers of a piShape are")
        return (
            Term(name, "pi_shape", (a, b, b, b + abs(b - a))),
            "a piShape rises from its first number to its second and falls as it rose (as JFML does it)",
        )
    rises = key.startswith("right") == right_rises
    note = (
        "left and right: a right set is one at the right (IEEE 1855 as JFML does it)"
        if right_rises
        else "left and right name the flank: a right set falls (FML before the standard)"
    )
    if key.endswith("linearshape"):
        return Term(name, "ramp", (a, b) if rises else (b, a)), note
    ends = (a, b, math.inf, b) if rises else (-math.inf, b, a, b)
    return Term(name, "gaussian_product", ends), note


DEEPEST = 50
STANDARD = "http://www.ieee1855.org"


@dataclass(eq=False)
class Element:
    """An element: its name as written, its attributes by their names in small letters, its text and its children."""

    tag: str
    line: int
    column: int
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)
    text: str = ""

    @property
    def key(self) -> str:
        """The name in small letters."""
        return self.tag.casefold()


def tree(source: Source) -> tuple[Element, bool]:
    """The root of an XML text, and whether it is in the standard's name space.

    Raises:
        DataError: it is no XML, is nested too deep, or has a document type (whose entities could grow without end).
    """
    parser = expat.ParserCreate("utf-8", " ")  # as the text is encoded below, whatever it declares
    parser.buffer_text = True
    top = Element("", 1, 1, {})
    path = [top]
    spaces: set[str] = set()

    def place() -> tuple[int, int]:
        return parser.CurrentLineNumber, parser.CurrentColumnNumber + 1

    def refuse(*_: object) -> NoReturn:
        source.fail(*place(), "expected XML without a document type")

    def start(tag: str, attributes: dict[str, str]) -> None:
        if len(path) > DEEPEST:
            source.fail(*place(), f"more than {DEEPEST} elements inside each other")
        space, _, name = tag.rpartition(" ")
        spaces.add(space)
        element = Element(name, *place(), {key.rpartition(" ")[2].casefold(): v for key, v in attributes.items()})
        path[-1].children.append(element)
        path.append(element)

    def end(_: str) -> None:
        path.pop()

    def text(data: str) -> None:
        path[-1].text += data

    parser.StartElementHandler, parser.EndElementHandler, parser.CharacterDataHandler = start, end, text
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(source.text.encode("utf-8", "replace"), True)
    except expat.ExpatError as error:
        source.fail(error.lineno, error.offset + 1, f"expected XML: {expat.ErrorString(error.code)}")
    return top.children[0], STANDARD in spaces


_T_NORMS = {
    "MIN": "minimum",
    "PROD": "algebraic_product",
    "BDIF": "bounded_difference",
    "BSUM": "bounded_difference",
    "DRP": "drastic_product",
    "DRS": "drastic_product",
    "EPROD": "einstein_product",
    "HPROD": "hamacher_product",
    "NILMIN": "nilpotent_minimum",
}
"""With BSUM and DRS, which the published schema has where it means BDIF and DRP."""
_S_NORMS = {
    "MAX": "maximum",
    "PROBOR": "algebraic_sum",
    "BSUM": "bounded_sum",
    "DRS": "drastic_sum",
    "ESUM": "einstein_sum",
    "HSUM": "hamacher_sum",
    "NILMAX": "nilpotent_maximum",
}
_DEFUZZIFIERS = {
    "COG": "centroid",
    "COA": "bisector",
    "LM": "smallest_of_maximum",
    "RM": "largest_of_maximum",
    "MOM": "mean_of_maximum",
}
_VARIABLES = {"fuzzyvariable": "fuzzyterm", "tskvariable": "tskterm", "tsukamotovariable": "tsukamototerm"}
_BASES = ("mamdanirulebase", "tskrulebase", "tsukamotorulebase", "rulebase")


@dataclass
class _Reading:
    source: Source
    right_rises: bool
    leave_out: bool
    notes: list[str] = field(default_factory=list)
    inputs: int = 0
    names: list[str] = field(default_factory=list)
    complements: set[tuple[str, str]] = field(default_factory=set)

    def fail(self, element: Element, sentence: str) -> NoReturn:
        self.source.fail(element.line, element.column, sentence)

    def attribute(self, element: Element, name: str, default: str | None = None) -> str:
        value = element.attributes.get(name.casefold(), default)
        if value is None:
            self.fail(element, f"expected the attribute {name} of <{element.tag}>")
        return value

    def number(self, element: Element, name: str, default: str | None = None) -> float:
        text = self.attribute(element, name, default)
        number = read_number(text.strip())
        if number is None:
            self.fail(element, f"expected a number as {name}, found {text!r}")
        return number

    def norm(self, element: Element, name: str, known: dict[str, str], default: str) -> str:
        text = self.attribute(element, name, default)
        if text.upper() not in known:
            self.fail(element, f"expected {name}{nearest(text.upper(), list(known))}, found {text!r}")
        return known[text.upper()]

    def only(self, element: Element, *tags: str) -> Element:
        """The one child of an element with one of these names."""
        found = [child for child in element.children if child.key in tags]
        if len(found) != 1:
            self.fail(element, f"expected one <{tags[0]}> in <{element.tag}>, found {len(found)}")
        return found[0]


def loads(
    text: str, name: str = "text.xml", leave_out_unknown: bool = False, right_rises: bool | None = None
) -> System:
    """The system of a text in fuzzy markup language; errors speak of it as ``name``. ``leave_out_unknown`` leaves out
    rules that name what does not exist, and says so in the notes.

    Raises:
        DataError: it is broken, or holds what has no counterpart here; says line, column and what was expected.
    """
    source = Source(text, name)
    root, standard = tree(source)
    if root.key not in ("fuzzysystem", "fuzzycontroller"):
        source.fail(root.line, root.column, f"expected <fuzzySystem>, found <{root.tag}>")
    reading = _Reading(source, standard if right_rises is None else right_rises, leave_out_unknown)
    variables = [child for child in reading.only(root, "knowledgebase").children if _is_variable(reading, child)]
    given = [v for v in variables if _is_input(reading, v)]
    reading.inputs = len(given)
    inputs = [_input(reading, v) for v in given]
    outputs = [_output(reading, v, inputs) for v in variables if v not in given]
    names = Names.of(inputs, outputs)
    blocks: list[RuleBlock] = []
    for child in root.children:
        if child.key in _BASES:
            blocks += _rule_base(reading, child, names)
        elif child.key != "knowledgebase":
            reading.fail(child, f"expected a rule base of Mamdani, TSK or Tsukamoto, found <{child.tag}>")
    with source.at(root.line, root.column):
        return System(
            reading.attribute(root, "name", ""),
            tuple(inputs),
            tuple(outputs),
            tuple(blocks),
            notes=tuple(reading.notes),
        )


def _is_variable(reading: _Reading, element: Element) -> bool:
    if element.key not in _VARIABLES:
        reading.fail(element, f"expected <fuzzyVariable>, <tskVariable> or <tsukamotoVariable>, found <{element.tag}>")
    return True


def _is_input(reading: _Reading, element: Element) -> bool:
    kind = reading.attribute(element, "type", "input" if element.key == "fuzzyvariable" else "output").casefold()
    if kind not in ("input", "output") or (kind == "input" and element.key != "fuzzyvariable"):
        reading.fail(element, f"expected type input or output of <{element.tag}>, found {kind!r}")
    return kind == "input"


def _common(reading: _Reading, element: Element, others: list[Input]) -> dict[str, Any]:
    name = reading.attribute(element, "name")
    if name in reading.names:
        reading.fail(element, f"a second variable {name!r}")
    reading.names.append(name)
    terms = [_term(reading, child, name, _VARIABLES[element.key]) for child in element.children]
    if "domainleft" in element.attributes or element.key != "tskvariable":
        low, high = reading.number(element, "domainleft"), reading.number(element, "domainright")
    else:
        low, high = hull([extent(term, [(v.low, v.high) for v in others]) for term in terms])
        reading.notes.append(f"{name} has no domain: {low:g} to {high:g}, from its terms")
    scale = reading.attribute(element, "scale", "")
    common = {"name": name, "low": low, "high": high, "terms": tuple(terms), "unit": "" if scale == "null" else scale}
    with reading.source.at(element.line, element.column):
        Variable(**common)  # type: ignore[arg-type]
    return common


def _input(reading: _Reading, element: Element) -> Input:
    return Input(**_common(reading, element, []))


def _output(reading: _Reading, element: Element, inputs: list[Input]) -> Output:
    common = _common(reading, element, inputs)
    common["default"] = reading.number(element, "defaultValue", "0")
    if element.key == "fuzzyvariable":
        common["aggregation"] = reading.norm(element, "accumulation", _S_NORMS, "MAX")
        common["defuzzifier"] = reading.norm(element, "defuzzifier", _DEFUZZIFIERS, "COG")
    else:
        combination = reading.attribute(element, "combination", "WA")
        if combination.upper() != "WA":
            reading.fail(element, f"expected combination WA, found {combination!r}")
        common |= {"aggregation": None, "defuzzifier": "weighted_average"}
    with reading.source.at(element.line, element.column):
        return Output(**common)


def _term(reading: _Reading, element: Element, variable: str, tag: str) -> Term:
    if element.key != tag:
        reading.fail(element, f"expected <{tag}>, found <{element.tag}>")
    name = reading.attribute(element, "name")
    if not name:
        reading.fail(element, "expected a name of the term")
    if tag == "tskterm":
        return _consequent(reading, element, name)
    if reading.attribute(element, "complement", "false").casefold() == "true":
        reading.complements.add((variable, name))
        reading.notes.append(f"{variable}, term {name} is a complement: its rules say 'not {name}'")
    if len(element.children) != 1 or element.children[0].key not in SHAPES:
        found = ", ".join(f"<{child.tag}>" for child in element.children) or "nothing"
        reading.fail(element, f"expected one shape such as <triangularShape> in term {name}, found {found}")
    shape = element.children[0]
    numbers = [reading.number(shape, f"param{k}") for k in range(1, SHAPES[shape.key] + 1)]
    for point in shape.children:
        numbers += [reading.number(point, "x"), reading.number(point, "y")]
    if (how := reading.attribute(shape, "interpolationMethod", "linear").casefold()) != "linear":
        reading.fail(shape, f"expected interpolationMethod linear, found {how!r}")
    with reading.source.at(shape.line, shape.column):
        term, note = term_of(name, shape.key, numbers, reading.right_rises)
    if note and note not in reading.notes:
        reading.notes.append(note)
    return term


def _consequent(reading: _Reading, element: Element, name: str) -> Term:
    numbers = []
    for child in element.children:
        number = read_number(child.text.strip())
        if number is None:
            reading.fail(child, f"expected a number, found {child.text.strip()!r}")
        numbers.append(number)
    order = reading.attribute(element, "order")
    wanted = {"0": 1, "1": reading.inputs + 1}.get(order)
    if len(numbers) != wanted:
        reading.fail(
            element, f"expected order 0 with 1 number or order 1 with {reading.inputs + 1}, found {len(numbers)}"
        )
    if order == "0":
        return Term(name, "constant", tuple(numbers))
    reading.notes.append(f"term {name}: its first number is the constant, the others belong to the inputs in order")
    return Term(name, "linear", (*numbers[1:], numbers[0]))


def _rule_base(reading: _Reading, element: Element, names: Names) -> list[RuleBlock]:
    """A rule base as one block; as several where its rules differ in their norms."""
    title = reading.attribute(element, "name", "")
    mamdani = element.key in ("mamdanirulebase", "rulebase")
    implication = reading.norm(element, "activationMethod", _T_NORMS, "MIN") if mamdani else None
    base = {key: reading.attribute(element, key, usual) for key, usual in (("andMethod", "MIN"), ("orMethod", "MAX"))}
    groups: list[tuple[tuple[str, str], list[Rule]]] = []
    for child in element.children:
        if child.key not in ("rule", "tskrule"):
            reading.fail(child, f"expected <rule>, found <{child.tag}>")
        norms = (
            reading.norm(child, "andMethod", _T_NORMS, base["andMethod"]),
            reading.norm(child, "orMethod", _S_NORMS, base["orMethod"]),
        )
        rule = _rule(reading, child, names)
        if rule is None:
            continue
        if not groups or groups[-1][0] != norms:
            groups.append((norms, []))
        groups[-1][1].append(rule)
    if len(groups) > 1:
        reading.notes.append(f"rule base {title}: its rules differ in their norms: {len(groups)} blocks")
    return [RuleBlock(tuple(rules), title, *norms, implication) for norms, rules in groups] or [
        RuleBlock((), title, implication=implication)
    ]


def _rule(reading: _Reading, element: Element, names: Names) -> Rule | None:
    consequent = reading.only(element, "consequent", "tskconsequent")
    for child in consequent.children:
        if child.key in ("else", "tskelse"):
            reading.fail(child, "an ELSE part has no counterpart here: write a rule with 'not' in its place")
    pairs = (
        (reading.only(element, "antecedent"), names.antecedent),
        (reading.only(consequent, "then", "tskthen"), names.consequent),
    )
    sides = [[_clause(reading, child, known) for child in part.children] for part, known in pairs]
    weight = reading.number(element, "weight", "1.0")
    connector = reading.attribute(element, "connector", "and").casefold()
    if connector not in ("and", "or"):
        reading.fail(element, f"expected connector and or or, found {connector!r}")
    troubles = [trouble for side in sides for _, trouble in side if trouble]
    if troubles and not reading.leave_out:
        reading.fail(element, troubles[0])
    if troubles:
        reading.notes.append(
            f"{reading.source.name}:{element.line}:{element.column}: {troubles[0]}: the rule is left out"
        )
        return None
    if not sides[0] or not sides[1]:
        reading.fail(element, "expected a clause in the antecedent and in the consequent")
    node: Antecedent = sides[0][0][0]
    for there, _ in sides[0][1:]:
        node = And(node, there) if connector == "and" else Or(node, there)
    with reading.source.at(element.line, element.column):
        return Rule(node, tuple(there for there, _ in sides[1]), weight)


def _clause(reading: _Reading, element: Element, known: Any) -> tuple[Is, str]:
    if element.key not in ("clause", "tskclause"):
        reading.fail(element, f"expected <clause>, found <{element.tag}>")
    variable = reading.only(element, "variable").text.strip()
    term = reading.only(element, "term").text.strip()
    modifier = reading.attribute(element, "modifier", "").casefold()
    if modifier and modifier not in HEDGES:
        reading.fail(element, f"expected a modifier{nearest(modifier, list(HEDGES))}, found {modifier!r}")
    trouble = ""
    if variable not in known:
        trouble = f"there is no variable {variable!r} here{nearest(variable, list(known))}"
    elif term not in known[variable]:
        trouble = f"{variable} has no term {term!r}{nearest(term, list(known[variable]))}"
    hedges = (*([modifier] if modifier else []), *(["not"] if (variable, term) in reading.complements else []))
    return Is(variable, term, hedges), trouble
