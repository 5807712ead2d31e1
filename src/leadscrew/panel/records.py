"""What was done at a simulated machine, to keep: session file, Python script.

The session of every run of a second or more, or with an event, is kept in the folder by itself when the run ends:
by a stop, a reset, another machine, or the end of the panel.
"""

from __future__ import annotations

import threading
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.panel.machine import Later
from leadscrew.util import atomic
from leadscrew.util.errors import DataError, LeadscrewError

if TYPE_CHECKING:
    from leadscrew.operate.operated import Operated, Session

MOST_FILES = 500
KEPT, KEPT_S = 50, 1.0
"""Sessions that were kept by themselves: at most so many, of runs of so many simulated seconds or with an event."""
WAIT_S = 1.0
"""How long the end of the panel waits for a session that is being written."""
_NAMES = "run-[0-9]*-[0-9]*.toml"
Kept = tuple["Session", float]
"""A session, and the control period of its loop in s."""


class Records:
    """The session of the run, or while that has not begun, of the run before it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "sessions"
        self._ended: Kept | None = None
        self._writing: threading.Thread | None = None
        self._last = self.problem = ""

    def ended(self, operated: Operated) -> None:
        """A run ended: its session can be had until the next one ends, and its file is written beside."""
        if not operated.period:
            return
        self._ended = kept = operated.session(), operated.period_s
        if kept[0].events or operated.period * operated.period_s >= KEPT_S:
            self._writing = threading.Thread(target=self._keep, args=(kept, self._writing), name="leadscrew-session")
            self._writing.daemon = True
            self._writing.start()

    def _keep(self, kept: Kept, before: threading.Thread | None) -> None:
        """Writes the session, and removes the oldest of those that were kept so."""
        if before is not None:
            before.join()
        path = self.folder / f"run-{datetime.now(UTC):%Y%m%d-%H%M%S%f}.toml"
        try:
            atomic.atomic_write(text_of(kept, "toml"), path)
            for old in sorted(self.folder.glob(_NAMES))[:-KEPT]:
                old.unlink()
        except (LeadscrewError, OSError) as error:
            self.problem = f"The session of the run that ended could not be kept: {error}"
        else:
            self._last = str(path)

    def close(self) -> str:
        """Waits for what is being written; where the last session lies, or why there is none."""
        if self._writing is not None:
            self._writing.join(WAIT_S)
        return self.problem or (f"The session of the last run: {self._last}" if self._last else "")

    def session(self, operated: Operated | None) -> Kept:
        """Of the run now, or of the one before it.

        Raises:
            DataError: nothing has run yet.
        """
        if operated is not None and operated.period:
            return operated.session(), operated.period_s
        if self._ended is None:
            raise DataError("nothing has run yet: start the machine first")
        return self._ended

    def text(self, operated: Operated | None, format: str) -> Later:
        """The session as text: ``toml``, or ``py`` for a script that makes it again."""
        kept = self.session(operated)
        return Later(lambda: text_of(kept, format), lambda text: {"text": text})

    def save(self, operated: Operated | None, name: str) -> Later:
        """Session and script in the folder, under a name that is free."""
        kept = self.session(operated)

        def work() -> dict[str, Any]:
            files = [self.folder / f"{name}.toml", self.folder / f"{name}.py"]
            if any(f.exists() or f.is_symlink() for f in files):
                raise DataError(f"there is a session {name} already; choose another name")
            if self.folder.is_dir() and sum(1 for _ in self.folder.iterdir()) >= 2 * MOST_FILES:
                raise DataError(f"{self.folder} holds {MOST_FILES} sessions, the most that it may; remove some first")
            for path in files:
                atomic.atomic_write(text_of(kept, path.suffix[1:]), path)
            return {"name": name, "files": [f.name for f in files]}

        return Later(work, lambda found: found)


def text_of(kept: Kept, format: str) -> str:
    """The session as TOML, or as a Python script."""
    session, period_s = kept
    if format == "py":
        from leadscrew.operate import script

        return script.text(session, period_s)
    from leadscrew.operate import session_file

    return session_file.text(session)


__all__ = ["Records", "text_of"]
