"""Controllers taken apart: their maps against worked numbers and their own steps, and what is refused."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.analysis.stability.loop import sampled_loop
from leadscrew.analysis.stability.lure import ErrorMap, declare, lure
from leadscrew.controllers._feed_forward_table import feed_forward_table
from leadscrew.controllers._learned_feed_forward import learned_feed_forward
from leadscrew.controllers._look_ahead import look_ahead
from leadscrew.controllers._npid import NPIDParams, npid
from leadscrew.controllers._npid_after import npid_after
from leadscrew.controllers._npid_slope import npid_slope
from leadscrew.controllers._parallel import PIDState
from leadscrew.controllers._pd_dob import pd_dob
from leadscrew.kernel.block import controller, make
from leadscrew.kernel.loop import Loop
from leadscrew.plants._xy_table_cutting import xy_table_cutting
from leadscrew.references._eased_sine import eased_sine_motion
from leadscrew.resolve import block
from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
from leadscrew.studies.npid_xytable.tunings import TUNINGS, table_pid
from leadscrew.util.errors import ValueRefused
from tests.controllers.xy_loop import outputs

UM = 1e-3


@pytest.mark.parametrize(
    ("name", "unit", "scale_mm"), [("paper.npid_mm", "mm", 3.0), ("corrected.npid_um", "um", 3e-3)]
)
def test_table_1_has_the_printed_sector_and_the_slope_of_5_55(name, unit, scale_mm):
    found = lure(TUNINGS[name])
    assert found.sector == pytest.approx((1.0, 2.35241), abs=1e-5)
    assert found.slope_sector == pytest.approx((1.0, 5.5463), abs=5e-5)
    assert (found.error_unit, found.scale_mm) == (unit, pytest.approx(scale_mm)) and not found.dependent
    assert found.gain(1.5 * scale_mm) == pytest.approx(math.cosh(1.5), rel=1e-14)
    assert found.curve(np.array([-scale_mm])) == pytest.approx([-scale_mm * math.cosh(1.5)], rel=1e-14)


def test_a_clipped_error_has_a_lower_bound_of_zero_and_says_so():
    found = lure(TUNINGS["corrected.npid_um_clipped"])
    assert found.sector == pytest.approx((0.0, 2.35241), abs=1e-5)
    assert found.slope_sector == pytest.approx((0.0, 5.5463), abs=5e-5)
    assert found.gain(3.0) < 3e-3 and found.slope(3.0) == 0.0
    assert any("lower bound of the sector is 0" in note for note in found.notes)


def test_the_slope_limited_law_has_one_bound_for_gain_and_slope():
    found = lure(npid_slope(k=2.2, es_um=0.5))
    assert found.sector == found.slope_sector == (1.0, 2.2)
    assert found.slope(0.5 * UM) == pytest.approx(1.6, rel=1e-12)
    assert found.gain(1.0) == pytest.approx(2.2, rel=1e-3) and found.gain(1.0) < 2.2


def test_a_gain_behind_the_pid_is_no_static_map():
    found = lure(npid_after)
    assert found.dependent and found.slope_sector is None and found.sector == pytest.approx((1.0, math.cosh(1.5)))
    assert any("circle criterion" in note for note in found.notes)


@pytest.mark.slow
@pytest.mark.parametrize(
    "linear",
    [
        table_pid,
        block("torque_pid"),
        pd_dob(kp_slow=0.0, kd_slow=0.0),
        look_ahead(pd_dob(kp_slow=0.0, kd_slow=0.0), actuation_delay_s=1e-4, measurement_delay_s=1e-4),
        *(CONTROLLERS[f"ours.{k}"] for k in ("pid_ff", "cascade", "pid_dob_150", "resonant_full", "repetitive")),
        learned_feed_forward(table_pid, rate=0.0),
    ],
    ids=lambda b: b.name,
)
def test_linear_controllers_have_the_sector_one_whatever_their_command_adds(linear):
    found = lure(linear)
    assert not found.nonlinear and found.sector == found.slope_sector == (1.0, 1.0) and found.curve(0.3) == 0.3


def test_the_linear_part_is_the_pid():
    errors = np.random.default_rng(5).normal(scale=3.0 * UM, size=100)
    zeros = np.zeros(100)
    assert outputs(lure(npid).linear, errors, zeros) == outputs(table_pid, errors, zeros)


@pytest.mark.parametrize("inner", [npid, npid_slope])
def test_the_map_is_the_one_that_the_step_computes(inner):
    only_p = inner(kp=1.0, ki=0.0, kd=0.0)
    errors = np.linspace(-9.0 * UM, 9.0 * UM, 37)
    steps = [outputs(only_p, [e], [0.0])[0] for e in errors]
    found = lure(inner)
    assert found.curve(errors) == pytest.approx(steps, rel=1e-14, abs=1e-18)
    h = 1e-8
    secant = [(found.curve(e + h) - found.curve(e - h)) / (2.0 * h) for e in errors + 0.11 * UM]
    assert found.slope(errors + 0.11 * UM) == pytest.approx(secant, rel=1e-5)
    assert found.slope_sector is not None
    low, high = found.slope_sector
    assert low <= found.slope(errors).min() and found.slope(errors).max() <= high


def test_a_wrapper_that_adds_a_feed_forward_changes_nothing():
    found = lure(feed_forward_table(npid, [0.1, -0.4, 0.2], 0.1))
    assert found.nonlinear and found.sector == lure(npid).sector and found.linear.params.inner.alpha == 0.0


def test_a_limit_of_the_output_is_named_and_left_out():
    found = lure(npid(lower=-5.0, upper=10.0))
    assert "lower = -5, upper = 10 V" in found.notes[0] and found.linear.params.upper == math.inf
    assert not lure(table_pid(lower=-0.01, upper=0.01)).nonlinear


class Scheduled(NamedTuple):
    kp: float = 1.32
    kd: float = 0.006805
    per_mm: float = 0.0
    per_speed: float = 0.0
    beyond_mm: float = 0.0


@controller(Scheduled(), PIDState(), unit="V")
def scheduled(p, s, command, feedback, dt):
    """A PD with a gain that grows with the command, or with its speed."""
    e = command.position - feedback
    g = 1.0 + p.per_mm * max(abs(command.position) - p.beyond_mm, 0.0) + p.per_speed * abs(command.velocity)
    return PIDState(0.0, e, 0.0, 0.0), g * (p.kp * e + p.kd * (e - s.last) / dt)


class Weighted(NamedTuple):
    law: NPIDParams = NPIDParams()
    per_mm: float = 0.0


def weighted(p, s, command, feedback, dt):
    """An NPID whose output grows with the command."""
    after, u = npid.step(p.law, s, command, feedback, dt)
    return after, u * (1.0 + p.per_mm * abs(command))


@pytest.mark.parametrize("gain", [{"per_mm": 50.0}, {"per_mm": 1e-4}, {"per_mm": 1.0, "beyond_mm": 14.0},
                                  {"per_speed": 1e-4}])  # fmt: skip
def test_a_gain_that_is_scheduled_on_the_command_is_refused(gain):
    assert not lure(scheduled).nonlinear
    with pytest.raises(ValueRefused, match="answers the same error differently under a command"):
        lure(scheduled(**gain))


def test_so_is_one_behind_a_declared_map_and_shares_that_are_learned_and_gains_by_speed():
    by_command = make("controller", weighted, Weighted(), PIDState())
    assert lure(by_command).nonlinear
    for changing in (by_command(per_mm=0.01), learned_feed_forward(table_pid), pd_dob):
        with pytest.raises(ValueRefused, match="schedules on the command or adapts to it"):
            lure(changing)


def test_sampled_loop_refuses_them_too():
    def loop(law):
        return Loop(reference=eased_sine_motion, controller=law, plant=xy_table_cutting, period=5e-4, metrics={})

    still = sampled_loop(loop(scheduled)).closed_poles()
    assert np.abs(still).max() < 1.0
    for changing in (scheduled(per_mm=50.0), scheduled(per_speed=1e-3), learned_feed_forward(table_pid)):
        with pytest.raises(ValueRefused, match="it answers an error otherwise"):
            sampled_loop(loop(changing))
    held = sampled_loop(loop(learned_feed_forward(table_pid, rate=0.0)))
    assert held.gain_limit() == pytest.approx(2.51, abs=1e-3)


@pytest.mark.parametrize("name", ["smc", "vud_beta_e", "power_law", "super_twisting"])
def test_a_nonlinear_controller_without_a_map_is_refused_with_the_way_to_declare_one(name):
    with pytest.raises(ValueRefused, match=r"no map of the error is declared.*declare\("):
        lure(block(name, "controller"))


def test_a_continuous_controller_and_a_plant_are_refused():
    for found in (block("smc_ideal"), block("xy_table")):
        with pytest.raises(ValueRefused, match="sampled controller"):
            lure(found)


class CubicParams(NamedTuple):
    kp: float = 1.32
    kd: float = 0.006805
    growth: float = 1e4


@controller(CubicParams(), PIDState())
def cubic(p, s, command, feedback, dt):
    """A PD with an error that grows with its cube up to 10 um."""
    e = command - feedback
    f = e * (1.0 + p.growth * min(e * e, 1e-4))
    return PIDState(0.0, f, 0.0, 0.0), p.kp * f + p.kd * (f - s.last) / dt


def grown(p, e):
    return 1.0 + p.growth * min(e * e, 1e-4)


def test_a_controller_of_ones_own_is_taken_apart_by_its_declared_map():
    with pytest.raises(ValueRefused, match=r"declare\(CubicParams\)"):
        lure(cubic)

    @declare(CubicParams)
    def right(p):
        return ErrorMap(
            lambda e: grown(p, e), lambda e: 1.0 + 3.0 * p.growth * min(e * e, 1e-4), (1.0, 2.0), (1.0, 4.0),
            {"growth": 0.0}, scale_mm=0.01,
        )  # fmt: skip

    assert lure(cubic).sector == (1.0, 2.0)

    @declare(CubicParams)
    def wrong(p):
        return ErrorMap(
            lambda e: 1.1 * grown(p, e), lambda e: 1.0, (1.0, 2.5), (1.0, 4.5), {"growth": 0.0}, scale_mm=0.01
        )

    with pytest.raises(ValueRefused, match="does not answer as its map"):
        lure(cubic)

    @declare(CubicParams)
    def optimistic(p):
        return ErrorMap(lambda e: grown(p, e), lambda e: 1.0, (1.0, 1.5), (1.0, 4.0), {"growth": 0.0}, scale_mm=0.01)

    with pytest.raises(ValueRefused, match=r"declared with a gain K\(e\) from 1 to 1\.5, but at an error of"):
        lure(cubic)

    @declare(CubicParams)
    def incomplete(p):
        return ErrorMap(lambda e: grown(p, e), lambda e: 1.0, (1.0, 2.0), (1.0, 4.0), {"kp": 1.0}, scale_mm=0.01)

    with pytest.raises(ValueRefused, match="made a straight line"):
        lure(cubic)


def test_a_part_beside_the_nonlinear_gain_is_refused():
    class Both(NamedTuple):
        inner: NPIDParams = NPIDParams()
        beside: float = 0.5

    def with_beside(p, s, command, feedback, dt):
        after, u = npid.step(p.inner, s, command, feedback, dt)
        return after, u + p.beside * (command - feedback)

    with pytest.raises(ValueRefused, match="beside the nonlinear gain"):
        lure(make("controller", with_beside, Both(), PIDState()))
