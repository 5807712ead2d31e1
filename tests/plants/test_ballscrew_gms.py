"""The stage under Maxwell-slip friction: closed forms, the other implementation, convergence, what it remembers."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.linalg import expm

from leadscrew.friction.maxwell_slip import MaxwellSlipScrew
from leadscrew.kernel.block import controller, reference
from leadscrew.kernel.loop import Loop
from leadscrew.plants._ballscrew_gms import ballscrew_gms, sliding_at
from leadscrew.plants._ballscrew_stage import INERTIA
from leadscrew.references._ramp import ramp
from leadscrew.references._waypoints import waypoints
from leadscrew.studies.fsmc_ballscrew.tunings import SCHEDULED as TUNINGS
from leadscrew.util.errors import ValueRefused
from tests.controllers.stage_loop import errors_um
from tests.controllers.test_pd_dob import from_rest, maxwell_stage
from tests.tools import runnable

F = MaxwellSlipScrew()


class SineParams(NamedTuple):
    """A sine of torque."""

    amplitude: float = 11.0


@reference(SineParams())
def sine_torque(p, t):
    """The torque of an open loop."""
    return p.amplitude * math.sin(2.0 * math.pi * 2.5 * t)


@controller()
def through(command):
    """What is asked for."""
    return command


@controller()
def its_position(command):
    """The place of a motion, taken as a torque."""
    return command.position


def opened(torque, plant=ballscrew_gms, period=1e-3, **more):
    return Loop(reference=torque, controller=through, plant=plant, period=period, metrics={}, **more)


def held(torque):
    return ramp(initial=torque, rate=0.0)


def test_a_slow_torque_bends_it_by_the_sum_of_its_springs_and_nearly_as_lugre():
    run = opened(ramp(rate=0.4, duration=30.0), ballscrew_gms(longest_step=1e-4), 1e-2).run(20.0, ("plant", "output"))
    x, torque = run["plant.angle"], run["output"]
    springs = np.minimum(np.outer(x, F.stiffness), F.share * F.static).sum(axis=1)
    assert np.abs(springs - torque).max() < 0.002 * F.static
    assert np.abs(F.static * -np.expm1(-1e5 * x / F.static) - torque).max() < 0.04 * F.static
    assert x[-1] == pytest.approx(1.7e-4, rel=0.05)


def test_stuck_it_swings_as_a_mass_on_its_springs():
    """0.3 N m is below the first element's 0.352 N m: a linear oscillator, overdamped 26 times, by SciPy's expm."""
    a = np.array([[0.0, 1.0, 0.0], [-1e5 / INERTIA, -(F.damping + F.viscous) / INERTIA, 0.3 / INERTIA], [0.0] * 3])
    there = (expm(a * 2e-3) @ [0.0, 0.0, 1.0])[0]
    errors = []
    for step in (2e-7, 1e-7):
        run = opened(held(0.3), ballscrew_gms(longest_step=step)).run(0.003, "plant")
        errors.append(abs(run["plant.angle"][2] - there))
    assert there == pytest.approx(3e-6 * (1.0 - math.exp(-2e-3 * 1e5 / F.damping)), rel=1e-2)
    assert errors[0] < 1e-3 * there and errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


@pytest.mark.parametrize("torque", [7.0, -8.5])
def test_in_steady_sliding_it_follows_the_stribeck_map(torque):
    run = opened(held(torque), sliding_at(ballscrew_gms(longest_step=1e-5), math.copysign(1.0, torque))).run(
        0.02, ("plant",)
    )
    assert run["plant.speed"][-1] == pytest.approx((torque - math.copysign(6.24, torque)) / 0.4, rel=1e-6)


def test_started_in_steady_sliding_it_goes_on_sliding():
    run = opened(held(6.24 + 0.4 * 2.0), sliding_at(ballscrew_gms, 2.0)).run(0.01, ("plant",))
    assert run["plant.speed"] == pytest.approx(np.full(10, 2.0), rel=1e-9)
    assert run["plant.angle"] == pytest.approx(2e-3 * np.arange(10), rel=1e-9)


def test_it_is_the_mass_on_a_slide_with_other_units():
    mine = opened(sine_torque, ballscrew_gms(longest_step=4e-6)).run(0.1, ("plant.angle",))
    other = opened(sine_torque, maxwell_stage(), substeps=250).run(0.1, ("plant.position",))
    assert np.ptp(mine["plant.angle"]) > 0.05
    assert mine["plant.angle"] == pytest.approx(other["plant.position"], abs=1e-12)


def test_the_error_of_an_open_loop_falls_with_the_step_and_is_3_nm_at_1_us():
    """Against half the step; 2e-6 rad are 3 nm at the table, of 0.2 mm."""
    ways = [opened(sine_torque, ballscrew_gms(longest_step=h)).run(0.15, ("plant",))["plant.angle"]
            for h in (1e-6, 2e-6, 4e-6, 5e-7)]  # fmt: skip
    off = [np.abs(way - ways[3]).max() for way in ways[:3]]
    assert np.ptp(ways[0]) > 0.05
    assert off[0] < off[1] < off[2] < 6e-6 and off[0] < 2e-6


def test_it_comes_back_to_where_it_turned():
    """0 to 6, -2, 2 and -2 N m: the inner loop closes. The Masing rule gives the place: half the way, doubled."""
    corners = waypoints([0.0, 6.0, -2.0, 2.0, -2.0], dwell=0.5, max_velocity=0.5, max_acceleration=1e3)
    loop = Loop(reference=corners, controller=its_position, plant=ballscrew_gms(longest_step=1e-4), period=1e-2,
                metrics={})  # fmt: skip
    run = loop.run(50.0, ("plant", "output"))
    torque, angle = run["output"], run["plant.angle"]
    there = np.flatnonzero(np.abs(torque + 2.0) < 1e-9)
    first, again = there[np.flatnonzero(np.diff(there) > 1)[0]], there[-1]
    assert torque[first:again].max() == pytest.approx(2.0)
    assert angle[again] == pytest.approx(angle[first], abs=3e-8) and np.ptp(angle[first:again]) > 1e-5


def test_elements_that_do_not_fit_are_refused():
    with pytest.raises(ValueRefused, match="shares of all elements must sum to 1"):
        opened(held(1.0), ballscrew_gms(**{"friction.share": np.full(6, 0.2)})).run(0.01)


def test_it_shows_the_table_in_mm_when_asked():
    run = opened(held(11.0), ballscrew_gms(travel_per_rad=1.5923)).run(0.02, ("actual", "plant.angle"))
    assert np.array_equal(run["actual"], 1.5923 * run["plant.angle"]) and run["actual"][-1] > 0.0


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    loop = opened(sine_torque(amplitude=60.0), ballscrew_gms(longest_step=1e-4))
    plain = loop.run(0.03, ("plant",), engine="python")
    assert np.ptp(plain["plant.angle"]) > 1e-3
    for engine in ("llvm", runnable("c")):
        fast = loop.run(0.03, ("plant",), engine=engine)
        assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seconds", "largest"), [("slow", 12.6, 0.083), ("wide", 12.6, 0.21), ("fast", 4.0, 0.355)]
)
def test_the_robust_controller_stays_within_the_known_errors(name, seconds, largest):
    found = errors_um(from_rest(TUNINGS["ours.pd_dob_robust"], name, ballscrew_gms).run(seconds, "true_error"))[0]
    assert 0.85 * largest < found < 1.02 * largest
