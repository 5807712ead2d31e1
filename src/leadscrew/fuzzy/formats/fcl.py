"""IEC 61131-7 fuzzy control language, ``.fcl``: :func:`loads` and :func:`dumps`."""

from __future__ import annotations

import itertools
import re
from bisect import bisect_right
from dataclasses import dataclass, field
from typing import Any

from leadscrew.fuzzy.formats.extent import extent, hull
from leadscrew.fuzzy.formats.fll import rules_as_fuzzylite, shapes_of_fuzzylite
from leadscrew.fuzzy.formats.losses import Saying, integrated, uses
from leadscrew.fuzzy.formats.place import Source, plain
from leadscrew.fuzzy.formats.vocabulary import (
    DUALS,
    FCL_METHODS,
    FCL_S_NORMS,
    FCL_T_NORMS,
    FLL_SHAPES,
    NO_SHAPE,
    class_term,
    class_text,
    first_name,
)
from leadscrew.fuzzy.rules_text import Cursor, Names, Token, read_number, read_rule, rule_text
from leadscrew.fuzzy.system import WEIGHTED, And, Input, Or, Output, Rule, RuleBlock, System, Term, Variable
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import DataError

POINTS = "points"
_HEIGHTS = {"ramp": (0.0, 1.0), "triangle": (0.0, 1.0, 0.0), "trapezoid": (0.0, 1.0, 1.0, 0.0)}
"""The shapes that are written as points, by the heights of their points."""
_JFUZZY: dict[str, tuple[str, int]] = {
    "trian": ("triangle", 3),
    "trape": ("trapezoid", 4),
    "gauss": ("gaussian", 2),
    "gauss2": ("gaussian_product", 4),
    "gbell": ("bell", 3),
    "sigm": ("sigmoid", 2),
    "dsigm": ("sigmoid_difference", 4),
    "cosine": ("cosine", 2),
    "singletons": ("singleton", 2),
}


@dataclass(frozen=True)
class Given:
    """A term as it stands in the file; ``kind`` is empty for a mere number."""

    name: str
    at: Token
    kind: str
    numbers: tuple[float, ...]


def given_term(cursor: Cursor) -> Given:
    """The term after the word TERM."""
    name = cursor.take()
    if not name.is_name or not name.text[:1].replace("_", "a").isalnum():
        cursor.fail("the name of a term", name)
    cursor.expect(":=")
    at = cursor.token
    kind, numbers = "", []
    if at.text == "(":
        kind = POINTS
    elif read_number(at.text) is None:
        kind = cursor.take().text
        if kind in NO_SHAPE or kind.casefold() == "function":
            cursor.refuse(f"a {kind} is {NO_SHAPE.get(kind, NO_SHAPE['Function'])}", at)
    if kind == POINTS or kind.casefold() == "singletons":
        numbers = _points(cursor)
    else:
        while (number := read_number(cursor.token.text)) is not None:
            numbers.append(number)
            cursor.take()
    if cursor.token.text != ";":
        cursor.fail("a number or ';'" if kind != POINTS else "'(' or ';'")
    cursor.take()
    return Given(name.text, at, kind, tuple(numbers))


def _points(cursor: Cursor) -> list[float]:
    numbers: list[float] = []
    while cursor.skip("("):
        for end in (",", ")"):
            number = read_number(cursor.token.text)
            if number is None:
                cursor.fail("a number")
            numbers.append(number)
            cursor.take()
            cursor.expect(end)
    return numbers


def term_of(source: Source, given: Given, weighted: bool, inputs: int) -> Term:
    """The term that is meant; of an output whose defuzzifier is ``weighted``, a number is a constant."""
    name, kind, numbers, at = given.name, given.kind, list(given.numbers), given.at
    with source.at(at.line, at.column):
        if not kind:
            if len(numbers) != 1:
                source.fail(at.line, at.column, f"expected one number, found {len(numbers)}")
            return Term(name, "constant" if weighted else "singleton", tuple(numbers))
        if kind == POINTS:
            return _polyline(name, numbers)
        if kind not in FLL_SHAPES and kind.casefold() in _JFUZZY:
            return _of_jfuzzylogic(source, given, kind.casefold(), numbers)
        if kind not in FLL_SHAPES and (same := [k for k in FLL_SHAPES if k.casefold() == kind.casefold()]):
            kind = same[0]
        if kind not in FLL_SHAPES:
            hint = nearest(kind, [*FLL_SHAPES, *_JFUZZY])
            source.fail(at.line, at.column, f"expected a shape{hint}, found {kind!r}")
        if kind == "Linear" and len(numbers) != inputs + 1:
            wanted = f"{inputs + 1} numbers (one for each input and a constant)"
            source.fail(at.line, at.column, f"expected {wanted}, found {len(numbers)}")
        return class_term(name, kind, numbers)


def _polyline(name: str, numbers: list[float]) -> Term:
    """Points as the shape that they are: a ramp, a triangle, a trapezoid, or a polyline."""
    xs, ys = tuple(numbers[::2]), tuple(numbers[1::2])
    if all(a < b for a, b in itertools.pairwise(xs)):
        if ys == (1.0, 0.0):
            return Term(name, "ramp", (xs[1], xs[0]))
        for shape, heights in _HEIGHTS.items():
            if ys == heights:
                return Term(name, shape, xs)
    return Term(name, "discrete", tuple(numbers))


def _of_jfuzzylogic(source: Source, given: Given, kind: str, numbers: list[float]) -> Term:
    shape, count = _JFUZZY[kind]
    if len(numbers) != count:
        what = "one point: more singletons than one are no shape here" if kind == "singletons" else f"{count} numbers"
        source.fail(given.at.line, given.at.column, f"expected {what}, found {len(numbers)} numbers")
    height = 1.0
    if kind == "gbell":
        numbers = [numbers[2], numbers[0], numbers[1]]
    elif kind == "sigm":
        numbers = [numbers[1], numbers[0]]
    elif kind == "dsigm":
        numbers = [numbers[1], numbers[0], numbers[2], numbers[3]]
    elif kind == "cosine":
        numbers = [numbers[1], 2.0 * numbers[0]]
    elif kind == "singletons":
        numbers, height = [numbers[0]], numbers[1]
    return Term(given.name, shape, tuple(numbers), height)


def term_text(term: Term) -> str:
    """A term as it is written: a number, points where they say it all, else fuzzylite's name and numbers."""
    xs = term.parameters
    if term.shape in ("constant", "singleton"):
        return plain(xs[0])
    if term.shape == "discrete" and term.height == 1.0:
        return _point_text(xs[::2], xs[1::2])
    ends, ys = xs, _HEIGHTS.get(term.shape, ())
    if term.shape == "ramp" and xs[1] < xs[0]:
        ends, ys = xs[::-1], (1.0, 0.0)
    rising = all(-1e300 < a < b < 1e300 for a, b in itertools.pairwise(ends))
    return _point_text(ends, ys) if ys and rising and term.height == 1.0 else class_text(term)


def _point_text(xs: tuple[float, ...], ys: tuple[float, ...]) -> str:
    return " ".join(f"({plain(x)}, {plain(y)})" for x, y in zip(xs, ys, strict=True))


_TOKEN = re.compile(
    r"(?P<space>\s+)"
    r"|(?P<line>//[^\r\n]*)"
    r"|(?P<open>\(\*|/\*)"
    r"|(?P<number>[+-]?(?:[0-9]+(?:\.(?!\.)[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?(?!\w)|[+-](?:inf|nan)(?!\w))"
    r"|(?P<word>\w+(?:\.\w+)*)"
    r"|(?P<sign>:=|\.\.|<=|>=|==|!=|[^\s\w])"
)
_FOR_BLOCKS = "function_block var_input var_output var fuzzify defuzzify ruleblock"
_FOR_ITEMS = "rule term range method accu act default enabled lock lock_previous lock_range"
KEYWORDS = frozenset((*_FOR_BLOCKS.split(), *(f"end_{word}" for word in _FOR_BLOCKS.split()), *_FOR_ITEMS.split()))
"""Words that are no names in this format, beside those of the rules."""


def tokens(source: Source) -> list[Token]:
    """The tokens of a text, comments left out, an empty one last.

    Raises:
        DataError: a comment is never closed.
    """
    text = source.text
    starts = [0, *(match.end() for match in re.finditer(r"\r\n|\r|\n", text))]
    row: list[Token] = []
    at = 0

    def token(body: str, position: int) -> Token:
        line = bisect_right(starts, position)
        return Token(body, line, position - starts[line - 1] + 1)

    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            source.fail(*_place(token("", at)), f"expected a word or a number, found {text[at]!r}")
        kind = match.lastgroup
        at = match.end()
        if kind == "open":
            close = "*)" if match[0] == "(*" else "*/"
            end = text.find(close, at)
            if end < 0:
                source.fail(*_place(token("", match.start())), f"expected {close} to close the comment")
            at = end + 2
        elif kind not in ("space", "line"):
            row.append(token(match[0], match.start()))
    row.append(token("", len(text)))
    return row


def _place(token: Token) -> tuple[int, int]:
    return token.line, token.column


_BLOCKS = ("var_input", "var_output", "fuzzify", "defuzzify", "ruleblock", "end_function_block")
_RULE_ITEMS = ("and", "or", "act", "accu", "enabled", "rule", "end_ruleblock")


@dataclass
class _Draft:
    """A variable, while its blocks are read."""

    name: str
    at: Token
    limits: tuple[float, float] | None = None
    terms: list[Given] = field(default_factory=list)
    enabled: bool = True
    method: str | None = None
    accumulation: str | None = None
    default: float = float("nan")
    locks: set[str] = field(default_factory=set)
    described: bool = False


@dataclass
class _RuleDraft:
    name: str
    at: Token
    norms: dict[str, str] = field(default_factory=dict)
    accumulation: tuple[str, Token] | None = None
    rules: list[Rule] = field(default_factory=list)
    enabled: bool = True


class _Reading:
    def __init__(self, source: Source, leave_out: bool) -> None:
        self.source = source
        self.leave_out = leave_out
        self.notes: list[str] = []
        self.cursor = Cursor(tokens(source), source.name)
        self.inputs: dict[str, _Draft] = {}
        self.outputs: dict[str, _Draft] = {}
        self.blocks: list[_RuleDraft] = []

    def number(self) -> float:
        token = self.cursor.take()
        number = read_number(token.text)
        if number is None:
            self.cursor.fail("a number", token)
        return number

    def name(self, what: str) -> Token:
        if not self.cursor.token.is_name or not self.cursor.token.text.replace(".", "_").isidentifier():
            self.cursor.fail(what)
        return self.cursor.take()

    def title(self, head: Token, stop: tuple[str, ...]) -> str:
        """The words after a head, on its line and before the first keyword."""
        words = []
        while self.cursor.token.text and self.cursor.token.line == head.line and self.cursor.token.key not in stop:
            words.append(self.cursor.take().text)
        return " ".join(words)

    def assign(self) -> None:
        self.cursor.expect(":=", ":")

    def flag(self) -> bool:
        self.assign()
        value = self.cursor.expect("true", "false").key == "true"
        self.cursor.expect(";")
        return value

    def choice(self, known: dict[str, str], what: str) -> str:
        self.assign()
        token = self.cursor.take()
        found = next((value for name, value in known.items() if name.casefold() == token.key), None)
        if found is None:
            self.cursor.refuse(
                f"expected {what}{nearest(token.text.upper(), list(known))}, found {token.text!r}", token
            )
        self.cursor.expect(";")
        return found

    def limits(self) -> tuple[float, float]:
        start = self.cursor.expect("(")
        low = self.number()
        self.cursor.expect("..")
        high = self.number()
        self.cursor.expect(")")
        self.cursor.expect(";")
        if not low < high:
            self.cursor.refuse(f"expected a range whose low end is below its high, found {low} .. {high}", start)
        return low, high


def loads(text: str, name: str = "text.fcl", leave_out_unknown: bool = False) -> System:
    """The system of a ``.fcl`` text; errors speak of it as ``name``. ``leave_out_unknown`` leaves out rules that name
    what does not exist, and says so in the notes.

    Raises:
        DataError: it is broken; says line, column and what was expected.
    """
    reading = _Reading(Source(text, name), leave_out_unknown)
    cursor = reading.cursor
    head = cursor.expect("function_block")
    title = reading.title(head, _BLOCKS)
    rule_blocks: list[tuple[Token, int]] = []
    while (block := cursor.expect(*_BLOCKS)).key != "end_function_block":
        if block.key == "ruleblock":
            rule_blocks.append((block, cursor.at))
            _pass_over(cursor)
        elif block.key in ("fuzzify", "defuzzify"):
            _read_variable(reading, block)
        else:
            _declare(reading, reading.inputs if block.key == "var_input" else reading.outputs)
    if cursor.token.text:
        cursor.fail("the end, after one FUNCTION_BLOCK")
    for block, cursor.at in rule_blocks:
        _read_rules(reading, block)
    inputs = [_input(reading, draft) for draft in reading.inputs.values()]
    outputs = [_output(reading, draft, inputs) for draft in reading.outputs.values()]
    integral = {output.name for output in outputs if output.defuzzifier not in WEIGHTED}
    outputs = integrated(reading.source, outputs)
    blocks = [_rule_block(reading, draft, integral) for draft in reading.blocks]
    with reading.source.at(1, 1):
        return System(title, tuple(inputs), tuple(outputs), tuple(blocks), notes=tuple(reading.notes))


def _pass_over(cursor: Cursor) -> None:
    """Passes over a rule block, which is read when all variables are known."""
    while cursor.token.text and cursor.token.key != "end_ruleblock":
        cursor.take()
    cursor.expect("end_ruleblock")


def _declare(reading: _Reading, drafts: dict[str, _Draft]) -> None:
    cursor = reading.cursor
    last: _Draft | None = None
    while not cursor.skip("end_var"):
        if cursor.token.key == "range" and last:
            cursor.take()
            reading.assign()
            last.limits = reading.limits()
            continue
        token = reading.name("a variable or END_VAR")
        if token.text in reading.inputs or token.text in reading.outputs:
            cursor.refuse(f"a second variable {token.text!r}", token)
        last = drafts[token.text] = _Draft(token.text, token)
        cursor.expect(":")
        reading.name("a type such as REAL")
        if cursor.token.text == "(":
            last.limits = reading.limits()
            continue
        if cursor.skip(":="):
            last.default = reading.number()
        cursor.expect(";")


def _read_variable(reading: _Reading, block: Token) -> None:
    cursor = reading.cursor
    token = reading.name("a variable")
    drafts, section = (reading.inputs, "VAR_INPUT") if block.key == "fuzzify" else (reading.outputs, "VAR_OUTPUT")
    if token.text not in drafts:
        hint = nearest(token.text, list(drafts))
        cursor.refuse(f"expected a variable of {section}{hint}, found {token.text!r}", token)
    draft = drafts[token.text]
    if draft.described:
        cursor.refuse(f"a second {block.text} {token.text}", token)
    draft.described = True
    output = ("method", "accu", "default", "lock", "lock_previous", "lock_range") if block.key == "defuzzify" else ()
    while (item := cursor.expect("term", "range", "enabled", *output, f"end_{block.key}")).key != f"end_{block.key}":
        if item.key == "term":
            draft.terms.append(given_term(cursor))
        elif item.key == "range":
            reading.assign()
            draft.limits = reading.limits()
        elif item.key == "enabled":
            draft.enabled = reading.flag()
        elif item.key == "method":
            draft.method = reading.choice(FCL_METHODS, "a METHOD")
        elif item.key == "accu":
            draft.accumulation = reading.choice(FCL_S_NORMS, "an ACCU")
        elif item.key == "default":
            _default(reading, draft)
        elif item.key == "lock":
            reading.assign()
            draft.locks.add(cursor.expect("previous", "range").key)
            while cursor.skip("|"):
                draft.locks.add(cursor.expect("previous", "range").key)
            cursor.expect(";")
        elif reading.flag():
            draft.locks.add(item.key.removeprefix("lock_"))


def _default(reading: _Reading, draft: _Draft) -> None:
    reading.assign()
    if reading.cursor.skip("nc"):
        draft.locks.add("previous")
    else:
        draft.default = reading.number()
        if reading.cursor.skip("|"):
            reading.cursor.expect("nc")
            draft.locks.add("previous")
    reading.cursor.expect(";")


def _read_rules(reading: _Reading, head: Token) -> None:
    cursor = reading.cursor
    draft = _RuleDraft(reading.title(head, _RULE_ITEMS), head)
    names = Names(
        {n: [t.name for t in d.terms] for n, d in (reading.inputs | reading.outputs).items()},
        {n: [t.name for t in d.terms] for n, d in reading.outputs.items()},
        any_case=True,
    )
    known = {"and": FCL_T_NORMS, "or": FCL_S_NORMS, "act": FCL_T_NORMS, "accu": FCL_S_NORMS}
    while (item := cursor.expect(*_RULE_ITEMS)).key != "end_ruleblock":
        if item.key == "enabled":
            draft.enabled = reading.flag()
        elif item.key == "accu":
            draft.accumulation = (reading.choice(FCL_S_NORMS, "an ACCU"), item)
        elif item.key != "rule":
            draft.norms[item.key] = reading.choice(known[item.key], f"a norm for {item.text}")
        else:
            while cursor.token.text and cursor.token.text != ":":
                cursor.take()
            cursor.expect(":")
            rule, trouble = read_rule(cursor, names)
            cursor.skip(";")
            if not trouble:
                draft.rules.append(rule)
            elif reading.leave_out:
                reading.notes.append(f"{trouble}: the rule is left out: {rule_text(rule)}")
            else:
                raise DataError(trouble)
    reading.blocks.append(draft)


def _common(reading: _Reading, draft: _Draft, terms: list[Term], others: list[Input]) -> dict[str, Any]:
    limits = draft.limits
    if limits is None:
        limits = hull([extent(term, [(v.low, v.high) for v in others]) for term in terms])
        reading.notes.append(f"{draft.name} has no RANGE: {limits[0]:g} to {limits[1]:g}, from its terms")
    return {
        "name": draft.name,
        "low": limits[0],
        "high": limits[1],
        "terms": tuple(terms),
        "enabled": draft.enabled,
        "lock_range": "range" in draft.locks,
    }


def _input(reading: _Reading, draft: _Draft) -> Input:
    terms = [term_of(reading.source, given, weighted=False, inputs=len(reading.inputs)) for given in draft.terms]
    with reading.source.at(draft.at.line, draft.at.column):
        return Input(**_common(reading, draft, terms, []))


def _output(reading: _Reading, draft: _Draft, inputs: list[Input]) -> Output:
    numbers = all(given.kind in ("", "Constant", "Linear") for given in draft.terms)
    defuzzifier = draft.method
    if defuzzifier is None:
        defuzzifier = "weighted_average" if numbers else "centroid"
        reading.notes.append(f"{draft.name} has no METHOD: {'COGS' if numbers else 'COG'}")
    weighted = defuzzifier in WEIGHTED
    terms = [term_of(reading.source, given, weighted, len(reading.inputs)) for given in draft.terms]
    with reading.source.at(draft.at.line, draft.at.column):
        return Output(
            **_common(reading, draft, terms, inputs),
            aggregation=_accumulation(reading, draft, weighted),
            defuzzifier=defuzzifier,
            default=draft.default,
            lock_previous="previous" in draft.locks,
        )


def _accumulation(reading: _Reading, draft: _Draft, weighted: bool) -> str | None:
    """The ACCU of an output: its own, that of the rule blocks that conclude about it, or the usual one."""
    if draft.accumulation:
        return draft.accumulation
    found = ""
    for block in reading.blocks:
        if block.accumulation and any(there.variable == draft.name for r in block.rules for there in r.consequents):
            norm, token = block.accumulation
            if found and found != norm:
                reading.cursor.refuse(f"another ACCU for {draft.name} than in the rule block before", token)
            found = norm
    if weighted:
        return None
    if not found:
        reading.notes.append(f"{draft.name} has no ACCU: MAX")
    return found or "maximum"


def _rule_block(reading: _Reading, draft: _RuleDraft, integral: set[str]) -> RuleBlock:
    conjunction, disjunction = draft.norms.get("and"), draft.norms.get("or")
    implication = draft.norms.get("act")
    title = f"rule block {draft.name}".rstrip()
    block = RuleBlock(tuple(draft.rules))
    if conjunction is None and uses(block, And):
        pairs = {s: t for t, s in DUALS.items()}
        conjunction = pairs.get(disjunction or "", "minimum")
        reading.notes.append(f"{title} has no AND: {conjunction}")
    if disjunction is None and uses(block, Or):
        disjunction = DUALS[conjunction or "minimum"]
        reading.notes.append(f"{title} has no OR: {disjunction}, which De Morgan's law pairs with its AND")
    if implication is None and any(c.variable in integral for rule in draft.rules for c in rule.consequents):
        implication = "minimum"
        reading.notes.append(f"{title} has no ACT: MIN")
    return RuleBlock(tuple(draft.rules), draft.name, conjunction, disjunction, implication, enabled=draft.enabled)


_NAME = rf"(?!(?i:{'|'.join(KEYWORDS)}|inf|nan)\Z)[A-Za-z_][A-Za-z0-9_]*"
_TITLE = r"[A-Za-z_][A-Za-z0-9_]*(?: [A-Za-z0-9_]+)*"


def dumps(system: System, notes: list[str] | None = None) -> str:
    """A system as ``.fcl`` text; ``notes`` collects what was left out without an effect on outputs.

    Raises:
        ValueRefused: the format cannot express the system; names what.
    """
    saying = Saying("fcl")
    system = saying.named(rules_as_fuzzylite(saying, saying.without_disabled_rules(system)), _NAME)
    saying.units_and_docs(system, docs=True)
    shapes_of_fuzzylite(saying, system)
    lines = [f"// {comment}" for comment in saying.integration(system, "midpoint", 100)]
    lines += [f"FUNCTION_BLOCK {_title(saying, system.name)}".rstrip(), ""]
    for section, variables in (("VAR_INPUT", system.inputs), ("VAR_OUTPUT", system.outputs)):
        lines += [section, *(f"  {variable.name}: REAL;" for variable in variables), "END_VAR", ""]
    for input in system.inputs:
        if input.lock_range:
            saying.refuse(f"input {input.name}: that it is held inside its universe")
        lines += [f"FUZZIFY {input.name}", *_common_lines(saying, input, "constant"), "END_FUZZIFY", ""]
    for output in system.outputs:
        no = "singleton" if output.defuzzifier in WEIGHTED else "constant"
        lines += [
            f"DEFUZZIFY {output.name}",
            *_common_lines(saying, output, no),
            f"  METHOD : {first_name(FCL_METHODS, output.defuzzifier)};",
        ]
        if output.aggregation:
            lines.append(f"  ACCU : {first_name(FCL_S_NORMS, output.aggregation)};")
        lines.append(f"  DEFAULT := {plain(output.default)}{' | NC' if output.lock_previous else ''};")
        if output.lock_range:
            lines.append(f"  LOCK : RANGE{' | PREVIOUS' if output.lock_previous else ''};")
        lines += ["END_DEFUZZIFY", ""]
    for block in system.blocks:
        lines += [*_rule_block_lines(saying, block), ""]
    lines.append("END_FUNCTION_BLOCK")
    if notes is not None:
        notes += saying.notes
    return "\n".join(lines) + "\n"


def _title(saying: Saying, name: str, between: str = " ") -> str:
    """A name of a block of which every word can stand in the file (of a rule block, one word: fuzzylite takes one)."""
    words = [re.sub(r"\W", "_", word, flags=re.ASCII) for word in name.split()]
    words = [f"{word}_" if word.casefold() in (*KEYWORDS, "and", "or") else word for word in words]
    title = between.join(words)
    title = title if re.fullmatch(_TITLE, title) or not title else f"_{title}"
    if title != name:
        saying.note(f"{name!r} is called {title!r} in the file")
    return title


def _common_lines(saying: Saying, variable: Variable, no: str) -> list[str]:
    """Range and terms; a number is a constant where the defuzzifier is weighted and else a singleton: ``no`` is the
    shape that it cannot be here.
    """
    for term in variable.terms:
        if term.shape == no or (term.shape == "singleton" and term.height != 1.0):
            saying.refuse(f"{variable.name}, term {term.name}: a {term.shape}")
    return [
        *([] if variable.enabled else ["  ENABLED : FALSE;"]),
        f"  RANGE := ({plain(variable.low)} .. {plain(variable.high)});",
        *(f"  TERM {term.name} := {term_text(term)};" for term in variable.terms),
    ]


def _rule_block_lines(saying: Saying, block: RuleBlock) -> list[str]:
    if block.activation != "general":
        saying.refuse(f"rule block {block.name!r}: activation {block.activation}")
    lines = [f"RULEBLOCK {_title(saying, block.name, '_')}".rstrip()]
    if not block.enabled:
        lines.append("  ENABLED : FALSE;")
    for key, norm, known in (
        ("AND", block.conjunction, FCL_T_NORMS),
        ("OR", block.disjunction, FCL_S_NORMS),
        ("ACT", block.implication, FCL_T_NORMS),
    ):
        if norm:
            lines.append(f"  {key} : {first_name(known, norm)};")
    lines += [f"  RULE {k} : {rule_text(rule, str)};" for k, rule in enumerate(block.rules, start=1)]
    return [*lines, "END_RULEBLOCK"]
