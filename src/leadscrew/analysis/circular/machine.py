"""What draws a circle: one loop of two axes, or one loop for each, and how their signals are named."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from leadscrew.analysis.circular import command
from leadscrew.kernel.block import Block
from leadscrew.kernel.errors import ValueRefused
from leadscrew.kernel.frame import as_floats
from leadscrew.kernel.layout import Layout
from leadscrew.kernel.loop import Loop

MM = {"mm": 1.0, "um": 1e-3, "m": 1e3, "in": 25.4, "inch": 25.4}
"""Millimetres in the units that a block may say."""


@dataclass(frozen=True)
class Machine:
    """What draws: one loop of two axes, or one loop for each."""

    x: Loop
    y: Loop | None = None
    """The loop of Y; None: ``x`` moves both."""
    unit: str | None = None
    """Of the loops' positions; what their blocks say unless given."""

    def mm(self) -> float:
        """Millimetres in the unit of the loops.

        Raises:
            ValueRefused: it is not known, no length, or differs between the axes.
        """
        said = {self.unit} if self.unit else {_unit(loop) for loop in (self.x, self.y) if loop is not None}
        if len(said) != 1:
            raise ValueRefused(f"the axes have different units: {', '.join(sorted(said))}; a circle needs one")
        unit = next(iter(said))
        if not unit:
            raise ValueRefused(f"{self.x.name} does not say the unit of its position; expected {', '.join(MM)}")
        if unit not in MM:
            raise ValueRefused(f"{self.x.name} moves in {unit}; a circle needs a length: {', '.join(MM)}")
        return MM[unit]


def _unit(loop: Loop) -> str:
    said = [b.unit for s in ("plant", "sensor", "reference") if (b := loop.blocks[s]) is not None]
    return next((u for u in said if u in MM), next((u for u in said if u), ""))


def with_reference(loop: Loop, reference: Block) -> Loop:
    """The loop with another reference; its metrics, which may be about the old one, left out."""
    held: dict[str, Any] = {s: b for s, b in loop.blocks.items() if s != "reference"}
    return Loop(
        reference=reference,
        metrics={},
        period=None if loop.continuous else loop.period,
        sample=loop.period,
        substeps=loop.substeps,
        method=loop.method,
        computation_delay=loop.sent * loop.step,
        transport_delay=loop.seen * loop.step,
        bound=loop.bound,
        seed=loop.seed,
        rtol=loop.rtol,
        atol=loop.atol,
        engine=loop.engine,
        name=loop.name,
        **held,
    )


def _leaves(signal: Any) -> dict[str, float]:
    """The numbers of a signal by dotted name; a lone number has none."""
    floats = as_floats(signal)
    layout = Layout(floats)
    values = layout.pack(floats)[0]
    return {leaf.key: float(values[leaf.at]) for leaf in layout.scalars}


def place_of(loop: Loop, signal: str, field: str, which: int) -> tuple[str, float]:
    """Column and first value of an axis's position in a signal."""
    leaves = {f".{k}" if k else "": v for k, v in _leaves(loop.signals[signal]).items()}
    for name in (f"{field}.position", field):
        if name in leaves:
            return signal + name, leaves[name]
    if field:
        shown = ", ".join(k.lstrip(".") for k in leaves if k) or "one number"
        raise ValueRefused(
            f"{loop.name} has not two axes: its {signal} is {shown}, expected x and y; give the loop of the other axis"
        )
    shown = ", ".join(k.lstrip(".") for k in leaves)
    if any(k.startswith(".x") for k in leaves) and any(k.startswith(".y") for k in leaves):
        raise ValueRefused(f"{loop.name} has both axes already; the loop of another axis is for a loop of one")
    raise ValueRefused(f"{loop.name}: its {signal} is {shown}; expected one position for axis {'XY'[which]}")


def reference_of(loop: Loop, which: int, both: bool) -> Block:
    """The circle in the form of the loop's command."""
    keys = set(_leaves(loop.signals["command"]))
    ends = {k.rsplit(".", 1)[-1] for k in keys}
    motion = bool(ends & {"position", "velocity", "acceleration"})
    if not both:
        if any(k not in ("", "position", "velocity", "acceleration") for k in keys):
            raise ValueRefused(
                f"{loop.name} is commanded by {', '.join(sorted(keys))}; a loop of one axis takes a position, or a "
                "motion"
            )
        blocks = (command.circle_x_motion, command.circle_y_motion) if motion else (command.circle_x, command.circle_y)
        return replace(blocks[which], unit=_unit(loop))
    axes = {k.split(".", 1)[0] for k in keys}
    if axes not in ({"x", "y"}, {"x", "y", "z"}):
        shown = ", ".join(sorted(axes)) or "one number"
        raise ValueRefused(
            f"{loop.name} has not two axes: it is commanded by {shown}, expected x and y; give the loop of the other "
            "axis"
        )
    if motion:
        return command.circle_motion if len(axes) == 2 else command.circle_motion_3
    return command.circle_point if len(axes) == 2 else command.circle_point_3
