"""MATLAB ``.fis`` files, version 2 of the text format, as MATLAB, Octave and fuzzylite write them.

How a centroid is integrated does not stand in the file: MATLAB and Octave take the trapezoid rule on 101 nodes, so
that is what is read. Where no rule fires the output is not a number (MATLAB: the middle of the range).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from leadscrew.fuzzy.formats.place import Source
from leadscrew.fuzzy.formats.said import integrated
from leadscrew.fuzzy.formats.vocabulary import FIS_DEFUZZIFIERS, FIS_S_NORMS, FIS_SHAPES, FIS_T_NORMS
from leadscrew.fuzzy.system import (
    WEIGHTED,
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
from leadscrew.kernel.sheet import nearest

_FUNCTION = re.compile(r"'(.*)'\s*:\s*'([^':,\s]*)'?\s*,\s*\[([^\]]*)\]")
_RULE = re.compile(r"([^,]*),([^()]*)\(([^()]*)\)\s*:\s*(\S+)")
_INTEGER = re.compile(r"[0-9]{1,9}")
_NUMBER = re.compile(r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|[iI][nN][fF])")
HEDGES = {0: (), 5: ("somewhat",), 20: ("very",), 30: ("extremely",), 40: ("very", "very"), 99: ("any",)}
"""Hedges by the hundredths of an index."""


@dataclass
class _Entry:
    key: str
    value: str
    line: int
    column: int


@dataclass
class _Section:
    title: str
    line: int
    entries: dict[str, _Entry] = field(default_factory=dict)
    functions: list[_Entry] = field(default_factory=list)


@dataclass
class _Reading:
    source: Source
    sections: dict[str, _Section] = field(default_factory=dict)
    rules: list[_Entry] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    names: list[str] = field(default_factory=list)

    def numbers(self, text: str, line: int, column: int) -> list[float]:
        found = []
        for match in re.finditer(r"[^\s,;]+", text):
            if not _NUMBER.fullmatch(match[0]):
                self.source.fail(line, column + match.start(), f"expected a number, found {match[0]!r}")
            found.append(float(match[0]))
        return found

    def value(self, section: _Section, key: str, default: str | None = None) -> _Entry:
        entry = section.entries.get(key.casefold())
        if entry is None:
            if default is None:
                self.source.fail(section.line, 1, f"expected {key}= in [{section.title}]")
            return _Entry(key, f"'{default}'", section.line, 1)
        return entry

    def text(self, section: _Section, key: str, default: str | None = None) -> tuple[str, _Entry]:
        entry = self.value(section, key, default)
        value = entry.value
        if len(value) >= 2 and value[0] == value[-1] == "'":
            return value[1:-1], entry
        self.source.fail(entry.line, entry.column, f"expected {key}='...', found {value!r}")

    def count(self, section: _Section, key: str, there: int) -> None:
        entry = section.entries.get(key.casefold())
        if entry and not (_INTEGER.fullmatch(entry.value) and int(entry.value) == there):
            self.source.fail(
                entry.line, entry.column, f"expected {key}={there}, the number there is, found {entry.value!r}"
            )

    def method(self, section: _Section, key: str, known: dict[str, str], default: str) -> str:
        name, entry = self.text(section, key, default)
        if name not in known:
            self.source.fail(entry.line, entry.column, f"expected a {key}{nearest(name, list(known))}, found {name!r}")
        return known[name]


def loads(text: str, name: str = "text.fis", leave_out_unknown: bool = False) -> System:
    """The system of a ``.fis`` text; errors speak of it as ``name``.

    Raises:
        DataError: it is broken; says line, column and what was expected.
    """
    reading = _Reading(Source(text, name))
    _sections(reading)
    system = reading.sections.get("system")
    if system is None:
        reading.source.fail(1, 1, "expected a section [System]")
    title, _ = reading.text(system, "Name", "")
    inputs = [Input(*_variable(reading, s)) for s in _numbered(reading, system, "Input")]
    defuzzifier = reading.method(system, "DefuzzMethod", FIS_DEFUZZIFIERS, "centroid")
    aggregation: str | None = reading.method(system, "AggMethod", FIS_S_NORMS, "max")
    implication: str | None = reading.method(system, "ImpMethod", FIS_T_NORMS, "min")
    if defuzzifier in WEIGHTED:
        if aggregation != "unbounded_sum":
            reading.notes.append("AggMethod is not used with wtaver and wtsum (as in MATLAB; Octave uses it)")
        aggregation = implication = None
    outputs = []
    for section in _numbered(reading, system, "Output"):
        base = _variable(reading, section)
        kind = {"aggregation": aggregation, "defuzzifier": defuzzifier}
        if defuzzifier not in WEIGHTED:
            kind["integration"] = "trapezoid"
        with reading.source.at(section.line, 1):
            outputs.append(Output(*base, **kind))  # type: ignore[arg-type]
    outputs = integrated(reading.source, outputs)
    reading.count(system, "NumRules", len(reading.rules))
    rules = [rule for entry in reading.rules if (rule := _rule(reading, entry, inputs, outputs))]
    block = RuleBlock(
        tuple(rules),
        conjunction=reading.method(system, "AndMethod", FIS_T_NORMS, "min"),
        disjunction=reading.method(system, "OrMethod", FIS_S_NORMS, "max"),
        implication=implication,
    )
    with reading.source.at(system.line, 1):
        return System(title, tuple(inputs), tuple(outputs), (block,), notes=tuple(reading.notes))


def _lines(source: Source) -> Iterator[tuple[int, int, str]]:
    for number, line in enumerate(source.lines, start=1):
        body = line.lstrip()
        column = len(line) - len(body) + 1
        kept = 0 if body[:1] in ("%", "#") else max(body.rfind("'"), body.rfind("]")) + 1
        comment = re.search(r"[%#]", body[kept:])
        if comment:
            body = body[: kept + comment.start()]
        if body := body.rstrip():
            yield number, column, body


def _sections(reading: _Reading) -> None:
    source = reading.source
    section: _Section | None = None
    for number, column, body in _lines(source):
        if body.startswith("[") and "=" not in body:
            if not body.endswith("]"):
                source.fail(number, column + len(body), "expected ']' after the name of a section")
            title = body[1:-1].strip()
            if not re.fullmatch(r"system|rules|(?:input|output)[0-9]{1,6}", title.casefold()):
                source.fail(number, column, f"expected [System], [Input1], [Output1] or [Rules], found {body!r}")
            if title.casefold() in reading.sections:
                source.fail(number, column, f"a second section {body}")
            section = reading.sections[title.casefold()] = _Section(title, number)
        elif section is None:
            source.fail(number, column, f"expected a section such as [System], found {body!r}")
        elif section.title.casefold() == "rules":
            reading.rules.append(_Entry("", body, number, column))
        else:
            key, equals, value = body.partition("=")
            if not equals:
                source.fail(number, column, f"expected NAME=VALUE, found {body!r}")
            start = column + len(key) + 1 + len(value) - len(value.lstrip())
            entry = _Entry(key.strip(), value.strip(), number, start)
            if re.fullmatch(r"mf[0-9]{1,6}", entry.key.casefold()):
                section.functions.append(entry)
            elif entry.key.casefold() in section.entries:
                source.fail(number, column, f"a second {entry.key}= in [{section.title}]")
            else:
                section.entries[entry.key.casefold()] = entry


def _numbered(reading: _Reading, system: _Section, kind: str) -> list[_Section]:
    there = {int(key[len(kind) :]): s for key, s in reading.sections.items() if key.startswith(kind.casefold())}
    for wanted, index in enumerate(sorted(there), start=1):
        if index != wanted:
            reading.source.fail(there[index].line, 1, f"expected [{kind}{wanted}], found [{kind}{index}]")
    reading.count(system, f"Num{kind}s", len(there))
    return [there[index] for index in sorted(there)]


def _variable(reading: _Reading, section: _Section) -> tuple[str, float, float, tuple[Term, ...]]:
    source = reading.source
    name, entry = reading.text(section, "Name")
    if not name:
        source.fail(entry.line, entry.column, f"expected a name of [{section.title}]")
    if name in reading.names:
        source.fail(entry.line, entry.column, f"a second variable {name!r}")
    reading.names.append(name)
    limits = reading.value(section, "Range")
    ends = reading.numbers(limits.value.strip("[]"), limits.line, limits.column + 1)
    if len(ends) != 2 or not limits.value.startswith("[") or not limits.value.endswith("]"):
        source.fail(limits.line, limits.column, f"expected Range=[LOW HIGH], found {limits.value!r}")
    reading.count(section, "NumMFs", len(section.functions))
    terms: list[Term] = []
    for wanted, function in enumerate(section.functions, start=1):
        if int(function.key[2:]) != wanted:
            source.fail(function.line, 1, f"expected MF{wanted}=, found {function.key}=")
        terms.append(_term(reading, function, name, [t.name for t in terms]))
    with source.at(limits.line, limits.column):
        Variable(name, ends[0], ends[1], ())
    return name, ends[0], ends[1], tuple(terms)


def _term(reading: _Reading, function: _Entry, variable: str, taken: list[str]) -> Term:
    source, line, column = reading.source, function.line, function.column
    match = _FUNCTION.fullmatch(function.value)
    if match is None:
        source.fail(line, column, f"expected 'NAME':'KIND',[NUMBERS], found {function.value!r}")
    name, kind = match[1], match[2]
    if kind not in FIS_SHAPES:
        source.fail(line, column + match.start(2), f"expected a membership function{nearest(kind, list(FIS_SHAPES))}, "
                    f"found {kind!r}")  # fmt: skip
    numbers = reading.numbers(match[3], line, column + match.start(3))
    shape, order = FIS_SHAPES[kind]
    if kind == "linear":
        order = tuple(range(sum(title.startswith("input") for title in reading.sections) + 1))
    if order and len(numbers) != len(order):
        each = " (one for each input and a constant)" if kind == "linear" else ""
        source.fail(
            line, column + match.start(3), f"expected {len(order)} numbers for {kind}{each}, found {len(numbers)}"
        )
    if not name:
        source.fail(line, column, f"expected a name of MF{len(taken) + 1}")
    given = name
    while name in taken:
        name += "_"
    if name != given:
        reading.notes.append(f"variable {variable}: a second term {given!r} is called {name}")
    with source.at(line, column + match.start(3)):
        return Term(name, shape, tuple(numbers[k] for k in order) if order else tuple(numbers))


def _rule(reading: _Reading, entry: _Entry, inputs: list[Input], outputs: list[Output]) -> Rule | None:
    source = reading.source
    match = _RULE.fullmatch(entry.value)
    if match is None:
        source.fail(entry.line, entry.column, f"expected INPUTS, OUTPUTS (WEIGHT) : 1 or 2, found {entry.value!r}")
    sides = []
    for group, variables, what in ((1, inputs, "input"), (2, outputs, "output")):
        column = entry.column + match.start(group)
        numbers = reading.numbers(match[group], entry.line, column)
        if len(numbers) != len(variables):
            source.fail(
                entry.line, column, f"expected {len(variables)} numbers, one for each {what}, found {len(numbers)}"
            )
        sides.append([_index(reading, v, x, entry.line, column) for v, x in zip(variables, numbers, strict=True) if x])
    antecedent, consequents = sides
    if match[4] not in ("1", "2"):
        source.fail(entry.line, entry.column + match.start(4), f"expected 1 (and) or 2 (or), found {match[4]!r}")
    weight = reading.numbers(match[3], entry.line, entry.column + match.start(3))
    if len(weight) != 1 or not 0.0 <= weight[0] <= 1.0:
        source.fail(entry.line, entry.column + match.start(3), f"expected a weight from 0 to 1, found {match[3]!r}")
    if not antecedent:
        source.fail(entry.line, entry.column, "expected a term of some input: all are 0")
    if not consequents:
        reading.notes.append(f"line {entry.line}: a rule that concludes nothing is left out")
        return None
    node: Antecedent = antecedent[0]
    for there in antecedent[1:]:
        node = And(node, there) if match[4] == "1" else Or(node, there)
    return Rule(node, tuple(consequents), weight[0])


def _index(reading: _Reading, variable: Variable, number: float, line: int, column: int) -> Is:
    if abs(number) > 1e6:
        reading.source.fail(
            line, column, f"expected a term of {variable.name} (1 to {len(variable.terms)}), found {number:g}"
        )
    index, hundredths = divmod(round(abs(number) * 100), 100)
    if not 1 <= index <= len(variable.terms):
        reading.source.fail(
            line, column, f"expected a term of {variable.name} (1 to {len(variable.terms)}), found {number:g}"
        )
    if hundredths not in HEDGES or abs(abs(number) * 100 - round(abs(number) * 100)) > 1e-6:
        reading.source.fail(line, column, f"expected a hedge (.05, .20, .30, .40 or .99), found {number:g}")
    if (
        hundredths == 30
        and (note := "the hedge .30 is 'extremely' as in fuzzylite (Octave: the cube)") not in reading.notes
    ):
        reading.notes.append(note)
    hedges = (*(("not",) if number < 0 else ()), *HEDGES[hundredths])
    return Is(variable.name, variable.terms[index - 1].name, hedges)
