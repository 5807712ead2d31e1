"""What the disturbances of the ball-screw stage and of the milling table do, and that they end."""

import math

import numpy as np
import pytest

from tests.operate.playing import loop_of, play

pytestmark = pytest.mark.slow

# ---- fsmc_ballscrew: 1 mm at 1 Hz; what a disturbance adds to the torque, against the run without it

RATE = 2.0 * math.pi
LEAD = 1.5923
"""mm of the table per radian."""


@pytest.fixture(scope="module")
def calm():
    return play("fsmc_ballscrew", None, 1.0, 4.0)


def added(run, calm, first_s, last_s):
    """Torque over that of the undisturbed run, where the screw turns at more than half its speed, times its sense."""
    speed = calm.span("plant.speed", first_s, last_s)
    torque = run.span("output", first_s, last_s) - calm.span("output", first_s, last_s)
    fast = np.abs(speed) > 0.5 * RATE / LEAD
    return torque[fast] * np.sign(speed[fast])


def test_a_torque_pulse_is_answered_by_the_motor_and_ends(calm):
    run = play("fsmc_ballscrew", "load_pulse", 1.0, 4.0, size=2.0, for_s=0.5)
    assert np.count_nonzero(run["disturbance"]) == 2000
    assert set(run.span("disturbance", 0.0, 0.5)) == {2.0}
    answer = run.span("output", 0.3, 0.5) - calm.span("output", 0.3, 0.5)
    assert np.mean(answer) == pytest.approx(-2.0, abs=0.05)
    later = run.span("output", 2.0, 4.0) - calm.span("output", 2.0, 4.0)
    assert np.mean(later) == pytest.approx(0.0, abs=0.02)


def test_more_friction_takes_more_torque_in_sliding(calm):
    """Half of Coulomb's 6.24 N m more."""
    run = play("fsmc_ballscrew", "friction", 1.0, 4.0, factor=1.5, for_s=2.0)
    assert np.mean(added(run, calm, 0.5, 2.0)) == pytest.approx(3.12, abs=0.05)
    assert np.mean(added(run, calm, 3.0, 4.0)) == pytest.approx(0.0, abs=0.02)
    assert run.after == run.before


def test_more_viscous_friction_takes_torque_in_proportion_to_speed(calm):
    run = play("fsmc_ballscrew", "viscous", 1.0, 4.0, factor=3.0, for_s=2.0)
    speed = calm.span("plant.speed", 1.0, 2.0)
    torque = run.span("output", 1.0, 2.0) - calm.span("output", 1.0, 2.0)
    slope = float(np.dot(speed, torque) / np.dot(speed, speed))
    assert slope == pytest.approx(2.0 * run.before["plant.friction.viscous"], rel=0.03)
    assert run.after == run.before


def test_more_inertia_takes_torque_in_proportion_to_acceleration(calm):
    """J is worth 9 mN m here, beside 6 N m of friction."""
    run = play("fsmc_ballscrew", "inertia", 1.0, 4.0, factor=4.0, for_s=2.0)
    acceleration = calm.span("command.acceleration", 1.0, 2.0) / LEAD
    torque = run.span("output", 1.0, 2.0) - calm.span("output", 1.0, 2.0)
    slope = float(np.dot(acceleration, torque) / np.dot(acceleration, acceleration))
    assert slope == pytest.approx(3.0 * run.before["plant.inertia"], rel=0.3)
    assert run.after == run.before


def test_noise_of_the_scale_has_the_size_asked_for_and_ends():
    run = play("fsmc_ballscrew", "noise", 1.0, 3.0, deviation=100.0, for_s=1.0)
    w = 1e6 * (run["feedback"] - run["actual"])
    assert np.std(w[run.at : run.at + 4000]) == pytest.approx(math.hypot(100.0, 10.0 / 12**0.5), rel=0.04)
    assert np.abs(w[run.at + 4000 :]).max() <= 5.0 + 1e-6


def test_go_to_starts_a_new_move_from_where_the_last_one_ended():
    loop = loop_of("fsmc_ballscrew", scenario="step_quintic")
    run = play("fsmc_ballscrew", "go_to", 0.3, 0.6, loop=loop, target=-2.0, time=0.1)
    command = run["command.position"]
    assert command[run.at - 1] == command[run.at] == 1.0
    assert command[-1] == -2.0
    assert np.abs(np.diff(command)).max() < 1.875 * 3.0 / 0.1 * run.period_s * 1.01
    assert 1e3 * abs(run["actual"][-1] + 2.0) < 3.0


def test_move_to_starts_a_filtered_step_from_the_end_of_the_last():
    loop = loop_of("fsmc_ballscrew", "ours.pd_dob", "step_filtered")
    run = play("fsmc_ballscrew", "move_to", 0.5, 0.5, loop=loop, target=-1.0)
    command = run["command.position"]
    assert command[run.at] == pytest.approx(1.0, abs=1e-6)
    assert command[-1] == pytest.approx(-1.0, abs=1e-6)
    assert np.abs(np.diff(command)).max() < 2.0 * 150.0 / math.e * run.period_s * 1.01


# ---- npid_xytable


@pytest.fixture(scope="module")
def cutting():
    return play("npid_xytable", None, 3.0, 6.0)


def test_the_load_of_a_deeper_cut_is_so_many_times_the_load(cutting):
    run = play("npid_xytable", "cutting_force", 3.0, 6.0, factor=3.0, for_s=2.0)
    assert run.span("disturbance", 0.0, 2.0) == pytest.approx(3.0 * cutting.span("disturbance", 0.0, 2.0))
    assert (run.span("disturbance", 2.0, 6.0) == cutting.span("disturbance", 2.0, 6.0)).all()
    assert run.after == run.before


def test_all_forces_of_the_cut_grow_together():
    """In the linear loop of the PID what three times the forces add is twice what these forces are worth."""
    loop = loop_of("npid_xytable", "paper.pid")
    none, once, thrice = (
        play("npid_xytable", "cutting_force", 3.0, 4.0, loop=loop, factor=f, for_s=2.0).span("true_error", 1.0, 2.0)
        for f in (0.0, 1.0, 3.0)
    )
    assert np.std(once - none) > 1e-3
    assert thrice - once == pytest.approx(2.0 * (once - none), abs=1e-5)


def line(run, hz, first_s, last_s):
    """Amplitude and phase of the true error at a frequency, um; the slow motion is taken out first."""
    e = 1e3 * run.span("true_error", first_s, last_s)
    t = run.span("time", first_s, last_s)
    own = np.column_stack(
        [np.ones_like(t), t] + [f(2.0 * math.pi * h * t) for h in (0.7, 1.4, 2.1, 50 / 3, hz) for f in (np.sin, np.cos)]
    )
    found = np.linalg.lstsq(own, e, rcond=None)[0]
    return complex(found[-2], found[-1])


def test_a_push_at_the_table_is_worth_its_share_of_the_proportional_gain():
    """5 mV over 1.32 V/mm, and the little that the guide's own stiffness is worth."""
    loop = loop_of("npid_xytable", "paper.pid")
    run, calm = (play("npid_xytable", name, 3.0, 2.0, loop=loop, **more) for name, more in PUSHES)
    over = run["disturbance"] - calm["disturbance"]
    assert np.count_nonzero(over) == 1000
    assert over[run.at : run.at + 1000] == pytest.approx(5e-3)
    pushed = run.span("true_error", 0.3, 0.5) - calm.span("true_error", 0.3, 0.5)
    assert pushed == pytest.approx(-5e-3 / (1.32 + 166.3 / 69380.0), rel=0.01)
    assert np.abs(run.span("true_error", 1.5, 2.0) - calm.span("true_error", 1.5, 2.0)).max() < 1e-5


PUSHES = ("load_pulse", {"size": 5.0, "for_s": 0.5}), (None, {})


def test_the_spindle_goes_on_from_its_angle_at_another_speed():
    loop = loop_of("npid_xytable", "paper.pid", "spindle_1000", scenario__column=0)
    run = play("npid_xytable", "spindle_speed", 3.1234, 4.0, loop=loop, rpm=1500.0)
    now, b, a = run.at * run.period_s, run.before, run.after
    for teeth, phase in ((1, "plant.spindle_phase"), (2, "plant.tooth_phase")):
        angles = [2 * math.pi * teeth * x["plant.spindle_hz"] * now + x[phase] for x in (b, a)]
        assert math.remainder(angles[1] - angles[0], 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert a["plant.spindle_hz"] == 25.0
    assert abs(line(run, 50.0, 1.0, 4.0)) > 20.0 * abs(line(run, 100.0 / 3.0, 1.0, 4.0))


def test_a_stronger_drive_makes_the_gain_that_grows_chatter(cutting):
    run = play("npid_xytable", "drive_gain", 3.0, 6.0, factor=1.2, for_s=2.0)
    rough = [np.abs(np.diff(x.span("output", 0.5, 2.0))).mean() for x in (run, cutting)]
    assert rough[0] > 1.2 * rough[1]
    assert run.after == run.before


def test_more_friction_needs_more_voltage():
    """Of a sine with room to slide: 130 mV more, at its fastest."""
    loop = loop_of("npid_xytable", "paper.pid", "sine_1mm_on_friction_medium")
    run = play("npid_xytable", "friction", 2.0, 6.0, loop=loop, friction=150.0, for_s=3.0)
    inside, outside = (np.abs(run.span("output", *x)).max() for x in ((1.0, 3.0), (4.0, 6.0)))
    assert 0.1 < inside - outside < 0.2
    assert run.after == run.before


@pytest.mark.parametrize(("scenario", "count_um"), [("spindle_1000", 0.0), ("measured_1000", 0.5)])
def test_noise_of_the_encoder_has_the_size_asked_for_and_ends(scenario, count_um):
    run = play("npid_xytable", "noise", 1.0, 3.0, loop=loop_of("npid_xytable", "paper.pid", scenario), deviation=2.0)
    own = 1e3 * run.before["sensor.noise_mm"]
    w = 1e3 * (run["feedback"] - run["actual"])
    rounding = count_um / 12**0.5
    assert np.std(w[run.at : run.at + 4000]) == pytest.approx(math.hypot(2.0, rounding), rel=0.04)
    assert np.std(w[run.at + 4000 :]) == pytest.approx(math.hypot(own, rounding), rel=0.05)


def test_go_to_steps_the_command_of_a_step():
    run = play("npid_xytable", "go_to", 0.5, 0.5, loop=loop_of("npid_xytable", scenario="step_10um"), target=-5.0)
    assert run["command"][run.at - 1 : run.at + 1] == pytest.approx([0.01, -0.005])
