"""What may reach a terminal: names in files are data, and no data moves its cursor, sets its title or hides text."""

from __future__ import annotations

import re
from typing import Any, TextIO

_COLOUR = r"\[(?:[0-2]|22|39|3[0-7]|9[0-7])?(?:;(?:[0-2]|22|39|3[0-7]|9[0-7]))*m"
"""Bold, dim and the foreground colours that tables are printed in."""
_PLAIN = r"[\x00-\x08\x0b\x0c\x0e-\x1a\x1c-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]"
CONTROL = re.compile(rf"\x1b(?!{_COLOUR})|\r(?!\n)|{_PLAIN}")


def visible(text: str) -> str:
    r"""The text with control characters as ``\x1b``; line ends, tabs and the colours of tables stay."""
    return CONTROL.sub(lambda found: repr(found[0])[1:-1], text)


class Guarded:
    """A text stream that writes only what :func:`visible` leaves."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """As the stream's; gives the number of characters asked for."""
        self._stream.write(visible(text))
        return len(text)

    def writelines(self, lines: Any) -> None:
        """As the stream's."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)
