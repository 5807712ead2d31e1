"""Loops around controllers that no study has yet, for the table of exports."""

from leadscrew.controllers.pid import TUNINGS
from leadscrew.controllers.sliding import smc_integral
from leadscrew.controllers.vud import vud_beta_e
from leadscrew.kernel.loop import Loop
from leadscrew.plants.lathe_servo import lathe_servo
from leadscrew.references.sine import sine
from leadscrew.sensors.grating_count import grating_count
from tests.controllers.stage_loop import stage_loop
from tests.controllers.xy_loop import xy_loop


def pid():
    return xy_loop(TUNINGS["ours.pid_ms_159"](max_output=0.03, filter_s=1e-4), sine(amplitude=1.0, frequency=2.0))


def sliding_with_integral():
    return stage_loop(smc_integral, encoder_mm=1e-4)


def lathe_to_and_fro():
    """The lathe axis under A+, never at rest."""
    return Loop(
        reference=sine(amplitude=60.0, frequency=0.37),
        controller=vud_beta_e,
        plant=lathe_servo,
        sensor=grating_count,
        period=1e-3,
        metrics={},
    )
