"""Loops of the lathe axis that no scenario of the study has."""

from leadscrew.controllers._vud.duty_pid import duty_pid
from leadscrew.kernel.loop import Loop
from leadscrew.plants._lathe_servo import lathe_servo
from leadscrew.references._step import step
from leadscrew.sensors._counts import grating_count
from leadscrew.studies.vud_lathe.controllers import FAST
from leadscrew.studies.vud_lathe.scenarios import METRICS


def lathe_loop(controller, target=-50.0, sensor=grating_count, plant=lathe_servo, period=1e-3, **more):
    return Loop(
        reference=step(initial=0.0, target=target, time=0.0),
        controller=controller,
        sensor=sensor,
        plant=plant,
        period=period,
        metrics=METRICS,
        **more,
    )


def pid():
    return lathe_loop(duty_pid)


def fast():
    """With the gain learned, the settings that use every line of the block."""
    return lathe_loop(FAST["ours.vud_fast_robust"])
