"""What the machine says, passed on to every page; and what a page that comes later has to know."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from leadscrew.panel.backfill import Backfill
from leadscrew.panel.control import Control
from leadscrew.panel.link import Link, NoAnswer
from leadscrew.panel.plain import text_of

if TYPE_CHECKING:
    from leadscrew.panel.audit import Audit
    from leadscrew.panel.client import Client

BUILDING = {"running": "building", "t": 0.0, "period": 0, "speed": 1.0, "behind": False, "changed": {}, "ghost": None,
            "figures": None, "scope": {}, "can_undo": False, "can_redo": False, "message": ""}  # fmt: skip


class Relay:
    """From the machine's process to the pages."""

    def __init__(self, link: Link, audit: Audit, timeout_s: float) -> None:
        self.link, self.audit = link, audit
        self.control = Control(timeout_s)
        self.clients: dict[int, Client] = {}
        self.machine: str = ""
        self.state: dict[str, Any] = dict(BUILDING)
        self.frames = Backfill()
        self.first_problem = ""
        """Why the first machine could not be built."""
        self.on_first_problem: Callable[[], None] = lambda: None
        self._run_and_columns: tuple[Any, ...] = ()
        self._capture: str = ""
        self._problem = ""

    def heard(self, data: bytes) -> None:
        """One message of the machine's process."""
        kind, body = data[:1], data[1:]
        if kind == b"F":
            self._frame(body)
        elif kind == b"S":
            self.state = json.loads(body)
            self._tell_state()
        elif kind == b"M":
            self._new_machine(body.decode())
        elif kind == b"W":
            for client in self.clients.values():
                if client.views:
                    client.put_latest("why", body.decode())
        elif kind == b"C":
            self._capture = body.decode()
        elif kind == b"N":
            self._notice(json.loads(body))

    def _frame(self, frame: bytes) -> None:
        if frame[1] == 3:
            for client in self.clients.values():
                client.put(self._capture)
                client.put(frame)
            return
        self.frames.add(frame)
        for client in self.clients.values():
            client.put_frame(frame)
            left_out = client.dropped()
            if left_out:
                client.put(notice("info", f"This page is slow: {left_out} pieces of the live signals were left out."))

    def _new_machine(self, text: str) -> None:
        self.machine = text
        found = json.loads(text)
        layout = found.get("run"), [c["name"] for c in found.get("columns", ())]
        if layout != self._run_and_columns:
            self._run_and_columns = layout
            self.frames.clear()
        self.link.remember(found)
        self._look()
        for client in self.clients.values():
            client.put(text)

    def _notice(self, message: dict[str, Any]) -> None:
        if message.pop("first", False) and not self.machine:
            self.first_problem = message["text"]
            self.state = {**BUILDING, "running": "stopped", "message": message["text"]}
            self._tell_state()
            self.on_first_problem()
        self._all(text_of(message))

    def lost_machine(self, text: str, again: bool) -> None:
        """The process ended; pages are told, and see a stopped machine."""
        end = "it was started again" if again else "choose a machine to begin again"
        self.audit.note("machine lost", ok=False, error=text)
        self.state = {**BUILDING, "running": "building" if again else "stopped", "message": f"{text}; {end}."}
        kept = "That run cannot be replayed; what was changed in it stands in the audit."
        self._all(notice("error", f"{text}; {end}. {kept}"))
        self._tell_state()

    def _look(self) -> None:
        """The machine works out the views that anybody looks at."""
        views = sorted({v for c in self.clients.values() for v in c.views})
        with contextlib.suppress(NoAnswer):
            if self.link.alive:
                self.link.tell("views", {"views": views})

    def _note(self, what: str, client: Client | None, **said: Any) -> None:
        """An entry of the log, shown to every page."""
        said.setdefault("t", self.state.get("t"))
        who, number = (client.name or client.address, client.number) if client else ("time-out", None)
        entry = self.audit.note(what, who=who, client=number, **said)
        self._all(text_of({"kind": "audit", "entry": entry}))
        if self.audit.problem != self._problem:
            self._problem = self.audit.problem
            said_now = f"The log cannot be written: {self._problem}. Its entries are shown here only."
            self._all(notice("warning", said_now if self._problem else "The log is written again."))

    def _state_text(self) -> str:
        watchers = sum(1 for n in self.clients if not self.control.has(n))
        told = {"kind": "state", **self.state, "writer": self.control.told(), "watchers": watchers}
        return text_of(told)

    def _tell_state(self) -> None:
        text = self._state_text()
        for client in self.clients.values():
            client.put_latest("state", text)

    def _all(self, text: str) -> None:
        for client in self.clients.values():
            client.put(text)


def notice(level: str, text: str) -> str:
    return text_of({"kind": "notice", "level": level, "text": text})


__all__ = ["BUILDING", "Relay", "notice"]
