"""What may reach a terminal: names in files are data, and no data moves its cursor, sets its title or hides text."""

from __future__ import annotations

from typing import Any, TextIO

from leadscrew.util.escape import terminal


class Guarded:
    """A text stream that writes only what :func:`leadscrew.util.escape.terminal` leaves."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """As the stream's; gives the number of characters asked for."""
        self._stream.write(terminal(text))
        return len(text)

    def writelines(self, lines: Any) -> None:
        """As the stream's."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)
