"""The process that is attached to HAL: run by the Python that LinuxCNC's ``hal`` module belongs to, spoken to by pipes.

It needs nothing but that module and ``halcmd``; the panel imports the form of the packets from here. Commands come as
JSON, one a line; answers and samples go out as packets: a letter, the length, and JSON (``J``) or rows of doubles
(``S``: number of the first period, rows, columns, the rows). It keeps the bounds of what may be written itself. When
its standard input ends, which is so however the panel ends, it returns the parameters to their safe values and takes
away from HAL all that it put there.

Functions are put into a running thread of HAL, and taken out, in the pause between two of its periods. HAL does that
without stopping the thread and without asking where it is. One that is just then inside the function that is taken out
goes on in a freed entry: the real-time process ends with a segmentation fault, and the machine with it. With LinuxCNC
2.9 on an ordinary kernel under load that took about 1,000 removals; with the pause, 25,000 did nothing.
"""

from __future__ import annotations

import array
import collections
import contextlib
import ctypes
import errno
import json
import os
import select
import signal
import struct
import subprocess
import sys
import time
from pathlib import Path

SEEN_S = 30e-6
"""From the end of a period to when the thread sleeps."""
LATE_S = 150e-6
"""From the end of a period after which the next pause is waited for; at most a third of a period."""
PATIENCE_S = 10.0


class NoPause(Exception):
    """No pause was found."""


def sleepers():
    """Handles of the states of HAL's real-time threads; none where the system does not show them."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if not (process / "comm").read_text().startswith("rtapi_app"):
                continue
            for task in (process / "task").iterdir():
                if ":T#" in (task / "comm").read_text():
                    found.append(os.open(task / "stat", os.O_RDONLY))
    return found


def asleep(handles):
    """Whether all of the threads sleep."""
    with contextlib.suppress(OSError):
        return all(x[x.rindex(b")") + 2 :][:1] in b"SZX" for x in (os.pread(h, 300, 0) for h in handles))
    return True


def in_pause(hal, thread, period, act):
    """What ``act`` gives, called while the thread sleeps between two periods, or does not run at all.

    Raises:
        NoPause: the thread never sleeps long enough.
    """
    handles, get, now = sleepers(), hal.get_value, time.monotonic
    late, still = min(LATE_S, period / 3.0), max(0.1, 20 * period)
    until = now() + PATIENCE_S
    try:
        while now() < until:
            last, began = get(f"{thread}.time"), now()
            while get(f"{thread}.time") == last and now() - began < still:
                pass
            seen = now()
            while now() - seen < min(SEEN_S, late / 2.0):
                pass
            if asleep(handles) and now() - seen < late:
                return act()
    finally:
        for handle in handles:
            os.close(handle)
    raise NoPause


def library():
    """HAL's own library, which the module hal has loaded: a call takes a microsecond, halcmd a thousand."""
    return ctypes.CDLL("liblinuxcnchal.so.0")


def into_thread(name, thread, period):
    """Puts a function at the end of a thread.

    Raises:
        OSError, NoPause: HAL refuses it, or no pause was found.
    """
    import hal

    add, words = library().hal_add_funct_to_thread, (name.encode(), thread.encode(), -1)
    code = in_pause(hal, thread, period, lambda: add(*words))
    if code:
        raise OSError(-code, f"HAL does not take {name} into {thread}: {os.strerror(-code)}")


def out_of_thread(name, thread, period):
    """Takes a function out of a thread; False: it is still there. It should be idle by now."""
    import hal

    take, words = library().hal_del_funct_from_thread, (name.encode(), thread.encode())
    try:
        code = in_pause(hal, thread, period, lambda: take(*words))
    except (NoPause, RuntimeError, OSError):
        return False
    time.sleep(max(0.02, 5 * period))
    return code in (0, -errno.EINVAL)


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


POLL_S = 0.004
"""How often samples are fetched."""
SILENCE_S = 10.0
"""Without a sign of life of the panel after which the safe values return."""


class Attached:
    """What is done for the panel."""

    def __init__(self, component, outbox):
        import hal

        self.hal, self.component, self.outbox = hal, component, outbox
        self.plan = self.fifo = None
        self.parameters, self.safe, self.ramps, self.written = {}, {}, {}, set()
        self.heard = self.stepped = time.monotonic()
        self.over = self.asked_to_end = False

    def obey(self, line):
        """One command, and its answer."""
        self.heard = time.monotonic()
        asked = json.loads(line)
        try:
            found = getattr(self, f"do_{asked['do']}")(asked)
        except (Refused, RuntimeError, OSError) as error:
            found = {"error": str(error)}
        if "id" in asked:
            self.outbox.say({"re": asked["id"], **(found or {})})

    def do_alive(self, asked):
        """A sign of life."""

    def do_clean(self, asked):
        """Takes away what a helper that was killed has left."""
        if stays := take_away(asked["plan"]):
            raise Refused(stays)

    def do_attach(self, asked):
        """Samples what the plan says, or leaves everything as it was."""
        for key, p in asked["parameters"].items():
            now = self.hal.get_value(p["hal"])
            if not p["low"] <= now <= p["high"]:
                bounds = f"[{p['low']:g}, {p['high']:g}]"
                raise Refused(f"parameters: {key}: {p['hal']} is {now:g} now, outside of {bounds}: widen them")
        plan = {**asked["plan"], "thread": "", "made": [], "loaded": False, "claimed": False}
        try:
            self._attach(plan, asked["plan"])
        except BaseException:
            self.fifo = None
            take_away(plan)
            raise
        self.plan, self.parameters = plan, asked["parameters"]
        values = self.do_values({})["values"]
        self.safe = {k: values[k] if p["safe"] is None else p["safe"] for k, p in self.parameters.items()}
        return {"values": values, "safe": self.safe}

    def _attach(self, plan, asked):
        """Does what is asked; ``plan`` has what of it is done."""
        channel = plan["channel"]
        for marker in asked["made"]:
            halcmd("newsig", marker, "bit")
            plan["made"].append(marker)
        if asked["loaded"]:
            halcmd("loadrt", "sampler", *plan["load"])
            plan["loaded"] = True
        plan["enabled"] = bool(self.hal.get_value(f"sampler.{channel}.enable"))
        self.fifo = Fifo(self.hal, self.component, channel, plan["kinds"], plan["columns"])
        plan["claimed"] = True
        for new, *linked in plan["nets"]:
            halcmd("net", *linked)
            if new:
                plan["made"].append(linked[0])
        self.hal.set_p(f"sampler.{channel}.enable", "1")
        try:
            into_thread(f"sampler.{channel}", asked["thread"], plan["period_s"])
        except NoPause:
            raise Refused(f"the thread {asked['thread']} never rests between its periods: it is overloaded") from None
        plan["thread"] = asked["thread"]

    def do_values(self, asked):
        """The parameters as they are in HAL."""
        return {"values": {k: self.hal.get_value(p["hal"]) for k, p in self.parameters.items()}}

    def do_set(self, asked):
        """Writes parameters: all of them or none."""
        wanted = asked["values"]
        for key, value in wanted.items():
            self._allowed(key, value)
        old = {k: self.hal.get_value(self.parameters[k]["hal"]) for k in wanted}
        began, done = time.monotonic(), []
        try:
            for key, value in wanted.items():
                self.ramps.pop(key, None)
                done.append(key)
                self._begin(key, value)
        except (Refused, RuntimeError) as error:
            for key in done:
                self._back(key, old[key])
            raise Refused(f"{error}; what was set with it is back at its old value") from None
        return {"old": old, "took_s": time.monotonic() - began, "ramps": sorted(set(self.ramps) & set(wanted))}

    def _back(self, key, value):
        self.ramps.pop(key, None)
        try:
            self._put(key, value)
        except (Refused, RuntimeError) as error:
            self.outbox.say({"event": "warning", "text": f"{key} is not back at {value!r}: {error}"})

    def do_safe(self, asked):
        """What was written goes back to its safe value, at its rate where it has one."""
        for key in self.written:
            self._begin(key, self.safe[key])

    def _allowed(self, key, value):
        limits = self.parameters.get(key)
        if limits is None:
            raise Refused(f"{key} is not among the parameters of the file")
        if (
            isinstance(value, bool)
            or not isinstance(value, int | float)
            or not limits["low"] <= value <= limits["high"]
        ):
            raise Refused(f"{key} = {value!r}: allowed range is [{limits['low']:g}, {limits['high']:g}]")

    def _begin(self, key, value):
        """At once, or as a ramp."""
        self.written.add(key)
        if self.parameters[key]["rate"] is None:
            self._put(key, value)
        else:
            self.ramps[key] = value

    def _put(self, key, value):
        """Writes one parameter and reads it back."""
        name, whole = self.parameters[key]["hal"], self.parameters[key]["type"] == "int"
        if isinstance(self.hal.get_value(name), bool):
            raise Refused(f"{name} has become a bit in HAL: it is not written")
        self.hal.set_p(name, str(int(value)) if whole else repr(float(value)))
        back = self.hal.get_value(name)
        if back != value:
            raise Refused(f"{name} is {back!r} in HAL after {value!r} was written: something else writes it, too")

    def step(self):
        """Moves ramps on."""
        now = time.monotonic()
        passed, self.stepped = min(now - self.stepped, 0.05), now
        for key, target in list(self.ramps.items()):
            most = self.parameters[key]["rate"] * passed
            try:
                at = self.hal.get_value(self.parameters[key]["hal"])
                value = target if abs(target - at) <= most else at + (most if target > at else -most)
                self._put(key, value)
            except (Refused, RuntimeError) as error:
                del self.ramps[key]
                self.outbox.say({"event": "warning", "text": f"{key} is not updated: {error}"})
                continue
            if value == target:
                del self.ramps[key]
                self.outbox.say({"event": "reached", "key": key, "value": value})

    def samples(self):
        """Sends what was sampled."""
        if self.fifo is None:
            return
        width = len(self.fifo.columns)
        for first, rows in self.fifo.fetch():
            self.outbox.put(b"S", BLOCK.pack(first, len(rows) // width, width) + rows.tobytes())

    def watch(self):
        """The safe values return where the panel is silent."""
        if self.plan is None or time.monotonic() - self.heard < SILENCE_S:
            return
        self.heard = time.monotonic()
        values = self.do_values({})["values"]
        if any(values[k] != self.safe[k] for k in self.written):
            self.do_safe({})
            self.outbox.say({"event": "warning", "text": f"the panel was silent for {SILENCE_S:g} s: safe values"})

    def do_leave(self, asked):
        """The end, as it is wanted."""
        self.over = True
        return self.end()

    def end(self):
        """Safe values of what was written, and HAL as it was; gives what returned."""
        plan, self.plan = self.plan, None
        if plan is None:
            return {"back": {}}
        back = {}
        for key in sorted(self.written) if plan["on_leave"] == "safe" else ():
            value = self.safe[key]
            try:
                if self.hal.get_value(self.parameters[key]["hal"]) != value:
                    self._begin(key, value)
                    back[key] = value
            except (Refused, RuntimeError) as error:
                self.outbox.say({"event": "warning", "text": f"{key} is not back at {value!r}: {error}"})
        until = time.monotonic() + 12.0
        while self.ramps and back and time.monotonic() < until:
            time.sleep(0.002)
            self.step()
        self.fifo = None
        stays = take_away(plan)
        return {"back": back, "stays": stays}


def main():
    """Until the panel ends, or leaves."""
    sys.path.pop(0)  # no module of this folder stands in for one of the same name elsewhere
    import hal

    component = hal.component(f"leadscrew-panel.{os.getpid()}")
    component.ready()
    attached = Attached(component, Outbox(sys.stdout.fileno()))

    def stop(number, frame):
        attached.over = attached.asked_to_end = True

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    attached.outbox.say({"event": "ready", "pid": os.getpid()})
    waiting, source = b"", sys.stdin.fileno()
    try:
        while not attached.over:
            if select.select([source], [], [], POLL_S)[0]:
                got = os.read(source, 65536)
                if not got:
                    break
                *lines, waiting = (waiting + got).split(b"\n")
                for line in lines:
                    attached.obey(line)
            attached.step()
            attached.samples()
            attached.outbox.flush()
            attached.watch()
    finally:
        if attached.asked_to_end:
            attached.outbox.say({"event": "warning", "text": "LinuxCNC ends, or has unloaded the panel"})
        attached.end()
        attached.outbox.last()
        component.exit()


if __name__ == "__main__":
    main()
