"""Who may come in: the address that was served, pages of this server, the token; and no more than a person can do."""

from __future__ import annotations

import hmac
import ipaddress
import secrets
import socket
import time
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from dataclasses import dataclass, field
from typing import Any

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
PER_S, BURST = 60.0, 120.0
"""Messages a second that a client may send, and how many at once."""


def is_loopback(host: str) -> bool:
    """Whether only this computer can reach an address."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


@dataclass(frozen=True)
class Gate:
    """What is asked of every request.

    ``host``: the address served; a wildcard one is met under any address of this computer given in numbers, and under
    its name. A name that somebody else's DNS points here (rebinding) is refused.
    """

    host: str
    port: int
    token: str = ""

    def knows_host(self, header: str) -> bool:
        """Whether a Host header names this server."""
        name, port = _split(header)
        if port != self.port or not name:
            return False
        if name in _names(self.host):
            return True
        if is_loopback(self.host):
            return name in LOOPBACK
        if not _is_wildcard(self.host):
            return False
        return _is_number(name) or name in _own_names()

    def knows_origin(self, origin: str, host_header: str) -> bool:
        """Whether a page of this server asks: its origin is the address that it asks at."""
        return origin.lower() == f"http://{host_header.lower()}" and self.knows_host(host_header)

    def knows_token(self, given: str | None) -> bool:
        """Whether the token is right, in a time that says nothing about it; true where none is needed."""
        if not self.token:
            return True
        return hmac.compare_digest((given or "").encode("utf-8", "replace"), self.token.encode())

    def token_of(self, scope: Scope) -> str | None:
        """The token of a request: ``Authorization: Bearer``; never in an address, which browsers and proxies keep."""
        header = _header(scope, b"authorization")
        return header[7:].strip() if header.lower().startswith("bearer ") else None


def new_token() -> str:
    """A token that nobody guesses."""
    return secrets.token_urlsafe(24)


@dataclass
class Rate:
    """A bucket of messages: ``BURST`` at once, ``PER_S`` a second."""

    left: float = BURST
    at: float = field(default_factory=time.monotonic)
    per_s: float = PER_S
    burst: float = BURST

    def takes(self, now: float | None = None) -> bool:
        """Whether one more message is let in."""
        now = time.monotonic() if now is None else now
        self.left, self.at = min(self.burst, self.left + self.per_s * (now - self.at)), now
        if self.left < 1:
            return False
        self.left -= 1
        return True


class Door:
    """ASGI around the application: Host of everything, Origin of what acts, token of ``/api``, headers on answers."""

    def __init__(self, app: Any, gate: Gate, refused: Callable[[Scope, str], None]) -> None:
        self.app, self.gate, self.refused = app, gate, refused

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        host = _header(scope, b"host")
        status, text = self._judge(scope, host)
        if text:
            self.refused(scope, text)
            await _deny(scope, receive, send, status, text, _headers(""))
            return
        await self.app(scope, receive, _with_headers(send, _headers(host)) if scope["type"] == "http" else send)

    def _judge(self, scope: Scope, host: str) -> tuple[int, str]:
        """Status and sentence of a refusal; an empty one lets in."""
        if not self.gate.knows_host(host):
            return 421, "this server is not known under the address asked; open the address that it printed"
        acts = scope["type"] == "websocket" or scope["method"] not in ("GET", "HEAD")
        if acts and not self.gate.knows_origin(_header(scope, b"origin"), host):
            return 403, "only pages of this panel may ask this (the Origin is another one, or missing)"
        if scope["path"].startswith("/api/") and _header(scope, b"sec-fetch-site") not in ("", "none", "same-origin"):
            return 403, "only pages of this panel may ask this (another site's page asked)"
        needs = scope["type"] == "http" and scope["path"].startswith("/api/")
        if needs and not self.gate.knows_token(self.gate.token_of(scope)):
            return 401, "the token is missing or wrong; open the address with the token that the server printed"
        return 200, ""


def _headers(host: str) -> list[tuple[bytes, bytes]]:
    sockets = f" ws://{host}" if host else ""
    policy = (
        f"default-src 'self'; connect-src 'self'{sockets}; img-src 'self' data: blob:; object-src 'none'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
    said = {
        "content-security-policy": policy,
        "x-content-type-options": "nosniff",
        "x-frame-options": "DENY",
        "referrer-policy": "no-referrer",
        "cross-origin-opener-policy": "same-origin",
        "cross-origin-resource-policy": "same-origin",
        "cache-control": "no-cache",
    }
    return [(k.encode(), v.encode("latin-1", "replace")) for k, v in said.items()]


def _with_headers(send: Send, headers: list[tuple[bytes, bytes]]) -> Send:
    ours = {name for name, _ in headers}

    async def sent(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            kept = [
                (k, v) for k, v in message.get("headers", ()) if k.lower() not in ours - {b"content-security-policy"}
            ]
            has = {k.lower() for k, _ in kept}
            message["headers"] = kept + [(k, v) for k, v in headers if k not in has]
        await send(message)

    return sent


async def _deny(
    scope: Scope, receive: Receive, send: Send, status: int, text: str, headers: list[tuple[bytes, bytes]]
) -> None:
    """The refusal as an HTTP answer, of a WebSocket too where the server can."""
    kind = "http"
    if scope["type"] == "websocket":
        await receive()
        if "websocket.http.response" not in scope.get("extensions", {}):
            await send({"type": "websocket.close", "code": 1008, "reason": text[:100]})
            return
        kind = "websocket.http"
    head = [*headers, (b"content-type", b"text/plain; charset=utf-8")]
    await send({"type": f"{kind}.response.start", "status": status, "headers": head})
    await send({"type": f"{kind}.response.body", "body": text.encode()})


def _header(scope: Scope, name: bytes) -> str:
    """A header that stands once; empty where it is missing or stands several times."""
    found = [v for k, v in scope["headers"] if k.lower() == name]
    return found[0].decode("latin-1") if len(found) == 1 else ""


def _split(header: str) -> tuple[str, int]:
    """Name and port of a Host header."""
    name, colon, port = header.lower().rpartition(":")
    if not colon or (header.endswith("]") and header.startswith("[")):
        return header.lower(), 80
    return (name, int(port)) if port.isascii() and port.isdecimal() and len(port) <= 5 else ("", 0)


def _names(host: str) -> Iterable[str]:
    plain = host.lower()
    return (plain, f"[{plain}]") if ":" in plain else (plain,)


def _is_number(name: str) -> bool:
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return False
    return True


def _is_wildcard(host: str) -> bool:
    try:
        return ipaddress.ip_address(host.strip("[]")).is_unspecified
    except ValueError:
        return False


def _own_names() -> tuple[str, ...]:
    name = socket.gethostname().lower()
    return name, f"{name}.local", *LOOPBACK


__all__ = ["Door", "Gate", "Rate", "is_loopback", "new_token"]
