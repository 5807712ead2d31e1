"""Records of the stage from which ``leadscrew identify friction`` reads the friction, at 4 kHz with a scale of 10 nm.

- ``test``: the move of :obj:`leadscrew.references.friction_test` under a bare PD, which lets the torque creep up while
  the bristles hold: it determines all six parameters;
- ``sines``: 5 sin t + sin 2 pi t mm under a PD with disturbance observer, in motion from the start: static friction and
  Stribeck speed act in it for a third of a millisecond a reversal, and cannot be identified.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.parameters import Unit
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.references._friction_test import friction_test, friction_test_duration
from leadscrew.references._motion import Motion
from leadscrew.sensors._counts import ruler
from leadscrew.studies.fsmc_ballscrew.controllers import BARE_PD, CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.scenarios import ENCODER_NM, MACHINES, PERIOD_S

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

SINES_S = 7.9
"""Length of the record of two sines."""


class TwoSines(NamedTuple):
    """Amplitudes and rates, in the unit of the loop's command."""

    first: Annotated[float, Unit("mm")] = 5.0
    first_rate: Annotated[float, Unit("rad/s")] = 1.0
    second: Annotated[float, Unit("mm")] = 1.0
    second_rate: Annotated[float, Unit("rad/s")] = 2.0 * math.pi


@reference(TwoSines())
def two_sines(p, t):
    """The sum of two sines, as a :class:`Motion`."""
    a = p.first * math.sin(p.first_rate * t)
    b = p.second * math.sin(p.second_rate * t)
    return Motion(
        a + b,
        p.first * p.first_rate * math.cos(p.first_rate * t) + p.second * p.second_rate * math.cos(p.second_rate * t),
        -p.first_rate * p.first_rate * a - p.second_rate * p.second_rate * b,
    )


def record_loop(kind: str, machine: str = "nominal", changes: Mapping[str, Any] | None = None) -> tuple[Loop, float]:
    """The loop that makes a record, ``test`` or ``sines``, and for how many seconds."""
    from leadscrew.kernel.loop import Loop

    axis, test = MACHINES[machine], kind == "test"
    loop = Loop(
        reference=friction_test() if test else two_sines,
        controller=BARE_PD if test else CONTROLLERS["ours.pd_dob_fixed"],
        plant=axis.plant,
        sensor=ruler(resolution_mm=1e-6 * ENCODER_NM),
        period=PERIOD_S,
        metrics={},
        **axis.options,
    )
    loop = loop.using(changes) if changes else loop
    plant, p = loop.blocks["plant"], two_sines.params
    assert plant is not None
    if not test:
        speed = (p.first * p.first_rate + p.second * p.second_rate) / TRAVEL_MM_PER_RAD
        loop.blocks["plant"] = axis.start(plant, speed)
    return loop, friction_test_duration() if test else SINES_S
