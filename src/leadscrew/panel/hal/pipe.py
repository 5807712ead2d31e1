"""The pipes to the process that is attached to HAL."""

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
from leadscrew.panel.hal.attached_parts import BLOCK, PACKET
from leadscrew.panel.hal.show import HalRefused

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


__all__ = ["Block", "Pipe"]
