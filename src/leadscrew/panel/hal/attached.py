"""The process that is attached to HAL: run by the Python that LinuxCNC's ``hal`` module belongs to, spoken to by pipes.

It needs nothing but that module, ``halcmd`` and the file ``attached_parts.py`` beside it. Commands come as JSON, one a
line; answers and samples go out as packets: a letter, the length, and JSON (``J``) or rows of doubles (``S``: number of
the first period, rows, columns, the rows). It keeps the bounds of what may be written itself. When its standard input
ends, which is so however the panel ends, it returns the parameters to their safe values and takes away from HAL all
that it put there.
"""

import json
import os
import select
import signal
import sys
import time

if __name__ == "__main__":
    # Last, not first: no module of this folder stands in for one of the same name elsewhere.
    sys.path.append(sys.path.pop(0))
    from attached_parts import BLOCK, Fifo, Outbox, Refused, halcmd, take_away
    from attached_pause import NoPause, into_thread
else:
    from leadscrew.panel.hal.attached_parts import BLOCK, Fifo, Outbox, Refused, halcmd, take_away
    from leadscrew.panel.hal.attached_pause import NoPause, into_thread

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
                self.outbox.say({"event": "warning", "text": f"{key} stands still: {error}"})
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
