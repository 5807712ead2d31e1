r"""Foreign text in each language that we write: names, titles, units, notes and paths stay data there.

Foreign is what a user, a file or a docstring gives. Whatever it holds, the result ends no comment, string, cell or
element, starts no command, and can be encoded as UTF-8. Text without such characters comes back as it is.
"""

from __future__ import annotations

import re
import shlex
import unicodedata
from html import escape as _html

from leadscrew.util.errors import ValueRefused

LONGEST_NAME = 1000

_INVISIBLE = r"[\x00-\x08\x0b\x0c\x0e-\x1a\x1c-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]"
_COLOUR = r"\[(?:[0-2]|22|39|3[0-7]|9[0-7])?(?:;(?:[0-2]|22|39|3[0-7]|9[0-7]))*m"
"""Bold, dim and the foreground colours that tables are printed in."""
_CONTROL = re.compile(rf"\x1b|\r(?!\n)|{_INVISIBLE}")
_CONTROL_BUT_COLOUR = re.compile(rf"\x1b(?!{_COLOUR})|\r(?!\n)|{_INVISIBLE}")
_ACTIVE_COMMENT = re.compile(
    r"(\s*(?:msg|debug|print|log|logopen|logappend|logclose|probeopen|probeclose|py|pyrun|pyreload|abort)\s*),", re.I
)
_LONGEST_COMMENT = 240
"""A line of a LinuxCNC program has 255 characters."""


def checked_line(what: str, name: str, longest: int = LONGEST_NAME) -> str:
    """A name or title: one line of printable characters.

    Raises:
        ValueRefused: it is longer, or holds a line end, a control or a bidirectional character.
    """
    if not isinstance(name, str) or len(name) > longest or not name.isprintable():
        shown = f"{name[:40]!r}..." if isinstance(name, str) and len(name) > 40 else repr(name)
        raise ValueRefused(f"{what} = {shown}: expected one line of printable characters, {longest} at most")
    return name


# ---- plain text
def one_line(text: str) -> str:
    """For a comment up to the end of the line (CSV, HAL, TOML, Python) and for messages: printable, single spaces."""
    return " ".join(_printable(text).split())


def visible(text: str) -> str:
    r"""For XML writers that escape markup themselves: control and bidirectional characters as ``\x1b``; lines stay."""
    return _CONTROL.sub(_code, text)


def terminal(text: str) -> str:
    """For a terminal: as :func:`visible`, but the colours of tables stay."""
    return _CONTROL_BUT_COLOUR.sub(_code, text)


def figure(text: str) -> str:
    """For a text in a figure of Matplotlib: a dollar sign starts no formula."""
    return visible(text).replace("$", r"\$")


def file_name(text: str) -> str:
    """For a part of a file name: letters, digits, dot, dash, underscore; no hidden file, 150 characters at most."""
    return re.sub(r"^\.+|[^\w.-]+", "_", text)[:150]


# ---- pages
def html(text: str) -> str:
    """For text and quoted attributes of HTML."""
    return _html(visible(text))


def markdown(text: str) -> str:
    """For a name in a line or table cell of Markdown."""
    text = re.sub(r"([\\`*\[\]<|$])|(?<!\w)(_)|(_)(?!\w)|(~)(?=~)", lambda m: f"\\{m[0]}", one_line(text))
    return re.sub(r"&(?=#|\w+;)", "&amp;", text)


def markdown_doc(text: str, cell: bool = False) -> str:
    """For a docstring in Markdown, whose marks stay: no HTML, no images; ``cell``: on one line, for a table."""
    text = re.sub(r"<(?=[A-Za-z/!?])|(?<=!)\[", lambda m: f"\\{m[0]}", visible(text))
    return one_line(text).replace("|", r"\|") if cell else text


def markdown_code(text: str) -> str:
    """A code span of Markdown, with its backticks."""
    text = one_line(text)
    runs = [len(run) for run in re.findall("`+", text)]
    fence = "`" * (1 + max(runs, default=0))
    space = " " if runs else ""
    return f"{fence}{space}{text}{space}{fence}"


# ---- C and HAL
def c_comment(text: str) -> str:
    """For a comment of C: nothing that ends it or joins its lines; a line end becomes a space."""
    text = _printable(text.replace("``", "")).replace("??/", "?? /")
    return text.replace("*/", "* /").replace("/*", "/ *")


def c_string(text: str) -> str:
    """For a string of C, between its quotes."""
    return re.sub(r'[\\"]|(?<=\?)\?', lambda m: f"\\{m[0]}", one_line(text))


def c_format(text: str) -> str:
    """For a format of ``printf``, between its quotes."""
    return c_string(text).replace("%", "%%")


def hal_string(text: str) -> str:
    """For a string of halcompile, which knows no escapes: ASCII, a quote becomes an apostrophe."""
    plain = one_line(text).replace("µ", "u").replace("μ", "u").replace('"', "'").replace("\\", "/")
    plain = unicodedata.normalize("NFKD", plain).encode("ascii", "replace").decode()
    return " ".join(plain.replace("??/", "?? /").split())


# ---- G-code, Python, shell, TOML
def gcode_comment(text: str) -> str:
    """For a comment of G-code, between its parentheses: ASCII, no comment that a control executes, no line too long."""
    text = text.replace("(", "[").replace(")", "]")
    text = "".join(c if c.isprintable() and c.isascii() else "?" for c in text)
    text = _ACTIVE_COMMENT.sub(r"\1;", text, count=1) if _ACTIVE_COMMENT.match(text) else text
    return text if len(text) <= _LONGEST_COMMENT else f"{text[: _LONGEST_COMMENT - 3]}..."


def python_docstring(text: str) -> str:
    """For a docstring of Python, between its quotes."""
    return re.sub(r'[\\"]', lambda m: f"\\{m[0]}", one_line(text))


def shell(text: object) -> str:
    """For one word of a command, such as a path, to be copied into a POSIX shell."""
    return shlex.quote(str(text))


def toml_string(text: str) -> str:
    """A basic string of TOML, with its quotes; reads back as the same text.

    Raises:
        ValueRefused: half of a surrogate pair, as names of files that are no UTF-8 have it.
    """
    if re.search(r"[\ud800-\udfff]", text):
        raise ValueRefused(f"{visible(text)!r} cannot be written as TOML: it is no Unicode text; rename it")
    text = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\U{ord(c):08X}" for c in text) + '"'


def toml_key(key: str, dotted: bool = True) -> str:
    """A key of TOML: bare where that can be; ``dotted``: identifiers with dots between them name nested tables."""
    bare = re.fullmatch(r"[A-Za-z0-9_-]+", key, re.ASCII)
    nested = dotted and all(part.isidentifier() and part.isascii() for part in key.split("."))
    return key if bare or nested else toml_string(key)


def _printable(text: str) -> str:
    return "".join(c if c.isprintable() else " " for c in text)


def _code(found: re.Match[str]) -> str:
    return repr(found[0])[1:-1]
