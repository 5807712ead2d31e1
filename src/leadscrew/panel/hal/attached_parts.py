"""What the process at HAL is made of: its packets, the reader of sampler's FIFO, and how HAL is left as it was.

Imported by ``attached.py`` as a plain file beside it, and by the panel for the form of the packets. LinuxCNC's ``hal``
is imported only by what runs in that process.
"""

import array
import collections
import contextlib
import json
import os
import select
import struct
import subprocess
import time

if __package__:
    from leadscrew.panel.hal.attached_pause import out_of_thread
else:
    from attached_pause import out_of_thread  # type: ignore[no-redef]

MOST_WAITING = 16_000_000
"""Bytes that wait for the panel at most; then the oldest samples are dropped, which shows as a gap."""
PACKET = struct.Struct("<cI")
BLOCK = struct.Struct("<QII")


class Refused(Exception):
    """What was asked is not done; one sentence says why."""


def halcmd(*words):
    """Runs a command of HAL.

    Raises:
        Refused: it failed.
    """
    done = subprocess.run(["halcmd", *words], capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)
    if done.returncode:
        told = [x for x in done.stderr.splitlines() if x.strip() and not x.startswith(("Note:", "Running with"))]
        raise Refused(f"halcmd {' '.join(words)}: {told[0] if told else f'ended with {done.returncode}'}")


def tried(*words):
    """As ``halcmd``; what fails is passed over, for what may be gone already."""
    try:
        halcmd(*words)
    except Refused:
        return False
    return True


class Outbox:
    """Packets that wait for the panel; never blocks."""

    def __init__(self, handle):
        self.handle, self.size, self.head = handle, 0, b""
        self.waiting: collections.deque[tuple[bytes, bytes]] = collections.deque()
        os.set_blocking(handle, False)

    def put(self, kind, payload):
        """One packet; the oldest samples are dropped where too much waits."""
        self.waiting.append((kind, PACKET.pack(kind, len(payload)) + payload))
        self.size += len(payload)
        while self.size > MOST_WAITING and any(k == b"S" for k, _ in self.waiting):
            at = next(i for i, (k, _) in enumerate(self.waiting) if k == b"S")
            self.size -= len(self.waiting[at][1]) - PACKET.size
            del self.waiting[at]
        self.flush()

    def say(self, message):
        """One message."""
        self.put(b"J", json.dumps(message).encode())

    def flush(self):
        """As much as the pipe takes."""
        try:
            while self.head or self.waiting:
                if not self.head:
                    self.head = self.waiting.popleft()[1]
                    self.size -= len(self.head) - PACKET.size
                self.head = self.head[os.write(self.handle, self.head) :]
        except BlockingIOError:
            return
        except OSError:
            self.head = b""
            self.waiting.clear()

    def last(self):
        """What waits, as far as the panel takes it within a second."""
        until = time.monotonic() + 1.0
        self.flush()
        while (self.head or self.waiting) and time.monotonic() < until:
            select.select([], [self.handle], [], 0.1)
            self.flush()


class Fifo:
    """Reads a channel of sampler; numbers the periods, those that were lost included.

    The sampler's own numbers do not count what found the FIFO full (LinuxCNC 2.9), so overruns are counted, and put
    where they happened: behind the rows that the full FIFO held.
    """

    def __init__(self, hal, component, channel, kinds, columns):
        self.stream = hal.stream(component, hal.sampler_base + channel, kinds)
        self.columns, self.next, self.last = columns, 0, None
        while self.stream.readable:
            self.stream.read()
        self.overruns = self.stream.num_overruns
        self.lost = self.full = 0
        """Periods lost behind the next ``full`` rows."""

    def fetch(self):
        """Blocks of consecutive rows: number of the first period, and the numbers row by row."""
        stream, blocks = self.stream, []
        first, rows = self.next, array.array("d")
        while stream.readable:
            row = stream.read()
            jump = self._jump()
            if jump:
                if rows:
                    blocks.append((first, rows))
                self.next += jump
                first, rows = self.next, array.array("d")
            rows.extend(float(row[i]) for i in self.columns)
            self.next += 1
        if rows:
            blocks.append((first, rows))
        return blocks

    def _jump(self):
        """Periods that were lost before the row that was read last."""
        number = self.stream.sampleno
        jump = 0 if self.last is None else (number - self.last - 1) & 0xFFFFFFFF
        self.last, jump = number, jump if jump < 1 << 31 else 0
        if self.lost and not self.full:
            jump, self.lost = max(jump, self.lost), 0
        overruns = self.stream.num_overruns
        if overruns != self.overruns and not self.lost:
            self.lost, self.full = (overruns - self.overruns) & 0xFFFFFFFF, self.stream.maxdepth - 1
            self.overruns = overruns
        self.full = max(0, self.full - 1)
        return jump


def take_away(plan):
    """Leaves HAL as it was before ``attach``; what is gone already is passed over. Gives what stays, as a sentence."""
    import hal

    name = f"sampler.{plan['channel']}"
    if plan["claimed"]:
        with contextlib.suppress(RuntimeError):
            hal.set_p(f"{name}.enable", "0")
        if plan["thread"] and not out_of_thread(name, plan["thread"], plan["period_s"]):
            return f"{name} stays in the thread, idle: no moment was found to take it out; the next panel does"
    if plan["loaded"]:
        tried("unloadrt", "sampler")
    elif plan["claimed"]:
        for pin in plan["pins"]:
            tried("unlinkp", pin)
        if plan["enabled"]:
            tried("setp", f"{name}.enable", "1")
    for made in reversed(plan["made"]):
        tried("delsig", made)
    return ""
