"""Loops around controllers that no study has yet, for the table of exports."""

from dataclasses import replace

from leadscrew.actuators._dead_zone import dead_zone
from leadscrew.controllers._adaptive_resonant import adaptive_resonant
from leadscrew.controllers._biquad import LowPass, Notch, biquad
from leadscrew.controllers._cascade_ppi import cascade_ppi
from leadscrew.controllers._dead_zone_inverse import dead_zone_inverse
from leadscrew.controllers._filters import lead_lag, low_pass, notch
from leadscrew.controllers._friction_feed_forward import friction_feed_forward
from leadscrew.controllers._guard import force_guard
from leadscrew.controllers._input_dob import input_dob
from leadscrew.controllers._learned_feed_forward import learned_feed_forward
from leadscrew.controllers._npid_after import npid_after
from leadscrew.controllers._npid_split import npid_split
from leadscrew.controllers._pd_dob import pd_dob
from leadscrew.controllers._repetitive import repetitive
from leadscrew.controllers._series import series
from leadscrew.controllers._sliding.integral import smc_integral
from leadscrew.controllers._sliding.super_twisting import super_twisting
from leadscrew.controllers._vud import vud_beta_e, vud_scaled
from leadscrew.disturbances._hard_spot import hard_spot
from leadscrew.fuzzy.block import controller
from leadscrew.kernel.loop import Loop
from leadscrew.plants._lathe_servo import lathe_servo
from leadscrew.plants._servo_axis import servo_axis
from leadscrew.plants._turning import turning
from leadscrew.references._cutting_program import cutting_program
from leadscrew.references._eased_sine import eased_sine_motion
from leadscrew.references._sine import sine
from leadscrew.references._step import step
from leadscrew.sensors._counts import axis_reading, grating_count
from leadscrew.sensors._faulty_load_cell import faulty_load_cell
from leadscrew.studies.fsmc_ballscrew.tunings import FUZZY as FSMC
from leadscrew.studies.grey_turning.tunings import TUNINGS as GREY_FUZZY
from leadscrew.studies.npid_xytable.tunings import TUNINGS, XY_TABLE
from tests.controllers.emps_cascade import emps_cascade
from tests.controllers.stage_loop import stage_loop
from tests.controllers.table_axis import table_axis
from tests.controllers.xy_loop import xy_loop
from tests.fuzzy.systems import mamdani, sugeno


def pid():
    return xy_loop(
        TUNINGS["ours.pid_ms_159"](lower=-0.03, upper=0.03, filter_s=1e-4), sine(amplitude=1.0, frequency=2.0)
    )


def npid_of_limited_slope():
    return xy_loop(TUNINGS["ours.npid_slope_159"](lower=-0.03, upper=0.03), sine(amplitude=1.0, frequency=2.0))


def npid_in_two_paths():
    return xy_loop(npid_split(lower=-0.03, upper=0.03), sine(amplitude=1.0, frequency=2.0))


def npid_with_the_gain_behind():
    return xy_loop(npid_after(lower=-0.03, upper=0.03, anti_windup=2), sine(amplitude=1.0, frequency=2.0))


def identified_axis():
    """The cascade of an identified axis, with its model fed forward, on the axis."""
    return Loop(
        reference=eased_sine_motion(amplitude=20.0, frequency=2.0),
        controller=emps_cascade(kvi=3.0, velocity_share=1.0, model_share=0.9),
        plant=servo_axis,
        sensor=axis_reading(noise=1e-3),
        period=1e-3,
    )


def cascade():
    return table_axis(
        cascade_ppi(kpos=150.0, kvp=0.004, kvi=0.6, acceleration_v=1e-5, lower=-0.06, upper=0.06), frequency=5.0
    )


def input_observer():
    return table_axis(input_dob(TUNINGS["ours.pid_ms_159"], lower=-0.06, upper=0.06, model=XY_TABLE), frequency=5.0)


def friction_fed_forward():
    return table_axis(friction_feed_forward(TUNINGS["ours.pid_ms_159"]), frequency=5.0)


def following_the_spindle():
    return table_axis(
        adaptive_resonant(TUNINGS["ours.pid_ms_159"], model=XY_TABLE), frequency=5.0, spindle_hz=51.0, tooth_v=2e-3
    )


def repeating():
    return table_axis(repetitive(TUNINGS["ours.pid_ms_159"], 0.2 + 1e-4, room=500), frequency=5.0)


def resonant_table():
    return table_axis(TUNINGS["ours.resonant_box"](lower=-0.04, upper=0.04), frequency=5.0)


def resonant_table_fed_forward():
    return table_axis(TUNINGS["ours.resonant_full"](**{"inner.spindle_hz": 50.0}), frequency=5.0)


def table_that_learns_its_friction():
    return table_axis(learned_feed_forward(TUNINGS["ours.pid_ms_159"], friction_share=0.0), frequency=5.0)


def pid_through_a_notch():
    block = biquad(TUNINGS["ours.pid_ms_159"], Notch(centre_hz=120.0, width_hz=30.0), LowPass(corner_hz=700.0))
    return xy_loop(block, sine(amplitude=1.0, frequency=2.0))


def low_passed():
    return xy_loop(low_pass(corner_hz=200.0), sine(amplitude=1.0, frequency=2.0))


def notched():
    return xy_loop(notch(), sine(amplitude=1.0, frequency=2.0))


def leading():
    return xy_loop(lead_lag(zero_hz=8.0, pole_hz=80.0), sine(amplitude=1.0, frequency=2.0))


def pid_behind_filters():
    block = series(series(TUNINGS["ours.pid_ms_159"], low_pass(corner_hz=300.0)), lead_lag(zero_hz=30.0, pole_hz=3.0))
    return xy_loop(block, sine(amplitude=1.0, frequency=2.0))


def pid_against_a_dead_zone():
    drive = dead_zone(threshold=0.02, subtract=True)
    return xy_loop(dead_zone_inverse(TUNINGS["ours.pid_ms_159"]), sine(amplitude=1.0, frequency=2.0), actuator=drive)


def pid_with_a_tracking_differentiator():
    return xy_loop(TUNINGS["ours.pid_td"], sine(amplitude=1.0, frequency=2.0))


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


def force_under_guard():
    """A cut at 150 N under guard, through a hard spot and a load cell that is broken for a while."""
    return Loop(
        reference=cutting_program,
        controller=force_guard(GREY_FUZZY["corrected.gpfc_b_stfc"]),
        plant=turning,
        sensor=faulty_load_cell(fault=4, from_s=3.0, until_s=3.1),
        disturbance=hard_spot,
        period=0.02,
        substeps=20,
        metrics={},
    )
