"""The panel's server: bound at once, the page served while the machine is still being built, ended by Ctrl-C."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import logging
import os
import shutil
import signal
import socket
import sys
import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlencode

from leadscrew.panel.http_guard import Gate, new_token
from leadscrew.util.errors import DataError, EngineError, ValueRefused

SWEPT_S = 3600.0
SILENT_S = 10.0
"""A network that takes nothing for so long has lost the page, though nobody said so."""

if TYPE_CHECKING:
    from leadscrew.panel.process import Spec


Say = Callable[[str], None]


@dataclass(frozen=True)
class Options:
    """Where the panel is served, and for whom."""

    token: str
    host: str = "127.0.0.1"
    port: int = 8420
    timeout_s: float = 30.0
    folder: Path = Path()


def bound(host: str, port: int) -> socket.socket:
    """A socket that listens there.

    Raises:
        ValueRefused: the port is taken, or the address is none of this computer; says what to do.
    """
    try:
        info = socket.getaddrinfo(host.strip("[]"), port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0]
    except OSError as error:
        raise ValueRefused(f"--host {host}: {error.strerror or error}; give an address of this computer") from None
    found = socket.socket(*info[:3])
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            found.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, int(1000 * SILENT_S))
        found.bind(info[4])
        found.listen(64)
    except OSError as error:
        found.close()
        if error.errno == errno.EADDRINUSE:
            raise ValueRefused(
                f"--port {port}: another program has it (perhaps a panel that runs already: open the link that it "
                "printed); end that one, or give another port, --port 0 for a free one"
            ) from None
        if error.errno in (errno.EACCES, errno.EPERM):
            raise ValueRefused(f"--port {port}: this user may not serve there; give one from 1024 on") from None
        raise ValueRefused(f"--host {host}: {error.strerror}; give an address of this computer") from None
    found.setblocking(False)
    return found


def token_for(file: Path | None) -> str:
    """The token: of the file, or a new one.

    Raises:
        DataError: the file cannot be read, or holds no token of 16 characters or more.
    """
    if file is None:
        return new_token()
    try:
        text = file.read_text(encoding="utf-8").strip()
    except (OSError, ValueError) as error:
        raise DataError(f"--token-file {file} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not 16 <= len(text) <= 200 or not text.isascii() or not text.isprintable() or " " in text:
        raise DataError(f"--token-file {file}: expected 16 to 200 ASCII characters without blanks, in one line")
    return text


def address(options: Options, port: int) -> str:
    """The link to open, with the token; its answer leads to the address without it."""
    host = options.host
    if host in ("0.0.0.0", "::"):
        host = socket.gethostname()
    host = f"[{host}]" if ":" in host and not host.startswith("[") else host
    return f"http://{host}:{port}/?{urlencode({'token': options.token})}"


def serve(options: Options, spec: Spec, said: Say, ended: Say) -> int:
    """Serves until Ctrl-C or a signal to end; ``said`` is given the address as soon as it can be opened, ``ended`` what
    is to be said at the end, such as where the session lies.

    Gives the exit code.

    Raises:
        LeadscrewError: the port is taken, the folder cannot be written, the machine named cannot be built, or what
            the panel is made of is not installed.
    """
    missing = [name for name in ("starlette", "uvicorn", "websockets") if find_spec(name) is None]
    if missing:
        raise EngineError(f"the panel needs {', '.join(missing)}: pip install leadscrew[panel]")
    listening = bound(options.host, options.port)
    try:
        return _serve(options, spec, (said, ended), listening)
    finally:
        listening.close()


def _serve(options: Options, spec: Spec, say: tuple[Say, Say], listening: socket.socket) -> int:
    before = os.umask(0o077)
    try:
        return _over(options, spec, say, listening)
    finally:
        os.umask(before)


def _over(options: Options, spec: Spec, say: tuple[Say, Say], listening: socket.socket) -> int:
    """Serves, with files that only this user can read."""
    from leadscrew.panel.audit import Audit
    from leadscrew.panel.link import Link

    audit = Audit(options.folder)
    sweep(options.folder)
    link = Link(spec)
    try:
        port = listening.getsockname()[1]
        say[0](address(options, port))
        from leadscrew.panel.app import application
        from leadscrew.panel.hub import Hub

        gate = Gate(options.host, port, options.token)
        hub = Hub(link, audit, options.timeout_s)
        asyncio.run(_run(application(hub, gate, options.folder), hub, listening))
    finally:
        link.close()
        audit.close()
        if link.last_words:
            say[1](link.last_words)
    if hub.first_problem:
        raise ValueRefused(hub.first_problem)
    return 0


def sweep(folder: Path) -> None:
    """Removes what an earlier panel left of uploads and of opening a browser, an hour old or more: others may share the
    folder.
    """
    for left in [*folder.glob(".upload-*"), *folder.glob("captures/.upload-*"), *folder.glob("open-*.html")]:
        with contextlib.suppress(OSError):
            if time.time() - left.stat().st_mtime > SWEPT_S:
                shutil.rmtree(left) if left.is_dir() and not left.is_symlink() else left.unlink()


STRANGERS = (
    "ASGI callable returned without", "Exceeded concurrency limit", "Invalid HTTP request received",
    "Invalid UTF-8 sequence received", "No supported WebSocket library", "Unsupported upgrade request",
)  # fmt: skip
"""How messages of the server begin that broken or refused requests cause: they are noted, or nobody's business."""


def _is_news(record: logging.LogRecord) -> bool:
    """Whether the terminal needs a message of the server."""
    return not record.getMessage().startswith(STRANGERS)


async def _run(app: Any, hub: Any, listening: socket.socket) -> None:
    import uvicorn

    from leadscrew.panel.connections import REQUEST_S, Connection

    class Server(uvicorn.Server):
        """Signals are ours."""

        def capture_signals(self) -> Any:
            return nullcontext()

    logging.getLogger("uvicorn.error").addFilter(_is_news)
    config = uvicorn.Config(
        app, lifespan="on", log_config=None, access_log=False, ws="websockets-sansio", http=Connection, loop="asyncio",
        ws_max_size=65_536, ws_ping_interval=5.0, ws_ping_timeout=10.0, ws_per_message_deflate=False,
        timeout_graceful_shutdown=2, server_header=False, timeout_keep_alive=int(REQUEST_S), limit_concurrency=200,
    )  # fmt: skip
    server = Server(config)

    def end() -> None:
        server.force_exit = server.should_exit
        server.should_exit = True

    loop = asyncio.get_running_loop()
    if sys.platform == "win32":
        signal.signal(signal.SIGINT, lambda *_: loop.call_soon_threadsafe(end))
    else:
        for number in (signal.SIGINT, signal.SIGTERM):
            loop.add_signal_handler(number, end)
    hub.on_first_problem = end
    await server.serve(sockets=[listening])


__all__ = ["Options", "address", "bound", "serve", "token_for"]
