"""Loops around controllers that no study has yet, for the table of exports."""

from dataclasses import replace

from leadscrew.actuators.dead_zone import dead_zone
from leadscrew.controllers.pd_dob import pd_dob
from leadscrew.controllers.pid import TUNINGS
from leadscrew.controllers.sliding import smc_integral
from leadscrew.controllers.sliding.fuzzy import TUNINGS as FSMC
from leadscrew.controllers.sliding.super_twisting import super_twisting
from leadscrew.controllers.vud import vud_beta_e, vud_scaled
from leadscrew.fuzzy.block import controller
from leadscrew.kernel.loop import Loop
from leadscrew.plants.lathe_servo import lathe_servo
from leadscrew.references.sine import sine
from leadscrew.references.step import step
from leadscrew.sensors.grating_count import grating_count
from tests.controllers.stage_loop import stage_loop
from tests.controllers.xy_loop import xy_loop
from tests.fuzzy.systems import mamdani, sugeno


def pid():
    return xy_loop(TUNINGS["ours.pid_ms_159"](max_output=0.03, filter_s=1e-4), sine(amplitude=1.0, frequency=2.0))


def sliding_with_integral():
    return stage_loop(smc_integral, encoder_mm=1e-4)


def sliding_with_fuzzy_rules():
    return stage_loop(FSMC["ours.fsmc_4khz"], encoder_mm=1e-4)


def sliding_with_the_printed_rules():
    return stage_loop(FSMC["ours.fsmc_printed_4khz"], encoder_mm=1e-4)


def super_twisted():
    return stage_loop(super_twisting, encoder_mm=1e-5)


def disturbance_observer():
    return stage_loop(pd_dob(max_torque=40.0), encoder_mm=1e-5)


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


def lathe_with_a_dead_zone():
    """The lathe axis under the tuned rules, 5 % of the duty lost to friction, integral action and inverse at work."""
    return Loop(
        reference=step(target=-50.0),
        controller=vud_scaled(integral_gain=2.0, dead_zone=0.05),
        actuator=dead_zone(threshold=0.05, subtract=True),
        plant=lathe_servo,
        sensor=grating_count,
        period=1e-3,
        metrics={},
    )


def fuzzy(system):
    """The lathe axis under a fuzzy controller of the error and its rate, to and fro."""
    inside = replace(system, inputs=tuple(replace(v, lock_range=True) for v in system.inputs))
    block = controller(inside, {"e": ("error", 0.05), "de": ("rate", 0.002)}, output_scale=-3.0, unit="1",
                       drive="duty", full_scale=1.0, sense=-1)  # fmt: skip
    return Loop(
        reference=sine(amplitude=60.0, frequency=0.37),
        controller=block,
        plant=lathe_servo,
        sensor=grating_count,
        period=1e-3,
        metrics={},
    )


def fuzzy_exact():
    """49 rules, the centroid in closed form."""
    return fuzzy(mamdani(integration="exact"))


def fuzzy_sampled():
    """49 rules, the centroid as a sum over 100 cells."""
    return fuzzy(mamdani())


def fuzzy_table():
    """49 rules of Takagi and Sugeno, of which only the active ones are computed: a table."""
    return fuzzy(sugeno())
