"""What a nonlinear PID is designed for: the axis, what disturbs it, what it is judged by; and its loops.

The axis is :obj:`leadscrew.plants.xy_table_cutting`, ``gain / (s^2 + damping s + stiffness)`` with a dead time of any
length, sampled. The work is a sine under force lines, one :class:`Case` a spindle speed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal

from leadscrew.kernel.block import Block
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.analysis.stability.linear import LinearLoop
    from leadscrew.kernel.loop import Loop

Law = Literal["slope", "cosh"]
"""``slope``: npid_slope, whose slope and gain have one bound ``k``. ``cosh``: the paper's npid."""

LINES = 5


@dataclass(frozen=True)
class Gains:
    """Of the PID behind the nonlinear gain, as in Table I: V/mm, V/(mm s), V s/mm."""

    kp: float = 1.32
    ki: float = 0.000825
    kd: float = 0.006805

    def as_dict(self) -> dict[str, float]:
        """By parameter."""
        return {"kp": self.kp, "ki": self.ki, "kd": self.kd}

    def times(self, factor: float) -> Gains:
        """All gains times a factor."""
        return Gains(factor * self.kp, factor * self.ki, factor * self.kd)


@dataclass(frozen=True)
class Case:
    """One spindle speed: force lines at the motor, V, and what turns."""

    name: str
    volts: tuple[float, ...] = (0.0,) * LINES
    spindle_hz: float = 0.0


@dataclass(frozen=True)
class Work:
    """What the axis does while it is judged, and how it is measured."""

    cases: tuple[Case, ...] = (Case("no force"),)
    lines_hz: tuple[float, ...] = (2.1, 3.5, 4.9, 6.3, 7.7)
    amplitude_mm: float = 1.0
    frequency_hz: float = 0.7
    encoder_um: float = 0.5
    noise_um: float = 0.1
    runout_v: float = 1e-3
    tooth_v: float = 2e-3
    teeth: int = 2
    tracking_weight: float = 1.0
    """Weight of the error at the motion's frequency; every force line has 1."""

    def __post_init__(self) -> None:
        if not self.cases or any(len(c.volts) != len(self.lines_hz) or len(c.volts) > LINES for c in self.cases):
            raise ValueRefused(f"work: needs one case at least, each with {len(self.lines_hz)} force lines, at most 5")
        for name in ("amplitude_mm", "encoder_um", "noise_um", "tracking_weight"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueRefused(f"{name} = {value!r} (work): allowed from 0")
        if self.amplitude_mm == 0.0 and not any(any(c.volts) for c in self.cases):
            raise ValueRefused("work: no motion and no force lines, so there is no error to make small")


@dataclass(frozen=True)
class TableAxis:
    """The plant, its dead time and its period."""

    gain: float = 69380.0
    damping: float = 144.8
    stiffness: float = 166.3
    dead_time_s: float = 0.775e-3
    period_s: float = 5e-4
    limit_v: float = 10.0
    name: str = field(default="XY table", compare=False)

    def plant(self, **more: Any) -> Block:
        """The axis as a block.

        Raises:
            ValueRefused: a coefficient out of range, or a dead time of more than four periods.
        """
        from leadscrew.plants._xy_table_cutting import xy_table_cutting

        made: Block = xy_table_cutting(
            gain=self.gain, damping=self.damping, stiffness=self.stiffness, dead_time_s=self.dead_time_s, **more
        )
        if not (math.isfinite(self.period_s) and self.period_s > 0.0):
            raise ValueRefused(f"period_s = {self.period_s!r} (axis): must be positive")
        assert made.prepare is not None
        made.prepare(made.params, self.period_s)
        return made

    def loop(self, controller: Block, work: Work | None = None, case: Case | None = None) -> Loop:
        """The loop of a controller at its work, read through the encoder; without work at rest, read ideally."""
        from leadscrew.actuators._saturation import saturation
        from leadscrew.disturbances._five_sines import five_sines
        from leadscrew.kernel.loop import Loop
        from leadscrew.kernel.metrics import chatter, max_error, rms_error
        from leadscrew.references._eased_sine import eased_sine
        from leadscrew.sensors._counts import noisy_ruler

        late = {"from_time": 0.5 * RUN_S}
        metrics = {"rms_error": rms_error(**late), "max_error": max_error(**late), "chatter": chatter(**late)}
        common: dict[str, Any] = {
            "controller": controller, "actuator": saturation(lower=-self.limit_v, upper=self.limit_v),
            "period": self.period_s, "name": self.name, "metrics": metrics,
        }  # fmt: skip
        if work is None:
            return Loop(reference=eased_sine(amplitude=0.0), plant=self.plant(), **common)
        asked = case or work.cases[0]
        plant = self.plant(spindle_hz=asked.spindle_hz, spindle_v=work.runout_v, tooth_v=work.tooth_v, teeth=work.teeth)
        made = Loop(
            reference=eased_sine(amplitude=work.amplitude_mm, frequency=work.frequency_hz),
            disturbance=five_sines,
            plant=plant,
            sensor=noisy_ruler(resolution_mm=1e-3 * max(work.encoder_um, 1e-9), noise_mm=1e-3 * work.noise_um),
            **common,
        )
        return made.using(line_changes(work.lines_hz, asked.volts))

    def linear(self, gains: Gains) -> LinearLoop:
        """The sampled linear loop of a PID, from the steps that run, cut at the error."""
        from leadscrew.analysis.stability.loop import sampled_loop
        from leadscrew.controllers._pid import pid

        made = self.loop(pid.using(**gains.as_dict()))
        made.__dict__["signals"] = _signals()
        return sampled_loop(made, self.name)


@lru_cache(maxsize=1)
def _signals() -> dict[str, Any]:
    """The shapes of the signals of :meth:`TableAxis.loop` at rest: the same for all values, and slow to find."""
    from leadscrew.controllers._pid import pid

    return TableAxis().loop(pid).signals


RUN_S = 20.0
"""Of a run, s; its second half is judged: 7 periods of 0.7 Hz."""


def line_changes(lines_hz: Sequence[float], volts: Sequence[Any]) -> dict[str, Any]:
    """Parameters of ``five_sines``, by dotted key of a loop."""
    from leadscrew.disturbances._five_sines import five_sines

    places = five_sines.params._fields
    found: dict[str, Any] = {}
    for place, hz, v in zip(places, lines_hz, volts, strict=False):
        found |= {f"disturbance.{place}.frequency": hz, f"disturbance.{place}.amplitude": v}
    return found


def block_of(law: Law, gains: Gains, strength: float = 1.0, scale_um: float = 1.0, **more: Any) -> Block:
    """A controller of a law: ``strength`` is ``k``, or ``x = alpha e_max``; ``scale_um`` is ``es``, or ``e_max``.

    Raises:
        ValueRefused: a law that there is not, or a value out of range.
    """
    from leadscrew.controllers._npid import npid
    from leadscrew.controllers._npid_slope import npid_slope

    if law not in ("slope", "cosh"):
        raise ValueRefused(f"law = {law!r}: there are slope (npid_slope) and cosh (npid)")
    base: Block = npid_slope if law == "slope" else npid
    made: Block = base(**gains.as_dict(), **parameters_of(law, strength, scale_um), **more)
    return made


def parameters_of(law: Law, strength: Any, scale_um: Any) -> dict[str, Any]:
    """The parameters of the law's block beside the gains."""
    if law == "slope":
        return {"k": strength, "es_um": scale_um}
    return {"alpha": strength / scale_um, "e_max": scale_um}


def bounds_of(law: Law, strength: float) -> tuple[float, float]:
    """Largest gain ``K`` and largest slope of a law."""
    if law == "slope":
        return strength, strength
    return math.cosh(strength), math.cosh(strength) + strength * math.sinh(strength)


def strength_for(law: Law, gain: float, slope: float) -> float:
    """The largest strength with a gain of at most ``gain`` and a slope of at most ``slope``; 1 or 0: none.

    For the cosh: ``cosh x + x sinh x = slope``, solved by bisection; 2.265 gives x = 0.872.
    """
    if law == "slope":
        return max(1.0, min(gain, slope))
    low, high = 0.0, 1.0
    limit = 700.0
    while high < limit and _allowed(high, gain, slope):
        low, high = high, 2.0 * high
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _allowed(middle, gain, slope) else (low, middle)
    return low


def _allowed(x: float, gain: float, slope: float) -> bool:
    top, steepest = bounds_of("cosh", x)
    return top <= gain and steepest <= slope


def changes_of(values: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters of the controller by dotted key of a loop."""
    return {f"controller.{key}": value for key, value in values.items()}
