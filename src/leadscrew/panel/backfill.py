"""The last minute of frames, for a page that comes or comes back."""

from __future__ import annotations

import struct
import time
from collections import deque

SECONDS, MOST_BYTES = 60.0, 24_000_000
"""How far back it reaches, and its most memory."""
PIECE = 250_000
"""Bytes above which frames are not joined into one."""
HEADER = struct.Struct("<BBHIIIdd")


class Backfill:
    """A ring of encoded frames of one run and layout."""

    def __init__(self) -> None:
        self._ring: deque[tuple[float, bytes]] = deque()
        self._bytes = 0

    def clear(self) -> None:
        """Another run, or other columns."""
        self._ring.clear()
        self._bytes = 0

    def add(self, frame: bytes, now: float | None = None) -> None:
        """A frame; too old ones leave."""
        now = time.monotonic() if now is None else now
        self._ring.append((now, frame))
        self._bytes += len(frame)
        while self._ring and (self._ring[0][0] < now - SECONDS or self._bytes > MOST_BYTES):
            self._bytes -= len(self._ring.popleft()[1])

    def since(self, period: float | None) -> list[bytes]:
        """Frames that reach to ``period`` or beyond, joined where they follow each other; the ghost's come last."""
        found: list[bytes] = []
        for kind in (1, 2):
            found += _joined([f for _, f in self._ring if f[1] == kind and (period is None or _end(f) > period)])
        return found


def _end(frame: bytes) -> float:
    """The period after the last row's."""
    _, _, _, rows, _, _, first, stride = HEADER.unpack_from(frame)
    return float(first + rows * stride)


def _joined(frames: list[bytes]) -> list[bytes]:
    """Frames whose rows follow each other at the same stride, as one."""
    found: list[bytes] = []
    parts: list[bytes] = []
    size, end = 0, -1.0
    for frame in frames:
        follows = parts and frame[24:32] == parts[0][24:32] and HEADER.unpack_from(frame)[6] == end
        if parts and not (follows and size + len(frame) <= PIECE):
            found.append(_one(parts))
            parts, size = [], 0
        parts.append(frame)
        size, end = size + len(frame), _end(frame)
    return [*found, _one(parts)] if parts else found


def _one(parts: list[bytes]) -> bytes:
    if len(parts) == 1:
        return parts[0]
    head = list(HEADER.unpack_from(parts[0]))
    head[3] = sum(HEADER.unpack_from(p)[3] for p in parts)
    return HEADER.pack(*head) + b"".join(p[HEADER.size :] for p in parts)


__all__ = ["HEADER", "Backfill"]
