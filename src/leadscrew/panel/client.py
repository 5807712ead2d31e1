"""One page's line: what it is to be sent waits in a bounded queue, so that a slow page slows nobody else."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from typing import Any

from leadscrew.panel.http_guard import Rate

MOST_BYTES, MOST_FRAMES = 4_000_000, 250
"""Live frames that wait for a page, at most; then the oldest are left out."""
MOST_TEXTS, MOST_WAITING = 2000, 150_000_000
"""Messages, and bytes, that may not be left out and wait; a page with more is cut off."""
SAID_S = 2.0
SILENT_S = 10.0
"""A page that takes nothing for so long is lost."""


class Client:
    """A page; ``send`` of the WebSocket is called only by :meth:`pump`."""

    def __init__(self, number: int, address: str) -> None:
        self.number, self.address = number, address
        self.name, self.secret = "", ""
        self.views: tuple[str, ...] = ()
        self.rate = Rate()
        self.over = 0
        """Messages beyond the rate since it was last said."""
        self.over_at = 0.0
        self.gone = False
        self._must: deque[tuple[int, str | bytes]] = deque()
        self._frames: deque[tuple[int, bytes]] = deque()
        self._latest: dict[str, tuple[int, str]] = {}
        self._serial = 0
        self._bytes = self._waiting = self._dropped = 0
        self._said_at = 0.0
        self._ready = asyncio.Event()

    def put(self, message: str | bytes) -> None:
        """A message that has to arrive."""
        self._must.append((self._next(), message))
        self._waiting += len(message)
        if len(self._must) > MOST_TEXTS or self._waiting > MOST_WAITING:
            self.gone = True

    def put_latest(self, kind: str, message: str) -> None:
        """A message that the next of its kind replaces while it waits."""
        self._latest[kind] = self._next(), message

    def put_frame(self, frame: bytes) -> None:
        """Live rows; the oldest are left out where too many wait."""
        self._frames.append((self._next(), frame))
        self._bytes += len(frame)
        while self._bytes > MOST_BYTES or len(self._frames) > MOST_FRAMES:
            _, old = self._frames.popleft()
            self._bytes -= len(old)
            self._dropped += 1

    def put_old(self, frames: list[bytes]) -> None:
        """Rows from before; they come ahead of what is live, and are no reason to leave that out."""
        for frame in frames:
            self.put(frame)

    def end(self) -> None:
        """Nothing more is sent."""
        self.gone = True
        self._ready.set()

    def dropped(self) -> int:
        """Frames left out since this was said; 0 where that was just now."""
        now = time.monotonic()
        if not self._dropped or now - self._said_at < SAID_S:
            return 0
        self._said_at, count, self._dropped = now, self._dropped, 0
        return count

    def take(self) -> str | bytes | None:
        """What is to be sent next, in the order in which it came; None where nothing waits."""
        heads = [q[0][0] for q in (self._must, self._frames) if q] + [number for number, _ in self._latest.values()]
        if not heads:
            return None
        first = min(heads)
        if self._must and self._must[0][0] == first:
            message = self._must.popleft()[1]
            self._waiting -= len(message)
            return message
        for kind, (number, text) in self._latest.items():
            if number == first:
                del self._latest[kind]
                return text
        _, frame = self._frames.popleft()
        self._bytes -= len(frame)
        return frame

    async def pump(self, socket: Any) -> None:
        """Sends what waits, for as long as the page is there.

        Raises:
            TimeoutError: it is lost, though nobody said so.
        """
        while not self.gone:
            message = self.take()
            if message is None:
                self._ready.clear()
                await self._ready.wait()
                continue
            async with asyncio.timeout(SILENT_S):
                await (socket.send_text(message) if isinstance(message, str) else socket.send_bytes(message))

    def _next(self) -> int:
        self._serial += 1
        self._ready.set()
        return self._serial


__all__ = ["Client"]
