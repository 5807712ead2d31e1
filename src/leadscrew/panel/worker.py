"""The process of the machine: it ticks, obeys, and tells; the server process never computes.

It is a child of the server process, ends with it in whatever way that ends, and never sees the network. What it is
asked and what it answers go over one connection: messages begin with a letter, see ``SAYS``.
"""

from __future__ import annotations

import contextlib
import os
import queue
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.panel.strict_json import text_of
from leadscrew.util.errors import LeadscrewError

if TYPE_CHECKING:
    from leadscrew.panel.machine import Later, Machine
    from leadscrew.panel.process import Spec

TICK_S, STATE_S, WHY_S = 0.02, 0.25, 0.1
SAID_S = 10.0
"""The same error is not said again for so long."""
END_S = 1.5
"""How long the end may take."""
SAYS = {"reply": b"R", "machine": b"M", "state": b"S", "why": b"W", "notice": b"N", "capture": b"C", "frame": b"F",
        "end": b"E"}  # fmt: skip
"""First byte of a message to the server; of a frame, its encoding follows, of the others a JSON object."""


class Gone(Exception):
    """The server has gone, or wants the end: so does this process."""


class Worker:
    """Drives one machine, in one thread; another reads the connection, others do what takes long."""

    def __init__(self, connection: Connection, spec: Spec) -> None:
        self.connection, self.spec = connection, spec
        self.inbox: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self.views: tuple[str, ...] = ()
        self._changed = True
        self._last = "", 0.0
        self.machine: Machine | None = None

    def run(self) -> None:
        """Until the end.

        Raises:
            Gone: that is it.
        """
        threading.Thread(target=self._read, daemon=True).start()
        self._begin()
        tick_at = state_at = why_at = time.monotonic()
        while True:
            with contextlib.suppress(queue.Empty):
                left = tick_at - time.monotonic()
                act = self.inbox.get(timeout=left) if left > 0 else self.inbox.get_nowait()
                act()
            now = time.monotonic()
            if now < tick_at:
                if self._changed:
                    self._tell()
                continue
            tick_at = max(tick_at + TICK_S, now + 0.2 * TICK_S)
            self._tick(now)
            if now >= why_at and self.views:
                why_at = now + WHY_S
                self._why()
            if self._changed or now >= state_at:
                state_at = now + STATE_S
                self._tell()

    # What goes out.

    def say(self, kind: str, message: Mapping[str, Any]) -> None:
        """One message to the server."""
        self._out(SAYS[kind] + text_of(message).encode())

    def say_frame(self, frame: Any) -> None:
        """One frame to the server."""
        self._out(SAYS["frame"] + frame.encode())

    def _out(self, data: bytes) -> None:
        try:
            self.connection.send_bytes(data)
        except OSError as error:
            raise Gone from error

    def _tell(self) -> None:
        """News, then the state."""
        machine = self.machine
        if machine is None:
            return
        self._changed = False
        with self._guarded():
            self._news(machine)
            self.say("state", machine.state())

    def _news(self, machine: Machine) -> None:
        for kind, message in machine.news():
            if kind == "machine":
                self.say("machine", machine.describe())
            elif kind == "capture":
                self.say("capture", {"kind": "capture", "capture": message["capture"]})
                self.say_frame(message["frame"])
            else:
                self.say("notice", {"kind": "notice", **message})

    # What the machine does.

    def _begin(self) -> None:
        try:
            self.machine = machine_of(self.spec)
        except LeadscrewError as error:
            self.say("notice", {"kind": "notice", "level": "error", "text": str(error), "first": True})
            raise Gone from None
        begun = self.machine.begin()
        if begun is not None:
            self._later(begun, None, "begin")

    def _tick(self, now: float) -> None:
        machine = self.machine
        if machine is None:
            return
        with self._guarded():
            self._news(machine)
            for frame in machine.tick(now):
                self.say_frame(frame)
            self._news(machine)

    def _why(self) -> None:
        machine = self.machine
        assert machine is not None
        try:
            found = machine.why(self.views)
        except Exception as error:
            self.views = ()
            self.say("notice", {"kind": "notice", "level": "warning", "text": f"The view cannot be shown: {error}"})
            traceback.print_exc()
            return
        if found:
            self.say("why", {"kind": "why", **found})

    def _failed(self, error: Exception) -> None:
        """An error of ours: it is said, the machine stands still, the panel lives."""
        text = f"The machine was stopped by an error in the program: {type(error).__name__}: {error}"
        now = time.monotonic()
        if text != self._last[0] or now - self._last[1] > SAID_S:
            self._last = text, now
            traceback.print_exception(error)
            self.say("notice", {"kind": "notice", "level": "error", "text": text})
        if self.machine is not None:
            self.machine.fail(text)
        self._changed = True

    @contextlib.contextmanager
    def _guarded(self) -> Iterator[None]:
        """An error of ours stops the machine and not the process; the end of the connection does end it."""
        try:
            yield
        except Gone:
            raise
        except Exception as error:
            self._failed(error)

    # What comes in.

    def _read(self) -> None:
        """Takes in what the server asks, so that it never waits for the machine."""
        try:
            while True:
                ticket, do, args = self.connection.recv()
                if do == "end":
                    break
                self.inbox.put(partial(self._obey, ticket, do, args))
        except (EOFError, OSError):
            pass
        self.end()
        time.sleep(END_S)
        os._exit(1)

    def end(self) -> None:
        """Asks for the end, from any thread."""
        self.inbox.put(self._end)

    def _end(self) -> None:
        """The machine is left as it is safe, and the process ends."""
        said = ""
        if self.machine is not None:
            with contextlib.suppress(LeadscrewError):
                said = self.machine.close()
        if said:
            self.say("end", {"text": said})
        raise Gone

    def _obey(self, ticket: int, do: str, args: dict[str, Any]) -> None:
        if do == "views":
            self.views = tuple(args["views"])
            return
        assert self.machine is not None
        self._changed = True
        try:
            found = self.machine.ask(do, args)
        except Exception as error:
            self._refused(ticket, error)
            return
        if isinstance(found, dict):
            with self._guarded():
                self._news(self.machine)
            self.say("reply", {"ticket": ticket, "ok": True, "result": found})
        else:
            self._later(found, ticket, do)

    def _refused(self, ticket: int | None, error: Exception) -> None:
        if not isinstance(error, LeadscrewError):
            self._failed(error)
        text = str(error) if isinstance(error, LeadscrewError) else f"{type(error).__name__}: {error}"
        if ticket is None:
            self.say("notice", {"kind": "notice", "level": "error", "text": text, "first": True})
        else:
            self.say("reply", {"ticket": ticket, "ok": False, "error": text})

    def _later(self, later: Later, ticket: int | None, do: str) -> None:
        """Works on an answer in a thread of its own; the machine runs on meanwhile."""

        def work() -> None:
            try:
                found = later.work()
            except Exception as error:
                self.inbox.put(partial(self._refused, ticket, error))
            else:
                self.inbox.put(partial(self._finish, later, found, ticket))

        threading.Thread(target=work, daemon=True, name=do).start()

    def _finish(self, later: Later, found: Any, ticket: int | None) -> None:
        self._changed = True
        try:
            result = later.done(found)
        except Exception as error:
            self._refused(ticket, error)
            return
        self._tell()
        if ticket is not None:
            self.say("reply", {"ticket": ticket, "ok": True, "result": result})


def machine_of(spec: Spec) -> Machine:
    """The machine that is asked for."""
    if spec.hal:
        from leadscrew.panel import hal

        found: Machine = hal.HalMachine(hal.read(spec.hal), spec.folder, spec.run)
        return found
    from leadscrew.operate.operated import Start
    from leadscrew.panel.sim_machine import SimMachine

    start = Start(spec.study, spec.controller or None, spec.scenario or None, dict(spec.changes or {}), spec.seed,
                  circle=spec.circle)  # fmt: skip
    return SimMachine(start, Path(spec.folder), spec.run, spec.named, spec.own)


__all__ = ["SAYS", "Gone", "Worker", "machine_of"]
