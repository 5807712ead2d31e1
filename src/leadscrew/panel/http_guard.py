"""Who may come in: the address that was served, pages of this server, who opened its link; and at a person's pace."""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
import secrets
import socket
import time
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import parse_qs

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
PER_S, BURST = 60.0, 120.0
"""Messages a second that a client may send, and how many at once."""
NOT_OPENED = "open the link that leadscrew panel printed when it started: this browser has not opened it"
OPENED = b"""<!doctype html><html lang="en"><meta charset="utf-8"><title>Leadscrew panel</title>
<meta http-equiv="refresh" content="0; url=/"><p><a href="/">To the panel</a></p></html>"""
"""The answer to the link where a file or a page of another site led to it. It leads on by itself: browsers send no
strict cookie with the redirected request of such a link."""


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
    its name. A name that somebody else's DNS points here (rebinding) is refused. ``token``: whoever gives it comes in;
    with an empty one, nobody does.
    """

    host: str
    port: int
    token: str

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
        """Whether the token is right, in a time that says nothing about it."""
        return bool(self.token) and _same(given or "", self.token)

    @property
    def cookie(self) -> tuple[str, str]:
        """Name and value of the cookie of a browser that opened the link. Browsers send it to every port of the host:
        the name has the port, and the token cannot be had from the value.
        """
        value = hmac.new(self.token.encode(), b"leadscrew panel", hashlib.sha256).hexdigest()
        return f"leadscrew_{self.port}", value

    def opens(self, scope: Scope) -> bool:
        """Whether a request is for the link: ``/?token=...`` with the right token."""
        if scope["type"] != "http" or scope["method"] != "GET" or scope["path"] != "/":
            return False
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [])
        return len(given) == 1 and self.knows_token(given[0])

    def admits(self, scope: Scope) -> bool:
        """Whether a request has the cookie, or, of a program, the token: ``Authorization: Bearer ...``."""
        bearer = _header(scope, b"authorization")
        if bearer[:7].lower() == "bearer " and self.knows_token(bearer[7:].strip()):
            return True
        name, value = self.cookie
        given = (part.partition("=") for part in _header(scope, b"cookie").split(";"))
        return bool(self.token) and any(key.strip() == name and _same(own.strip(), value) for key, _, own in given)


def new_token() -> str:
    """A token that nobody guesses."""
    return secrets.token_urlsafe(24)


def _same(given: str, wanted: str) -> bool:
    return hmac.compare_digest(given.encode("utf-8", "replace"), wanted.encode())


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


class HttpGuard:
    """ASGI around the application: Host and cookie of everything, Origin of what acts, headers on answers."""

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
        if self.gate.opens(scope):
            await self._welcome(scope, send, _headers(host))
            return
        await self.app(scope, receive, _with_headers(send, _headers(host)) if scope["type"] == "http" else send)

    async def _welcome(self, scope: Scope, send: Send, headers: list[tuple[bytes, bytes]]) -> None:
        """The answer to the link: the cookie, and on to the address without the token."""
        name, value = self.gate.cookie
        kept = [(k, v) for k, v in headers if k != b"cache-control"]
        cookie = f"{name}={value}; Path=/; HttpOnly; SameSite=Strict".encode()
        head = [
            (b"content-type", b"text/html; charset=utf-8"),
            (b"cache-control", b"no-store"),
            (b"set-cookie", cookie),
        ]
        direct = _header(scope, b"sec-fetch-site") in ("none", "same-origin")
        if direct:
            head.append((b"location", b"/"))
        await send({"type": "http.response.start", "status": 303 if direct else 200, "headers": [*kept, *head]})
        await send({"type": "http.response.body", "body": b"" if direct else OPENED})

    def _judge(self, scope: Scope, host: str) -> tuple[int, str]:
        """Status and sentence of a refusal; an empty one lets in."""
        if not self.gate.knows_host(host):
            return 421, "this server is not known under the address asked; open the link that leadscrew panel printed"
        acts = scope["type"] == "websocket" or scope["method"] not in ("GET", "HEAD")
        if acts and not self.gate.knows_origin(_header(scope, b"origin"), host):
            return 403, "only pages of this panel may ask this (the Origin is another one, or missing)"
        if scope["path"].startswith("/api/") and _header(scope, b"sec-fetch-site") not in ("", "none", "same-origin"):
            return 403, "only pages of this panel may ask this (another site's page asked)"
        if not self.gate.opens(scope) and not self.gate.admits(scope):
            return 401, NOT_OPENED
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
    if status == 401:
        head.append((b"www-authenticate", b"Bearer"))
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


__all__ = ["Gate", "HttpGuard", "Rate", "is_loopback", "new_token"]
