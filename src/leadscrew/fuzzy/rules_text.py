"""Rules as text: ``if service is poor or (food is very rancid and mood is any) then tip is cheap with 0.5``.

Keywords (``if is not and or then with``) and hedges in any case; ``and`` binds closer than ``or``; several consequents
with ``and`` or a comma; ``x is not y`` and ``not x is y`` mean the same; a name that is no plain word stands in quotes.
A table of two inputs is read by :func:`table`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NoReturn

from leadscrew.fuzzy.system import HEDGES, And, Antecedent, Is, Or, Rule, System, Variable
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import DataError, entry_point

__all__ = ["Cursor", "Names", "Token", "parse", "quoted", "read_number", "read_rule", "rule_text", "table", "tokens"]

KEYWORDS = ("if", "is", "and", "or", "then", "with")
RESERVED = frozenset((*KEYWORDS, *HEDGES))
"""Words that are no names, unless they stand in quotes."""
MOST_PROPOSITIONS = 250
DEEPEST = 60
_TOKEN = re.compile(
    r"""\s*(?:(?P<sign>[(),;])|"(?P<double>(?:[^"]|"")*)"|'(?P<single>(?:[^']|'')*)'|(?P<word>[^\s(),;"']+))"""
)
_NUMBER = re.compile(r"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|inf|nan)", re.IGNORECASE | re.ASCII)


@dataclass(frozen=True, slots=True)
class Token:
    """A word, a sign or a quoted name, and where it stands; the end of the text is an empty one."""

    text: str
    line: int
    column: int
    quoted: bool = False

    @property
    def key(self) -> str:
        """The text in small letters; empty where it is quoted, so that it is never taken for a keyword."""
        return "" if self.quoted else self.text.casefold()

    @property
    def is_name(self) -> bool:
        """It can name a variable or a term."""
        return self.quoted or (self.text not in ("", "(", ")", ",", ";") and self.key not in RESERVED)


@dataclass(frozen=True)
class Names:
    """The names that rules may use: of variables, each with its terms."""

    antecedent: Mapping[str, Sequence[str]]
    consequent: Mapping[str, Sequence[str]]
    any_case: bool = False
    """A name in other letters is taken too, where only one fits (IEC 61131-3: case does not count)."""

    @classmethod
    def of(cls, inputs: Sequence[Variable], outputs: Sequence[Variable], any_case: bool = False) -> Names:
        """The names of variables."""
        there = {v.name: [t.name for t in v.terms] for v in outputs}
        return cls({**{v.name: [t.name for t in v.terms] for v in inputs}, **there}, there, any_case)

    def find(self, name: str, known: Sequence[str]) -> str | None:
        """The known name that is meant."""
        if name in known or not self.any_case:
            return name if name in known else None
        fitting = [other for other in known if other.casefold() == name.casefold()]
        return fitting[0] if len(fitting) == 1 else None


class Cursor:
    """A place in a row of tokens."""

    def __init__(self, row: list[Token], where: str) -> None:
        self.row = row
        self.where = where
        self.at = 0

    @property
    def token(self) -> Token:
        """The token that comes next."""
        return self.row[self.at]

    def take(self) -> Token:
        """The next token, passed over."""
        token = self.row[self.at]
        self.at = min(self.at + 1, len(self.row) - 1)
        return token

    def fail(self, expected: str, token: Token | None = None) -> NoReturn:
        """Raises DataError: where, what was expected and what stands there."""
        token = token or self.token
        found = repr(token.text) if token.text or token.quoted else "the end"
        self.refuse(f"expected {expected}, found {found}", token)

    def refuse(self, sentence: str, token: Token | None = None) -> NoReturn:
        """Raises DataError with a sentence and its place."""
        token = token or self.token
        raise DataError(f"{self.where}:{token.line}:{token.column}: {sentence}")

    def expect(self, text: str, *others: str) -> Token:
        """The next token, which must be one of these words or signs."""
        if self.token.key not in (text, *others):
            self.fail(" or ".join(repr(x) for x in (text, *others)))
        return self.take()

    def skip(self, *texts: str) -> bool:
        """Passes over the next token where it is one of these."""
        if self.token.key not in texts or not self.token.text:
            return False
        self.take()
        return True


def read_number(text: str) -> float | None:
    """The number that a text is, ``inf`` and ``nan`` included; None where it is none."""
    return float(text) if _NUMBER.fullmatch(text) else None


def tokens(text: str, where: str = "rule", line: int = 1, column: int = 1) -> list[Token]:
    """The tokens of a text that starts at a line and column.

    Raises:
        DataError: a quote is never closed.
    """
    row: list[Token] = []
    at, start = 0, 1 - column
    while True:
        match = _TOKEN.match(text, at)
        end = match.end() if match else len(text)
        begin = match.start(match.lastgroup or 0) if match else at + len(text[at:]) - len(text[at:].lstrip())
        for position in range(at, begin):
            if text[position] == "\n":
                line, start = line + 1, position + 1
        if match is None:
            if begin < len(text):
                raise DataError(f"{where}:{line}:{begin - start + 1}: expected the quote {text[begin]} to be closed")
            row.append(Token("", line, len(text) - start + 1))
            return row
        kind = match.lastgroup or ""
        body = match[kind]
        if kind in ("double", "single"):
            mark = '"' if kind == "double" else "'"
            row.append(Token(body.replace(mark * 2, mark), line, begin - start, True))
            for position in range(begin, end):
                if text[position] == "\n":
                    line, start = line + 1, position + 1
        else:
            row.append(Token(body, line, begin - start + 1))
        at = end


@entry_point
def parse(
    text: str, names: Names | System | None = None, *, where: str = "rule", line: int = 1, column: int = 1
) -> Rule:
    """A rule from its text; ``names`` (or a system) checks that what it names exists.

    Raises:
        DataError: it is no rule, or names what does not exist; says ``where:line:column`` and what was expected.
    """
    cursor = Cursor(tokens(text, where, line, column), where)
    if isinstance(names, System):
        names = Names.of(names.inputs, names.outputs)
    rule, trouble = read_rule(cursor, names)
    cursor.skip(";")
    if cursor.token.text or cursor.token.quoted:
        cursor.fail("'and', 'with' or the end of the rule")
    if trouble:
        raise DataError(trouble)
    return rule


def read_rule(cursor: Cursor, names: Names | None = None) -> tuple[Rule, str]:
    """The rule at a cursor, and a sentence on the first name in it that does not exist (empty: all exist)."""
    reading = _Reading(cursor, names)
    cursor.expect("if")
    antecedent = reading.disjunction(0)
    cursor.expect("then")
    consequents = [reading.proposition(consequent=True)]
    while cursor.skip("and", ","):
        consequents.append(reading.proposition(consequent=True))
    weight = 1.0
    if cursor.skip("with"):
        token = cursor.take()
        number = None if token.quoted else read_number(token.text)
        if number is None or not 0.0 <= number <= 1.0:
            cursor.fail("a weight from 0 to 1", token)
        weight = number
    return Rule(antecedent, tuple(consequents), weight), reading.trouble


class _Reading:
    def __init__(self, cursor: Cursor, names: Names | None) -> None:
        self.cursor = cursor
        self.names = names
        self.trouble = ""
        self.count = 0

    def disjunction(self, depth: int) -> Antecedent:
        node = self.conjunction(depth)
        while self.cursor.skip("or"):
            node = Or(node, self.conjunction(depth))
        return node

    def conjunction(self, depth: int) -> Antecedent:
        node = self.factor(depth)
        while self.cursor.skip("and"):
            node = And(node, self.factor(depth))
        return node

    def factor(self, depth: int) -> Antecedent:
        cursor = self.cursor
        start = cursor.token
        if depth > DEEPEST:
            cursor.refuse(f"more than {DEEPEST} parentheses inside each other")
        if cursor.skip("not"):
            node = self.factor(depth + 1)
            if not isinstance(node, Is):
                cursor.refuse("'not' stands before one proposition only, not before several in parentheses", start)
            return Is(node.variable, node.term, ("not", *node.hedges))
        if cursor.skip("("):
            node = self.disjunction(depth + 1)
            cursor.expect(")")
            return node
        return self.proposition(consequent=False)

    def proposition(self, consequent: bool) -> Is:
        cursor = self.cursor
        self.count += 1
        if self.count > MOST_PROPOSITIONS:
            cursor.refuse(f"more than {MOST_PROPOSITIONS} propositions in a rule")
        variable = self.name("an output" if consequent else "a variable")
        cursor.expect("is")
        hedges = []
        while cursor.token.key in HEDGES:
            hedges.append(cursor.take().key)
        if len(hedges) > DEEPEST:
            cursor.refuse(f"more than {DEEPEST} hedges before a term")
        if hedges and hedges[-1] == "any" and not consequent and not cursor.token.is_name:
            return Is(self.known(variable, None, consequent)[0], "", tuple(hedges))
        term = self.name("a term")
        return Is(*self.known(variable, term, consequent), tuple(hedges))

    def name(self, what: str) -> Token:
        if not self.cursor.token.is_name:
            self.cursor.fail(what)
        return self.cursor.take()

    def known(self, variable: Token, term: Token | None, consequent: bool) -> tuple[str, str]:
        """The names of a proposition as the variables spell them; what does not exist is kept in ``trouble``."""
        text = term.text if term else ""
        if self.names is None:
            return variable.text, text
        there = self.names.consequent if consequent else self.names.antecedent
        name = self.names.find(variable.text, list(there))
        if name is None:
            what = "output" if consequent else "variable"
            self.unknown(variable, f"there is no {what} {variable.text!r}{nearest(variable.text, list(there))}")
            return variable.text, text
        if term is None:
            return name, ""
        terms = list(there[name])
        found = self.names.find(text, terms)
        if found is None:
            self.unknown(term, f"{name} has no term {text!r}{nearest(text, terms)}")
        return name, found or text

    def unknown(self, token: Token, sentence: str) -> None:
        self.trouble = self.trouble or f"{self.cursor.where}:{token.line}:{token.column}: {sentence}"


def quoted(name: str) -> str:
    """A name as it stands in a rule: in quotes where it is no plain word."""
    if name and name.casefold() not in RESERVED and not re.search(r"""[\s(),;"']""", name):
        return name
    return '"' + name.replace('"', '""') + '"'


def rule_text(rule: Rule, name: Callable[[str], str] = quoted) -> str:
    """A rule as text, which :func:`parse` reads back to an equal rule; ``name`` writes the names."""
    text = f"if {_antecedent(rule.antecedent, name)} then "
    text += " and ".join(_antecedent(there, name) for there in rule.consequents)
    return text if rule.weight == 1.0 else f"{text} with {rule.weight!r}"


def _antecedent(node: Antecedent, name: Callable[[str], str]) -> str:
    if isinstance(node, Is):
        return " ".join((name(node.variable), "is", *node.hedges, *([name(node.term)] if node.term else [])))
    parts: list[str] = []
    kind = type(node)
    left: Antecedent = node
    while isinstance(left, kind):
        parts.append(_inner(left.right, isinstance(left.right, Or if kind is Or else And | Or), name))
        left = left.left
    parts.append(_inner(left, kind is And and isinstance(left, Or), name))
    return f" {'and' if kind is And else 'or'} ".join(reversed(parts))


def _inner(node: Antecedent, parentheses: bool, name: Callable[[str], str]) -> str:
    return f"({_antecedent(node, name)})" if parentheses else _antecedent(node, name)


def table(
    text: str, rows: str, columns: str, output: str, names: Names | System | None = None, *, where: str = "table"
) -> tuple[Rule, ...]:
    """The rules ``if rows is R and columns is C then output is CELL`` of a table.

    The first line holds the terms of ``columns`` (with or without a word in the corner), each further line a term of
    ``rows`` and its cells; ``-`` is a cell without a rule.

    Raises:
        DataError: a line has too few or too many cells, a term stands twice or does not exist; says where.
    """
    if isinstance(names, System):
        names = Names.of(names.inputs, names.outputs)
    lines: list[list[Token]] = []
    for token in tokens(text, where)[:-1]:
        if not lines or lines[-1][0].line != token.line:
            lines.append([])
        lines[-1].append(token)
    if len(lines) < 2:
        raise DataError(f"{where}:1:1: expected a line of terms of {columns} and one line for each term of {rows}")
    head, body = lines[0], lines[1:]
    if len(head) == len(body[0]):
        head = head[1:]
    _no_twice(head, where)
    _no_twice([line[0] for line in body], where)
    rules = []
    for line in body:
        if len(line) != len(head) + 1:
            at = line[-1]
            wanted = f"expected {len(head)} cells after {line[0].text!r}, found {len(line) - 1}"
            raise DataError(f"{where}:{at.line}:{at.column}: {wanted}")
        for column, cell in zip(head, line[1:], strict=True):
            if cell.text == "-" and not cell.quoted:
                continue
            cursor = Cursor([cell], where)
            reading = _Reading(cursor, names)
            spelled = [
                reading.known(Token(variable, term.line, term.column, True), term, variable == output)
                for variable, term in ((rows, line[0]), (columns, column), (output, cell))
            ]
            if reading.trouble:
                raise DataError(reading.trouble)
            (r, c, o) = (Is(*pair) for pair in spelled)
            rules.append(Rule(And(r, c), (o,)))
    return tuple(rules)


def _no_twice(row: list[Token], where: str) -> None:
    seen: set[str] = set()
    for token in row:
        if token.text in seen:
            raise DataError(f"{where}:{token.line}:{token.column}: {token.text!r} is repeated")
        seen.add(token.text)
