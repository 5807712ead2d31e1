"""How a machine begins, alone or as two axes of a circle, and how it gets another controller in the run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from leadscrew.kernel.frame import SLOTS
from leadscrew.kernel.parameters import checked_replace
from leadscrew.operate.axes import Axes, Later
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.kernel.loop import Loop
    from leadscrew.operate.operated import Start
    from leadscrew.operate.profile import Profile


@dataclass(frozen=True)
class Prepared:
    """A controller ready to take over: built, and its loop compiled."""

    controller: str
    loop: Loop
    """The study's own loop of it."""

    @property
    def block(self) -> Block:
        """The controller as the study's loop has it."""
        found = self.loop.blocks["controller"]
        assert found is not None
        return found

    @property
    def bumpless(self) -> bool:
        """Whether its first output will be the last one of the controller before it."""
        return self.block.align is not None


def built(start: Start, profile: Profile, controller: str | None) -> Loop:
    """The study's loop of a controller in the scenario of ``start``, as it is operated."""
    experiment = start.experiment()
    if controller != start.controller:
        kept = {k: v for k, v in start.changes.items() if not k.startswith("controller.")}
        experiment = replace(experiment, controller=controller, changes=kept)
    return profile.operated(experiment.loop())


def beginning(loop: Loop, start: Start) -> Axes:
    """The machine at its start.

    On a circle the second axis runs as the study has it, with the replicate 1 of the noise; the first is a quarter of
    a turn ahead, at rest at its reversal with its bristles unbent.

    Raises:
        ValueRefused: two axes of a machine that has no circle.
    """
    if not start.circle:
        return Axes([loop.start(engine=start.engine)])
    return Axes([ahead(loop).start(engine=start.engine), loop.start(engine=start.engine, replicate=1)])


def ahead(loop: Loop) -> Loop:
    """The loop of the first axis of a circle."""
    from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD

    command, plant = loop.blocks["reference"], loop.blocks["plant"]
    assert command is not None and plant is not None
    if command.name not in ("sine", "sine_motion") or plant.name != "ballscrew_stage":
        raise ValueRefused(
            f"circle: two axes are run of a ballscrew_stage under a sine; here the plant is {plant.name} and the "
            f"reference {command.name}: choose a sine scenario of fsmc_ballscrew, or one axis"
        )
    p = command.params
    new = loop.using({"reference.phase": p.phase + 0.5 * math.pi})
    radius = p.offset + p.amplitude * math.cos(p.phase)
    new.blocks["plant"] = plant.starting(angle=radius / TRAVEL_MM_PER_RAD, speed=0.0, bristle=0.0)
    return new


def refusal(prepared: Loop, running: Loop) -> str:
    """Why a controller cannot take over the running machine, in words; empty if it can."""
    if prepared.period != running.period:
        return f"it is made for a period of {prepared.period:g} s, this loop runs at {running.period:g} s"
    if prepared.continuous or running.continuous:
        return "a continuous loop has one controller from its start to its end"
    for slot in SLOTS:
        mine, theirs = (x.blocks[slot].name if x.blocks[slot] else "none" for x in (prepared, running))  # type: ignore[union-attr]
        if slot != "controller" and mine != theirs:
            return f"it is made for the {slot.replace('_', ' ')} {mine}, this loop has {theirs}"
    return ""


def switched(axes: Axes, prepared: Prepared, parts: list[dict[str, Any]]) -> Axes:
    """The machine from here on under another controller, each axis with its own values."""
    both = zip(axes.lives, parts, strict=True)
    lives = [live.switch(_with(prepared.block, part)) for live, part in both]
    new = Axes(lives)
    new.period = axes.period
    for x in axes.pending:
        kept = tuple({k: v for k, v in part.items() if not k.startswith("controller.")} for part in x.parts)
        if any(kept):
            new.later(Later(x.period, kept, x.why))
    return new


def _with(block: Block, part: Mapping[str, Any]) -> Block:
    changes = {k.removeprefix("controller."): v for k, v in part.items()}
    return replace(block, params=checked_replace(block.params, changes, where=block.name)) if changes else block


__all__ = ["Prepared", "ahead", "beginning", "built", "refusal", "switched"]
