"""Who changed what and when, the refused attempts too: lines of JSON in a file that never grows without bound."""

from __future__ import annotations

import contextlib
import json
import os
from collections import deque
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TextIO

from leadscrew.panel.strict_json import plain
from leadscrew.util.errors import DataError

MOST_BYTES, FILES = 4_000_000, 5
"""Size at which a file is put aside, and how many are kept."""
SHOWN = 1000
"""Entries held to be shown, of what was done and of what was refused."""
LONGEST = 200


class Audit:
    """The log of one folder; every entry is handed to the system at once."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "audit.jsonl"
        self._done: deque[tuple[int, dict[str, Any]]] = deque(maxlen=SHOWN)
        self._refused: deque[tuple[int, dict[str, Any]]] = deque(maxlen=SHOWN)
        """Apart, so that what is refused does not push out what was done."""
        self._count = 0
        self.problem = ""
        """Why the last entry could not be written; empty where it was."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file: TextIO | None = self._opened()
        except OSError as error:
            raise DataError(
                f"{self.path} cannot be written: {error.strerror or error}; give another --folder"
            ) from None

    def note(
        self,
        what: str,
        *,
        who: str = "",
        client: int | None = None,
        t: float | None = None,
        key: str = "",
        old: Any = None,
        new: Any = None,
        ok: bool = True,
        error: str = "",
    ) -> dict[str, Any]:
        """Writes an entry and gives it."""
        entry = {
            "at": datetime.now(UTC).isoformat(timespec="milliseconds"), "t": t, "who": _short(who), "client": client,
            "what": _short(what), "key": _short(key), "old": _bounded(old), "new": _bounded(new), "ok": ok,
            "error": _short(error),
        }  # fmt: skip
        self._count += 1
        (self._done if ok else self._refused).append((self._count, entry))
        self._write(json.dumps(entry, allow_nan=False, ensure_ascii=True))
        return entry

    def last(self, count: int) -> list[dict[str, Any]]:
        """The newest entries, oldest first; at least half of them are what was done, where there is so much."""
        done, refused = list(self._done)[-count:], list(self._refused)[-count:]
        refused = refused[-max(count // 2, count - len(done)) :]
        found = done[-(count - len(refused)) :] if count > len(refused) else []
        return [entry for _, entry in sorted([*found, *refused], key=lambda x: x[0])]

    def close(self) -> None:
        """The end of the log."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _write(self, line: str) -> None:
        """A full disk must not stop the machine: what cannot be written is only shown. A file that was removed is made
        anew.
        """
        if self._file is None:
            return
        try:
            if self._file.closed or os.fstat(self._file.fileno()).st_nlink == 0:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                self._file = self._opened()
            self._file.write(line + "\n")
            self._file.flush()
            if self._file.tell() > MOST_BYTES:
                self._rotate()
        except OSError as error:
            self.problem = error.strerror or str(error)
            with contextlib.suppress(OSError):
                self._file.close()
        else:
            self.problem = ""

    def _rotate(self) -> None:
        assert self._file is not None
        self._file.close()
        for number in range(FILES - 1, 0, -1):
            old = self.path if number == 1 else self.path.with_suffix(f".{number - 1}.jsonl")
            if old.exists():
                old.replace(self.path.with_suffix(f".{number}.jsonl"))
        self._file = self._opened()

    def _opened(self) -> TextIO:
        """Appends; a link in its place is not followed."""
        handle = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0), 0o600)
        return os.fdopen(handle, "a", encoding="utf-8")


def _bounded(value: Any) -> Any:
    """The value where it is short; else its beginning as text."""
    found = plain(value)
    if isinstance(found, Mapping | list | str):
        text = found if isinstance(found, str) else json.dumps(found)
        return found if len(text) <= LONGEST else text[: LONGEST - 3] + "..."
    return found


def _short(text: str) -> str:
    shown = "".join(c if c.isprintable() else " " for c in str(text)[: 2 * LONGEST])
    return shown if len(shown) <= 2 * LONGEST - 3 else shown[: 2 * LONGEST - 3] + "..."


__all__ = ["Audit"]
