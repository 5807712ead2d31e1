"""Reads IEC 61131-7 fuzzy control language, ``.fcl``, in the dialects of fuzzylite and jFuzzyLogic."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from leadscrew.fuzzy.formats.extent import extent, hull
from leadscrew.fuzzy.formats.fcl_terms import Given, given_term, term_of
from leadscrew.fuzzy.formats.fcl_text import tokens
from leadscrew.fuzzy.formats.place import Source
from leadscrew.fuzzy.formats.said import integrated, uses
from leadscrew.fuzzy.formats.vocabulary import DUALS, FCL_METHODS, FCL_S_NORMS, FCL_T_NORMS
from leadscrew.fuzzy.rules_text import Cursor, Names, Token, read_number, read_rule, rule_text
from leadscrew.fuzzy.system import WEIGHTED, And, Input, Or, Output, Rule, RuleBlock, System, Term
from leadscrew.kernel.errors import DataError
from leadscrew.kernel.sheet import nearest

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
