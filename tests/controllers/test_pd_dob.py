"""PD with a disturbance observer: hand-worked steps, loads that it must find, known errors on the three sines."""

import math

import numpy as np
import pytest

from leadscrew.controllers._pd_dob import PdDobState, pd_dob
from leadscrew.disturbances._pulse_load import pulse_load
from leadscrew.disturbances._step_load import step_load
from leadscrew.friction.maxwell_slip import MaxwellSlip
from leadscrew.kernel.block import plant
from leadscrew.kernel.loop import DivergenceWarning, Loop
from leadscrew.kernel.module import Module
from leadscrew.plants._ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD, ballscrew_stage
from leadscrew.plants._mass_maxwell_slip import mass_maxwell_slip
from leadscrew.references._motion import Motion
from leadscrew.references._sine import sine_motion
from leadscrew.sensors._counts import ruler
from leadscrew.studies.fsmc_ballscrew.tunings import SCHEDULED as TUNINGS
from leadscrew.util.errors import ValueRefused
from tests.controllers.stage_loop import SINES, UM, errors_um, stage_loop

SIGNALS = ("true_error", "output")
DT = 2.5e-4
ROBUST, OURS = TUNINGS["ours.pd_dob_robust"], TUNINGS["ours.pd_dob"]


def stepped(block, *readings, dt=DT):
    """State and torque after some readings, each a command and a feedback."""
    p, s, u = block.prepare(block.params, dt), block.state, None
    for command, feedback in readings:
        s, u = block.step(p, s, command, feedback, dt)
    return s, u


def seconds(name):
    return 4.0 if name == "fast" else 4.0 * math.pi


def from_rest(block, name, plant=ballscrew_stage, period=DT, encoder=True, **more):
    """A sine that starts at its lower end, at rest."""
    amplitude, rate = SINES[name]
    size = amplitude / TRAVEL_MM_PER_RAD
    return Loop(
        reference=sine_motion(amplitude=size, frequency=rate / (2.0 * math.pi), phase=-0.5 * math.pi, offset=size),
        controller=block, plant=plant, sensor=ruler(resolution_mm=1e-5 / TRAVEL_MM_PER_RAD) if encoder else None,
        period=period, metrics={}, **({"method": "rodas", "rtol": 1e-6, "atol": 1e-12} | more),
    )  # fmt: skip


# ---- the law
def test_two_periods_worked_by_hand():
    block = pd_dob(kp=100.0, kd=0.5, kp_slow=50.0, kd_slow=1.0, slow_speed=2.0, observer_rate=1000.0, low_pass_hz=0.0,
                   friction=False, inertia=4e-4)  # fmt: skip
    first, second = Motion(0.0, 2.0, 10.0), Motion(5e-4, 2.0, 10.0)
    s, u = stepped(block, (first, 1e-5))
    kp, kd = 100.0 + 0.5 * 50.0, 0.5 + 0.5 * 1.0  # the command moves at slow_speed: half of what is gained at rest
    one = 4e-4 * 10.0 - kp * 1e-5
    assert u == pytest.approx(one, rel=1e-12) and s.load == 0.0
    s, u = stepped(block, (first, 1e-5), (second, 5.3e-4))
    rate = (3e-5 - 1e-5) / DT
    q = 4e-4 * 2.0 + DT * one
    d = 1000.0 * (q - 4e-4 * (2.0 + rate))
    assert s.load == pytest.approx(d, rel=1e-9)
    assert u == pytest.approx(4e-4 * 10.0 - kp * 3e-5 - kd * rate + d, rel=1e-9)


def test_the_low_pass_is_exact_over_a_period():
    """Error ramps by 1e-6 a period: the rate nears 4e-3 rad/s as 1 - exp(-t / tau) does."""
    block, still = pd_dob(low_pass_hz=200.0), Motion(0.0, 0.0, 0.0)
    s, _ = stepped(block, *((still, 1e-6 * k) for k in range(9)))
    assert s.rate == pytest.approx(1e-6 / DT * (1.0 - math.exp(-8 * DT * 2.0 * math.pi * 200.0)), rel=1e-12)


def test_with_the_error_differentiated_the_filter_does_not_lag_the_command():
    """Perfect tracking at a constant acceleration: no rate of error; with the angle differentiated there is one."""
    moving = [(Motion(0.5 * 20.0 * t * t, 20.0 * t, 20.0), 0.5 * 20.0 * t * t) for t in DT * np.arange(40)]
    s, _ = stepped(OURS(friction=False), *moving)
    assert s.rate == 0.0
    s, _ = stepped(ROBUST(friction=False), *moving)
    kept = math.exp(-2.0 * math.pi * 2000.0 * DT)
    late = DT * (0.5 + kept / (1.0 - kept))
    assert s.rate - 20.0 * DT * 39 == pytest.approx(-20.0 * late, rel=1e-6)


@plant(None, PdDobState(), output="angle")
def screw(s, u, load):
    """1e-3 kg m^2, free."""
    return PdDobState(s.target, (u + load) / 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def test_a_load_that_the_model_does_not_know_is_found_and_taken_away():
    block = pd_dob(friction=False, inertia=1e-3, kp_slow=0.0, kd_slow=0.0, kp=500.0, kd=1.0)
    loop = Loop(reference=sine_motion(amplitude=0.0), controller=block, plant=screw, period=DT, metrics={},
                disturbance=step_load(size=0.7, time=0.01))  # fmt: skip
    run = loop.run(0.2, record=("controller", "true_error", "output"))
    assert run["controller.load"][-1] == pytest.approx(-0.7, rel=1e-6)
    assert abs(run["true_error"][-1]) < 1e-9
    alone = loop.using({"controller.observer_rate": 0.0}).run(0.2, record="true_error")
    assert -alone["true_error"][-1] == pytest.approx(0.7 / 500.0, rel=1e-3)


def far_away(seconds):
    """A free screw that is called back from 0.3 rad with at most 0.5 N m."""
    block = pd_dob(friction=False, inertia=1e-3, kp_slow=0.0, kd_slow=0.0, max_torque=0.5)
    loop = Loop(
        reference=sine_motion(amplitude=0.0), controller=block, plant=screw.starting(angle=-0.3), period=DT, metrics={}
    )
    return loop.run(seconds, record=("controller", "output"))


def test_at_the_torque_limit_the_observer_does_not_wind_up():
    """Told the torque that the PD wanted, kp 0.3 rad = 83 N m, it would claim as much."""
    run = far_away(0.5)
    assert np.abs(run["output"]).max() == 0.5
    assert np.abs(run["controller.load"]).max() < 0.25


def after_a_blow(block):
    """Largest and last error in um of a standing axis hit by 40 N m for 20 ms."""
    run = Loop(
        reference=sine_motion(amplitude=0.0), controller=block, plant=ballscrew_stage, period=DT, method="rodas",
        sensor=ruler(resolution_mm=1e-5 / TRAVEL_MM_PER_RAD), metrics={}, rtol=1e-5, atol=1e-9,
        disturbance=pulse_load(size=40.0, start=0.1, duration=0.02),
    ).run(0.5, record="true_error")  # fmt: skip
    error = UM * np.abs(run["true_error"])
    return run.diverged, error.max(), error[-400:].max()


@pytest.mark.slow
def test_a_blow_at_rest_needs_a_limit_of_the_torque():
    """The schedule goes by the commanded speed: torn loose it meets the gains for bristles that hold."""
    with pytest.warns(DivergenceWarning):
        assert after_a_blow(pd_dob)[0]
    diverged, largest, last = after_a_blow(pd_dob(max_torque=60.0))
    assert not diverged and largest == pytest.approx(5.3, abs=0.05) and last < 0.0015
    assert not after_a_blow(TUNINGS["ours.pd_dob_fixed"])[0]


def test_a_settled_loop_keeps_no_denormal_numbers():
    run = far_away(2.0)
    assert run["controller.rate"][-1] == run["controller.momentum"][-1] == run["controller.load"][-1] == 0.0


# ---- on the stage
KNOWN = [
    ("ours.pd_dob_aggressive", {"slow": (0.0036, 2e-5), "wide": (0.0075, 2e-4), "fast": (0.0195, 4e-4)}),
    ("ours.pd_dob_robust", {"slow": (0.011, 5e-4), "wide": (0.010, 5e-4), "fast": (0.055, 5e-4)}),
]
"""RMS in um of an earlier and independent simulation of ours, and how near ours must be."""


@pytest.mark.slow
@pytest.mark.parametrize(("tuning", "name", "known"), [(t, n, k) for t, rows in KNOWN for n, k in rows.items()])
def test_at_4_khz_with_a_10_nm_encoder_it_leaves_the_known_errors(tuning, name, known):
    run = stage_loop(TUNINGS[tuning], name, encoder_mm=1e-5).run(seconds(name), record="true_error")
    assert errors_um(run)[1] == pytest.approx(known[0], abs=known[1])


@pytest.mark.slow
@pytest.mark.parametrize("block", [ROBUST, OURS], ids=["robust", "ours"])
def test_and_stays_below_the_known_peaks(block):
    for name, largest in (("slow", 0.07), ("wide", 0.11), ("fast", 0.21)):
        assert errors_um(stage_loop(block, name, encoder_mm=1e-5).run(seconds(name), record="true_error"))[0] < largest


@pytest.mark.slow
def test_without_a_schedule_slow_motion_sticks_and_slips():
    peaks = {
        tuning: errors_um(stage_loop(TUNINGS[tuning], "wide", encoder_mm=1e-5).run(4.0 * math.pi))[0]
        for tuning in ("ours.pd_dob_fixed", "ours.pd_dob_robust")
    }
    assert peaks["ours.pd_dob_fixed"] == pytest.approx(1.44, rel=0.03)
    assert peaks["ours.pd_dob_robust"] < 0.1 * peaks["ours.pd_dob_fixed"]


def test_differentiating_the_error_takes_a_third_off_the_fast_sine():
    peaks = [errors_um(stage_loop(b, "fast", encoder_mm=1e-5).run(4.0, record="true_error")) for b in (ROBUST, OURS)]
    assert peaks[1][0] < 0.7 * peaks[0][0] and peaks[1][1] < 0.8 * peaks[0][1]


def test_at_a_constant_slow_feed_the_schedule_chatters_and_the_fixed_gains_do_not():
    """At 0.1 rad/s; commanded as the ramp of a slow and very wide sine."""
    swing = {}
    for tuning in ("ours.pd_dob_fixed", "ours.pd_dob"):
        v = 0.1
        loop = Loop(
            reference=sine_motion(amplitude=1e4 * v, frequency=1e-4 / (2.0 * math.pi)), controller=TUNINGS[tuning],
            plant=ballscrew_stage.starting(speed=v, bristle=6.24e-5), period=DT,
            sensor=ruler(resolution_mm=1e-5 / TRAVEL_MM_PER_RAD), metrics={}, method="rodas", rtol=1e-6, atol=1e-12,
        )  # fmt: skip
        run = loop.run(1.0, record=SIGNALS)
        swing[tuning] = np.ptp(run["output"][2000:])
        assert errors_um(run)[0] < 0.1
    assert swing["ours.pd_dob_fixed"] < 0.2 and 1.0 < swing["ours.pd_dob"] < 4.0


CHANGED = [
    ({"friction.coulomb": 1.2 * 6.24, "friction.static": 1.2 * 9.36}, {"slow": 0.050, "wide": 0.12, "fast": 0.356}),
    ({"inertia": 1.3 * INERTIA}, {"slow": 0.064, "fast": 0.191}),
]


@pytest.mark.slow
@pytest.mark.parametrize(("changes", "name", "largest"), [(c, n, v) for c, rows in CHANGED for n, v in rows.items()])
def test_another_friction_or_inertia_than_believed_leaves_the_known_errors(changes, name, largest):
    run = from_rest(ROBUST, name, ballscrew_stage(**changes)).run(seconds(name), record="true_error")
    assert errors_um(run)[0] == pytest.approx(largest, rel=0.02)


@pytest.mark.slow
def test_less_friction_than_believed_is_worse_than_more():
    weak = ballscrew_stage(**{"friction.coulomb": 0.8 * 6.24, "friction.static": 0.8 * 9.36})
    run = from_rest(ROBUST, "fast", weak).run(4.0, record="true_error")
    assert 1.0 < errors_um(run)[0] < 1.6


@pytest.mark.slow
def test_faster_sampling_gives_less_error():
    for name, largest in (("slow", 0.069), ("wide", 0.071), ("fast", 0.166)):
        run = stage_loop(ROBUST, name, period=1e-4, encoder_mm=1e-5).run(seconds(name), record="true_error")
        assert errors_um(run)[0] == pytest.approx(largest, rel=0.02)


def maxwell_stage():
    """The stage with six Maxwell elements in place of LuGre's bristles."""
    elements = {
        "friction.attraction": 0.0, "friction.attraction_per_travel": 1e5, "friction.coulomb": 6.24,
        "friction.static": 9.36, "friction.stribeck_speed": 1e-3, "friction.viscous": 0.4,
        "friction.damping": MaxwellSlip().damping,
    }  # fmt: skip
    return mass_maxwell_slip(mass=INERTIA, **elements)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "largest"), [("slow", 0.083), ("wide", 0.21), ("fast", 0.355)])
def test_on_another_friction_model_than_believed_the_errors_are_no_larger_than_known(name, largest):
    loop = from_rest(ROBUST, name, maxwell_stage(), method="rk4", substeps=250)
    found = errors_um(loop.run(seconds(name), record="true_error"))[0]
    assert 0.85 * largest < found < 1.02 * largest


# ---- as a block
@pytest.mark.parametrize("block", [ROBUST, OURS], ids=["robust", "ours"])
@pytest.mark.parametrize("output", [4.0, -7.0, 25.0])
def test_from_rest_the_first_output_after_an_align_is_the_last_one_before(block, output):
    p, here = block.prepare(block.params, DT), Motion(0.2, 0.0, 0.0)
    _, u = block.step(p, block.align(p, here, 0.2 + 3e-5, output), here, 0.2 + 3e-5, DT)
    assert u == pytest.approx(output, abs=1e-9)


def test_without_an_observer_static_friction_is_the_most_that_an_align_holds():
    block, here = pd_dob(observer_rate=0.0), Motion(0.0, 0.0, 0.0)
    p = block.prepare(block.params, DT)
    _, u = block.step(p, block.align(p, here, 0.0, 50.0), here, 0.0, DT)
    assert u == pytest.approx(9.36)


@pytest.mark.slow
def test_it_takes_over_in_motion_without_a_kick():
    live = stage_loop(TUNINGS["ours.pd_dob_fixed"], "fast").start()
    before = live.advance(400)["output"]
    live = live.switch(OURS)
    after = live.advance(400, record=SIGNALS)
    assert live.bumpless
    assert abs(after["output"][0] - before[-1]) < 0.1 and UM * np.abs(after["true_error"]).max() < 5.0


def test_a_positive_error_gives_a_positive_torque():
    _, u = stepped(pd_dob, (Motion(1e-4, 0.0, 0.0), 0.0))
    assert pd_dob.sense == 1 and u > 0.0


def test_in_mm_it_is_the_same_motion():
    by_rad = stage_loop(OURS, "fast").run(0.3, record="actual")["actual"]
    mm = stage_loop(OURS(travel_per_rad=1.5923), "fast", plant=ballscrew_stage(travel_per_rad=1.5923))
    by_mm = mm.using({"reference.amplitude": 1.0}).run(0.3, record="actual")["actual"]
    assert by_mm / 1.5923 == pytest.approx(by_rad, abs=1e-8)


@pytest.mark.sweep
@pytest.mark.parametrize(
    "changes", [{}, {"rate_of_error": False, "max_torque": 9.0, "pieces": 0}, {"friction": False, "low_pass_hz": 0.0}]
)
def test_all_engines_give_the_same_bits(changes):
    loop = from_rest(pd_dob(**changes), "fast")
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.02, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[column], plain[column]) for column in plain.signals)


@pytest.mark.sweep
def test_a_batch_gives_the_bits_of_single_runs():
    loop = stage_loop(OURS, "fast", method="sdirk3", substeps=10)
    gains = np.linspace(200.0, 400.0, 17)
    batch = loop.batch(0.1, {"controller.kp": gains}, record="true_error")
    for k in (0, 7, 16):
        single = loop.using({"controller.kp": gains[k]}).run(0.1, record="true_error")
        assert np.array_equal(batch["true_error"][k], single["true_error"])


def test_a_slow_speed_of_zero_is_refused():
    with pytest.raises(ValueRefused, match=r"slow_speed = 0.0"):
        pd_dob(slow_speed=0.0)


def test_the_align_is_inside_the_step_subset():
    module, here, p = Module(), Motion(0.2, 0.1, 0.0), pd_dob.prepare(pd_dob.params, DT)
    module.arguments[id(pd_dob.align), "params"] = type(p)
    module.arguments[id(pd_dob.align), "command"] = Motion
    translated = module.callable(pd_dob.align)
    assert module.namespace()[translated](p, here, 0.19, 3.0) == pd_dob.align(p, here, 0.19, 3.0)
