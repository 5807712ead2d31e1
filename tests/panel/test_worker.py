"""The machine's process where something in it goes wrong: it is said, the machine stands still, the process lives."""

from __future__ import annotations

import json

import pytest

from leadscrew.panel.machine import Later
from leadscrew.panel.process import Spec
from leadscrew.panel.worker import Gone, Worker


class Line:
    """In place of the connection to the server."""

    def __init__(self):
        self.said, self.broken = [], False

    def send_bytes(self, data):
        if self.broken:
            raise BrokenPipeError
        self.said.append((data[:1].decode(), json.loads(data[1:])))

    def of(self, kind):
        return [message for k, message in self.said if k == kind]


class Faulty:
    """A machine of which everything fails that is told to."""

    def __init__(self, *fails):
        self.fails, self.failed = fails, []

    def _maybe(self, what):
        if what in self.fails:
            raise ZeroDivisionError(f"in {what}")

    def tick(self, now):
        self._maybe("tick")
        return []

    def news(self):
        self._maybe("news")
        return [("machine", {})]

    def describe(self):
        self._maybe("describe")
        return {"kind": "machine"}

    def state(self):
        self._maybe("state")
        return {"running": "stopped"}

    def why(self, views):
        self._maybe("why")
        return {}

    def ask(self, do, args):
        self._maybe("ask")
        if do == "later":
            return Later(lambda: self._maybe("work"), lambda found: {})
        return {"done": do}

    def fail(self, text):
        self.failed.append(text)


def worker(*fails):
    found = Worker(Line(), Spec("."))
    found.machine = Faulty(*fails)
    return found, found.connection, found.machine


@pytest.mark.parametrize("what", ["tick", "news", "describe"])
def test_an_error_of_ours_in_a_tick_is_said_once_and_stops_the_machine(what, capsys):
    process, line, machine = worker(what)
    for i in range(20):
        process._tick(0.02 * i)
        process._tell()
    assert len(line.of("N")) == 1 and f"ZeroDivisionError: in {what}" in line.of("N")[0]["text"]
    assert machine.failed and "Traceback" in capsys.readouterr().err


@pytest.mark.parametrize("what", ["ask", "news"])
def test_an_error_of_ours_in_a_command_is_its_answer(what):
    process, line, _ = worker(what)
    process._obey(7, "set", {})
    replies = line.of("R")
    assert [r["ticket"] for r in replies] == [7] and replies[0]["ok"] is (what != "ask")
    assert len(line.of("N")) == 1


def test_an_error_of_ours_in_what_takes_long_is_its_answer():
    process, line, _ = worker("work")
    process._obey(8, "later", {})
    process.inbox.get(timeout=5)()
    assert [(r["ticket"], r["ok"]) for r in line.of("R")] == [(8, False)]


def test_a_view_that_fails_is_not_tried_again():
    process, line, machine = worker("why")
    process.views = ("rules",)
    process._why()
    assert process.views == () and "cannot be shown" in line.of("N")[0]["text"] and machine.failed == []


def test_without_the_server_the_process_ends():
    process, line, _ = worker()
    line.broken = True
    for act in (process._tell, lambda: process._tick(0.0), lambda: process._obey(1, "set", {})):
        with pytest.raises(Gone):
            act()
