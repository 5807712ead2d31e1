"""The tokens of IEC 61131-7 text (``.fcl``), and its keywords."""

from __future__ import annotations

import re
from bisect import bisect_right

from leadscrew.fuzzy.formats.place import Source
from leadscrew.fuzzy.rules_text import Token

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
