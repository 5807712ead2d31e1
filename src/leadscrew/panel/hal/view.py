"""What the page is told of a HAL: its columns, plots and parameters, from the file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from leadscrew.kernel.sheet import Entry
from leadscrew.panel.hal.file import HalFile, Signal

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


def entries(file: HalFile, safe: Mapping[str, Any]) -> dict[str, Entry]:
    """The parameters as data sheets; ``safe`` values are the defaults."""
    return {
        p.key: Entry(p.key, p.type, safe.get(p.key, p.safe), p.unit, p.help, p.low, p.high) for p in file.parameters
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


def _parameter(file: HalFile, entry: Entry, values: Mapping[str, Any]) -> dict[str, Any]:
    own = next(p for p in file.parameters if p.key == entry.key)
    group, dot, label = entry.key.partition(".")
    rate = f" Changes by {own.rate:g} {own.unit}/s at most." if own.rate else ""
    return {
        "key": entry.key, "group": group if dot else file.name, "label": label if dot else entry.key,
        "type": entry.type, "unit": entry.unit, "doc": f"{entry.doc} HAL: {own.hal}.{rate}".strip(),
        "low": entry.above, "high": entry.below, "low_open": False, "high_open": False, "default": entry.default,
        "value": values.get(entry.key), "live": True, "why_not": "",
    }  # fmt: skip


__all__ = ["CAN", "NOTICE", "describe", "entries", "plots", "study"]
