"""The stage on a real drive: what a machine adds to the ideal loop, one by one and all together, from rest.

Every loop here has a torque drive and a filtered scale, and the stage with an axial mode where there is a mode or
ripple. What is off is set so far out that it does not matter: a limit of 1 kN m, no lag, no filter, a spring of 1e12
N/m. A sine starts at its lower end, where the axis stands and the drive is without torque; so no delay line has to be
filled. Two reversals count, of the fast sine too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.actuators._torque_drive import torque_drive
from leadscrew.kernel.metrics import max_error
from leadscrew.plants._ballscrew_axial import ballscrew_axial
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD, ballscrew_stage
from leadscrew.references._sine import sine_motion
from leadscrew.sensors._filtered_ruler import filtered_ruler
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.scenarios import PERIOD_S, sine_of
from leadscrew.studies.lab import Lab, measure

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

LIMIT_NM, LAG_S, RIPPLE, FILTER_HZ = 15.0, 2e-4, 0.01, 1000.0
"""Torque limit (1.6 times static friction), lag of the current loop, ripple at 6 and at 24 a turn, filter: chosen."""

OFF: Mapping[str, Any] = {
    "plant.stiffness": 1e12, "plant.damping_ratio": 1.0, "actuator.max_torque": 1e3, "actuator.lag_s": 0.0,
    "sensor.low_pass_hz": 0.0,
}  # fmt: skip
_ON: dict[str, dict[str, Any]] = {
    "limit": {"actuator.max_torque": LIMIT_NM},
    "lag": {"actuator.lag_s": LAG_S},
    "ripple": {"plant.ripple_low.share": RIPPLE, "plant.ripple_high.share": RIPPLE},
    "delay": {},
    "mode": {"plant.stiffness": 1e8, "plant.damping_ratio": 0.03},
    "filter": {"sensor.low_pass_hz": FILTER_HZ},
}


class Drive(NamedTuple):
    """What is switched on, and the period of control."""

    doc: str
    on: tuple[str, ...] = ()
    period: float = PERIOD_S

    @property
    def changes(self) -> dict[str, Any]:
        """Parameters of the loop by dotted key."""
        changed = dict(OFF)
        for name in self.on:
            changed |= _ON[name]
        return changed


EVERYTHING = tuple(_ON)

DRIVES: dict[str, Drive] = {
    "ideal": Drive("nothing added"),
    "limit": Drive(f"torque limit {LIMIT_NM:g} N·m", ("limit",)),
    "lag": Drive(f"current loop of {1e3 * LAG_S:g} ms", ("lag",)),
    "ripple": Drive("torque ripple of 1 % at 6 and 24 a turn", ("ripple",)),
    "delay": Drive("one sample of computation delay", ("delay",)),
    "mode": Drive("axial mode, 201 Hz held and 266 Hz free", ("mode",)),
    "filter": Drive("scale filtered at 1 kHz", ("filter",)),
    "delay_filter": Drive("one sample of delay and the filter", ("delay", "filter")),
    "all": Drive("everything", EVERYTHING),
    "1khz": Drive("1 kHz, nothing added", period=1e-3),
    "all_1khz": Drive("1 kHz, everything", EVERYTHING, 1e-3),
}
"""By name, in the order of the table."""

SECONDS = {"sine_slow": 7.0, "sine_wide": 7.0, "sine_fast": 2.3}
COUNTS_FROM = {"sine_slow": 3.0, "sine_wide": 3.0, "sine_fast": 1.3}
"""How long a sine runs, and from when on it counts, s."""

ADAPTIVE: Mapping[str, Any] = MappingProxyType({"method": "rodas", "rtol": 1e-5, "atol": 1e-8})
"""Position to a hundredth of a nanometre a step."""


def driven(controller: str, scenario: str, drive: str = "ideal", **changes: Any) -> Loop:
    """The loop of a controller on a drive; ``changes``: more parameters by dotted key, dots as ``__``."""
    from leadscrew.kernel.loop import Loop

    asked = DRIVES[drive]
    sine, delay = sine_of(scenario), asked.period if "delay" in asked.on else 0.0
    plant = ballscrew_axial if {"mode", "ripple"} & set(asked.on) else ballscrew_stage
    size, frequency = sine.amplitude_mm, sine.rate_rad_s / (2.0 * math.pi)
    loop = Loop(
        reference=sine_motion(amplitude=size, frequency=frequency, phase=-0.5 * math.pi, offset=size),
        controller=CONTROLLERS[controller],
        plant=plant(travel_per_rad=TRAVEL_MM_PER_RAD),
        actuator=torque_drive,
        sensor=filtered_ruler,
        period=asked.period,
        computation_delay=delay,
        metrics={"max": max_error(from_time=COUNTS_FROM[scenario])},
        bound=2.0 * size + 0.1,
        **ADAPTIVE,
    )
    more = asked.changes | {key.replace("__", "."): value for key, value in changes.items()}
    return loop.using({key: value for key, value in more.items() if key in loop.sheet})


@measure
def largest_um(lab: Lab, controller: str, scenario: str, drive: str = "ideal") -> float | None:
    """Largest true error of the table in the second half of a run, um; None where it leaves the track by 0.1 mm."""
    loop = driven(controller, scenario, drive)
    loop.adopt_program(lab.once(("program", loop.compiled_from()), lambda: loop))
    found = loop.run(SECONDS[scenario], every=0).metrics["max"]
    return 1e3 * float(found) if np.isfinite(found) else None
