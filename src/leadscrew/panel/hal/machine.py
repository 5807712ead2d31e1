"""A real machine under the panel: what HAL's sampler takes is shown, what the file lists can be written.

The page is told of the columns, plots and parameters of the file.
"""

from __future__ import annotations

import contextlib
import time
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.kernel.parameters import ParameterSpec, nearest
from leadscrew.panel import presets, scope_commands
from leadscrew.panel.error_sums import ErrorSums
from leadscrew.panel.frames import LIVE, Frame, Thinner
from leadscrew.panel.hal.attach import Attachment
from leadscrew.panel.hal.file import HalFile, Signal
from leadscrew.panel.hal.show import HalRefused
from leadscrew.panel.machine import Later
from leadscrew.util.errors import LeadscrewError, NameUnknown, ValueRefused

NOTICE = (
    "Real machine: {name}, LinuxCNC's HAL. What you set acts at once. This panel is no safety device: it never touches "
    "enable, E-stop or motion; keep the E-stop in reach."
)
GROUPS = {
    "command": "Command and feedback", "feedback": "Command and feedback", "actual": "Command and feedback",
    "error": "Error", "output": "Output", "disturbance": "Disturbance", "other": "Other",
}  # fmt: skip
CAN = {"start": False, "hold": True, "stop": False, "reset": False, "speed": False, "switch": False, "compare": False,
       "circle": False}  # fmt: skip


def entries(file: HalFile, safe: Mapping[str, Any]) -> dict[str, ParameterSpec]:
    """The parameters as data sheets; ``safe`` values are the defaults."""
    return {
        p.key: ParameterSpec(p.key, p.type, safe.get(p.key, p.safe), p.unit, p.help, p.low, p.high)
        for p in file.parameters
    }  # fmt: skip


def describe(file: HalFile, safe: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """The ``machine`` message, without the number of the run."""
    return {
        "kind": "machine", "simulated": False, "notice": NOTICE.format(name=file.name),
        "title": f"REAL MACHINE: {file.name} at LinuxCNC",
        "paper": "", "study": study(file), "controller": "", "scenario": "", "period_s": file.period_s,
        "duration_s": None, "seed": None, "circle": False, "window_s": file.window_s, "notes": "",
        "columns": [{"name": s.source, "unit": s.unit} for s in file.signals], "plots": plots(file),
        "parameters": [_parameter(file, e, values) for e in entries(file, safe).values()], "disturbances": [],
        "views": [], "can": dict(CAN), "controllers": [], "scenarios": [], "studies": [],
    }  # fmt: skip


def study(file: HalFile) -> str:
    """What stands for the study: presets and captures name it."""
    return f"hal: {file.name}"


def plots(file: HalFile) -> list[dict[str, Any]]:
    """The plots of the file; where it has none, one for each kind of role and unit."""
    signals = {s.source: s for s in file.signals}
    if file.plots:
        return [
            _plot(p.title, [signals[s] for s in p.sources], [b.model_dump() for b in p.bands]) for p in file.plots
        ]  # fmt: skip
    found: dict[tuple[str, str], list[Signal]] = {}
    for signal in file.signals:
        found.setdefault((GROUPS[signal.role], signal.shown), []).append(signal)
    titles = [title for title, _ in found]
    return [
        _plot(f"{title}, {unit}" if titles.count(title) > 1 and unit else title, members, [])
        for (title, unit), members in found.items()
    ]


def _plot(title: str, signals: list[Signal], bands: list[dict[str, Any]]) -> dict[str, Any]:
    traces = [
        {"signal": s.source, "label": s.label, "role": s.role, "factor": s.factor, "unit": s.shown} for s in signals
    ]
    return {"title": title, "unit": signals[0].shown, "traces": traces, "bands": bands}


def _parameter(file: HalFile, entry: ParameterSpec, values: Mapping[str, Any]) -> dict[str, Any]:
    own = next(p for p in file.parameters if p.key == entry.key)
    group, dot, label = entry.key.partition(".")
    rate = f" Changes by {own.rate:g} {own.unit}/s at most." if own.rate else ""
    return {
        "key": entry.key, "group": group if dot else file.name, "label": label if dot else entry.key,
        "type": entry.type, "unit": entry.unit, "doc": f"{entry.doc} HAL: {own.hal}.{rate}".strip(),
        "low": entry.above, "high": entry.below, "low_open": False, "high_open": False, "default": entry.default,
        "value": values.get(entry.key), "live": True, "why_not": "",
    }  # fmt: skip


SILENT_S = 1.0
"""Without samples after which the page says that HAL's threads stand still."""
ASK_S = 1.0
"""How often the parameters are read back, for those that somebody else has changed."""
HELD = "the display is held, the machine is not: Hold again shows on"
NEVER = {
    "start": "the panel never starts a real machine: do that in LinuxCNC",
    "stop": "the panel is no way to stop a real machine: use its E-stop or LinuxCNC",
    "reset": "the panel never resets a real machine: do that in LinuxCNC",
    "speed": "a real machine has one speed of time",
    "machine": "the panel is attached to a real machine: start another panel for a simulated one",
    "switch": "controllers of a real machine are not switched from the panel: that takes another HAL file",
    "disturb": "the panel puts no disturbance on a real machine",
    "compare": "a real machine has no second one beside it: take captures before and after, and overlay them",
    "session": "what a real machine did cannot be run again: captures and the audit keep it",
    "session_save": "what a real machine did cannot be run again: captures and the audit keep it",
}
"""Commands that are refused, and why."""


class HalMachine:
    """A machine at LinuxCNC's HAL."""

    def __init__(self, file: HalFile, folder: str | Path = ".", run: int = 0) -> None:
        self.file, self.folder, self.run = file, Path(folder), run + 1
        self.columns = [s.source for s in file.signals]
        self.message = ""
        self.lost = 0
        self.period = 0
        self.scope = scope_commands.ScopeCommands(self.folder / "captures")
        self.attachment = Attachment(file)
        self._held = self._resumed = False
        self._sampled_at = self._asked_at = self._told_at = 0.0
        self._told: dict[str, Any] = {}
        self._undo: list[tuple[dict[str, Any], dict[str, Any]]] = []
        self._redo: list[tuple[dict[str, Any], dict[str, Any]]] = []
        self._writes: deque[float] = deque()
        self._news: list[tuple[str, dict[str, Any]]] = []
        units = {s.source: s.unit for s in file.signals}
        self.scope.watch(["time", *self.columns], {"time": "s", **units}, file.period_s)
        self.live = Thinner(LIVE, self.run)
        self.live.pace(1.0 / file.period_s)
        error = next((s for s in file.signals if s.role == "error"), None)
        self.error_sums = ErrorSums(
            1 + self.columns.index(error.source) if error else None, error.factor if error else 1.0,
            error.shown if error else "",
        )  # fmt: skip
        self._commands: dict[str, Callable[[dict[str, Any]], dict[str, Any] | Later]] = {
            name.removeprefix("_do_"): getattr(self, name) for name in dir(self) if name.startswith("_do_")
        }

    # What the process asks of it.

    def begin(self) -> Later:
        """Attaches."""
        return Later(self.attachment.attach, self._attached)

    def _attached(self, said: list[str]) -> dict[str, Any]:
        self._sampled_at = self._asked_at = time.monotonic()
        for text in said:
            self._notice("warning", text)
        self._news.append(("machine", {}))
        return {"run": self.run}

    @property
    def values(self) -> dict[str, Any]:
        """The parameters as they are in HAL, or on their way to."""
        return self.attachment.values

    def describe(self) -> dict[str, Any]:
        """The ``machine`` message."""
        self._told = dict(self.values)
        return {**describe(self.file, self.attachment.safe, self.values), "run": self.run}

    def tick(self, now: float) -> list[Frame]:
        """What was sampled since; never waits for HAL."""
        pipe = self.attachment.pipe
        if pipe is None:
            return []
        pipe.take()
        if now - self._asked_at >= ASK_S and not pipe.ended:
            self._asked_at = now
            with contextlib.suppress(HalRefused):
                pipe.send({"id": 0, "do": "values"})
        for text in self.attachment.heard():
            self._notice("warning", text)
        blocks, pipe.blocks = pipe.blocks, []
        frames: list[Frame] = []
        for first, rows in blocks:
            self._sampled_at = now
            frames += self._seen(first, rows)
        return frames

    def _seen(self, first: int, rows: np.ndarray) -> list[Frame]:
        """New rows go to the scope, the figures and the page; a gap is told, and breaks the traces."""
        frames = self._gap(first - self.period) if first != self.period else []
        if self._resumed and not self._held:
            frames, self._resumed = [self._nothing()], False
        self.period = first + len(rows)
        whole = np.column_stack([np.arange(first, self.period) * self.file.period_s, rows])
        about = {"study": study(self.file), "values": self.values, "real machine": True}
        self.scope.feed(first, whole, about)
        self.error_sums.feed(whole)
        return [] if self._held else frames + self.live.feed(first, rows)

    def _gap(self, lost: int) -> list[Frame]:
        """Tells a gap; one row of no numbers for the first period that was lost."""
        self.lost += lost
        self._notice("warning", f"{lost} periods were lost at t = {self.period * self.file.period_s:.3f} s: sampler's "
                     f"FIFO was full; the traces have a gap there, {self.lost} periods in all so far")  # fmt: skip
        return [*self.live.flush(), self._nothing()]

    def _nothing(self) -> Frame:
        """One row of no numbers, which breaks the traces."""
        none = np.full((1, len(self.columns)), np.nan, dtype=np.float32)
        return Frame(LIVE, self.run, self.period, 1.0, none)

    def ask(self, do: str, args: dict[str, Any]) -> dict[str, Any] | Later:
        """Obeys one command."""
        if do in scope_commands.COMMANDS:
            return self.scope.ask(do, args)
        if do in NEVER:
            raise ValueRefused(NEVER[do])
        if do not in self._commands:
            raise NameUnknown(f"this machine has no command {do!r}{nearest(do, list(self._commands))}")
        return self._commands[do](args)

    def state(self) -> dict[str, Any]:
        """The machine's part of the ``state`` message."""
        running, message = self._running()
        return {
            "running": running, "speed": 1.0, "message": message or self.message, "t": self.period * self.file.period_s,
            "period": self.period, "behind": False, "ghost": None, "compare": "off", "lost": self.lost,
            "changed": {k: v for k, v in self.values.items() if v != self._told.get(k)},
            "figures": self.error_sums.state(self.file.period_s), "scope": self.scope.state(),
            "can_undo": bool(self._undo), "can_redo": bool(self._redo),
        }  # fmt: skip

    def _running(self) -> tuple[str, str]:
        pipe = self.attachment.pipe
        if pipe is None:
            return "building", ""
        if pipe.ended:
            return "stopped", f"{pipe.ended}; end the panel and start it again to attach again"
        if time.monotonic() - self._sampled_at > SILENT_S:
            return "stopped", "no samples come: HAL's threads do not run, or LinuxCNC has ended"
        return "running", HELD if self._held else ""

    def news(self) -> list[tuple[str, dict[str, Any]]]:
        """What pages have to be told, once."""
        found, self._news = self._news + self.scope.news(), []
        return found

    def why(self, views: tuple[str, ...]) -> dict[str, Any]:
        """A HAL has no views."""
        return {}

    def fail(self, text: str) -> None:
        """An error of ours: the safe values, and the text stays."""
        self.message = text
        with contextlib.suppress(LeadscrewError):
            self._do_safe({"why": "error in the panel"})

    def close(self) -> str:
        """What was written is back at its safe value, and HAL as it was."""
        self.attachment.leave()
        return ""

    # Commands.

    def _do_hold(self, args: dict[str, Any]) -> dict[str, Any]:
        """Holds the display, not the machine; again: shows on."""
        self._held = not self._held
        self._resumed = not self._held
        return self._now()

    def _do_set(self, args: dict[str, Any]) -> dict[str, Any]:
        self._at_this_rate()
        old, new = self._write(args["changes"])
        self._undo.append((old, new))
        self._redo.clear()
        return self._told_of(old, new)

    def _do_undo(self, args: dict[str, Any]) -> dict[str, Any]:
        return self._step_back(self._undo, self._redo, "undo")

    def _do_redo(self, args: dict[str, Any]) -> dict[str, Any]:
        return self._step_back(self._redo, self._undo, "redo")

    def _step_back(self, here: list[Any], there: list[Any], word: str) -> dict[str, Any]:
        if not here:
            raise ValueRefused(f"there is nothing to {word}")
        self._at_this_rate()
        before, after = here[-1]
        old, new = self._write(before)
        here.pop()
        there.append((after, before))
        return self._told_of(old, new)

    def _do_safe(self, args: dict[str, Any]) -> dict[str, Any]:
        """What this panel has written goes back to its safe value."""
        safe, written = self.attachment.safe, sorted(self.attachment.written)
        changes = {k: safe[k] for k in written if safe[k] != self.values[k]}
        old, new = self._write(changes) if changes else ({}, {})
        if changes:
            self._undo.append((old, new))
            self._redo.clear()
        return self._told_of(old, new)

    def _do_presets(self, args: dict[str, Any]) -> dict[str, Any]:
        return {"presets": presets.names(self.folder / "presets")}

    def _do_preset_save(self, args: dict[str, Any]) -> dict[str, Any]:
        found = presets.Preset(study(self.file), "", self.values)
        return {"name": presets.save(found, self.folder / "presets", args["name"]).stem}

    def _do_preset_delete(self, args: dict[str, Any]) -> dict[str, Any]:
        presets.delete(self.folder / "presets", args["name"])
        return {}

    def _do_preset_load(self, args: dict[str, Any]) -> dict[str, Any]:
        found = presets.load(self.folder / "presets", args["name"])
        if found.study != study(self.file):
            raise ValueRefused(f"the preset {args['name']} is of {found.study}, and this is {study(self.file)}")
        changes = {k: v for k, v in found.values.items() if v != self.values.get(k)}
        return self._do_set({"changes": changes}) if changes else self._told_of({}, {})

    def _at_this_rate(self) -> None:
        """Refuses a change that comes too soon after those before it."""
        now = time.monotonic()
        while self._writes and now - self._writes[0] > 1.0:
            self._writes.popleft()
        if len(self._writes) >= self.file.writes_per_s:
            raise ValueRefused(
                f"more than {self.file.writes_per_s:g} changes in a second: the file's writes_per_s allows no more"
            )
        self._writes.append(now)

    def _write(self, changes: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """All of the changes or none; old and new values.

        Raises:
            NameUnknown, ValueRefused: a key that is not listed, or a value that is not allowed; HAL is as before.
            HalRefused: HAL did not take it; what was written before it is back.
        """
        sheet = entries(self.file, self.attachment.safe)
        new = {}
        for key, value in changes.items():
            if key not in sheet:
                raise NameUnknown(f"{key[:80]!r} is not among the parameters of the file{nearest(key, list(sheet))}")
            new[key] = sheet[key].check(value)
        old = self.attachment.write(new)
        self.error_sums.restart(self.period)
        return old, new

    def _told_of(self, old: Mapping[str, Any], new: Mapping[str, Any]) -> dict[str, Any]:
        ramped = any(p.rate for p in self.file.parameters if p.key in new)
        return {**self._now(), "old": dict(old), "new": dict(new), "how": "ramped" if ramped else "at once",
                "before": None, "after": None}  # fmt: skip

    def _now(self) -> dict[str, Any]:
        return {"period": self.period, "t": self.period * self.file.period_s}

    def _notice(self, level: str, text: str) -> None:
        self._news.append(("notice", {"level": level, "text": text}))
