"""What all readers and writers of files share: places in a text, numbers."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

from leadscrew.util import reading
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

LARGEST, LINES = 2_000_000, 50_000
"""Longer texts are refused: no fuzzy system is that long."""


class Source:
    """A text and the name under which errors speak of it."""

    def __init__(self, text: str, name: str) -> None:
        reading.check(Path(name), len(text), LARGEST, "fuzzy systems")
        self.text = text
        self.name = name
        self.lines = re.split(r"\r\n|\r|\n", text)
        reading.check_count(name, len(self.lines), LINES, "lines", "leave out what repeats")

    def fail(self, line: int, column: int, sentence: str) -> NoReturn:
        """Raises DataError: file, line, column and a sentence."""
        raise DataError(f"{self.name}:{line}:{column}: {sentence}")

    @contextmanager
    def at(self, line: int, column: int) -> Iterator[None]:
        """What the data model refuses in here becomes a DataError with this place."""
        try:
            yield
        except (ValueRefused, NameUnknown) as error:
            self.fail(line, column, str(error))


def plain(number: float) -> str:
    """A number in the fewest digits that give it back; infinity as ``inf``, which all programs read."""
    return repr(float(number))


def load(path: str | Path) -> tuple[str, str]:
    """The text of a file, and a sentence where it is not UTF-8.

    Raises:
        DataError: it cannot be read, or holds binary data.
    """
    data = reading.data(Path(path), LARGEST, "fuzzy systems")
    try:
        text, note = reading.decoded(data)
    except UnicodeDecodeError as problem:
        raise DataError(f"{path}:1:1: expected UTF-16 text, by its first two bytes (byte {problem.start})") from None
    if "\0" in text:
        raise DataError(f"{path}:1:1: expected text, found binary data")
    return text, note and f"the file {note}"
