"""Connections that ask nothing: cut off after some seconds, and never so many that others cannot come in."""

from __future__ import annotations

import asyncio

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

REQUEST_S = 10.0
"""How long a connection may be open without a request, or with one whose header, or whose body after the answer, is not
complete. A request that is being answered has its own bounds.
"""
MOST_WAITING = 64
"""Connections that may wait so; with one more, the oldest is cut off."""


class Connection(H11Protocol):
    """One connection of the server, until it becomes a WebSocket."""

    cut_off: asyncio.TimerHandle | None = None
    """While it waits for a request: when it is cut off."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """A connection more."""
        super().connection_made(transport)
        self._wait()
        waiting = [(c.cut_off.when(), c) for c in self.connections if isinstance(c, Connection) and c.cut_off]
        if len(waiting) > MOST_WAITING:
            min(waiting, key=lambda x: x[0])[1].cut()

    def handle_events(self) -> None:
        """Bytes came: perhaps the last of a request's header."""
        super().handle_events()
        if self.cycle is not None and not self.cycle.response_complete:
            self._wait_no_more()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """A WebSocket from now on."""
        self._wait_no_more()
        super().handle_websocket_upgrade(event)

    def on_response_complete(self) -> None:
        """The request was answered, though its body may still be on its way."""
        self._wait()
        super().on_response_complete()

    def connection_lost(self, exc: Exception | None) -> None:
        """The end."""
        self._wait_no_more()
        super().connection_lost(exc)

    def cut(self) -> None:
        """Ends the connection; from now on it counts no more."""
        self._wait_no_more()
        self.connections.discard(self)
        self.transport.abort()

    def _wait(self) -> None:
        self._wait_no_more()
        self.cut_off = self.loop.call_later(REQUEST_S, self.cut)

    def _wait_no_more(self) -> None:
        if self.cut_off is not None:
            self.cut_off.cancel()
            self.cut_off = None


__all__ = ["MOST_WAITING", "REQUEST_S", "Connection"]
