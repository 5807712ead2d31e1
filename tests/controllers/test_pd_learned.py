"""PD that learns its friction: hand-worked steps, what it learns, and the errors that are left when it has."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.controllers._learned_friction import (
    LEAST,
    MOST,
    SPREAD,
    LearnedPlan,
    at_start,
    believed,
    foreseen,
    learn,
    seen,
    spread_at_start,
)
from leadscrew.controllers._pd_learned import initial, pd_learned
from leadscrew.disturbances._step_load import step_load
from leadscrew.friction.lugre import HAT, LuGre, bristle_after, bristle_rate
from leadscrew.kernel.block import plant
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.module import Module
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD, ballscrew_stage
from leadscrew.references._motion import Motion
from leadscrew.references._sine import sine_motion
from leadscrew.sensors._counts import ruler
from leadscrew.studies.fsmc_ballscrew.tunings import SCHEDULED as PD_DOB
from leadscrew.util.errors import ValueRefused
from tests.controllers.stage_loop import SINES, UM, stage_loop

DT = 2.5e-4
PLAIN = LuGre(stiffness=1e5, damping=300.0, viscous=0.4, coulomb=6.0, static=6.0)
"""Without Stribeck's fall, as what is learned."""


def stepped(block, state, *readings):
    """State and torque after some readings, each a command and a feedback."""
    p, s, u = block.prepare(block.params, DT), state, None
    for command, feedback in readings:
        s, u = block.step(p, s, command, feedback, DT)
    return s, u


def fresh(block):
    return initial(block.params)


def same(left, right):
    return all(np.array_equal(a, b) for a, b in zip(left, right, strict=True))


# ---- the friction that it learns
def test_friction_over_a_period_is_the_mean_that_scipy_finds():
    """From bristles bent backwards, through a reversal inside the period."""
    v, a, z0 = -0.004, 40.0, -0.7 * 6e-5

    def rates(t, y):
        speed = v + a * t
        z = y[0]
        rate = bristle_rate(PLAIN, speed, z)
        return [rate, PLAIN.stiffness * z + PLAIN.damping * rate + PLAIN.viscous * speed]

    exact = solve_ivp(rates, (0.0, DT), [z0, 0.0], rtol=1e-11, atol=1e-16)
    slope = np.zeros(5)
    found = foreseen(at_start(PLAIN), slope, -0.7, 0.0, v, a, 100, DT)
    assert found.torque == pytest.approx(exact.y[1, -1] / DT, rel=2e-4)
    assert found.share == pytest.approx(exact.y[0, -1] / 6e-5, rel=1e-4)


@pytest.mark.parametrize("number", range(5))
def test_its_slopes_are_those_of_a_difference_quotient(number):
    def torque(change):
        known, share, bent = at_start(PLAIN), -0.9, 0.0
        known[number] *= 1.0 + change
        known[4] += change if number == 4 else 0.0
        slope = np.zeros(5)
        for _ in range(6):
            found = foreseen(known, slope, share, bent, 0.05, 20.0, 6, DT)
            share, bent = found.share, found.bent
        return found.torque, slope[number] * (1.0 if number == 4 else at_start(PLAIN)[number])

    (more, _), (less, _), (_, slope) = torque(1e-5), torque(-1e-5), torque(0.0)
    assert (more - less) / 2e-5 == pytest.approx(slope, rel=1e-6)


def test_what_it_sees_of_a_measured_period_is_lugre_at_a_constant_speed():
    moved, z0 = 2e-5, -0.4 * 6e-5
    found = seen(at_start(PLAIN), -0.4, moved, DT)
    z1 = bristle_after(PLAIN, moved / DT, z0, DT)
    mean = PLAIN.stiffness * 0.5 * (z0 + z1) + PLAIN.damping * (z1 - z0) / DT + PLAIN.viscous * moved / DT
    assert found.share == pytest.approx(z1 / 6e-5, rel=1e-12)
    assert found.torque == pytest.approx(mean, rel=1e-12)


def test_learning_is_least_squares_with_the_believed_numbers_as_a_prior():
    """Against the normal equations of all periods at once; small noise, so that nothing is cut."""
    random = np.random.default_rng(1)
    rows = random.standard_normal((40, 5)) * np.array([1.0, 1e4, 1e-2, 1.0, 1.0])
    prior, spread = at_start(PLAIN), spread_at_start(PLAIN)
    truth = prior * (1.0 + 0.05 * random.standard_normal(5)) + np.array([0.0, 0.0, 0.0, 0.0, 0.2])
    y = rows @ truth + 1e-3 * random.standard_normal(40)
    plan = LearnedPlan(2.0, 0.0, 0.0, believed(PLAIN))
    known, p = prior.copy(), spread.copy()
    for row, measured in zip(rows, y, strict=True):
        learn(plan, known, p, np.zeros(5), row, row, measured - row @ known, 0.0, 1.0)
    weight = np.linalg.inv(spread) + rows.T @ rows / 4.0
    at_once = prior + np.linalg.solve(weight, rows.T @ (y - rows @ prior) / 4.0)
    assert known == pytest.approx(at_once, rel=1e-8)
    assert p == pytest.approx(np.linalg.inv(weight), rel=1e-6, abs=1e-16)


def test_one_wild_period_moves_it_by_three_standard_deviations_at_most():
    plan, row = LearnedPlan(0.5, 0.0, 0.0, believed(PLAIN)), np.array([1.0, 0.0, 0.0, 0.0, 0.0])
    moves = []
    for wild in (1e3, 1e6):
        known, p = at_start(PLAIN), spread_at_start(PLAIN)
        learn(plan, known, p, np.zeros(5), row, row, wild, 0.0, 0.0)
        moves.append(known[0] - 6.0)
    off = (SPREAD[0] * 6.0) ** 2
    assert moves[0] == moves[1] == pytest.approx(3.0 * off / math.sqrt(off + 0.25), rel=1e-12)


def test_it_never_leaves_the_neighbourhood_of_what_is_believed():
    plan, random = LearnedPlan(0.01, 0.0, 0.0, believed(HAT)), np.random.default_rng(2)
    known, p = at_start(HAT), spread_at_start(HAT)
    for _ in range(500):
        row = random.standard_normal(5) * np.array([1.0, 1e5, 1e-2, 4.0, 1.0])
        learn(plan, known, p, np.zeros(5), row, row, 1e3 * random.standard_normal(), 0.0, 1.0)
    assert np.all(known >= LEAST * believed(HAT)) and np.all(known <= MOST * believed(HAT))


def test_what_it_does_not_see_for_long_becomes_as_uncertain_as_at_the_start():
    plan, p = LearnedPlan(0.5, 0.0, 0.01, believed(HAT)), 1e-6 * spread_at_start(HAT)
    for _ in range(2000):
        learn(plan, at_start(HAT), p, np.zeros(5), np.zeros(5), np.zeros(5), 0.0, 0.0, 1.0)
    assert p == pytest.approx(spread_at_start(HAT), rel=1e-6)
    before = p.copy()
    learn(plan, at_start(HAT), p, np.zeros(5), np.zeros(5), np.zeros(5), 0.0, 0.0, 0.0)
    assert np.array_equal(p, before)


# ---- the law
FIXED = pd_learned(
    kp=100.0, kd=0.5, kp_slow=50.0, kd_slow=1.0, slow_speed=2.0, slow_time=0.1, kd_stuck=8.0, kd_share=0.5,
    observer_rate=1000.0, low_pass_hz=0.0, learns=False, inertia=4e-4,
    **{f"hat.{name}": value for name, value in PLAIN._asdict().items()},
)  # fmt: skip


def test_two_periods_worked_by_hand():
    """In sliding; speed and a tenth of a second of acceleration make sqrt(3.2^2 + 2.4^2) = 4 rad/s: m = 1 / 17."""
    first, second = Motion(0.0, 3.2, 24.0), Motion(8e-4, 3.2, 24.0)
    s, u = stepped(FIXED, fresh(FIXED), (first, 1e-5))
    kp, kd = 100.0 + 50.0 / 17.0, 0.5 + 1.0 / 17.0
    friction = 6.0 + 0.4 * (3.2 + 0.5 * 24.0 * DT)
    one = 4e-4 * 24.0 + friction - kp * 1e-5
    assert u == pytest.approx(one, rel=1e-12) and s.load == 0.0
    s, u = stepped(FIXED, fresh(FIXED), (first, 1e-5), (second, 8.3e-4))
    rate = (3e-5 - 1e-5) / DT
    q = 4e-4 * 3.2 + DT * (one - friction)
    d = 1000.0 * (q - 4e-4 * (3.2 + rate))
    assert s.load == pytest.approx(d, rel=1e-9)
    assert u == pytest.approx(4e-4 * 24.0 + friction - kp * 3e-5 - kd * rate + d, rel=1e-9)


def turned(moved, late, speed=20.0):
    """Torque of the rate of the error, just after a reversal, at a speed that is not slow."""
    begun = fresh(FIXED)._replace(share=-1.0, seen=-1.0, periods=3.0)
    here = Motion(moved, speed, 0.0)
    block = FIXED(kp=0.0, kd=0.0, kp_slow=0.0, kd_slow=0.0, observer_rate=0.0)
    s, u = stepped(block, begun, (here, moved + late))
    return u - s.friction, s


def test_just_after_a_reversal_the_rate_is_damped_as_much_as_the_bristles_bear():
    """A stage that is late is pushed with 8, and half of sigma_1 (1 - w) where that is less."""
    torque, s = turned(1e-6, -1e-8)
    assert torque == pytest.approx(8.0 * 1e-8 / DT, rel=1e-6)
    torque, s = turned(3e-4, -1e-8)
    gain = 0.5 * 300.0 * (1.0 - s.seen)
    assert gain < 8.0 and torque == pytest.approx(gain * 1e-8 / DT, rel=1e-6)


def test_a_stage_that_is_early_is_held_back_by_no_more_than_the_foreseen_damping():
    torque, s = turned(1e-6, 4e-5, speed=1e-3)
    damping = s.friction - 6.0 * s.slope[0] - 0.4 * 1e-3
    assert torque == pytest.approx(-damping, rel=1e-9) and 0.0 < damping < 8.0 * 4e-5 / DT


class Screw(NamedTuple):
    angle: float = 0.0
    speed: float = 0.0


@plant(None, Screw(), output="angle")
def screw(s, u, load):
    """1e-3 kg m^2, free."""
    return Screw(s.speed, (u + load) / 1e-3)


NO_FRICTION = pd_learned(
    learns=False, inertia=1e-3, kp=500.0, kd=1.0, kp_slow=0.0, kd_slow=0.0, kd_stuck=0.0, observer_rate=1500.0
)


@pytest.mark.slow
def test_a_load_that_the_model_does_not_know_is_found_and_taken_away():
    loop = Loop(reference=sine_motion(amplitude=0.0), controller=NO_FRICTION, plant=screw, period=DT, metrics={},
                disturbance=step_load(size=0.7, time=0.01))  # fmt: skip
    run = loop.run(0.2, record=("controller", "true_error"))
    assert run["controller.load"][-1] == pytest.approx(-0.7, rel=1e-6)
    assert abs(run["true_error"][-1]) < 1e-9


@pytest.mark.slow
def test_at_the_torque_limit_the_observer_does_not_wind_up_and_nothing_is_learned():
    block = NO_FRICTION(max_torque=0.5, learns=True)
    loop = Loop(reference=sine_motion(amplitude=0.0), controller=block, plant=screw.starting(angle=-0.3), period=DT,
                metrics={})  # fmt: skip
    run = loop.run(0.5, record=("controller", "output"))
    assert np.abs(run["output"]).max() == 0.5
    assert np.abs(run["controller.load"]).max() < 0.25
    assert run["controller.coulomb"][-1] == 6.24


def test_a_settled_loop_keeps_no_denormal_numbers():
    loop = Loop(reference=sine_motion(amplitude=0.0), controller=NO_FRICTION, plant=screw.starting(angle=-1e-4),
                period=DT, metrics={})  # fmt: skip
    run = loop.run(3.0, record=("controller", "output"))
    assert run["controller.rate"][-1] == run["controller.momentum"][-1] == run["controller.load"][-1] == 0.0


# ---- on the stage
def from_rest(block, name, plant=ballscrew_stage, period=DT, **more):
    """A sine that starts at its lower end, at rest."""
    amplitude, rate = SINES[name]
    size = amplitude / TRAVEL_MM_PER_RAD
    return Loop(
        reference=sine_motion(amplitude=size, frequency=rate / (2.0 * math.pi), phase=-0.5 * math.pi, offset=size),
        controller=block, plant=plant, sensor=ruler(resolution_mm=1e-5 / TRAVEL_MM_PER_RAD), period=period, metrics={},
        **({"method": "rodas", "rtol": 1e-5, "atol": 1e-11} | more),
    )  # fmt: skip


def friction(by):
    """The stage with this much more or less Coulomb and static friction."""
    return ballscrew_stage(**{"friction.coulomb": by * 6.24, "friction.static": by * 9.36})


@pytest.mark.slow
@pytest.mark.parametrize("by", [0.8, 1.0, 1.2])
def test_it_learns_what_table_2_believes_wrong(by):
    """Believed: bristles of 2e5 N m/rad and 632 N m s/rad, 1.2 N m s/rad viscous, 6.24 N m."""
    run = from_rest(pd_learned, "fast", friction(by)).run(8.0, record="controller")
    coulomb, bend = run["controller.coulomb"][-1], run["controller.bend"][-1]
    assert coulomb == pytest.approx(by * 6.24, rel=2e-3)
    assert coulomb / bend == pytest.approx(1e5, rel=0.1)
    assert run["controller.bristle_damping"][-1] == pytest.approx(math.sqrt(1e5), rel=0.1)
    assert run["controller.viscous"][-1] == pytest.approx(0.4, rel=0.01)


def usual_peak(block, name, by=1.0, seconds=12.0):
    """Median over the reversals of the second half, when it has learned, of the largest true error near each; um."""
    e = UM * np.abs(from_rest(block, name, friction(by)).run(seconds, record="true_error")["true_error"])
    half_period = round(math.pi / SINES[name][1] / DT)
    count = len(e) // half_period
    return np.median([e[k * half_period :][:half_period].max() for k in range(count // 2, count)])


@pytest.mark.slow
@pytest.mark.parametrize("by", [0.8, 1.0, 1.2])
@pytest.mark.parametrize(("name", "seconds"), [("wide", 25.2), ("fast", 8.0)])
def test_when_it_has_learned_the_usual_peak_is_half_of_that_with_the_fixed_model(name, seconds, by):
    """The usual one, because single peaks are several times as large: what the encoder's steps make of them."""
    assert usual_peak(pd_learned, name, by, seconds) < 0.5 * usual_peak(PD_DOB["ours.pd_dob"], name, by, seconds)


@pytest.mark.slow
def test_its_gains_without_learning_are_no_better_than_the_fixed_model():
    assert usual_peak(pd_learned(learns=False), "fast", 1.0, 6.0) > 3.0 * usual_peak(pd_learned, "fast", 1.0, 6.0)


def test_in_slow_motion_it_learns_nothing():
    run = from_rest(pd_learned, "slow").run(3.0, record="controller")
    assert np.all(run["controller.coulomb"][1:] == 6.24)


# ---- as a block
@pytest.mark.parametrize("output", [4.0, -7.0, 25.0])
def test_from_rest_the_first_output_after_an_align_is_the_last_one_before(output):
    p, here = pd_learned.prepare(pd_learned.params, DT), Motion(0.2, 0.0, 0.0)
    _, u = pd_learned.step(p, pd_learned.align(p, here, 0.2 + 3e-5, output), here, 0.2 + 3e-5, DT)
    assert u == pytest.approx(output, abs=1e-9)


@pytest.mark.slow
def test_it_takes_over_in_motion_without_a_kick():
    live = stage_loop(PD_DOB["ours.pd_dob_fixed"], "fast").start()
    before = live.advance(400)["output"]
    live = live.switch(pd_learned)
    after = live.advance(400, record=("true_error", "output"))
    assert live.bumpless
    assert abs(after["output"][0] - before[-1]) < 0.1 and UM * np.abs(after["true_error"]).max() < 5.0


def test_it_can_be_taken_over_twice():
    """What the first one learned is not what the second starts from."""
    for _ in range(2):
        live = stage_loop(PD_DOB["ours.pd_dob_fixed"], "fast").start()
        live.advance(400)
        live = live.switch(pd_learned)
        assert live.advance(1, record="controller")["controller.coulomb"][0] == 6.24
        assert live.advance(4000, record="controller")["controller.bend"][-1] > 1.5 * 3.12e-5


def test_a_positive_error_gives_a_positive_torque():
    _, u = stepped(pd_learned, fresh(pd_learned), (Motion(1e-4, 0.0, 0.0), 0.0))
    assert pd_learned.sense == 1 and u > 0.0


def test_in_mm_it_is_the_same_motion():
    by_rad = stage_loop(pd_learned, "fast").run(0.1, record="actual")["actual"]
    mm = stage_loop(pd_learned(travel_per_rad=1.5923), "fast", plant=ballscrew_stage(travel_per_rad=1.5923))
    by_mm = mm.using({"reference.amplitude": 1.0}).run(0.1, record="actual")["actual"]
    assert by_mm / 1.5923 == pytest.approx(by_rad, abs=1e-8)


@pytest.mark.sweep
@pytest.mark.parametrize("changes", [{}, {"learns": False, "low_pass_hz": 0.0}, {"max_torque": 9.0, "pieces": 1}])
def test_all_engines_give_the_same_bits(changes):
    loop = from_rest(pd_learned(**changes), "fast")
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.02, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[column], plain[column]) for column in plain.signals)


@pytest.mark.sweep
def test_a_batch_gives_the_bits_of_single_runs():
    loop = stage_loop(pd_learned, "fast", method="sdirk3", substeps=10)
    gains = np.linspace(200.0, 400.0, 9)
    batch = loop.batch(0.1, {"controller.kp": gains}, record="true_error")
    for k in (0, 4, 8):
        single = loop.using({"controller.kp": gains[k]}).run(0.1, record="true_error")
        assert np.array_equal(batch["true_error"][k], single["true_error"])


@pytest.mark.parametrize(
    ("name", "value"), [("slow_speed", 0.0), ("torque_noise", 0.0), ("forget", 1.5), ("pieces", 0)]
)
def test_values_without_a_meaning_are_refused(name, value):
    with pytest.raises(ValueRefused, match=rf"{name} = "):
        pd_learned(**{name: value})


def test_the_align_is_inside_the_step_subset():
    module, here, p = Module(), Motion(0.2, 0.1, 0.0), pd_learned.prepare(pd_learned.params, DT)
    module.arguments[id(pd_learned.align), "params"] = type(p)
    module.arguments[id(pd_learned.align), "command"] = Motion
    translated = module.callable(pd_learned.align)
    assert same(module.namespace()[translated](p, here, 0.19, 3.0), pd_learned.align(p, here, 0.19, 3.0))
