"""The linear view of a loop, against python-control, against closed formulas and against the loop that runs."""

import math
from typing import NamedTuple

import control
import numpy as np
import pytest

import leadscrew as ls
from leadscrew.actuators._limits import limits
from leadscrew.analysis.stability import margins, sampled_loop
from leadscrew.friction.asymmetric import one_way_lugre
from leadscrew.plants._mass_lugre import mass_lugre
from leadscrew.plants._xy_table import xy_table
from leadscrew.references._ramp import ramp
from leadscrew.references._sine import sine, sine_motion
from leadscrew.references._step import step
from leadscrew.sensors._counts import ruler
from leadscrew.studies.npid_xytable.tunings import table_pid
from leadscrew.util.errors import NameUnknown, ValueRefused


class Gain(NamedTuple):
    kp: float = 4.0


class PI(NamedTuple):
    kp: float = 4.0
    ki: float = 20.0


class Integral(NamedTuple):
    sum: float = 0.0


class LagParams(NamedTuple):
    tau: float = 0.1


class Position(NamedTuple):
    y: float = 0.0


class Pendulum(NamedTuple):
    angle: float = 0.0
    speed: float = 0.0


class Count(NamedTuple):
    n: int = 0


@ls.controller(Gain())
def proportional(p, command, feedback):
    return p.kp * (command - feedback)


@ls.controller(Gain())
def relay(p, command, feedback):
    return p.kp if command > feedback else -p.kp


@ls.controller(PI(), Integral(), continuous=True)
def pi(p, s, command, feedback):
    return Integral(p.ki * (command - feedback)), p.kp * (command - feedback) + s.sum


@ls.controller(Gain(), Count())
def every_fourth(p, s, command, feedback):
    return Count(s.n + 1), p.kp * (command - feedback) if s.n % 4 == 0 else 0.0


@ls.plant(LagParams(), Position())
def lag(p, s, u):
    return Position((u - s.y) / p.tau)


@ls.plant(LagParams(), Pendulum(), output="angle")
def pendulum(p, s, u):
    return Pendulum(s.speed, u - math.sin(s.angle) / p.tau)


def xy(**more):
    return ls.Loop(**{
        "reference": step(target=1.0), "controller": table_pid(kp=1.17, ki=175.5, kd=0.00433), "plant": xy_table,
        "period": 0.5e-3, "substeps": 20, "metrics": {}, **more,
    })  # fmt: skip


# ---- linear loops
def test_a_lag_under_a_gain_is_the_sampled_lag_of_the_textbook():
    """``kp (1 - a) / (z - a)`` with ``a = e^(-T / tau)``; its gain margin is ``(1 + a) / (kp (1 - a))``, at z = -1."""
    loop = ls.Loop(reference=step, controller=proportional, plant=lag, period=0.05, metrics={})
    a, kp = math.exp(-0.05 / 0.1), 4.0
    opened = loop.linearize().open_loop
    assert opened.dt == 0.05
    assert [opened.A[0, 0], opened.C[0, 0] * opened.B[0, 0]] == pytest.approx([a, kp * (1.0 - a)], rel=1e-12)
    found = loop.margins()
    assert found.gm == pytest.approx((1.0 + a) / (kp * (1.0 - a)), rel=1e-9)
    at = abs(opened(np.exp(1j * found.w_gc * 0.05)))
    assert at == pytest.approx(1.0, rel=1e-9)


def test_a_continuous_loop_has_the_margins_of_python_control():
    loop = ls.Loop(reference=sine, controller=pi, plant=lag, period=None, metrics={})
    found = loop.linearize()
    s = control.tf("s")
    model = (4.0 + 20.0 / s) / (0.1 * s + 1.0)
    assert found.open_loop.isctime()
    w = np.geomspace(0.1, 1e3, 50)
    assert np.allclose(found.open_loop(1j * w), model(1j * w), rtol=1e-9)
    gm, pm, _, _, wcp, _ = control.stability_margins(model)
    mine = loop.margins()
    assert (mine.pm_deg, mine.w_gc) == pytest.approx((pm, wcp), rel=1e-9) and math.isinf(gm) and math.isinf(mine.gm)


def test_margins_are_those_of_the_certificate_and_the_disk_margin_is_that_of_python_control():
    loop = xy(computation_delay=0.775e-3)
    mine, theirs = loop.margins(), margins(sampled_loop(loop))
    for name in ("gm", "pm_deg", "delay_s", "ms", "mt", "w_gc", "w_pc"):
        assert getattr(mine, name) == pytest.approx(getattr(theirs, name), rel=1e-9)
    w = np.geomspace(1.0, 0.9999 * math.pi / loop.period, 20_000)
    assert mine.disk == pytest.approx(control.disk_margins(loop.linearize().open_loop, w, skew=0.0)[0], rel=1e-5)
    assert "phase 37.22 deg" in repr(mine)


@pytest.mark.parametrize(
    "delays",
    [{}, {"computation_delay": 0.775e-3}, {"transport_delay": 0.6e-3}, {"transport_delay": 1e-3},
     {"computation_delay": 0.5e-3, "transport_delay": 0.225e-3}],
)  # fmt: skip
def test_the_step_response_of_a_linear_loop_is_the_run_itself(delays):
    loop = xy(**delays)
    response, run = loop.step_response(0.1), loop.run(0.1)
    assert response.time[1] == loop.period
    assert np.allclose(response.outputs[:200], run["actual"], rtol=0.0, atol=1e-11)


def test_a_load_and_the_output_are_in_the_closed_loop():
    """At rest an integral holds a load of 1 V with an output of -1 V."""
    closed = xy().linearize().closed_loop
    assert closed.input_labels == ["command", "disturbance"] and closed.output_labels == ["actual", "output"]
    assert np.allclose(closed.dcgain(), [[1.0, 0.0], [closed.dcgain()[1, 0], -1.0]], atol=1e-6)


# ---- around a point
def test_a_pendulum_is_linear_around_where_it_hangs_and_otherwise_around_where_it_stands():
    loop = ls.Loop(reference=step, controller=proportional, plant=pendulum, period=None, metrics={})
    for angle in (0.0, 1.0, math.pi):
        opened = loop.linearize(state={"plant.angle": angle}).open_loop
        assert np.sort_complex(opened.poles()) == pytest.approx(
            np.sort_complex(np.roots([1.0, 0.0, 10.0 * math.cos(angle)])), abs=1e-6
        )


def test_a_point_of_a_run_is_where_the_run_is():
    """A sine through a cubic spring: the stiffness is that of the position at that time."""

    @ls.plant(LagParams(), Pendulum(), output="angle")
    def spring(p, s, u):
        return Pendulum(s.speed, u - s.angle**3 - s.speed / p.tau)

    loop = ls.Loop(reference=ramp(rate=1.0, duration=3.0), controller=proportional(kp=50.0), plant=spring, metrics={})
    at = loop.run(2.0, record="plant")["plant.angle"]
    linear = loop.linearize(time=1.5)
    here = linear.point["actual"]
    assert here == at[1500] > 1.0
    poles = np.log(linear.open_loop.poles()) / loop.period
    assert np.sort(poles.real) == pytest.approx(np.sort(np.roots([1.0, 10.0, 3.0 * here**2]).real), rel=1e-6)


def test_friction_at_rest_is_the_spring_of_its_bristles():
    """``m x'' + (s1 + s2) x' + s0 x = u``; bristle less position stays as it is and is no pole of the loop."""
    loop = ls.Loop(reference=sine, controller=proportional, plant=mass_lugre, period=None, metrics={})
    f, s = one_way_lugre(mass_lugre.params.friction, 0.0), control.tf("s")
    spring = 4.0 / (mass_lugre.params.mass * s**2 + (f.damping + f.viscous) * s + f.stiffness)
    found = loop.linearize().cut
    w = np.geomspace(1.0, 1e4, 40)
    assert len(found.a) == 2 and np.allclose(found.response(w), spring(1j * w), rtol=1e-6)
    assert loop.margins().ms == pytest.approx(np.abs(1.0 / (1.0 + spring(1j * w))).max(), rel=1e-2)


def test_friction_in_motion_has_the_jacobian_that_is_written_in_the_block():
    state = {"plant.position": 0.01, "plant.speed": 2e-3, "plant.bristle": 8e-6}
    loop = ls.Loop(reference=sine, controller=proportional, plant=mass_lugre, period=None, metrics={})
    opened = loop.linearize(state=state).open_loop
    exact = np.array(
        mass_lugre.jacobian(mass_lugre.params, mass_lugre.state._replace(position=0.01, speed=2e-3, bristle=8e-6))
    )
    assert pytest.approx(exact, rel=1e-5) == opened.A


def test_a_limit_far_away_is_not_seen_and_a_limit_reached_is_named():
    limited = xy(actuator=limits(lower=-10.0, upper=10.0))
    assert limited.margins().gm == pytest.approx(xy().margins().gm, rel=1e-9)
    with pytest.raises(ValueRefused, match=r"limits: does not answer its output at this point"):
        xy(actuator=limits(lower=-0.1, upper=0.1)).margins(time=0.5e-3)


def test_a_moved_plant_is_at_rest_there_with_a_controller_that_remembers_where_it_was():
    """Otherwise the derivative's first difference would drive the output to its limit."""
    limited = xy(actuator=limits(lower=-10.0, upper=10.0))
    assert limited.margins(state={"plant.position": 500.0}).gm == pytest.approx(xy().margins().gm, rel=1e-9)
    assert limited.linearize(state={"plant.position": 500.0}).point["command"] == 500.0


# ---- what has no linear view
@pytest.mark.parametrize(
    ("parts", "text"),
    [
        ({"controller": relay}, r"^relay: its output jumps at command = 0: "),
        ({"sensor": ruler(resolution_mm=1e-3)}, r"^ruler: .* or count it as ideal \(ideal=\['sensor'\]\)"),
        ({"controller": every_fourth}, r"^every_fourth: its state n counts on"),
        ({"controller": proportional(kp=0.0)}, r"^proportional: does not answer its error"),
    ],
)
def test_a_block_without_a_linear_view_is_named(parts, text):
    with pytest.raises(ValueRefused, match=text):
        xy(**parts).margins()


def test_a_ruler_that_counts_as_ideal_leaves_the_margins_of_the_rest():
    loop = xy(sensor=ruler(resolution_mm=1e-3))
    assert loop.margins(ideal=["sensor"]).gm == pytest.approx(xy().margins().gm, rel=1e-9)
    with pytest.raises(ValueRefused, match="sensor, actuator"):
        loop.margins(ideal=["plant"])


def test_an_unknown_state_is_refused_with_the_nearest():
    with pytest.raises(NameUnknown, match=r"there is no state 'plant.positon'; did you mean plant.position"):
        xy().linearize(state={"plant.positon": 1.0})


# ---- several axes, motions
class Two(NamedTuple):
    x: float = 0.0
    y: float = 0.0


class TwoLags(NamedTuple):
    x: LagParams = LagParams(0.1)
    y: LagParams = LagParams(0.2)


class TwoPositions(NamedTuple):
    x: Position = Position()
    y: Position = Position()


@ls.reference()
def corner(t):
    return Two(1.0, 2.0)


@ls.controller(Gain())
def both(p, command, feedback):
    return Two(p.kp * (command.x - feedback.x), p.kp * (command.y - feedback.y))


def where(s):
    return Two(s.x.y, s.y.y)


@ls.plant(TwoLags(), TwoPositions(), output=where)
def table(p, s, u):
    return TwoPositions(lag(p.x, s.x, u.x), lag(p.y, s.y, u.y))


@ls.controller(Gain())
def with_feed_forward(p, command, feedback):
    return p.kp * (command.position - feedback) + command.velocity


def test_two_axes_have_an_open_loop_of_two_errors_and_no_margins():
    loop = ls.Loop(reference=corner, controller=both(kp=1.0), plant=table, period=0.05, metrics={})
    opened = loop.linearize().open_loop
    assert opened.input_labels == ["error_x", "error_y"] and opened.output_labels == ["feedback_x", "feedback_y"]
    a = np.exp([-0.05 / 0.1, -0.05 / 0.2])
    assert np.allclose(opened(-1.0), np.diag((1.0 - a) / (-1.0 - a)))
    with pytest.raises(ValueRefused, match="compares 2 axes"):
        loop.margins()
    response = loop.step_response(1.0)
    assert response.outputs.shape == (2, 2, 21) and np.allclose(response.outputs[:, :, -1], 0.5 * np.eye(2), atol=1e-3)


def test_feed_forward_is_in_the_closed_loop_and_not_in_the_open_one():
    loop = ls.Loop(reference=sine_motion, controller=with_feed_forward, plant=lag, period=0.05, metrics={})
    linear = loop.linearize()
    assert linear.open_loop.ninputs == 1
    closed = linear.closed_loop
    assert closed.input_labels[:2] == ["command_position", "command_velocity"]
    assert closed.dcgain()[0, :2] == pytest.approx([4.0 / 5.0, 1.0 / 5.0])
