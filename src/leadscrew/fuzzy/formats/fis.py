"""MATLAB ``.fis`` files: :func:`loads` and :func:`dumps`.

MATLAB ``.fis`` files, version 2 of the text format, as MATLAB, Octave and fuzzylite write them.

How a centroid is integrated does not stand in the file: MATLAB and Octave take the trapezoid rule on 101 nodes, so
that is what is read. Where no rule fires the output is not a number (MATLAB: the middle of the range).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from leadscrew.fuzzy.formats.losses import Saying, integrated, uses
from leadscrew.fuzzy.formats.place import Source, plain
from leadscrew.fuzzy.formats.vocabulary import (
    FIS_DEFUZZIFIERS,
    FIS_S_NORMS,
    FIS_SHAPES,
    FIS_T_NORMS,
    FUZZYLITE_ONLY,
    first_name,
)
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
from leadscrew.kernel.parameters import nearest

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


def dumps(system: System, notes: list[str] | None = None) -> str:
    """A system as ``.fis`` text; ``notes`` collects what was left out without an effect on outputs.

    Raises:
        ValueRefused: the format cannot express the system; names what.
    """
    saying = Saying("fis")
    system = saying.without_disabled_rules(system)
    saying.units_and_docs(system, docs=True)
    for what, name in [("the system's", system.name), *_names(system)]:
        if any(c in name for c in "'\r\n") or not name.isprintable() or (what != "the system's" and not name):
            saying.refuse(f"{what} name {name!r}: it is empty or holds a quote or a control character")
    block = _one_block(saying, system)
    output = _one_kind_of_output(saying, system)
    sugeno = output.defuzzifier in WEIGHTED
    methods = {
        "AndMethod": _method(saying, "conjunction", block.conjunction, FIS_T_NORMS, "min"),
        "OrMethod": _method(saying, "disjunction", block.disjunction, FIS_S_NORMS, "max"),
        "ImpMethod": "prod" if sugeno else _method(saying, "implication", block.implication, FIS_T_NORMS, None),
        "AggMethod": "sum" if sugeno else _method(saying, "aggregation", output.aggregation, FIS_S_NORMS, None),
        "DefuzzMethod": _method(saying, "defuzzifier", output.defuzzifier, FIS_DEFUZZIFIERS, None),
    }
    lines = [f"% {comment}" for comment in saying.integration(system, "trapezoid", 100)]
    lines += ["[System]", f"Name='{system.name}'", f"Type='{'sugeno' if sugeno else 'mamdani'}'", "Version=2.0"]
    lines += [f"NumInputs={len(system.inputs)}", f"NumOutputs={len(system.outputs)}", f"NumRules={len(block.rules)}"]
    lines += [f"{key}='{name}'" for key, name in methods.items()]
    for kind, variables in (("Input", system.inputs), ("Output", system.outputs)):
        for index, variable in enumerate(variables, start=1):
            lines += ["", f"[{kind}{index}]", *_variable_lines(saying, variable)]
    lines += ["", "[Rules]", *(_rule_line(saying, rule, system) for rule in block.rules)]
    if notes is not None:
        notes += saying.notes
    return "\n".join(lines) + "\n"


def _names(system: System) -> list[tuple[str, str]]:
    variables = (*system.inputs, *system.outputs)
    return [("a variable's", v.name) for v in variables] + [("a term's", t.name) for v in variables for t in v.terms]


def _one_block(saying: Saying, system: System) -> RuleBlock:
    """The rules of all blocks, which must not differ in their methods."""
    blocks = [block for block in system.blocks if block.enabled]
    if len(blocks) < len(system.blocks):
        saying.note("a rule block is switched off: not written")
    for block in blocks:
        if block.activation != "general":
            saying.refuse(f"rule block {block.name!r}: activation {block.activation}")
    first = blocks[0] if blocks else RuleBlock(())
    for what in ("conjunction", "disjunction", "implication"):
        if len({getattr(block, what) for block in blocks if block.rules}) > 1:
            saying.refuse(f"rule blocks that differ in their {what}")
    if len(blocks) > 1:
        saying.note("the rule blocks become one")
        first = next((block for block in blocks if block.rules), first)
    elif first.name:
        saying.note(f"the name of rule block {first.name!r} is not written")
    merged = replace(first, rules=tuple(rule for block in blocks for rule in block.rules))
    for what, kind in (("conjunction", And), ("disjunction", Or)):
        if getattr(merged, what) is None and uses(merged, kind):
            saying.refuse(f"rules that need a {what} in a block that has none")
    return merged


def _one_kind_of_output(saying: Saying, system: System) -> Output:
    """An output that stands for all, which must not differ in how they are aggregated and defuzzified."""
    if not system.outputs:
        saying.refuse("a system without outputs")
    for what in ("aggregation", "defuzzifier"):
        if len({getattr(output, what) for output in system.outputs}) > 1:
            saying.refuse(f"outputs that differ in their {what}")
    for output in system.outputs:
        if not math.isnan(output.default):
            saying.refuse(f"output {output.name}: a default of {output.default!r} where no rule fires")
        if output.lock_previous:
            saying.refuse(f"output {output.name}: that the last value stays where no rule fires")
        if output.defuzzifier in WEIGHTED and output.aggregation is not None:
            saying.refuse(f"output {output.name}: aggregation {output.aggregation} with {output.defuzzifier}")
    return system.outputs[0]


def _method(saying: Saying, what: str, value: str | None, known: dict[str, str], default: str | None) -> str:
    if value is None and default is not None:
        return default
    name = first_name(known, value or "")
    if name is None:
        saying.refuse(f"the {what} {value or 'none'}")
    if "_" in name:
        saying.note(f"{what} {name}: MATLAB reads it only with a function of that name")
    return name


def _variable_lines(saying: Saying, variable: Variable) -> list[str]:
    for what in ("enabled", "lock_range"):
        if getattr(variable, what) != (what == "enabled"):
            saying.refuse(f"{variable.name}: {what} = {getattr(variable, what)}")
    lines = [f"Name='{variable.name}'", f"Range=[{plain(variable.low)} {plain(variable.high)}]"]
    lines.append(f"NumMFs={len(variable.terms)}")
    for index, term in enumerate(variable.terms, start=1):
        lines.append(f"MF{index}='{term.name}':{_function(saying, variable, term)}")
    return lines


def _function(saying: Saying, variable: Variable, term: Term) -> str:
    where = f"{variable.name}, term {term.name}"
    if term.height != 1.0 and term.shape not in ("constant", "linear"):
        saying.refuse(f"{where}: a height of {term.height!r}")
    kind, numbers = _kind(saying, where, term)
    if kind in FUZZYLITE_ONLY:
        saying.note(f"{where}: only fuzzylite reads {kind}")
    if kind in ("linsmf", "linzmf"):
        saying.note(f"{where}: {kind} is read by MATLAB, not by fuzzylite 6 and Octave")
    return f"'{kind}',[{' '.join(map(plain, numbers))}]"


def _kind(saying: Saying, where: str, term: Term) -> tuple[str, tuple[float, ...]]:
    if term.shape == "ramp":
        start, end = term.parameters
        return ("linsmf", (start, end)) if start <= end else ("linzmf", (end, start))
    for kind, (shape, order) in FIS_SHAPES.items():
        if shape == term.shape:
            places = order or tuple(range(len(term.parameters)))
            numbers = dict(zip(places, term.parameters, strict=True))
            return kind, tuple(numbers[k] for k in sorted(numbers))
    saying.refuse(f"{where}: a {term.shape}")


def _rule_line(saying: Saying, rule: Rule, system: System) -> str:
    clauses, kind = _clauses(saying, rule.antecedent)
    antecedent = _indices(saying, clauses, system.inputs, "input")
    consequents = _indices(saying, list(rule.consequents), system.outputs, "output")
    return f"{antecedent}, {consequents} ({plain(rule.weight) if rule.weight != 1.0 else 1}) : {kind}"


def _clauses(saying: Saying, node: Antecedent) -> tuple[list[Is], int]:
    """The propositions of a rule that has only ``and`` or only ``or``, and the number of its connective."""
    found: list[Is] = []
    kinds: set[type] = set()
    todo: list[Antecedent] = [node]
    while todo:
        node = todo.pop()
        if isinstance(node, Is):
            found.append(node)
        else:
            kinds.add(type(node))
            todo += [node.right, node.left]
    if len(kinds) > 1:
        saying.refuse("a rule with both 'and' and 'or'")
    return found, 2 if Or in kinds else 1


def _indices(saying: Saying, clauses: list[Is], variables: tuple[Variable, ...], what: str) -> str:
    numbers: dict[str, str] = {}
    known = {variable.name: variable for variable in variables}
    for there in clauses:
        if there.variable not in known:
            saying.refuse(f"a rule that asks for {there.variable}, which is no {what}")
        if there.variable in numbers:
            saying.refuse(f"a rule that names {there.variable} twice")
        numbers[there.variable] = _index_of(saying, there, known[there.variable])
    return " ".join(numbers.get(variable.name, "0") for variable in variables)


def _index_of(saying: Saying, there: Is, variable: Variable) -> str:
    sign = there.hedges[:1] == ("not",)
    hedges = there.hedges[sign:]
    hundredths = next((number for number, known in HEDGES.items() if known == hedges), None)
    if hundredths is None or not there.term or hundredths == 99:
        saying.refuse(f"'{' '.join((there.variable, 'is', *there.hedges, there.term)).rstrip()}'")
    index = 1 + [term.name for term in variable.terms].index(there.term)
    return f"{'-' if sign else ''}{index}{f'.{hundredths:02d}' if hundredths else ''}"
