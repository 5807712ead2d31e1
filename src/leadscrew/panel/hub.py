"""What pages and the machine say to each other: one page writes, the others watch, every attempt is noted.

What the machine says is passed on to every page; a page that comes later is told what it has to know.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from leadscrew.panel.backfill import Backfill
from leadscrew.panel.client import Client
from leadscrew.panel.control import Control
from leadscrew.panel.http_guard import Rate
from leadscrew.panel.link import Link, NoAnswer
from leadscrew.panel.messages import WRITERS, Hello, Message, Refused, parse
from leadscrew.panel.strict_json import text_of

if TYPE_CHECKING:
    from leadscrew.panel.audit import Audit
    from leadscrew.panel.client import Client
    from leadscrew.panel.control import Writer

BUILDING = {"running": "building", "t": 0.0, "period": 0, "speed": 1.0, "behind": False, "changed": {}, "ghost": None,
            "figures": None, "scope": {}, "can_undo": False, "can_redo": False, "message": ""}  # fmt: skip
MOST_CLIENTS = 32
MOST_OVER = 1000
"""Messages beyond the rate in a second that end a page's line."""
NOTED = {"machine", "switch", "set", "undo", "redo", "disturb", "start", "hold", "stop", "reset", "speed", "compare",
         "preset_save", "preset_load", "preset_delete", "session_save", "capture_save", "arm", "disarm",
         "force"}  # fmt: skip
"""Commands that are noted when they succeed; refused ones always are."""


MOST_REMEMBERED = 256


@dataclass
class Refusals:
    """What was refused to one page: how often it is noted, and what was not."""

    rate: Rate = field(default_factory=lambda: Rate(left=30.0, per_s=1.0, burst=30.0))
    unnoted: int = 0


class Hub:
    """Between the WebSockets and the machine's process."""

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
        self._number = 0
        self._requests = Rate(left=10.0, per_s=10.0, burst=10.0)
        self._refusals: dict[int, Refusals] = {}
        self._noted = Rate(left=300.0, per_s=10.0, burst=300.0)
        self._tasks: set[asyncio.Task[Any]] = set()

    def start(self) -> None:
        """Listens to the machine; called in the event loop."""
        self.link.listen(self.heard, self.lost_machine)
        self._do(self._watch())

    # From the machine.

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

    # From the pages.

    def come(self, hello: Hello, client: Client) -> dict[str, Any]:
        """A page that may come in: it is told everything; the result of its hello."""
        self.link.begin()
        client.name, client.secret = hello.name, hello.secret or ""
        before = self.control.resume(client.number, client.secret)
        if before is not None and self.control.writer is not None:
            self.control.writer.name = client.name
            self._note("resume", client)
            other = self.clients.get(before)
            if other is not None:
                other.put(notice("warning", "Control went to another page with this page's key; this one watches now."))
        self.clients[client.number] = client
        return {"you": client.number, "writer": before is not None}

    def welcome(self, client: Client, since: float | None) -> None:
        """The machine, its state, and the frames from ``since`` on."""
        if self.machine:
            client.put(self.machine)
        client.put(self._state_text())
        ahead = since is not None and since > float(self.state.get("period") or 0)
        client.put_old(self.frames.since(None if ahead else since))
        self._tell_state()

    def go(self, client: Client) -> None:
        """A page is gone: nothing stops."""
        client.end()
        if self.clients.pop(client.number, None) is None:
            return
        heir = next((c for c in self.clients.values() if c.secret == client.secret), None)
        if self.control.has(client.number) and heir is not None and client.secret:
            # A tab was duplicated, and one of the two closed: the other is of the same person.
            self.control.resume(heir.number, heir.secret)
            self._note("resume", heir)
        elif self.control.lost(client.number):
            self._note("connection lost", client)
            self._all(notice("warning", f"The page of {client.name}, who has control, is lost. Without it the machine "
                                         f"goes back to safe values in {self.control.timeout_s:g} s."))  # fmt: skip
        self._look()
        self._tell_state()

    def number(self) -> int:
        """Of a new client."""
        self._number += 1
        return self._number

    async def text(self, client: Client, text: str) -> None:
        """A message of a page."""
        if not client.rate.takes():
            self._too_many(client)
            return
        try:
            message = parse(text)
        except Refused as refused:
            self.refuse(client, str(refused), refused.id, refused.do or "message", refused.key)
            return
        if message.do in WRITERS and (why := self.no_control(self.control.has(client.number))):
            self.refuse(client, f"{message.do}: {why}", message.id, message.do)
            return
        await self._obey(client, message)

    def no_control(self, has: bool) -> str:
        """Why a page that has control, or has not, may not act; empty where it may."""
        if has:
            return ""
        held = self.control.writer
        return f"{held.name} has control; this page watches" if held else "take control first"

    def refuse(self, client: Client, error: str, id: int | None, do: str, key: str = "") -> None:
        """Says no, and notes it so seldom, of one page and of all, that nobody pushes out of the log what was done."""
        if len(self._refusals) > MOST_REMEMBERED:
            self._refusals.clear()
        refusals = self._refusals.setdefault(client.number, Refusals())
        if refusals.rate.takes() and self._noted.takes():
            more = f" (and {refusals.unnoted} more that were refused)" if refusals.unnoted else ""
            refusals.unnoted = 0
            self._note(do, client, ok=False, error=error + more, key=key)
        else:
            refusals.unnoted += 1
        client.put(text_of({"re": id, "ok": False, "error": error, **({"key": key} if key else {})}))

    def refused_request(self, what: str, address: str, error: str) -> None:
        """A request that was not let in: noted, at most ten a second, so that a flood does not fill the log."""
        if self._requests.takes():
            self.audit.note(what, who=address, ok=False, error=error)

    def note_http(self, request: Any, what: str, key: str = "", error: str = "") -> None:
        """A file that was fetched or sent; refused ones as seldom as other refusals."""
        if error and not self._noted.takes():
            return
        address = request.client.host if request.client else ""
        entry = self.audit.note(what, who=address, t=self.state.get("t"), key=key, ok=not error, error=error)
        self._all(text_of({"kind": "audit", "entry": entry}))

    def _too_many(self, client: Client) -> None:
        """Beyond the rate nothing is read; it is said once a second, and who goes on is cut off."""
        client.over += 1
        now = time.monotonic()
        if now - client.over_at > 1:
            client.over, client.over_at = 1, now
            self._note("too many messages", client, ok=False, error="more messages a second than are taken")
            client.put(notice("warning", "Too many messages: some were not read."))
        if client.over > MOST_OVER:
            client.end()

    async def _obey(self, client: Client, message: Message) -> None:
        do, args = message.do, message.args()
        here = {"take": self._take, "release": self._release, "audit": self._audit, "why": self._why, "ping": _ping}
        if do == "hello":
            self.refuse(client, "hello: was said already", message.id, do)
        elif do in here:
            self._answer(client, message.id, do, here[do](client, args))
        else:
            self._do(self._ask(client, message.id, do, args))

    def _answer(self, client: Client, id: int, do: str, result: dict[str, Any] | str) -> None:
        if isinstance(result, str):
            self.refuse(client, result, id, do)
        else:
            client.put(text_of({"re": id, "ok": True, "result": result}))

    async def _ask(self, client: Client, id: int, do: str, args: dict[str, Any]) -> None:
        """Asks the machine; the page need not be there any more when the answer comes."""
        try:
            result = await self.link.ask(do, args)
        except NoAnswer as error:
            tried = args.get("changes") or ({} if do != "speed" else {"speed": args.get("value")})
            named = sorted((at, -len(k), k) for k in tried if (at := str(error).find(k)) >= 0)
            key = named[0][2] if named else next(iter(tried), "") if len(tried) == 1 else ""
            self._note(do, client, ok=False, error=str(error), key=key, new=tried.get(key))
            client.put(text_of({"re": id, "ok": False, "error": str(error), **({"key": key} if key else {})}))
            return
        client.put(text_of({"re": id, "ok": True, "result": result}))
        if do in NOTED:
            self._note_done(do, args, result, client)

    def _note_done(self, do: str, args: dict[str, Any], result: dict[str, Any], client: Client | None) -> None:
        """One entry a key that changed; one for a command without."""
        new, old = result.get("new") or {}, result.get("old") or {}
        for key in new:
            self._note(do, client, t=result.get("t"), key=key, old=old.get(key), new=new[key])
        if not new or do in ("disturb", "preset_load"):
            said = {k: v for k, v in args.items() if v not in (None, {}, False)}
            self._note(do, client, t=result.get("t"), new=said or None)

    # What the hub answers itself.

    def _take(self, client: Client, args: dict[str, Any]) -> dict[str, Any] | str:
        had = self.control.has(client.number)
        problem = self.control.take(client.number, client.name, client.secret)
        if problem:
            return problem
        if not had:
            self._note("take", client)
        self._tell_state()
        return {"writer": True}

    def _release(self, client: Client, args: dict[str, Any]) -> dict[str, Any]:
        self.control.release()
        self._note("release", client)
        self._tell_state()
        return {"writer": False}

    def _audit(self, client: Client, args: dict[str, Any]) -> dict[str, Any]:
        return {"entries": self.audit.last(args["last"])}

    def _why(self, client: Client, args: dict[str, Any]) -> dict[str, Any]:
        client.views = tuple(args["views"])
        self._look()
        return {"views": list(client.views)}

    # Everything else.

    async def _watch(self) -> None:
        """Safe values and free control when the writer has been away for too long."""
        while True:
            await asyncio.sleep(min(0.25, self.control.timeout_s / 4))
            gone = self.control.timed_out()
            if gone is None:
                continue
            try:
                await self._make_safe(gone)
            except Exception:
                traceback.print_exc()

    async def _make_safe(self, gone: Writer) -> None:
        """The writer's time is over."""
        self._all(notice("warning", f"{gone.name} did not come back in {self.control.timeout_s:g} s: "
                                    "the machine goes back to safe values, and control is free."))  # fmt: skip
        self._tell_state()
        why = f"time-out of {gone.name}"
        try:
            result = await self.link.ask("safe", {"why": why})
            self._note_done("safe values", {"why": why}, result, None)
        except NoAnswer as error:
            self._note("safe values", None, ok=False, error=str(error))

    def _do(self, work: Any) -> None:
        """Runs beside, and is kept until it is done."""
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def close(self) -> None:
        """The end: pages are told, the process ends."""
        for task in self._tasks:
            task.cancel()
        self.link.close()
        self.audit.close()


def notice(level: str, text: str) -> str:
    return text_of({"kind": "notice", "level": level, "text": text})


def _ping(client: Client, args: dict[str, Any]) -> dict[str, Any]:
    return {"t": args["t"]}
