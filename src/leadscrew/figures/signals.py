"""The units of a loop's signals."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop


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
