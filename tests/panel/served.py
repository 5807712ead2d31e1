"""A real panel in a process of its own, and a page that talks to it as the browser's does."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import httpx
import numpy as np
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

HEADER = struct.Struct("<BBHIIIdd")


class Served:
    """``leadscrew panel --port 0`` with its files in ``folder``."""

    def __init__(self, folder: Path, *words: str) -> None:
        self.folder = folder
        self.began = time.monotonic()
        environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "leadscrew", "panel", *words, "--port", "0", "--no-open", "--folder", str(folder)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment,
        )  # fmt: skip
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        found = re.search(r"http://([^/\s]+):(\d+)/\?token=(\S+)", line)
        if found is None:
            self.process.wait(10)
            assert self.process.stderr is not None
            raise AssertionError(line + self.process.stderr.read())
        self.port, self.token = int(found[2]), unquote(found[3])
        self.address = f"127.0.0.1:{self.port}"
        self.bearer = {"authorization": f"Bearer {self.token}"}

    @property
    def link(self) -> str:
        """What a browser opens."""
        return f"http://{self.address}/?token={quote(self.token, safe='')}"

    def get(self, path: str) -> httpx.Response:
        """A file, as a program fetches it that has the token."""
        return httpx.get(f"http://{self.address}/{path}", headers=self.bearer, timeout=120)

    def worker(self) -> int:
        """Number of the process of the machine."""
        import psutil

        for child in psutil.Process(self.process.pid).children():
            with contextlib.suppress(psutil.Error):
                if "spawn_main" in " ".join(child.cmdline()):
                    return int(child.pid)
        raise AssertionError("the panel has no process for the machine")

    def page(self, **hello: Any) -> Page:
        """A page that said hello."""
        return Page(self, **hello)

    def end(self) -> int:
        """Ctrl-C; gives the exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            return self.process.wait(8)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise


class Page:
    """One WebSocket; keeps everything that came."""

    def __init__(self, served: Served, name: str = "Ann", origin: str = "", **hello: Any) -> None:
        self.socket: ClientConnection = connect(
            f"ws://{served.address}/ws", subprotocols=["leadscrew.1"], origin=origin or f"http://{served.address}",
            max_size=None, ping_interval=None, close_timeout=1.0, additional_headers=served.bearer,
        ).__enter__()  # fmt: skip
        self.number = 0
        self.machine: dict[str, Any] = {}
        self.state: dict[str, Any] = {}
        self.texts: list[dict[str, Any]] = []
        self.frames: list[tuple[int, int, float, float, np.ndarray]] = []
        self.hello = self.ask("hello", name=name, **{"secret": None, **hello})

    def send(self, do: str, **args: Any) -> int:
        """A question; gives its number."""
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "do": do, **args}))
        return self.number

    def ask(self, do: str, **args: Any) -> dict[str, Any]:
        """The reply to a question, whatever it is."""
        number = self.send(do, **args)
        return self.wait(lambda m: m.get("re") == number)

    def did(self, do: str, **args: Any) -> dict[str, Any]:
        """The result of a question that has to be obeyed."""
        reply = self.ask(do, **args)
        assert reply["ok"], reply
        return dict(reply["result"])

    def wait(self, wanted: Callable[[dict[str, Any]], bool], seconds: float = 20.0) -> dict[str, Any]:
        """The first message from now on that is wanted."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            message = self.one(end - time.monotonic())
            if message is not None and wanted(message):
                return message
        raise AssertionError(f"nothing came in {seconds} s; the last state: {self.state}; texts: {self.texts[-3:]}")

    def until(self, wanted: Callable[[dict[str, Any]], bool], seconds: float = 20.0) -> dict[str, Any]:
        """The first state from now on that is wanted."""
        return self.wait(lambda m: m.get("kind") == "state" and wanted(m), seconds)

    def listen(self, seconds: float) -> None:
        """Takes in what comes for so long."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.one(end - time.monotonic())

    def one(self, seconds: float) -> dict[str, Any] | None:
        """One message, where one comes; a text as its object."""
        try:
            data = self.socket.recv(timeout=max(0.001, seconds))
        except TimeoutError:
            return None
        if isinstance(data, bytes):
            version, kind, columns, rows, run, _, first, stride = HEADER.unpack_from(data)
            assert version == 1
            values = np.frombuffer(data, "<f8" if kind == 3 else "<f4", offset=HEADER.size).reshape(rows, columns)
            self.frames.append((kind, run, first, stride, values))
            return None
        message: dict[str, Any] = json.loads(data, parse_constant=lambda c: 1 / 0)
        if message.get("kind") == "machine":
            self.machine = message
        elif message.get("kind") == "state":
            self.state = message
        self.texts.append(message)
        return message

    def column(self, name: str, kind: int = 1) -> tuple[np.ndarray, np.ndarray]:
        """Periods and values of a signal of the run now, as they came."""
        at = [c["name"] for c in self.machine["columns"]].index(name)
        frames = [f for f in self.frames if f[0] == kind and f[1] == self.machine["run"]]
        periods = [first + stride * np.arange(len(v)) for _, _, first, stride, v in frames]
        empty = np.zeros(0)
        return np.concatenate([*periods, empty]), np.concatenate([*(f[4][:, at] for f in frames), empty])

    def close(self) -> None:
        """As a page that is closed."""
        with contextlib.suppress(ConnectionClosed):
            self.socket.close()

    def drop(self) -> None:
        """As a connection that breaks."""
        with contextlib.suppress(OSError):
            self.socket.socket.close()
