"""Metrics of a run and parameters of a study as rows for tables, terminal and page alike."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

from leadscrew.figures.signals import signal_unit
from leadscrew.kernel.parameters import ParameterSpec, entries

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.kernel.loop import Loop
    from leadscrew.kernel.run import Run
    from leadscrew.study_data import Study

_ROLE = re.compile(r":\w+:`~?(?:[\w.]+\.)?(\w+)`")


def plain(text: str) -> str:
    """A docstring without the marks of the documentation."""
    return _ROLE.sub(r"\1", text).replace("``", "")


def first_line(text: str) -> str:
    """The first line of a docstring, plain."""
    return plain(text.strip().splitlines()[0].strip()) if text.strip() else ""


# ---- metrics and units
class MetricRow(NamedTuple):
    """One metric of a run."""

    name: str
    value: float
    unit: str
    doc: str
    reason: str = ""
    """Why it has no value."""


def integrated(by: Mapping[str, Any]) -> str:
    """A loop's ``integration`` in words; empty for a plant that brings its own step."""
    if by["method"] == "own step":
        return ""
    if by["rtol"] is not None:
        return f"{by['method']} (rtol {by['rtol']:g}, atol {by['atol']:g})"
    return f"{by['method']} ({by['substeps']} step{'s' if by['substeps'] > 1 else ''} a period)"


def metric_unit(loop: Loop, metric: Block) -> str:
    """A metric's unit in this loop; a ``?`` stands where a block does not say its unit."""
    unit = metric.unit
    for mark, signal in (("[error]", "error"), ("[output]", "output")):
        if mark in unit:
            unit = unit.replace(mark, signal_unit(loop, signal) or "?")
    return unit


def metric_rows(run: Run) -> list[MetricRow]:
    """The metrics of a run, with units, and why one has no value."""
    blocks, reasons = run.loop.metrics, run.metrics_without_value
    return [
        MetricRow(
            name, float(value), metric_unit(run.loop, blocks[name]), first_line(blocks[name].doc), reasons.get(name, "")
        )
        for name, value in run.metrics.items()
    ]


# ---- what can be set
@dataclass(frozen=True)
class Setting:
    """One parameter that can be set, and in which controllers or scenarios it is there with this default."""

    entry: ParameterSpec
    where: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        row = asdict(self.entry)
        row = {k: row[k] for k in ("key", "type", "default", "unit", "doc")}
        names = {} if self.entry.choice is None else {"choices": list(self.entry.choice.names)}
        return row | {"range": self.entry.range, "where": list(self.where)} | names


def settings(study: Study) -> list[Setting]:
    """Everything that can be set in a study, each distinct default once."""
    controllers, scenarios = list(study.controllers), list(study.scenarios)
    found: list[Setting] = []
    for name in scenarios:
        _merge(found, entries(study.scenarios[name].params, "scenario."), name)
    for name in controllers:
        _merge(found, _without(study.loop(name, scenarios[0]), "reference."), name)
    for name in scenarios:
        sheet = study.loop(controllers[0], name).sheet
        _merge(found, (e for k, e in sheet.items() if k.startswith("reference.")), name)
    whole = (set(controllers), set(scenarios))
    found = [replace(s, where=()) if set(s.where) in whole else s for s in found]
    order = ("scenario", "reference", "sensor", "controller", "actuator", "plant")
    keys = list(dict.fromkeys(s.entry.key for s in found))

    def place(setting: Setting) -> tuple[int, int]:
        root = _root(setting)
        return order.index(root) if root in order else len(order), keys.index(setting.entry.key)

    return sorted(found, key=place)


def _root(setting: Setting) -> str:
    return setting.entry.key.split(".")[0]


def _without(loop: Loop, prefix: str) -> Iterable[ParameterSpec]:
    return (e for k, e in loop.sheet.items() if not k.startswith(prefix))


def _merge(found: list[Setting], sheet: Iterable[ParameterSpec], name: str) -> None:
    for entry in sheet:
        for at, known in enumerate(found):
            if _same(known.entry, entry):
                found[at] = replace(known, where=(*known.where, name))
                break
        else:
            found.append(Setting(entry, (name,)))


def _same(a: ParameterSpec, b: ParameterSpec) -> bool:
    import numpy as np

    return a.key == b.key and (a.unit, a.range) == (b.unit, b.range) and np.array_equal(a.default, b.default)
