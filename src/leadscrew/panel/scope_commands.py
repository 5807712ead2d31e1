"""The scope's part of a machine under the panel: arm, take, keep and load captures."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.operate import captures
from leadscrew.operate.scope import Scope, Trigger
from leadscrew.panel.frames import CAPTURE, Frame
from leadscrew.panel.machine import Later
from leadscrew.panel.strict_json import plain
from leadscrew.util.errors import DataError, LeadscrewError, NameUnknown

if TYPE_CHECKING:
    from leadscrew.operate.captures import Capture

KEPT, MOST_BYTES = 8, 150_000_000
"""Captures held in memory, to be saved by their number: at most so many, and, but for the last, so many bytes."""
COMMANDS = ("arm", "disarm", "force", "capture_save", "capture_load", "capture_receive", "captures")


class ScopeCommands:
    """One scope over a machine's rows, and the captures that it took or that were loaded."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.scope: Scope | None = None
        self.held: dict[int, Capture] = {}
        self._number = 0
        self._loading = threading.Lock()
        self._news: list[tuple[str, dict[str, Any]]] = []

    def watch(self, columns: Sequence[str], units: Mapping[str, str], period_s: float) -> None:
        """A new scope, for rows of these columns; a trigger that waits goes on waiting where its signal is there."""
        before = self.scope.state() if self.scope is not None else {}
        self.scope = Scope(columns, units, period_s)
        if before.get("phase") in ("armed", "taking") and before["trigger"] is not None:
            with contextlib.suppress(LeadscrewError):
                self.scope.arm(Trigger(**before["trigger"]))

    def feed(self, first: int, rows: np.ndarray, about: Mapping[str, Any]) -> None:
        """Rows of the machine; ``about``: what a capture taken now is of."""
        if self.scope is None:
            return
        self.scope.feed(first, rows)
        taken = self.scope.taken()
        if taken is not None:
            now = datetime.now(UTC).isoformat(timespec="seconds")
            self._show(replace(taken, about={**taken.about, **plain(about), "when": now}))

    def ask(self, do: str, args: Mapping[str, Any]) -> dict[str, Any] | Later:
        """Obeys one of ``COMMANDS``."""
        if do == "captures":
            return {"captures": [vars(c) for c in captures.names(self.folder)]}
        if do == "capture_load":
            return self._load(captures.find(self.folder, args["name"]))
        if do == "capture_receive":
            return self._receive(args["name"], Path(args["path"]))
        if do == "capture_save":
            return self._save(args)
        if self.scope is None:
            raise DataError("the scope has no machine yet")
        if do == "arm":
            self.scope.arm(Trigger(**{k: args[k] for k in ("signal", "level", "slope", "mode", "pre", "length_s")}))
        elif do == "disarm":
            self.scope.disarm()
        else:
            self.scope.force()
        return {"scope": plain(self.scope.state())}

    def state(self) -> dict[str, Any]:
        """For the ``state`` message."""
        return plain(self.scope.state()) if self.scope is not None else {}

    def news(self) -> list[tuple[str, dict[str, Any]]]:
        """Captures since the last call."""
        found, self._news = self._news, []
        return found

    def _save(self, args: Mapping[str, Any]) -> Later:
        which = args["which"]
        if which is None:
            which = max(self.held, default=0)
        if which not in self.held:
            raise NameUnknown(f"there is no capture {which}; the last {KEPT} are held, take it again or load it")
        capture = self.held[which]

        def work() -> Path:
            return captures.save(replace(capture, name=args["name"]), self.folder, args["name"], args["format"])

        return Later(work, lambda path: {"name": path.name, "bytes": path.stat().st_size})

    def _load(self, path: Path) -> Later:
        return Later(lambda: self._alone(lambda: captures.load(path, apart=True)), self._loaded)

    def _receive(self, name: str, sent: Path) -> Later:
        def work() -> Capture:
            return captures.received(self.folder, name, sent.read_bytes(), apart=True)

        return Later(lambda: self._alone(work), self._received)

    def _alone(self, read: Callable[[], Capture]) -> Capture:
        """Files are read one at a time, so that those who ask for many do not fill the memory."""
        if not self._loading.acquire(blocking=False):
            raise DataError("another capture is being loaded; a moment")
        try:
            return read()
        finally:
            self._loading.release()

    def _loaded(self, capture: Capture) -> dict[str, Any]:
        return {"capture": self._show(capture, loaded=True)}

    def _received(self, capture: Capture) -> dict[str, Any]:
        return {"name": capture.name, "rows": len(capture.rows)}

    def _show(self, capture: Capture, loaded: bool = False) -> int:
        """Holds a capture under a number and sends it to every page; gives the number. ``loaded``: from a file."""
        self._number += 1
        number = self._number
        self.held[number] = capture
        while len(self.held) > KEPT or (
            len(self.held) > 1 and sum(c.rows.nbytes for c in self.held.values()) > MOST_BYTES
        ):
            del self.held[min(self.held)]
        about = {
            "id": number,
            "name": capture.name or f"capture {number}",
            "columns": list(capture.columns),
            "units": dict(capture.units),
            "period_s": capture.period_s,
            "trigger_row": capture.trigger_row,
            "about": plain(capture.about),
            "rows": len(capture.rows),
            "loaded": loaded,
        }
        frame = Frame(CAPTURE, number, capture.first_period, 1.0, capture.rows)
        self._news.append(("capture", {"capture": about, "frame": frame}))
        return number


__all__ = ["COMMANDS", "ScopeCommands"]
