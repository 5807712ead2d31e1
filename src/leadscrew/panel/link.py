"""The server's side of the machine's process: started, asked, listened to, and started again when it is lost."""

from __future__ import annotations

import asyncio
import contextlib
import json
import multiprocessing
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from leadscrew.panel import process

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

    from leadscrew.panel.process import Spec

WAITING = 64
"""Questions that may wait for an answer; more are refused."""
ANSWER_S = 60.0
BEGIN_S = 0.6
"""How long the process waits for a page, so that two cores draw the page first; then it begins in any case."""
QUICK_S, TRIES = 30.0, 3
"""A process lost so soon after it began counts as a failed try; after so many it is not started again by itself."""


class NoAnswer(Exception):
    """The machine refused, or could not answer; the sentence says which."""


class Link:
    """One machine's process at a time."""

    def __init__(self, spec: Spec) -> None:
        self.spec = spec
        self.alive = False
        self.last_words = ""
        """What the process said at its end."""
        self._ticket = 0
        self._waiting: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._tries = 0
        self._heard: Callable[[bytes], None] = lambda data: None
        self._lost: Callable[[str, bool], None] = lambda text, again: None
        self._begun = False
        self.process: BaseProcess | None = None

    def begin(self) -> None:
        """Begins the process, where it has not begun yet."""
        if not self._begun:
            self.restart()

    def _start(self) -> None:
        """Begins the process; a Ctrl-C meant for the server does not reach it while it begins."""
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        self.process = context.Process(target=process.main, args=(theirs, self.spec), name="leadscrew", daemon=True)
        main = threading.current_thread() is threading.main_thread()
        before = signal.signal(signal.SIGINT, signal.SIG_IGN) if main else None
        try:
            self.process.start()
        finally:
            if main:
                signal.signal(signal.SIGINT, before)
        theirs.close()
        self._connection: Connection = ours
        self._begun = self.alive = True
        self._began = time.monotonic()

    def listen(self, heard: Callable[[bytes], None], lost: Callable[[str, bool], None]) -> None:
        """From now on every message goes to ``heard``, in the event loop; ``lost`` is told when the process ends, and
        whether it is started again. The process begins with the first page, at the latest after ``BEGIN_S``.
        """
        self._heard, self._lost = heard, lost
        self._loop = asyncio.get_running_loop()
        self._loop.call_later(BEGIN_S, self.begin)

    def _read_on(self) -> None:
        threading.Thread(target=self._read, args=(self._connection,), daemon=True, name="leadscrew-link").start()

    def _read(self, connection: Connection) -> None:
        """In a thread of its own, so that a large message never holds up the server."""
        with contextlib.suppress(RuntimeError):
            try:
                while True:
                    data = connection.recv_bytes()
                    if data[:1] == b"E":
                        self.last_words = json.loads(data[1:])["text"]
                        continue
                    self._loop.call_soon_threadsafe(self._take, data)
            except (EOFError, OSError):
                self._loop.call_soon_threadsafe(self._ended, connection)

    def _take(self, data: bytes) -> None:
        if data[:1] != b"R":
            self._heard(data)
            return
        reply = json.loads(data[1:])
        future = self._waiting.pop(reply["ticket"], None)
        if future is None or future.done():
            return
        if reply["ok"]:
            future.set_result(reply["result"])
        else:
            future.set_exception(NoAnswer(reply["error"]))

    def _ended(self, connection: Connection) -> None:
        """The process is gone: what waits for it is told, and another one begins, standing still."""
        if connection is not self._connection or not self.alive or self.process is None:
            return
        self.alive = False
        self.process.join(1.0)
        code = self.process.exitcode
        how = f"signal {-code}" if code is not None and code < 0 else f"exit code {code}"
        for future in self._waiting.values():
            if not future.done():
                future.set_exception(NoAnswer("the machine's process ended before it answered"))
        self._waiting.clear()
        self._tries = self._tries + 1 if time.monotonic() - self._began < QUICK_S else 1
        again = self._tries < TRIES
        self._lost(f"The machine's process ended ({how})", again)
        if again:
            self.restart()

    def restart(self) -> None:
        """Begins a process, the first or another after one that ended."""
        self._start()
        self._read_on()

    def remember(self, machine: dict[str, Any]) -> None:
        """What a new process would begin with: the machine that was described last."""
        study, controller, scenario = (machine.get(k) or "" for k in ("study", "controller", "scenario"))
        self.spec = replace(self.spec, study=study, controller=controller, scenario=scenario, changes=None,
                            run=int(machine.get("run") or 0), seed=machine.get("seed"),
                            circle=bool(machine.get("circle")))  # fmt: skip

    async def ask(self, do: str, args: dict[str, Any]) -> dict[str, Any]:
        """The machine's answer.

        Raises:
            NoAnswer: refused, no answer in time, too many wait, or the process is gone.
        """
        self.begin()
        if not self.alive:
            if do != "machine":
                raise NoAnswer("the machine's process ended; choose a machine to begin again")
            self._tries = 0
            self.spec = replace(self.spec, study=args["study"], controller=args["controller"] or "",
                                scenario=args["scenario"] or "", changes=args["changes"], seed=args["seed"],
                                circle=args["circle"])  # fmt: skip
            self.restart()
            return {}
        if len(self._waiting) >= WAITING:
            raise NoAnswer(f"{WAITING} questions wait for the machine already; a moment")
        self._ticket += 1
        ticket = self._ticket
        future: asyncio.Future[dict[str, Any]] = asyncio.get_running_loop().create_future()
        self._waiting[ticket] = future
        try:
            self.tell(do, args, ticket)
            return await asyncio.wait_for(future, ANSWER_S)
        except TimeoutError:
            raise NoAnswer(f"the machine did not answer within {ANSWER_S:g} s") from None
        finally:
            self._waiting.pop(ticket, None)

    def tell(self, do: str, args: dict[str, Any], ticket: int = 0) -> None:
        """Sends without waiting for an answer."""
        try:
            self._connection.send((ticket, do, args))
        except (OSError, ValueError):
            raise NoAnswer("the machine's process ended") from None

    def close(self) -> None:
        """Ends the process."""
        if self.alive:
            with contextlib.suppress(NoAnswer):
                self.tell("end", {})
        self.alive, self._begun = False, True  # none begins from now on
        if self.process is None:
            return
        self.process.join(2.0)
        if self.process.is_alive():
            self.process.kill()
            self.process.join(1.0)


__all__ = ["Link", "NoAnswer"]
