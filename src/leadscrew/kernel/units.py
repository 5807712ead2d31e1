"""What meets in a loop: the drive that a controller commands, and the units of command and feedback.

A block that does not say its unit or drive fits everywhere. An actuator with a unit of its own converts, one without
(a limit, an offset) passes on what it gets.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from leadscrew.kernel.block import Block


class UnitWarning(UserWarning):
    """Blocks of a loop whose units or drives differ."""


def mismatches(blocks: Mapping[str, Block | None]) -> Iterator[str]:
    """One sentence for each pair that does not fit."""
    controller, plant, actuator = blocks["controller"], blocks["plant"], blocks["actuator"]
    if controller is not None and plant is not None and (actuator is None or not actuator.unit):
        wanted, given = plant.drive, controller.drive
        if wanted and given and wanted != given:
            yield (
                f"{controller.name} commands a {given}, and {plant.name} takes a {wanted}: an actuator between them "
                "would convert it"
            )
    reference, sensor = blocks["reference"], blocks["sensor"]
    shown = sensor if sensor is not None and sensor.unit else plant
    if reference is not None and shown is not None and reference.unit and shown.unit and reference.unit != shown.unit:
        yield f"the command of {reference.name} is in {reference.unit}, the feedback of {shown.name} in {shown.unit}"
