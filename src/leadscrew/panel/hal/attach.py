"""Attaching to a HAL and leaving it: from the file to the process that does it, and the pipes to that process."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import select
import subprocess
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.export.hal_run import PYTHON
from leadscrew.panel.hal import plan
from leadscrew.panel.hal.attached import BLOCK, PACKET
from leadscrew.panel.hal.file import HalFile
from leadscrew.panel.hal.show import HalRefused, running

PIPE_BYTES = 1_048_576
F_SETPIPE_SZ = getattr(fcntl, "F_SETPIPE_SZ", 1031)
ANSWER_S = 10.0
"""Longest wait for an answer; attaching and leaving take about 0.2 s."""
Block = tuple[int, np.ndarray]
"""Number of the first period, rows."""


class Pipe:
    """Asks the process, and takes in what it sends."""

    def __init__(self) -> None:
        program = Path(__file__).resolve().with_name("attached.py")
        self.process = subprocess.Popen(
            [PYTHON, str(program)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, start_new_session=True, bufsize=0,
        )  # fmt: skip
        assert self.process.stdin and self.process.stdout and self.process.stderr
        self._out, self._in = self.process.stdin.fileno(), self.process.stdout.fileno()
        for stream in (self.process.stdout, self.process.stderr):
            os.set_blocking(stream.fileno(), False)
        with contextlib.suppress(OSError):
            fcntl.fcntl(self._in, F_SETPIPE_SZ, PIPE_BYTES)
        self._got = bytearray()
        self._number = 0
        self._answers: dict[int, dict[str, Any]] = {}
        self.blocks: list[Block] = []
        self.events: list[dict[str, Any]] = []
        self.ended = ""
        """Why the process ended; empty while it runs."""

    def ask(self, do: str, wait_s: float = ANSWER_S, **args: Any) -> dict[str, Any]:
        """What the process answers; samples that come meanwhile are kept.

        Raises:
            HalRefused: it refused, or it has ended.
        """
        self._number += 1
        self.send({"id": self._number, "do": do, **args})
        until = time.monotonic() + wait_s
        while self._number not in self._answers:
            left = until - time.monotonic()
            if left <= 0.0:
                raise HalRefused(f"the process at HAL did not answer {do!r} within {wait_s:g} s")
            select.select([self._in], [], [], left)
            self.take()
            if self.ended and self._number not in self._answers:
                raise HalRefused(self.ended)
        found = self._answers.pop(self._number)
        if "error" in found:
            raise HalRefused(found["error"])
        return found

    def send(self, message: Mapping[str, Any]) -> None:
        """One command, without waiting.

        Raises:
            HalRefused: the process has ended.
        """
        try:
            os.write(self._out, json.dumps(message).encode() + b"\n")
        except OSError:
            self._end()
            raise HalRefused(self.ended) from None

    def take(self) -> None:
        """Takes in what there is: samples to ``blocks``, events to ``events``."""
        try:
            while got := os.read(self._in, PIPE_BYTES):
                self._got += got
            self._end()
        except BlockingIOError:
            pass
        at, head = 0, PACKET.size
        while len(self._got) - at >= head:
            kind, length = PACKET.unpack_from(self._got, at)
            if len(self._got) - at < head + length:
                break
            self._packet(kind, bytes(self._got[at + head : at + head + length]))
            at += head + length
        del self._got[:at]

    def _packet(self, kind: bytes, payload: bytes) -> None:
        if kind == b"S":
            first, rows, columns = BLOCK.unpack_from(payload)
            table = np.frombuffer(payload, dtype=np.float64, offset=BLOCK.size)
            self.blocks.append((first, table.reshape(rows, columns)))
            return
        message = json.loads(payload)
        if message.get("re") == 0:
            self.events.append({"event": "values", **message})
        elif "re" in message:
            self._answers[message.pop("re")] = message
        else:
            self.events.append(message)

    def _end(self) -> None:
        """Says why the process ended."""
        if self.ended:
            return
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(5.0)
        assert self.process.stderr
        told = b""
        with contextlib.suppress(OSError):
            told = self.process.stderr.read() or b""
        lines = [x for x in told.decode(errors="replace").splitlines() if x.strip() and "fallback_uid" not in x]
        why = f": {lines[-1]}" if lines else f" with {self.process.returncode}"
        self.ended = f"the process at HAL has ended{why}"

    def close(self, wait_s: float = 20.0) -> None:
        """The process ends, which takes everything away from HAL; waits for it."""
        for stream in (self.process.stdin, self.process.stdout, self.process.stderr):
            if stream is self.process.stdin:
                with contextlib.suppress(OSError):
                    stream.close()  # type: ignore[union-attr]
                with contextlib.suppress(subprocess.TimeoutExpired):
                    self.process.wait(wait_s)
            elif stream is not None:
                stream.close()


LEFT = (
    "what a panel that was killed had left in HAL was taken away; parameters that it wrote stand as they were, and "
    "count as safe unless the file says otherwise"
)


class Attachment:
    """The values of the parameters, and the pipe that samples come from."""

    def __init__(self, file: HalFile) -> None:
        self.file = file
        self.pipe: Pipe | None = None
        self.values: dict[str, Any] = {}
        self.safe: dict[str, Any] = {}
        self.written: set[str] = set()
        """Keys that this panel has written: only these return to their safe values."""
        self._ramping: set[str] = set()

    def attach(self) -> list[str]:
        """Attaches to the HAL that runs here; gives what has to be said.

        Raises:
            HalRefused: no HAL runs, a fault in the file, or a parameter out of its bounds now; HAL is as before.
        """
        said: list[str] = []
        hal = running()
        other = hal.helpers()
        if other:
            raise HalRefused(f"another panel is attached to this HAL (process {other[0].pid}): end it first")
        left = plan.left_over(hal)
        wanted = plan.plan(self.file, hal) if left is None else None
        pipe = Pipe()
        try:
            if left is not None:
                pipe.ask("clean", plan=left)
                said.append(LEFT)
                wanted = plan.plan(self.file, running())
            parameters = {
                p.key: {"hal": p.hal, "type": p.type, "low": p.low, "high": p.high, "rate": p.rate,
                        "safe": int(p.safe) if p.type == "int" and p.safe is not None else p.safe}
                for p in self.file.parameters
            }  # fmt: skip
            try:
                found = pipe.ask("attach", plan=wanted, parameters=parameters)
            except HalRefused as error:
                raise HalRefused(f"{self.file.where}: {error}") from None
            self.values, self.safe = found["values"], found["safe"]
        except BaseException:
            pipe.close()
            raise
        self.pipe = pipe
        return said

    def write(self, new: Mapping[str, Any]) -> dict[str, Any]:
        """Writes checked values and gives the old ones.

        Raises:
            HalRefused: HAL did not take one of them, or the process has ended.
        """
        if self.pipe is None:
            raise HalRefused("the panel is not attached to HAL yet")
        found = self.pipe.ask("set", values=dict(new))
        self.pipe.events = [e for e in self.pipe.events if e["event"] != "values"]
        self.values.update(new)
        self.written |= set(new)
        self._ramping = (self._ramping - set(new)) | set(found["ramps"])
        return dict(found["old"])

    def heard(self) -> list[str]:
        """What the process has told, as sentences; values that somebody else has changed are taken over."""
        if self.pipe is None:
            return []
        events, self.pipe.events = self.pipe.events, []
        said = []
        for event in events:
            if event["event"] == "reached":
                self._ramping.discard(event["key"])
            elif event["event"] == "warning":
                said.append(event["text"])
            elif event["event"] == "values" and "values" in event:
                said += self._read_back(event["values"])
        return said

    def _read_back(self, values: Mapping[str, Any]) -> list[str]:
        said = []
        for key, value in values.items():
            if key not in self._ramping and value != self.values[key]:
                said.append(f"{key} was changed from {self.values[key]:g} to {value:g}, and not by this panel")
                self.values[key] = value
        return said

    def leave(self) -> dict[str, Any]:
        """The safe values, and HAL as it was; gives the parameters that returned. A second call does nothing."""
        pipe, self.pipe = self.pipe, None
        if pipe is None:
            return {}
        found: dict[str, Any] = {}
        with contextlib.suppress(HalRefused):
            found = pipe.ask("leave", wait_s=20.0).get("back", {})
        pipe.close()
        return found
