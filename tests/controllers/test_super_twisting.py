"""Super-twisting: hand-worked steps, a disturbance that its integral must follow, known errors on the three sines."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.controllers._sliding.super_twisting import super_twisting
from leadscrew.disturbances._sine_load import sine_load
from leadscrew.kernel.block import plant
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.module import Module
from leadscrew.plants._ballscrew_stage import INERTIA, ballscrew_stage
from leadscrew.references._motion import Motion
from leadscrew.references._sine import sine_motion
from leadscrew.util.errors import ValueRefused
from tests.controllers.stage_loop import UM, errors_um, stage_loop

SIGNALS = ("true_error", "output")
DT = 2.5e-4
STILL = Motion(0.0, 0.0, 0.0)


def stepped(block, *readings, dt=DT):
    """State and torque after some readings, each a command and a feedback."""
    p, s, u = block.prepare(block.params, dt), block.state, None
    for command, feedback in readings:
        s, u = block.step(p, s, command, feedback, dt)
    return s, u


def test_two_periods_worked_by_hand():
    block = super_twisting(lam=100.0, k1=2.0, k2=50.0, layer=1e-2, speed_filter_s=0.0, friction_from=0)
    s, u = stepped(block, (STILL, 4e-5))
    assert s.w == 0.0 and u == pytest.approx(-2.0 * math.sqrt(4e-3) * 0.4)
    s, u = stepped(block, (STILL, 4e-5), (STILL, 5e-5))
    sigma = 1e-5 / DT + 100.0 * 5e-5
    assert sigma > 1e-2 and s.surface == pytest.approx(sigma) and s.w == pytest.approx(-50.0 * DT)
    assert u == pytest.approx(-INERTIA * 100.0 * 1e-5 / DT - 2.0 * math.sqrt(sigma) - 50.0 * DT)


class Screw(NamedTuple):
    angle: float = 0.0
    speed: float = 0.0


@plant(None, Screw())
def without_friction(s, u, load):
    """The stage's inertia, free."""
    return Screw(s.speed, (u + load) / INERTIA)


@pytest.mark.slow
def test_the_integral_follows_a_disturbance_that_changes_more_slowly_than_k2():
    """0.5 N m at 10 rad/s changes by 5 N m/s at most, k2 is 95 N m/s."""
    block = super_twisting(friction_from=0)
    loop = Loop(
        reference=sine_motion(amplitude=0.0), controller=block, plant=without_friction, period=1e-5, metrics={},
        disturbance=sine_load(amplitude=0.5, frequency=10.0 / (2.0 * math.pi)),
    )  # fmt: skip
    run = loop.run(1.0, record=("controller", "disturbance", "true_error"))
    late = slice(50_000, None)
    assert np.abs(run["controller.w"][late] + run["disturbance"][late]).max() < 0.02
    weak = loop.using({"controller.k2": 2.0}).run(1.0, record=("controller", "disturbance"))
    assert np.abs(weak["controller.w"][late] + weak["disturbance"][late]).max() > 0.1


KNOWN = [("slow", 0.011, 5e-4), ("wide", 0.32, 0.02), ("fast", 0.33, 0.005)]
"""RMS in um of an earlier and independent simulation of ours, which chatters on the second sine, and how near."""


@pytest.mark.slow
@pytest.mark.parametrize(("name", "rms", "near"), KNOWN)
def test_at_4_khz_with_a_10_nm_encoder_it_leaves_the_known_errors(name, rms, near):
    seconds = 4.0 if name == "fast" else 4.0 * math.pi
    run = stage_loop(super_twisting, name, encoder_mm=1e-5).run(seconds, record=SIGNALS)
    largest, found = errors_um(run)
    assert found == pytest.approx(rms, abs=near)
    assert largest < {"slow": 0.03, "wide": 0.65, "fast": 0.93}[name]
    if name == "wide":
        assert np.abs(np.diff(run["output"])).sum() / seconds == pytest.approx(3e3, rel=0.05)


@pytest.mark.parametrize("output", [4.0, -7.0, 25.0])
@pytest.mark.parametrize("friction_from", [0, 1, 2])
def test_from_rest_the_first_output_after_an_align_is_the_last_one_before(output, friction_from):
    block, here = super_twisting(friction_from=friction_from), Motion(0.2, 0.0, 0.0)
    p = block.prepare(block.params, DT)
    _, u = block.step(p, block.align(p, here, 0.2 + 3e-5, output), here, 0.2 + 3e-5, DT)
    assert u == pytest.approx(output, abs=1e-9)


@pytest.mark.slow
def test_it_takes_over_in_motion_without_a_kick():
    live = stage_loop(super_twisting(k1=1.0), "fast").start()
    before = live.advance(400)["output"]
    live = live.switch(super_twisting)
    after = live.advance(400, record=SIGNALS)
    assert live.bumpless
    assert abs(after["output"][0] - before[-1]) < 1.0 and UM * np.abs(after["true_error"]).max() < 20.0


def test_a_positive_error_gives_a_positive_torque():
    _, u = stepped(super_twisting, (Motion(1e-4, 0.0, 0.0), 0.0))
    assert super_twisting.sense == 1 and u > 0.0


def test_in_mm_it_is_the_same_motion():
    by_rad = stage_loop(super_twisting, "fast").run(0.05, record="actual")["actual"]
    mm = stage_loop(super_twisting(travel_per_rad=1.5923), "fast", plant=ballscrew_stage(travel_per_rad=1.5923))
    by_mm = mm.using({"reference.amplitude": 1.0}).run(0.05, record="actual")["actual"]
    assert by_mm / 1.5923 == pytest.approx(by_rad, abs=1e-6)


def test_at_the_torque_limit_the_integral_waits():
    far = Motion(1.0, 0.0, 0.0)
    s, u = stepped(super_twisting(max_torque=12.0), *[(far, 0.0)] * 400)
    assert u == 12.0 and s.w == 0.0
    s, u = stepped(super_twisting(max_torque=12.0), *[(far, 0.0)] * 40, *[(Motion(-1.0, 0.0, 0.0), 0.0)] * 2)
    assert u == -12.0 and s.w == 0.0


@pytest.mark.sweep
@pytest.mark.parametrize("changes", [{}, {"friction_from": 2, "pieces": 0, "max_torque": 9.0, "speed_filter_s": 0.0}])
def test_all_engines_give_the_same_bits(changes):
    loop = stage_loop(super_twisting(**changes), "fast", encoder_mm=1e-5)
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.02, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[column], plain[column]) for column in plain.signals)


@pytest.mark.sweep
def test_a_batch_gives_the_bits_of_single_runs():
    loop = stage_loop(super_twisting, "fast", method="sdirk3", substeps=10)
    gains = np.linspace(0.5, 1.5, 17)
    batch = loop.batch(0.1, {"controller.k1": gains}, record="true_error")
    for k in (0, 7, 16):
        single = loop.using({"controller.k1": gains[k]}).run(0.1, record="true_error")
        assert np.array_equal(batch["true_error"][k], single["true_error"])


def test_a_layer_of_zero_is_refused():
    with pytest.raises(ValueRefused, match=r"layer = 0.0"):
        super_twisting(layer=0.0)


def test_the_align_is_inside_the_step_subset():
    module, here, p = Module(), Motion(0.2, 0.1, 0.0), super_twisting.prepare(super_twisting.params, DT)
    module.arguments[id(super_twisting.align), "params"] = type(p)
    module.arguments[id(super_twisting.align), "command"] = Motion
    translated = module.callable(super_twisting.align)
    assert module.namespace()[translated](p, here, 0.19, 3.0) == super_twisting.align(p, here, 0.19, 3.0)
