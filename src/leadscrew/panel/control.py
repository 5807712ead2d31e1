"""Who has control: one page at a time, which keeps it over a lost connection, and loses it after a time-out."""

from __future__ import annotations

import hmac
import time
from dataclasses import dataclass


@dataclass
class Writer:
    """The page that has control; ``client`` is None while its connection is lost, since ``lost_at`` (monotonic s)."""

    name: str
    secret: str
    client: int | None
    lost_at: float = 0.0


class Control:
    """The one writer."""

    def __init__(self, timeout_s: float) -> None:
        self.timeout_s = timeout_s
        self.writer: Writer | None = None

    def has(self, client: int) -> bool:
        """Whether this client has control."""
        return self.writer is not None and self.writer.client == client

    def is_of(self, secret: str) -> bool:
        """Whether the page of this secret has control, and is there."""
        found = self.writer
        return found is not None and found.client is not None and _same(found.secret, secret)

    def take(self, client: int, name: str, secret: str) -> str:
        """Gives control where it is free; empty, or the sentence why not."""
        if self.has(client):
            return ""
        if secret and self.resume(client, secret) is not None:
            return ""
        if self.writer is not None:
            free = f"it is free when given up, or {self.timeout_s:g} s after its page is lost"
            return f"{self.writer.name} has control; {free}"
        self.writer = Writer(name, secret, client)
        return ""

    def resume(self, client: int, secret: str) -> int | None:
        """Gives control back to the page that had it, by its secret; the client that had it until now, or -1 for none.

        None where this is another page.
        """
        found = self.writer
        if found is None or not _same(found.secret, secret):
            return None
        before, found.client = found.client, client
        return -1 if before is None else before

    def release(self) -> None:
        """Control is free."""
        self.writer = None

    def lost(self, client: int) -> bool:
        """The connection of a client ended; whether it had control."""
        if not self.has(client):
            return False
        assert self.writer is not None
        self.writer.client, self.writer.lost_at = None, time.monotonic()
        return True

    def timed_out(self) -> Writer | None:
        """The writer whose page has been lost for too long, once; control is then free."""
        found = self.writer
        if found is None or found.client is not None or time.monotonic() - found.lost_at < self.timeout_s:
            return None
        self.writer = None
        return found

    def told(self) -> dict[str, object] | None:
        """For the ``state`` message; the id is 0 while the page is lost."""
        found = self.writer
        return None if found is None else {"id": found.client or 0, "name": found.name}


def _same(one: str, other: str) -> bool:
    """Whether two secrets are the same; no secret is the same as none."""
    both = (one.encode("utf-8", "replace"), other.encode("utf-8", "replace"))
    return bool(one) and hmac.compare_digest(*both)


__all__ = ["Control", "Writer"]
