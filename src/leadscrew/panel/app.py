"""The web application: the page, its WebSocket, downloads and uploads."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from leadscrew.panel.client import Client
from leadscrew.panel.downloads import Downloads
from leadscrew.panel.http_guard import Gate, HttpGuard
from leadscrew.panel.hub import MOST_CLIENTS, Hub
from leadscrew.panel.messages import Hello, Refused, parse
from leadscrew.panel.strict_json import text_of

WEB = Path(__file__).parent / "web"
PROTOCOL = "leadscrew.1"
HELLO_S = 5.0
"""How long a page may take to say who it is."""
BROKEN = {
    1002: "no sound WebSocket frame; the connection was closed",
    1007: "a text that is not UTF-8; the connection was closed",
    1009: "a message of more than 64 KB; the connection was closed",
}
"""Why the server ends a line by itself, by the close code."""


def application(hub: Hub, gate: Gate, folder: Path, begun: Callable[[], None] | None = None) -> HttpGuard:
    """The application behind its guard."""

    @contextlib.asynccontextmanager
    async def life(_: Starlette) -> AsyncIterator[None]:
        hub.start()
        if begun is not None:
            begun()
        try:
            yield
        finally:
            hub.close()

    downloads = Downloads(hub, folder)
    routes = [
        Route("/", page),
        Mount("/static", StaticFiles(directory=WEB)),
        *downloads.routes(),
        WebSocketRoute("/ws", lines(hub)),
    ]
    return HttpGuard(Starlette(routes=routes, lifespan=life), gate, lambda scope, text: _note_refused(hub, scope, text))


async def page(_: Request) -> Response:
    """The page."""
    index = WEB / "index.html"
    if not index.is_file():
        return PlainTextResponse("The page is not installed (panel/web/index.html is missing).", status_code=500)
    return FileResponse(index, media_type="text/html; charset=utf-8")


def lines(hub: Hub) -> Callable[[WebSocket], Awaitable[None]]:
    """The WebSocket's end."""

    async def line(socket: WebSocket) -> None:
        client = Client(hub.number(), socket.client.host if socket.client else "")
        if PROTOCOL not in socket.scope.get("subprotocols", ()):
            _note_refused(hub, socket.scope, f"the WebSocket does not offer the subprotocol {PROTOCOL}")
            await socket.close(1002)
            return
        if len(hub.clients) >= MOST_CLIENTS:
            await socket.close(1013)
            return
        await socket.accept(subprotocol=PROTOCOL)
        since = await _greet(hub, socket, client)
        if client.number not in hub.clients:
            return
        hub.welcome(client, since)
        await _talk(hub, socket, client)

    return line


async def _greet(hub: Hub, socket: WebSocket, client: Client) -> float | None:
    """The first message: who it is; a page that may not come in hears why, and nothing else."""
    try:
        async with asyncio.timeout(HELLO_S):
            message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            if why := BROKEN.get(message.get("code", 0)):
                raise Refused(why)
            return None
        if message.get("text") is None:
            raise Refused("the first message has to be a hello, as text")
        hello = parse(message["text"])
        if not isinstance(hello, Hello):
            raise Refused("say hello first", hello.id, hello.do)
    except TimeoutError:
        refused = Refused(f"no hello came within {HELLO_S:g} s")
    except Refused as error:
        refused = error
    else:
        result = hub.come(hello, client)
        client.put(text_of({"re": hello.id, "ok": True, "result": result}))
        return hello.since
    hub.audit.note(refused.do or "hello", who=client.address, client=client.number, ok=False, error=str(refused))
    with contextlib.suppress(RuntimeError, WebSocketDisconnect):
        await socket.send_text(text_of({"re": refused.id, "ok": False, "error": str(refused)}))
        await socket.close(1008, "refused")
    return None


async def _talk(hub: Hub, socket: WebSocket, client: Client) -> None:
    """Both ways, until one of them ends."""
    tasks = [asyncio.create_task(_listen(hub, socket, client)), asyncio.create_task(client.pump(socket))]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        hub.go(client)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        with contextlib.suppress(Exception):
            async with asyncio.timeout(1.0):
                await socket.close(1008)


async def _listen(hub: Hub, socket: WebSocket, client: Client) -> None:
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            if why := BROKEN.get(message.get("code", 0)):
                hub.refuse(client, why, None, "message")
            return
        if message.get("text") is None:
            hub.refuse(client, "binary messages are not taken", None, "message")
        else:
            await hub.text(client, message["text"])


def _note_refused(hub: Hub, scope: Any, text: str) -> None:
    """Notes a request that was not let in; its query, where a token may stand, is left out."""
    address = scope["client"][0] if scope.get("client") else ""
    what = f"{scope.get('method', 'WebSocket')} {scope.get('path', '')[:80]}"
    hub.refused_request(what, address, text)


__all__ = ["PROTOCOL", "application"]
