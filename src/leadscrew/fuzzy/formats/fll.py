"""fuzzylite's ``.fll`` files: :func:`loads` and :func:`dumps`."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import Any

from leadscrew.fuzzy.formats.losses import Saying, integrated, mapped
from leadscrew.fuzzy.formats.place import Source, plain
from leadscrew.fuzzy.formats.vocabulary import (
    FLL_ACTIVATIONS,
    FLL_DEFUZZIFIERS,
    FLL_NORMS,
    class_name,
    class_term,
    class_text,
)
from leadscrew.fuzzy.rules_text import Names, parse, read_number, rule_text
from leadscrew.fuzzy.system import (
    INTEGRAL,
    T_NORMS,
    Antecedent,
    Input,
    Is,
    Output,
    Rule,
    RuleBlock,
    System,
    Term,
    Variable,
)
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import DataError
from leadscrew.util.escape import one_line

_KEYS = {
    "Engine": ("description",),
    "InputVariable": ("description", "enabled", "range", "lock-range", "term"),
    "OutputVariable": (
        "description", "enabled", "range", "lock-range", "aggregation", "accumulation", "defuzzifier", "default",
        "lock-previous", "term",
    ),
    "RuleBlock": ("description", "enabled", "conjunction", "disjunction", "implication", "activation", "rule"),
}  # fmt: skip
_WEIGHTED_KINDS = ("Automatic", "TakagiSugeno", "Tsukamoto")
_MONOTONE = ("ramp", "sigmoid", "s_shape", "z_shape", "concave")
_COMPARISON, _COUNT = "<=?|>=?|==|!=", "[0-9]{1,9}"
_VALUE = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_ACTIVATION_PARAMETERS = {
    "first": ("1", "0.0"),
    "last": ("1", "0.0"),
    "highest": ("1",),
    "lowest": ("1",),
    "threshold": (">=", "0.0"),
}
"""What fuzzylite takes where the file says nothing."""


@dataclass
class _Item:
    key: str
    value: str
    line: int
    column: int


@dataclass
class _Block:
    head: _Item
    items: list[_Item] = field(default_factory=list)

    def last(self, key: str) -> _Item | None:
        return next((item for item in reversed(self.items) if item.key == key), None)


class _Reading:
    def __init__(self, source: Source, leave_out: bool) -> None:
        self.source = source
        self.leave_out = leave_out
        self.inputs = 0
        self.names: list[str] = []
        self.notes: list[str] = []

    def fail(self, item: _Item, expected: str) -> Any:
        self.source.fail(item.line, item.column, f"expected {expected}, found {item.value!r}")

    def flag(self, block: _Block, key: str, default: bool) -> bool:
        item = block.last(key)
        if item and item.value not in ("true", "false"):
            self.fail(item, f"{key}: true or false")
        return item.value == "true" if item else default

    def numbers(self, item: _Item, text: str, column: int) -> list[float]:
        found = []
        for match in re.finditer(r"\S+", text):
            number = read_number(match[0])
            if number is None:
                self.source.fail(item.line, column + match.start(), f"expected a number, found {match[0]!r}")
            found.append(number)
        return found

    def named(self, item: _Item, known: dict[str, str], what: str) -> str:
        if item.value not in known:
            hint = nearest(item.value, list(known))
            self.source.fail(item.line, item.column, f"expected {what}{hint}, found {item.value!r}")
        return known[item.value]

    def norm(self, block: _Block, *keys: str, t_norm: bool) -> str | None:
        item = next((found for key in keys if (found := block.last(key))), None)
        if item is None or item.value in ("none", ""):
            return None
        known = {k: v for k, v in FLL_NORMS.items() if (v in T_NORMS) == t_norm}
        return self.named(item, known, f"a norm for {item.key}")

    def name(self, item: _Item, text: str) -> str:
        """A name without the characters that fuzzylite takes out of it, too."""
        found = re.sub(r"[^A-Za-z0-9_.]", "", text)
        if not found:
            self.fail(item, "a name")
        if found != text:
            self.notes.append(f"line {item.line}: {text!r} is called {found}, as in fuzzylite")
        return found


def loads(text: str, name: str = "text.fll", leave_out_unknown: bool = False) -> System:
    """The system of a ``.fll`` text; errors speak of it as ``name``. ``leave_out_unknown`` leaves out rules that name
    what does not exist, and says so in the notes.

    Raises:
        DataError: it is broken; says line, column and what was expected.
    """
    reading = _Reading(Source(text, name), leave_out_unknown)
    blocks = _blocks(reading.source)
    reading.inputs = sum(block.head.key == "InputVariable" for block in blocks)
    engine = next((block for block in blocks if block.head.key == "Engine"), None)
    inputs = [_input(reading, block) for block in blocks if block.head.key == "InputVariable"]
    outputs = [_output(reading, block) for block in blocks if block.head.key == "OutputVariable"]
    outputs = integrated(reading.source, outputs)
    names = Names.of(inputs, outputs)
    rules = [_rule_block(reading, block, names) for block in blocks if block.head.key == "RuleBlock"]
    about = engine.last("description") if engine else None
    with reading.source.at(1, 1):
        return System(
            engine.head.value if engine else "",
            tuple(inputs),
            tuple(outputs),
            tuple(rules),
            doc=about.value if about else "",
            notes=tuple(reading.notes),
        )


def _blocks(source: Source) -> list[_Block]:
    blocks: list[_Block] = []
    for number, line in enumerate(source.lines, start=1):
        body = line.partition("#")[0].rstrip()
        stripped = body.lstrip()
        if not stripped:
            continue
        key, colon, value = stripped.partition(":")
        start = len(body) - len(stripped) + 1
        item = _Item(key.strip(), value.strip(), number, start + len(key) + 1 + len(value) - len(value.lstrip()))
        if not colon:
            source.fail(number, start, f"expected 'key: value', found {stripped!r}")
        if item.key in _KEYS:
            if item.key == "Engine" and blocks:
                source.fail(number, start, "expected Engine: once, on top")
            blocks.append(_Block(item))
        elif not blocks:
            source.fail(number, start, f"expected Engine:, found {stripped!r}")
        else:
            allowed = _KEYS[blocks[-1].head.key]
            if item.key not in allowed:
                head = blocks[-1].head.key
                source.fail(
                    number, start, f"expected a key of {head}{nearest(item.key, list(allowed))}, found {item.key!r}"
                )
            if item.key not in ("term", "rule") and blocks[-1].last(item.key):
                source.fail(number, start, f"a second {item.key}:")
            blocks[-1].items.append(item)
    if not blocks:
        source.fail(1, 1, "expected Engine:")
    return blocks


def _common(reading: _Reading, block: _Block) -> dict[str, Any]:
    limits = block.last("range")
    low, high = -float("inf"), float("inf")
    if limits:
        ends = reading.numbers(limits, limits.value, limits.column)
        if len(ends) != 2:
            reading.fail(limits, "range: LOW HIGH")
        low, high = ends
    about = block.last("description")
    name = reading.name(block.head, block.head.value)
    if name in reading.names:
        reading.source.fail(block.head.line, block.head.column, f"a second variable {name!r}")
    reading.names.append(name)
    common: dict[str, Any] = {
        "name": name,
        "low": low,
        "high": high,
        "terms": tuple(_term(reading, item) for item in block.items if item.key == "term"),
        "doc": about.value if about else "",
        "enabled": reading.flag(block, "enabled", True),
        "lock_range": reading.flag(block, "lock-range", False),
    }
    with reading.source.at((limits or block.head).line, (limits or block.head).column):
        Variable(**common)
    return common


def _input(reading: _Reading, block: _Block) -> Input:
    return Input(**_common(reading, block))


def _output(reading: _Reading, block: _Block) -> Output:
    common = _common(reading, block)
    item = block.last("defuzzifier") or block.head
    kind, _, rest = item.value.partition(" ") if item.key == "defuzzifier" else ("none", "", "")
    if kind not in FLL_DEFUZZIFIERS:
        reading.fail(item, f"a defuzzifier{nearest(kind, list(FLL_DEFUZZIFIERS))}")
    defuzzifier = FLL_DEFUZZIFIERS[kind]
    resolution, rest = 100, rest.strip()
    if defuzzifier not in INTEGRAL:
        if rest not in ("", *_WEIGHTED_KINDS):
            reading.fail(item, f"{kind} with {', '.join(_WEIGHTED_KINDS)} or nothing")
        if rest == "TakagiSugeno" and any(t.shape not in ("constant", "linear") for t in common["terms"]):
            reading.fail(item, "TakagiSugeno with terms that are Constant or Linear")
        if rest == "Tsukamoto" and any(t.shape not in _MONOTONE for t in common["terms"]):
            reading.fail(item, "Tsukamoto with terms that rise or fall only (Ramp, Sigmoid, SShape, ZShape, Concave)")
    elif rest:
        if not re.fullmatch(r"[0-9]{1,6}", rest):
            reading.fail(item, f"{kind} and a whole number of cells")
        resolution = int(rest)
    else:
        reading.notes.append(
            f"output {common['name']}: no resolution: 100 as in fuzzylite 6 (pyfuzzylite 8 takes 1000)"
        )
    default = block.last("default")
    value = float("nan")
    if default:
        found = read_number(default.value)
        value = reading.fail(default, "default: NUMBER") if found is None else found
    with reading.source.at(item.line, item.column):
        return Output(
            **common,
            aggregation=reading.norm(block, "aggregation", "accumulation", t_norm=False),
            defuzzifier=defuzzifier,
            resolution=resolution,
            default=value,
            lock_previous=reading.flag(block, "lock-previous", False),
        )


def _term(reading: _Reading, item: _Item) -> Term:
    match = re.match(r"(\S+)\s+(\S+)", item.value)
    if match is None:
        return reading.fail(item, "term: NAME CLASS NUMBERS")
    name, kind = reading.name(item, match[1]), match[2]
    rest = "" if kind == "Function" else item.value[match.end() :]
    numbers = reading.numbers(item, rest, item.column + match.end())
    if kind == "Linear" and len(numbers) <= reading.inputs:
        reading.notes.append(f"line {item.line}: the numbers that {name} does not have are 0, as in fuzzylite")
        numbers += [0.0] * (reading.inputs + 1 - len(numbers))
    elif kind == "Linear" and len(numbers) > reading.inputs + 1:
        wanted = f"at most {reading.inputs + 1} numbers (one for each input and a constant)"
        reading.source.fail(item.line, item.column + match.end(), f"expected {wanted}, found {len(numbers)}")
    with reading.source.at(item.line, item.column + match.start(2)):
        return class_term(name, kind, numbers)


def _rule_block(reading: _Reading, block: _Block, names: Names) -> RuleBlock:
    activation = "general"
    parameters: tuple[str, ...] = ()
    implication = None
    item = block.last("activation")
    if item and item.value in FLL_NORMS:
        reading.notes.append(f"line {item.line}: activation {item.value} (fuzzylite 5) is taken as the implication")
        implication = reading.norm(block, "activation", t_norm=True)
    elif item and item.value not in ("none", ""):
        kind, *rest = item.value.split()
        activation = reading.named(_Item(item.key, kind, item.line, item.column), FLL_ACTIVATIONS, "an activation")
        parameters = _activation_parameters(reading, item, activation, tuple(rest))
    rules = tuple(rule for item in block.items if item.key == "rule" and (rule := _rule(reading, item, names)))
    with reading.source.at(block.head.line, block.head.column):
        return RuleBlock(
            rules,
            name=block.head.value,
            conjunction=reading.norm(block, "conjunction", t_norm=True),
            disjunction=reading.norm(block, "disjunction", t_norm=False),
            implication=implication or reading.norm(block, "implication", t_norm=True),
            activation=activation,
            activation_parameters=parameters,
            enabled=reading.flag(block, "enabled", True),
        )


def _activation_parameters(reading: _Reading, item: _Item, activation: str, given: tuple[str, ...]) -> tuple[str, ...]:
    usual = _ACTIVATION_PARAMETERS.get(activation, ())
    if not given:
        return usual
    wanted = [_COMPARISON if x == ">=" else _COUNT if x == "1" else _VALUE for x in usual]
    if len(given) != len(usual) or not all(re.fullmatch(p, x) for p, x in zip(wanted, given, strict=True)):
        reading.fail(item, f"{item.value.split()[0]} {' '.join(usual)}".strip() + " (or other numbers)")
    return tuple(plain(float(x)) if p == _VALUE else x for p, x in zip(wanted, given, strict=True))


def _rule(reading: _Reading, item: _Item, names: Names) -> Rule | None:
    place = {"where": reading.source.name, "line": item.line, "column": item.column}
    if not reading.leave_out:
        return parse(item.value, names, **place)  # type: ignore[arg-type]
    rule = parse(item.value, **place)  # type: ignore[arg-type]
    try:
        return parse(item.value, names, **place)  # type: ignore[arg-type]
    except DataError as error:
        reading.notes.append(f"{error}: the rule is left out: {rule_text(rule)}")
        return None


NAME = r"[A-Za-z0-9_.]+"


def dumps(system: System, notes: list[str] | None = None) -> str:
    """A system as ``.fll`` text; ``notes`` collects what was left out without an effect on outputs.

    Raises:
        ValueRefused: the format cannot express the system; names what.
    """
    saying = Saying("fll")
    system = saying.named(rules_as_fuzzylite(saying, saying.without_disabled_rules(system)), NAME)
    saying.units_and_docs(system, docs=False)
    shapes_of_fuzzylite(saying, system)
    lines = [f"# {comment}" for comment in saying.integration(system, "midpoint", None)]
    lines.append(f"Engine: {_line(saying, system.name)}".rstrip())
    if system.doc:
        lines.append(f"  description: {_line(saying, system.doc)}")
    for input in system.inputs:
        lines += _input_lines(saying, input)
    for output in system.outputs:
        lines += _output_lines(saying, output)
    for block in system.blocks:
        lines += _rule_block_lines(saying, block)
    if notes is not None:
        notes += saying.notes
    return "\n".join(lines) + "\n"


def rules_as_fuzzylite(saying: Saying, system: System) -> System:
    """The system with ``any`` as fuzzylite writes it: without a term, and without what ``any`` makes of no effect."""

    def proposition(there: Is) -> Is:
        if "any" not in there.hedges:
            return there
        kept = there.hedges[: there.hedges.index("any") + 1]
        if there.term or kept != there.hedges:
            saying.note(
                f"{there.variable} is {' '.join((*there.hedges, there.term))}: what follows 'any' is not written"
            )
        return replace(there, hedges=kept, term="")

    def rule(r: Rule) -> Rule:
        antecedent: Antecedent = mapped(r.antecedent, proposition)
        for there in r.consequents:
            if "any" in there.hedges:
                saying.refuse(f"a rule that concludes '{there.variable} is any'")
        return replace(r, antecedent=antecedent)

    return replace(system, blocks=tuple(replace(b, rules=tuple(rule(r) for r in b.rules)) for b in system.blocks))


def shapes_of_fuzzylite(saying: Saying, system: System) -> None:
    """Refuses what fuzzylite does not have: the defuzzifier height, singletons as sets, heights of consequents."""
    for output in system.outputs:
        if output.defuzzifier == "height":
            saying.refuse(f"output {output.name}: the defuzzifier height")
    for variable in (*system.inputs, *system.outputs):
        for term in variable.terms:
            if term.shape in ("constant", "linear") and term.height != 1.0:
                saying.refuse(f"{variable.name}, term {term.name}: a height of {term.height!r} of a {term.shape}")


def _line(saying: Saying, text: str) -> str:
    """A text as it can stand after a key: one line, without the sign of comments."""
    found = one_line(text.replace("#", " "))
    if found != text:
        saying.note(f"{text!r} is written as {found!r}")
    return found


def _common_lines(saying: Saying, variable: Variable) -> list[str]:
    for term in variable.terms:
        if term.shape == "singleton":
            saying.refuse(f"{variable.name}, term {term.name}: a singleton")
    about = [f"  description: {_line(saying, variable.doc)}"] if variable.doc else []
    return [
        *about,
        f"  enabled: {str(variable.enabled).lower()}",
        f"  range: {plain(variable.low)} {plain(variable.high)}",
        f"  lock-range: {str(variable.lock_range).lower()}",
    ]


def _terms(variable: Variable) -> list[str]:
    return [f"  term: {term.name} {class_text(term)}" for term in variable.terms]


def _input_lines(saying: Saying, variable: Input) -> list[str]:
    return [f"InputVariable: {variable.name}", *_common_lines(saying, variable), *_terms(variable)]


def _output_lines(saying: Saying, output: Output) -> list[str]:
    if output.defuzzifier in INTEGRAL:
        parameter = str(output.resolution)
    else:
        shapes = {term.shape for term in output.terms}
        parameter = "TakagiSugeno" if shapes <= {"constant", "linear"} else "Automatic"
    return [
        f"OutputVariable: {output.name}",
        *_common_lines(saying, output),
        f"  aggregation: {_class(output.aggregation)}",
        f"  defuzzifier: {_class(output.defuzzifier)} {parameter}",
        f"  default: {plain(output.default)}",
        f"  lock-previous: {str(output.lock_previous).lower()}",
        *_terms(output),
    ]


def _class(name: str | None) -> str:
    return class_name(name) if name else "none"


def _rule_block_lines(saying: Saying, block: RuleBlock) -> list[str]:
    return [
        f"RuleBlock: {_line(saying, block.name)}".rstrip(),
        f"  enabled: {str(block.enabled).lower()}",
        f"  conjunction: {_class(block.conjunction)}",
        f"  disjunction: {_class(block.disjunction)}",
        f"  implication: {_class(block.implication)}",
        f"  activation: {' '.join((_class(block.activation), *block.activation_parameters))}",
        *(f"  rule: {rule_text(rule, str)}" for rule in block.rules),
    ]
