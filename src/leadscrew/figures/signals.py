"""The units of a loop's signals, and which number of a signal the loop compares."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from leadscrew.kernel.frame import pairs, under
from leadscrew.kernel.layout import Layout, is_branch
from leadscrew.kernel.parameters import entries

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

PER_UNIT: tuple[dict[str, float], ...] = (
    {"m": 1.0, "mm": 1e3, "um": 1e6, "nm": 1e9},
    {"rad": 1.0, "urad": 1e6},
    {"V": 1.0, "mV": 1e3},
    {"1": 1.0, "%": 100.0},
    {"1/m": 1e3, "1/mm": 1.0},
    {"Hz": 1.0, "1/min": 60.0, "rad/s": 2.0 * math.pi},
)
"""How many of each unit are the same size."""


def factor_between(own: str, shown: str) -> float:
    """What a value in the unit ``own`` is multiplied by to be one in ``shown``; 1 where a unit is not known."""
    return next((per[shown] / per[own] for per in PER_UNIT if own in per and shown in per), 1.0)


UNITS = {"voltage": "V", "torque": "N m", "force": "N", "duty": "1"}
"""Of what a plant takes."""


def _taken(loop: Loop) -> str:
    """The unit that a plant takes, for a controller that does not say its own."""
    plant = loop.blocks["plant"]
    return UNITS.get(plant.drive, "") if plant is not None else ""


def signal_unit(loop: Loop, signal: str) -> str:
    """The unit of a loop's signal as far as its blocks say."""

    def of(*slots: str) -> str:
        return next((b.unit for s in slots if (b := loop.blocks[s]) is not None and b.unit), "")

    root = signal.split(".")[0]
    if root == "time":
        return "s"
    if root in ("output", "applied"):
        return of("controller") or ("" if of("actuator") else _taken(loop))
    if root == "disturbance":
        return of("disturbance")
    return of("plant", "sensor", "reference")


def column_units(loop: Loop) -> dict[str, str]:
    """The unit of every column, as far as signals, states and blocks say."""
    declared: dict[str, str] = {}
    for signal, example in loop.signals.items():
        if is_branch(example) and not signal.startswith("_"):
            root = "disturbance" if signal == "load" else signal
            declared |= {f"{root}.{e.key}": e.unit for e in entries(example)}
    for slot, block in loop.blocks.items():
        if block is not None and block.state is not None:
            declared |= {e.key: e.unit for e in entries(loop.start_state(block), f"{slot}.")}

    def unit(column: str) -> str:
        if declared.get(column):
            return declared[column]
        root, _, rest = column.partition(".")
        whole = signal_unit(loop, column) if rest in ("", "position", "deviation") else ""
        if root in ("error", "true_error"):
            return declared.get(f"feedback.{rest}") or declared.get(f"actual.{rest}") or whole
        return "" if column in declared and rest != "position" else whole

    return {c: unit(c) for c in loop.program.plan.columns}


def compared_column(loop: Loop, signal: str) -> str:
    """The column of a signal: its own, or of several numbers the first that command and feedback are compared by."""
    if signal not in ("command", "actual", "feedback", "error", "true_error"):
        return signal
    measured = "actual" if signal in ("actual", "true_error") else "feedback"
    pair = pairs(Layout(loop.signals["command"]).tree, Layout(loop.signals[measured]).tree)[0]
    return under(signal, {"command": pair.command, measured: pair.other}.get(signal, pair.suffix.removeprefix(".")))
