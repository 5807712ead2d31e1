"""Friction found from one record of 8 s, and the controller that believes it.

Two records of the stage at 4 kHz with a scale of 10 nm:

- ``sines``: 5 sin t + sin 2 pi t mm under a PD with disturbance observer and the paper's hat, as the digest's;
- ``test``: the move of :mod:`leadscrew.references.friction_test` under a bare PD, which lets the torque creep up while
  the bristles hold.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, NamedTuple

from leadscrew.controllers.pd_dob import TUNINGS
from leadscrew.friction.lugre import LuGre
from leadscrew.identify.friction import FrictionFit, fit_friction
from leadscrew.kernel.block import Block, reference
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.sheet import Unit
from leadscrew.plants.ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.references.friction_test import duration, friction_test
from leadscrew.references.motion import Motion
from leadscrew.sensors.ruler import ruler
from leadscrew.studies.fsmc_ballscrew.machines import MACHINES
from leadscrew.studies.fsmc_ballscrew.runs import ENCODER_NM, PERIOD_S, Loops
from leadscrew.studies.fsmc_ballscrew.tunings import BARE_PD

SINES_S = 7.9
"""Length of the digest's record."""


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
    axis = MACHINES[machine]
    common: dict[str, Any] = {
        "sensor": ruler(resolution_mm=1e-6 * ENCODER_NM), "period": PERIOD_S, "metrics": {}, **axis.options,
    }  # fmt: skip
    if kind == "test":
        loop = Loop(reference=friction_test(), controller=BARE_PD, plant=axis.plant, **common)
        return (loop.using(changes) if changes else loop), duration()
    law = TUNINGS["ours.pd_dob_fixed"](travel_per_rad=TRAVEL_MM_PER_RAD)
    loop = Loop(reference=two_sines, controller=law, plant=axis.plant, **common)
    loop = loop.using(changes) if changes else loop
    plant = loop.blocks["plant"]
    assert plant is not None
    p = two_sines.params
    loop.blocks["plant"] = axis.start(plant, (p.first * p.first_rate + p.second * p.second_rate) / TRAVEL_MM_PER_RAD)
    return loop, SINES_S


def identified(
    loops: Loops, kind: str, machine: str = "nominal", changes: Mapping[str, Any] | None = None
) -> FrictionFit:
    """Friction from a record of ``kind``: torque and reading of the scale, nothing else."""
    loop, seconds = record_loop(kind, machine, changes)
    run = loop.run(seconds, record=("output", "feedback"))
    return fit_friction(run.time, run["output"], run["feedback"] / TRAVEL_MM_PER_RAD)


def rounded(fit: FrictionFit) -> FrictionFit:
    """The fit with values of three digits, as one writes them down; what the fourth does is chance, see the claims."""
    short = LuGre(*(float(f"{value:.3g}") for value in fit.friction))
    return replace(fit, friction=short, inertia=float(f"{fit.inertia:.3g}"))


def believing(law: Block, fit: FrictionFit, gains: Mapping[str, float] | None = None) -> Block:
    """A controller with what was found as its hat, in three digits, and other gains if given."""
    short = rounded(fit)
    return replace(law, params=law.params._replace(hat=short.friction, inertia=short.inertia, **(gains or {})))
