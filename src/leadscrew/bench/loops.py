"""The loops that the bench measures: the lathe servo with 36 rules, with its plant in two forms."""

from __future__ import annotations

from typing import TYPE_CHECKING

from leadscrew.controllers._vud import vud_beta_e
from leadscrew.kernel.block import Block, plant
from leadscrew.kernel.metrics import iae, max_error, rms_error
from leadscrew.plants._lathe_servo import LatheServoParams, LatheServoState, lathe_servo, show
from leadscrew.references._step import step
from leadscrew.sensors._counts import grating_count

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

PERIOD_S = 0.001
TARGET_MM = -50.0
"""The step of Figure 11 (a)."""
SUBSTEPS = 10
"""RK4 steps in a control period."""
METRICS: dict[str, Block] = {"rms": rms_error, "iae": iae, "max": max_error}
"""The same three on every side of a comparison."""


@plant(LatheServoParams(), LatheServoState(), output=show, unit="mm", sense=-1)
def lathe_servo_rates(p, s, u):
    """The lathe's chain as a derivative, for integrators."""
    drive = -p.full_duty_speed_mm_s * min(1.0, max(-1.0, u))
    return LatheServoState(
        (drive - s.pwm) / p.pwm_lag_s,
        (s.pwm - s.current) / p.electrical_lag_s,
        (s.current - s.speed) / p.mechanical_lag_s,
        s.speed,
        (s.position - s.reading) / p.grating_lag_s,
    )


def lathe(form: str = "hold", target_mm: float = TARGET_MM) -> Loop:
    """The loop of ``corrected.vud_beta_e`` in ``fig11a_step_m50``; ``form`` of the plant: ``hold`` or ``rk4``."""
    from leadscrew.kernel.loop import Loop

    return Loop(
        reference=step(initial=0.0, target=target_mm, time=0.0),
        controller=vud_beta_e,
        plant=lathe_servo if form == "hold" else lathe_servo_rates,
        sensor=grating_count,
        period=PERIOD_S,
        substeps=1 if form == "hold" else SUBSTEPS,
        metrics=METRICS,
        name=f"lathe servo ({form})",
    )
