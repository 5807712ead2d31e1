"""XML as a tree whose elements know their line and column."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NoReturn
from xml.parsers import expat

from leadscrew.fuzzy.formats.place import Source

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
