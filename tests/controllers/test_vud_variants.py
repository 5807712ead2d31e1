"""Variants of the VUD law: against the printed blocks bit by bit, an independent loop, and worked numbers."""

import math

import numpy as np
import pytest

from leadscrew.actuators._dead_zone import dead_zone
from leadscrew.controllers._vud import vud, vud_beta_e, vud_family, vud_incremental, vud_integral_factor, vud_scaled
from leadscrew.controllers._vud.family import BETA_E, PRINTED
from leadscrew.controllers._vud.scaled import ROBUST
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.metrics import overshoot, settling_time, steady_state_error
from leadscrew.plants._lathe_servo import lathe_servo
from leadscrew.references._step import step
from leadscrew.sensors._counts import grating_count
from leadscrew.studies.vud_lathe.controllers import VARIANTS
from leadscrew.util.errors import ValueRefused
from tests.studies import lathe_oracle as oracle
from tests.tools import runnable

DT, COUNT = 1e-3, 0.000625
METRICS = {
    "fine": settling_time(percent=0.0, band=0.002),
    "overshoot": overshoot,
    "end": steady_state_error(from_time=2.0),
}


def lathe(controller, target, actuator=None):
    return Loop(
        reference=step(target=target), controller=controller, plant=lathe_servo, sensor=grating_count,
        actuator=actuator, period=DT, metrics=METRICS,
    )  # fmt: skip


def positions(target, periods, law, speed=289.0):
    """The independent axis under ``law(k, error, error_before, rho_before)``."""
    matrix, x, seen = oracle.axis_matrices(speed), np.zeros(6), np.empty(periods)
    rho, before = 0.0, 0.0
    for k in range(periods):
        seen[k] = x[3]
        error = target - math.floor(x[4] / COUNT + 0.5) * COUNT
        rho = law(k, error, before, rho)
        before = error
        x[5] = min(1.0, max(-1.0, rho))
        x = matrix @ x
    return seen


def clipped(x):
    return min(1.0, max(-1.0, x))


# ---- one block for all
MILDER = {"output_gain": 1.0, "output_tau": 0.5}
PRINTED_BLOCKS = {
    "printed": (vud, PRINTED),
    "beta_e": (vud_beta_e, BETA_E),
    "beta_e_half": (vud_beta_e(**MILDER), {**BETA_E, **MILDER}),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", PRINTED_BLOCKS)
@pytest.mark.parametrize("target", [-170.0, 50.0])
def test_the_family_is_the_printed_and_the_corrected_law_to_the_last_bit(name, target):
    block, changes = PRINTED_BLOCKS[name]
    a, b = (
        lathe(c, target).run(2.0, record=("actual.position", "output", "controller"))
        for c in (block, vud_family(**changes))
    )
    for signal in ("actual.position", "output"):
        assert np.array_equal(a[signal].view(np.int64), b[signal].view(np.int64)), signal
    for signal in a.signals:
        assert np.array_equal(a[signal], b[signal]), signal


@pytest.mark.slow
def test_the_scaled_controller_is_a_member_of_the_family():
    same = {f: getattr(ROBUST, f) for f in ROBUST._fields if f in vud_family.params._fields}
    member = vud_family(**{k: v for k, v in same.items() if np.ndim(v) == 0}, output_from="none", hold_inputs=True)
    a, b = (lathe(c, -170.0).run(1.0, record="output") for c in (vud_scaled(**ROBUST._asdict()), member))
    assert np.array_equal(a["output"].view(np.int64), b["output"].view(np.int64))


FOLLOWED = {
    "none": lambda rho, e, ec: None, "duty": lambda rho, e, ec: abs(rho) ** 0.7, "error": lambda rho, e, ec: e**0.7,
    "rate": lambda rho, e, ec: ec**0.7, "product": lambda rho, e, ec: (e * ec) ** 0.7,
    "mean": lambda rho, e, ec: (e**0.7 + ec**0.7) / 2.0, "maximum": lambda rho, e, ec: max(e, ec) ** 0.7,
}  # fmt: skip
FACTORS = {
    "none": lambda x: 1.0,
    "power": lambda x: abs(x) ** 0.8 + 0.01,
    "exponential": lambda x: 1.0 - 0.7 * math.exp(-3.0 * x * x),
}  # fmt: skip


@pytest.mark.parametrize("followed", FOLLOWED)
@pytest.mark.parametrize("kind", FACTORS)
def test_each_factor_is_its_formula_over_all_36_rules(followed, kind):
    block = vud_family(
        e_kind=kind, ec_kind=kind, e_tau=0.8, ec_tau=0.8, e_floor=0.01, ec_floor=0.01, bell_depth=0.7,
        bell_steepness=3.0, output_from=followed, output_tau=0.7, output_floor=0.02, output_gain=1.3, error_gain=1.5,
        rate_gain=-0.5, output_limit=0.9,
    )  # fmt: skip
    seed = 3 * list(FOLLOWED).index(followed) + list(FACTORS).index(kind)
    p, random = block.prepare(block.params, DT), np.random.default_rng(seed)
    for _ in range(50):
        before, now, rho = random.uniform(-190.0, 190.0), random.uniform(-0.3, 0.3), random.uniform(-1.0, 1.0)
        state = block.state._replace(e=before / 190.0, rho=rho, started=1.0)
        _, duty = block.step(p, state, before + now, 0.0, DT)
        e, ec = 1.5 * (before + now) / 190.0, -0.5 * now * 100.0 / 25.87
        z = FOLLOWED[followed](rho, abs(e), abs(ec))
        beta = 1.3 * (1.0 if z is None else z + 0.02)
        out = oracle.all_rules(e / FACTORS[kind](e), ec / FACTORS[kind](ec))
        assert duty == pytest.approx(max(-0.9, min(0.9, beta * out)), abs=1e-9)


def test_the_low_pass_of_the_rate_is_that_of_a_held_input():
    block = vud_family(filter_s=0.004)
    p, state = block.prepare(block.params, DT), block.state._replace(started=1.0)
    for k in range(20):
        state, _ = block.step(p, state, 0.02 * (k + 1), 0.0, DT)
    assert state.ec == pytest.approx((0.02 * 100.0 / 25.87) * (1.0 - math.exp(-20.0 * DT / 0.004)), rel=1e-12)


def test_the_first_period_knows_no_rate_and_contracts_nothing():
    for block in (vud_family(output_gain=1.5, output_first=0.4), vud_scaled, vud_incremental):
        first, _ = block.step(block.prepare(block.params, DT), block.state, -50.0, 0.0, DT)
        assert (first.ec, first.alpha_e, first.alpha_ec) == (0.0, 1.0, 1.0)
    block = vud_family(output_gain=1.5, output_first=0.4)
    _, duty = block.step(block.prepare(block.params, DT), block.state, -50.0, 0.0, DT)
    assert duty == pytest.approx(1.5 * 0.4 * 0.505 / 0.33 * 50.0 / 190.0)


@pytest.mark.parametrize(
    ("changes", "said"),
    [({"output_from": 7}, "output_from = 7"), ({"e_kind": 1.5}, "none, power, exponential"),
         ({"ec_floor": 0.0}, "ec_floor"),
     ({"e_centres": np.array([-1.0, -0.67, -0.33, -0.33, 0.67, 1.0])}, "increasing")],
)  # fmt: skip
def test_a_factor_that_there_is_not_is_refused(changes, said):
    with pytest.raises(ValueRefused, match=said):
        block = vud_family(**changes)
        block.prepare(block.params, DT)


# ---- on the axis
def test_the_printed_factors_on_the_rate_are_what_the_independent_loop_gives():
    def raw_rate(k, error, before, rho):
        e, ec = error / 190.0, (error - before) / 25.87 if k else 0.0
        alpha, beta = (abs(e) ** 0.9 + 1e-4, abs(rho) ** 0.9 + 1e-4) if k else (1.0, 1.0)
        return clipped(beta * oracle.all_rules(e / alpha, ec / (1.0001 if k else 1.0)))

    mine = lathe(VARIANTS["corrected.vud_raw_rate"], -50.0).run(1.5)
    theirs = positions(-50.0, 1500, raw_rate)
    assert np.abs(mine["actual.position"][:1500] - theirs).max() < 1e-6
    assert mine.metrics["fine"] == pytest.approx(1.148, abs=0.002)
    assert mine.metrics["overshoot"] == pytest.approx(0.255, abs=0.001)


def test_without_an_output_factor_the_axis_hunts_and_a_reversed_rate_swings_it():
    alone = lathe(VARIANTS["corrected.vud_beta_one"], -50.0).run(4.0)
    reverse = lathe(VARIANTS["corrected.vud_rate_reversed"], -50.0).run(4.0)
    assert alone.metrics["end"] == pytest.approx(1.675, abs=0.001) and math.isnan(alone.metrics["fine"])
    assert reverse.metrics["overshoot"] == pytest.approx(6.3, abs=0.05) and math.isnan(reverse.metrics["fine"])


def test_the_scaled_law_arrives_as_the_independent_loop_does():
    kept, memory = math.exp(-DT / 0.00213), [0.0]

    def law(k, error, before, rho):
        memory[0] = kept * memory[0] + (1.0 - kept) * ((error - before) * 100.0 / 25.87 if k else 0.0)
        e, ec = clipped(4.612 * error / 190.0), clipped(0.494 * memory[0])
        alpha_e = abs(e) ** 0.236 + 0.1685 if k else 1.0
        alpha_ec = abs(ec) ** 0.0986 + 0.1685 if k else 1.0
        return clipped(2.638 * oracle.all_rules(e / alpha_e, ec / alpha_ec))

    theirs = positions(-170.0, 2500, law)
    mine = lathe(vud_scaled, -170.0).run(2.5)
    assert oracle.settled(theirs, -170.0, 0.002) == pytest.approx(mine.metrics["fine"], abs=1.5e-3)
    assert np.abs(mine["actual.position"][:700] - theirs[:700]).max() < 1e-6
    assert mine.metrics["fine"] <= 0.72 and mine.metrics["overshoot"] <= 1.5e-3 and mine.metrics["end"] <= 0.3125e-3


@pytest.mark.parametrize(("target", "limit_s"), [(-50.0, 0.33), (-170.0, 0.79), (170.0, 0.79)])
def test_the_robust_set_is_quick_on_slow_and_fast_axes_that_the_search_did_not_see(target, limit_s):
    speeds = np.linspace(259.0, 334.0, 23)
    batch = lathe(vud_scaled(**ROBUST._asdict()), target).batch(3.0, {"plant.full_duty_speed_mm_s": speeds})
    assert batch.metrics["fine"].max() <= limit_s
    assert batch.metrics["overshoot"].max() <= 1.5e-3 and batch.metrics["end"].max() <= 0.3125e-3


# ---- against friction
@pytest.mark.slow
@pytest.mark.parametrize(("target", "limit_s"), [(-50.0, 0.75), (-170.0, 1.2)])
def test_with_integral_and_inverse_a_dead_zone_leaves_less_than_a_count(target, limit_s):
    lost = np.array([0.005, 0.01, 0.02, 0.03, 0.05])
    loop = lathe(vud_scaled(integral_gain=2.0), target, dead_zone(subtract=True))
    helped = loop.batch(3.0, {"actuator.threshold": lost, "controller.dead_zone": lost})
    alone = lathe(vud_scaled, target, dead_zone(subtract=True)).batch(3.0, {"actuator.threshold": lost})
    assert helped.metrics["end"].max() <= 0.625e-3 and helped.metrics["fine"].max() <= limit_s
    assert alone.metrics["end"].max() > 10.0 * helped.metrics["end"].max()


def test_more_than_the_whole_dead_zone_makes_the_axis_hunt():
    loop = lathe(vud_scaled(dead_zone=0.05), -50.0, dead_zone(threshold=0.05, subtract=True))
    ends = loop.batch(3.0, {"controller.dead_zone_share": np.array([1.0, 1.1])}).metrics["end"]
    assert ends[0] <= 0.3125e-3 and 1e-3 < ends[1] < 7e-3


def test_the_integral_works_near_the_target_alone_and_ends_with_the_error():
    block = vud_scaled(integral_gain=2.0)
    p, state = block.prepare(block.params, DT), block.state
    for _ in range(10):
        state, _ = block.step(p, state, -0.05, 0.0, DT)
    assert state.integral == pytest.approx(10 * 2.0 * 0.05 * DT)
    assert block.step(p, state, -0.2, 0.0, DT)[0].integral == 0.0
    assert block.step(p, state, -0.0005, 0.0, DT)[0].integral == 0.0


def test_the_inverse_adds_its_share_in_the_direction_of_the_duty():
    plain, helped = vud_scaled, vud_scaled(dead_zone=0.05)
    for command in (-1.0, 1.0):
        without, with_it = (b.step(b.prepare(b.params, DT), b.state, command, 0.0, DT)[1] for b in (plain, helped))
        assert with_it - without == pytest.approx(math.copysign(0.8 * 0.05, -command))
    assert helped.step(helped.prepare(helped.params, DT), helped.state, 0.0, 0.0, DT)[1] == 0.0


# ---- increments and Li's factor
@pytest.mark.slow
def test_increments_add_up_and_never_settle():
    block = vud_incremental(gain=0.01)
    p, state = block.prepare(block.params, DT), block.state._replace(e=-0.5, started=1.0, rho=0.25)
    _, duty = block.step(p, state, -95.0, 0.0, DT)
    assert duty == pytest.approx(0.25 + 0.01 * oracle.all_rules(-0.5 / (0.5**0.9 + 1e-4), 0.0), abs=1e-12)
    gains = np.array([1e-4, 1e-3, 1e-2, 1e-1])
    for target in (-50.0, -170.0):
        batch = lathe(vud_incremental, target).batch(4.0, {"controller.gain": gains})
        assert np.isnan(batch.metrics["fine"]).all() and batch.metrics["end"].min() > 6.0


def test_lis_factor_grows_with_the_error_and_shrinks_on_the_way_up():
    block = vud_integral_factor
    p = block.prepare(block.params, DT)
    for command, sign in ((-95.0, 1.0), (95.0, -1.0)):
        state = block.state
        for _ in range(101):
            state, _ = block.step(p, state, command, 0.0, DT)
        assert state.seen.beta == pytest.approx(0.3 + sign * 0.5 * 0.5 * 100 * DT)
    for _ in range(2000):
        state, _ = block.step(p, state, 95.0, 0.0, DT)
    assert state.seen.beta == 0.01


def test_with_lis_factor_the_axis_comes_near_and_hunts():
    ends = [lathe(vud_integral_factor, t).run(4.0, every=0).metrics for t in (-50.0, -170.0)]
    assert [round(1e3 * m["end"]) for m in ends] == [20, 47] and all(math.isnan(m["fine"]) for m in ends)


@pytest.mark.slow
def test_a_constant_factor_of_a_half_hunts_less_than_lis():
    settings = {"controller.integral_gain": np.array([0.5, 0.0]), "controller.start": np.array([0.3, 0.5])}
    li, constant = lathe(vud_integral_factor, -170.0).batch(4.0, settings).metrics["end"]
    assert constant < 0.75 * li


# ---- the set
def test_every_variant_is_explained_and_shares_one_of_four_programs():
    assert len({b.doc for b in VARIANTS.values()}) == len(VARIANTS)
    assert len({b.name for b in VARIANTS.values()}) == 4


@pytest.mark.sweep
@pytest.mark.parametrize("engine", ["llvm", "c"])
@pytest.mark.parametrize("name", ["corrected.vud_beta_max", "ours.vud_exponential", "ours.vud_opt_robust"])
def test_every_engine_gives_the_bits_of_plain_python(name, engine):
    loop = lathe(VARIANTS[name], -50.0)
    plain, fast = (loop.run(0.3, engine=e) for e in ("python", runnable(engine)))
    for signal in plain.signals:
        assert np.array_equal(plain[signal].view(np.int64), fast[signal].view(np.int64)), signal
