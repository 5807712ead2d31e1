"""Connections that ask nothing, or ask by drops: cut off, and meanwhile others are served."""

from __future__ import annotations

import asyncio
import contextlib

import pytest
from uvicorn import Config
from uvicorn.server import ServerState

from leadscrew.panel import connections
from leadscrew.panel.connections import Connection

REQUEST = b"GET / HTTP/1.1\r\nHost: here\r\n\r\n"


async def app(scope, receive, send):
    if scope["path"] == "/slow":
        await asyncio.sleep(0.2)
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"2")]})
    await send({"type": "http.response.body", "body": b"ok"})


@contextlib.asynccontextmanager
async def served():
    """Connects to a server of such connections; what is left of a server's connections at its end is closed."""
    config, state = Config(app, log_config=None), ServerState()
    server = await asyncio.get_running_loop().create_server(lambda: Connection(config, state, {}), "127.0.0.1", 0)
    lines = []

    async def connected():
        lines.append(await asyncio.open_connection(*server.sockets[0].getsockname()))
        return lines[-1]

    try:
        yield connected
    finally:
        for _, writer in lines:
            writer.close()
        server.close()


async def cut_off(reader, writer, drops=b""):
    """Sends a byte at a time for as long as somebody listens; whether the server ends it."""
    with contextlib.suppress(OSError):
        async with asyncio.timeout(20):
            for byte in drops:
                writer.write(bytes([byte]))
                await writer.drain()
                await asyncio.sleep(0.01)
                if reader.at_eof():
                    return True
            await reader.read()
    return reader.at_eof() or writer.transport.is_closing()


@pytest.mark.parametrize(
    "first, drops",
    [(b"", b""), (b"", b"GET / HTTP/1.1\r\nx: " + b"y" * 5000), (b"GET / HTTP/1.1\r\nHost: here\r\n", b""),
     (b"POST / HTTP/1.1\r\nHost: here\r\nContent-Length: 9999\r\n\r\n", b"x" * 5000), (REQUEST, b""),
     (REQUEST, REQUEST[:-1] + b"x: " + b"y" * 5000)],
    ids=["nothing", "a header by drops", "half a header", "a body by drops", "no next request", "a next one by drops"],
)  # fmt: skip
def test_who_asks_nothing_or_by_drops_is_cut_off(monkeypatch, first, drops):
    monkeypatch.setattr(connections, "REQUEST_S", 0.2)

    async def run():
        async with served() as connected:
            reader, writer = await connected()
            writer.write(first)
            assert await cut_off(reader, writer, drops)

    asyncio.run(run())


def test_connections_that_wait_keep_nobody_out_and_the_oldest_goes_first(monkeypatch):
    monkeypatch.setattr(connections, "MOST_WAITING", 5)

    async def run():
        async with served() as connected:
            silent = await asyncio.gather(*(connected() for _ in range(20)))
            reader, writer = await connected()
            writer.write(REQUEST)
            assert (await asyncio.wait_for(reader.readline(), 20)).startswith(b"HTTP/1.1 200")
            assert all([await cut_off(*line) for line in silent[:15]])
            assert not any(line[0].at_eof() for line in silent[-4:])

    asyncio.run(run())


def test_an_answer_that_takes_long_is_waited_for(monkeypatch):
    monkeypatch.setattr(connections, "REQUEST_S", 0.05)

    async def run():
        async with served() as connected:
            reader, writer = await connected()
            writer.write(REQUEST.replace(b"/", b"/slow", 1))
            assert (await asyncio.wait_for(reader.readline(), 20)).startswith(b"HTTP/1.1 200")

    asyncio.run(run())
