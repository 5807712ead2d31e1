"""The variables of a functional mock-up unit: what an importer sees of a controller."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.export.core import Core, Knob, Port
from leadscrew.kernel.errors import ValueRefused

_INTEGER = 2**31 - 1
_PLAIN = re.compile(r"[A-Za-z_]\w*", re.ASCII)


@dataclass(frozen=True)
class Variable:
    """One variable, with where it lies in C below ``v->``."""

    reference: int
    name: str
    kind: str
    """``real``, ``int``, ``bool`` or ``choice``."""
    causality: str
    """``input``, ``output`` or ``parameter``."""
    places: tuple[str, ...]
    start: float | int | bool | None = None
    unit: str = ""
    doc: str = ""
    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    open_high: bool = False
    names: tuple[str, ...] = ()
    """Of a choice, from 0."""

    @property
    def range(self) -> str:
        """The allowed range in interval notation; of a choice its numbers and names."""
        if self.names:
            return ", ".join(f"{i} {name}" for i, name in enumerate(self.names))
        left = "(" if self.open_low or self.low == -math.inf else "["
        right = ")" if self.open_high or self.high == math.inf else "]"
        return f"{left}{self.low:.15g}, {self.high:.15g}{right}"


def variables(core: Core) -> tuple[Variable, ...]:
    """All variables in the order of their references, which count from 1.

    Raises:
        ValueRefused: a whole number that 32 bits cannot hold.
    """
    found: list[Variable] = []
    taken = {"time"}
    for name, rest in _all(core):
        unique = name if name not in taken else f"parameters.{name}"
        taken.add(unique)
        found.append(Variable(len(found) + 1, unique, **rest))
    return tuple(found)


def _all(core: Core) -> Iterator[tuple[str, dict[str, Any]]]:
    command = next((p for p in core.inputs if p.role == "command"), core.inputs[0])
    for p in core.inputs:
        place = (f"in.{p.name}",)
        yield p.name, {"kind": "real", "causality": "input", "places": place, "start": p.start, **_said(p)}
    for name, start, doc in (
        ("enable", True, "run the controller, or hold the outputs at zero; taking it away clears a fault"),
        ("index_enable", False, "as LinuxCNC has it: when it falls, the coordinates jump and the controller sees none"),
    ):
        yield name, {"kind": "bool", "causality": "input", "places": (name,), "start": start, "doc": doc}

    for p in core.outputs:
        yield p.name, {"kind": "real", "causality": "output", "places": (f"machine.{p.name}",), **_said(p)}
    for name, kind, unit, doc in (
        ("error", "real", command.unit, "command - feedback"),
        ("saturated", "bool", "", "whether an output is at limits.max_output"),
        ("fault", "bool", "", "whether the outputs are held at zero by a fault"),
        ("fault_code", "int", "", "0 runs, 1 a number was not finite, 2 following error, 3 moved the wrong way"),
    ):
        place = ("machine.fault" if name.startswith("fault") else f"machine.{name}",)
        yield name, {"kind": kind, "causality": "output", "places": place, "unit": unit, "doc": doc}

    tuned = {"causality": "parameter"}
    for knob in core.knobs:
        yield _structured(knob.key), {**tuned, **_tuned(knob, core.real)}
    for name, unit, doc in (
        ("max_output", core.outputs[0].unit, "size of an output; 0: no limit"),
        ("max_error", command.unit, "size of the following error; 0: no limit"),
        ("max_wrong_way", command.unit, "way against the output while it should close the error; 0: no limit"),
    ):
        rest = {"kind": "real", "places": (f"machine.{name}",), "unit": unit, "doc": doc, "low": 0.0}
        yield f"limits.{name}", {**tuned, **rest, "start": _rounded(getattr(core.limits, name), core.real)}
    if core.bumpless:
        doc = "when enabled, go on from an output of zero without a jump; false: from the start state, as simulated"
        yield "bumpless", {**tuned, "kind": "bool", "places": ("machine.bumpless",), "start": False, "doc": doc}
    for role in ("command-deriv", "command-accel"):
        for p in [p for p in core.inputs if p.role == role][:1]:
            rest = {"kind": "bool", "places": (f"machine.derive_{p.name}",), "start": False}
            yield f"derive_{p.name}", {**tuned, **rest, "doc": f"differentiate the command, for want of {p.name}"}


def _said(port: Port) -> dict[str, Any]:
    return {"unit": port.unit, "doc": port.doc or port.key}


def _tuned(knob: Knob, real: str) -> dict[str, Any]:
    """What a knob says about itself, in numbers that the controller can hold."""
    rest: dict[str, Any] = {"kind": {"float": "real"}.get(knob.kind, knob.kind), "unit": knob.unit, "doc": knob.doc}
    rest["places"] = tuple(f"machine.params.{place}" for place in knob.places)
    if knob.kind == "bool":
        return {**rest, "start": bool(knob.value)}
    if knob.kind == "choice":
        return {**rest, "start": int(knob.value), "low": knob.low, "high": knob.high, "names": knob.names}
    rest |= {"open_low": knob.range.startswith("("), "open_high": knob.range.endswith(")")}
    if knob.kind == "int":
        if abs(knob.value) > _INTEGER:
            raise ValueRefused(
                f"{knob.key} = {knob.value}: an FMU holds whole numbers up to {_INTEGER}; do not export it"
            )
        low, high = max(knob.low, -_INTEGER), min(knob.high, _INTEGER)
        open_low = rest["open_low"] and low == knob.low
        open_high = rest["open_high"] and high == knob.high
        return {
            **rest,
            "start": int(knob.value),
            "low": low,
            "high": high,
            "open_low": open_low,
            "open_high": open_high,
        }
    low, high = _rounded(knob.low, real), _rounded(knob.high, real)
    return {**rest, "start": _rounded(knob.value, real), "low": low, "high": high}


def _rounded(value: float, real: str) -> float:
    return float(np.float32(value)) if real == "float" else float(value)


def _structured(key: str) -> str:
    """A dotted key as FMI's structured names allow it: a part that is no identifier stands in quotes."""
    return ".".join(part if _PLAIN.fullmatch(part) else f"'{part}'" for part in key.split("."))
