"""The stage with backlash: the exact play, SciPy, finite differences, and what each encoder sees."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.disturbances._step_load import step_load
from leadscrew.kernel.block import controller, reference
from leadscrew.kernel.loop import Loop
from leadscrew.plants._backlash import AxisPosition, Play, followed
from leadscrew.plants._backlash_two_mass import (
    BacklashTwoMassState,
    backlash_two_mass,
    damping_ratio,
    two_mass_jacobian,
)
from leadscrew.plants._ballscrew_backlash import (
    BallscrewBacklashState,
    backlash_in_motion,
    backlash_jacobian,
    ballscrew_backlash,
    planned,
)
from leadscrew.plants._ballscrew_play import BallscrewPlayState, ballscrew_play, play_in_motion, play_jacobian
from leadscrew.plants._ballscrew_stage import ballscrew_stage
from leadscrew.plants._mass_dahl import MassDahlState, mass_dahl, mass_dahl_jacobian
from leadscrew.references._sine import sine_motion
from leadscrew.sensors._counts import axis_encoder
from leadscrew.sensors._dual_encoder import dual_encoder
from leadscrew.studies.fsmc_ballscrew.tunings import SCHEDULED as TUNINGS
from tests.tools import runnable

LEAD = 1.5923e-3
TIGHT = {"method": "rodas", "rtol": 1e-8, "atol": 1e-13}


class SineParams(NamedTuple):
    """A sine of torque and a constant."""

    amplitude: float = 0.0
    frequency: float = 2.5
    constant: float = 0.0


@reference(SineParams())
def torque(p, t):
    """The torque of an open loop."""
    return p.amplitude * math.sin(2.0 * math.pi * p.frequency * t) + p.constant


@controller()
def through(command):
    """What is asked for."""
    return command


def opened(plant, period=1e-3, options=TIGHT, **changes):
    return Loop(reference=torque(**changes), controller=through, plant=plant, period=period, metrics={}, **options)


@pytest.mark.slow
# ---- classic
@pytest.mark.parametrize(
    "play",
    [Play(), Play(5e-6, 2e-5), Play(2e-6, 1e-6, 0.9, 1.1), Play(0.0, 0.0)],
    ids=["even", "gaps", "slopes", "none"],
)
def test_the_table_follows_the_exact_play_to_a_nanometre(play):
    """Slopes of 0.9 and 1.1: the two lines cross at 2 um / 0.2 before the start, and the way is short enough."""
    names = {f"play.{k}": v for k, v in play._asdict().items()}
    size = 9.4 if play.forward_slope != 1.0 else 12.0
    plant = ballscrew_play(**names)
    run = opened(plant, 2e-5, amplitude=size).run(0.8, ("plant.angle", "plant.table"))
    place, exact = 0.0, []
    for x in (LEAD * run["plant.angle"]).tolist():
        place = followed(play, place, x)
        exact.append(place)
    assert np.ptp(exact) > 1e-7
    assert np.abs(run["plant.table"] - np.array(exact)).max() < 2.5e-9


@pytest.mark.slow
def test_the_play_does_not_act_back_on_the_screw():
    run = opened(ballscrew_play, amplitude=12.0).run(0.8, ("plant",))
    alone = opened(ballscrew_stage, amplitude=12.0).run(0.8, ("plant",))
    assert np.ptp(alone["plant.angle"]) > 0.1
    assert np.abs(run["plant.angle"] - alone["plant.angle"]).max() < 1e-9


def test_a_sharper_flank_is_nearer_to_the_exact_play():
    off = []
    for flank in (1e-7, 1e-8):
        run = opened(ballscrew_play(flank=flank), 2e-5, amplitude=12.0).run(0.5, ("plant.angle", "plant.table"))
        place, exact = 0.0, []
        for x in (LEAD * run["plant.angle"]).tolist():
            place = followed(Play(), place, x)
            exact.append(place)
        off.append(np.abs(run["plant.table"] - np.array(exact)).max())
    assert off[0] < 1.1e-7 and off[1] < 1.1e-8 < 0.5 * off[0]


def finite(block, params, state, nudges, **signals):
    rows = []
    for i, nudge in enumerate(nudges):
        up, down = (
            np.array(block.step(params, state._replace(**{state._fields[i]: state[i] + side * nudge}), **signals))
            for side in (1.0, -1.0)
        )
        rows.append((up - down) / (2.0 * nudge))
    return np.array(rows).T


@pytest.mark.parametrize(
    ("speed", "table"), [(0.5, 1e-5), (0.5, 1.5923e-5 - 1e-6 + 3e-10), (-0.5, 1.5923e-5 + 1e-6 - 4e-10)],
    ids=["open", "forward", "backward"],
)  # fmt: skip
def test_the_jacobian_of_the_play_is_the_one_of_finite_differences(speed, table):
    state = BallscrewPlayState(0.01, speed, 3e-5, table)
    p = ballscrew_play.params
    rows = np.array(play_jacobian(p, state))
    found = finite(ballscrew_play, p, state, (1e-9, 1e-6, 1e-10, 1e-11), u=1.0, load=0.0)
    assert rows == pytest.approx(found, rel=1e-4, abs=1e-3)
    assert (rows[3, 3] == 0.0) == (table == 1e-5)


@pytest.mark.slow
# ---- modern
def test_two_masses_follow_scipy_through_the_gap():
    damping = 2.0 * damping_ratio(0.6) * math.sqrt(1e8 / (LEAD**2 / 2.12e-4 + 1.0 / 62.4))

    def level(fc, fs, vs, v):
        return fc + (fs - fc) * math.exp(-min((v / vs) ** 2, 700.0))

    def rates(_, x, u):
        d, rate = LEAD * x[0] - x[3], LEAD * x[1] - x[4]
        force = max(1e8 * (d - 1e-6) + damping * rate, 0.0) if d > 1e-6 else 0.0
        force -= max(1e8 * (-1e-6 - d) - damping * rate, 0.0) if d < -1e-6 else 0.0
        dz = x[1] - abs(x[1]) * x[2] * 1e5 / level(6.24, 9.36, 1e-3, x[1])
        dw = x[4] - abs(x[4]) * x[5] * 1e7 / 20.0
        screw = 1e5 * x[2] + math.sqrt(1e5) * dz + 0.4 * x[1]
        guide = 1e7 * x[5] + 3e4 * dw + 50.0 * x[4]
        return [x[1], (u - screw - LEAD * force) / 2.12e-4, dz, x[4], (force - guide) / 62.4, dw]

    plant = ballscrew_backlash(restitution=0.6, **{"guide.stiffness": 1e7, "guide.damping": 3e4})
    run = opened(plant, amplitude=11.0, frequency=20.0).run(0.045, ("plant",))
    x, rows = np.zeros(6), []
    for k in range(45):
        rows.append(x)
        u = 11.0 * math.sin(2.0 * math.pi * 20.0 * (k * 1e-3))
        x = solve_ivp(rates, (0.0, 1e-3), x, args=(u,), method="Radau", rtol=1e-9, atol=1e-14, max_step=1e-4).y[:, -1]
    rows = np.array(rows)
    twist = LEAD * rows[:, 0] - rows[:, 3]
    assert twist.max() > 1e-6 and twist.min() < -1e-6 and np.ptp(rows[:, 3]) > 1e-5
    assert np.abs(run["plant.angle"] - rows[:, 0]).max() < 2e-7
    assert np.abs(run["plant.table"] - rows[:, 3]).max() < 3e-10


@pytest.mark.parametrize("twist", [0.3e-6, 1.4e-6, -1.7e-6], ids=["open", "forward", "backward"])
def test_the_jacobian_of_two_masses_is_the_one_of_finite_differences(twist):
    p = planned(ballscrew_backlash.params, 1e-3)
    state = BallscrewBacklashState(0.01, 0.4, 3e-5, LEAD * 0.01 - twist, 5e-4, 7e-9)
    rows = np.array(backlash_jacobian(p, state))
    found = finite(ballscrew_backlash, p, state, (1e-7, 1e-6, 1e-10, 1e-10, 1e-8, 1e-13), u=1.0, load=3.0)
    assert rows == pytest.approx(found, rel=1e-4, abs=1e-2)
    assert (rows[4, 0] == 0.0) == (abs(twist) < 1e-6)


@pytest.mark.parametrize("twist", [0.3e-6, 1.4e-6, -1.7e-6], ids=["open", "forward", "backward"])
def test_the_jacobian_without_a_screw_is_the_one_of_finite_differences(twist):
    p = backlash_two_mass.prepare(backlash_two_mass(restitution=0.5).params, 1e-3)
    state = BacklashTwoMassState(1e-3, 4e-4, 1e-3 - twist, 6e-4, 7e-9)
    found = finite(backlash_two_mass, p, state, (1e-10, 1e-8, 1e-10, 1e-8, 1e-13), u=1.0, load=3.0)
    assert np.array(two_mass_jacobian(p, state)) == pytest.approx(found, rel=1e-4, abs=1e-2)


@pytest.mark.parametrize(("speed", "force", "exponent"), [(0.02, 0.4, 1.0), (-0.02, 0.4, 1.5), (0.03, -0.7, 0.5)])
def test_the_jacobian_of_dahl_is_the_one_of_finite_differences(speed, force, exponent):
    p = mass_dahl(**{"friction.exponent": exponent}).params
    state = MassDahlState(0.1, speed, force)
    found = finite(mass_dahl, p, state, (1e-6, 1e-8, 1e-8), u=0.3)
    assert np.array(mass_dahl_jacobian(p, state)) == pytest.approx(found, rel=1e-5, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_started_in_motion_both_go_on_evenly(speed):
    """Driven by what rubs: 6.24 N m and 0.4 N m s/rad at the screw; with two masses the guide as well."""
    way = math.copysign(1.0, speed)
    rubs = way * 6.24 + 0.4 * speed
    guide = LEAD * (way * 20.0 + 50.0 * LEAD * speed)
    for plant, start, push in (
        (ballscrew_play, play_in_motion, rubs), (ballscrew_backlash, backlash_in_motion, rubs + guide),
    ):  # fmt: skip
        run = opened(start(plant, speed), constant=push).run(0.02, ("plant",))
        assert run["plant.speed"] == pytest.approx(np.full(20, speed), rel=1e-6)
        assert run["plant.table"] == pytest.approx(LEAD * speed * 1e-3 * np.arange(20), abs=2e-10)


@pytest.mark.slow
def test_a_force_on_the_table_stretches_the_joint():
    """Through the gap, and then as far as what the guide leaves of 100 N bends 1e8 N/m; the screw stands."""
    loop = Loop(reference=torque, controller=through, plant=ballscrew_backlash, period=1e-3, metrics={},
                disturbance=step_load(size=100.0, time=0.0), **TIGHT)  # fmt: skip
    run = loop.run(0.6, ("plant",))
    pressed = 1e8 * (run["plant.table"][-1] - LEAD * run["plant.angle"][-1] - 1e-6)
    assert 80.0 < pressed < 120.0 and abs(run["plant.angle"][-1]) < 1e-5
    assert pressed == pytest.approx(100.0 - 1e9 * run["plant.guide_bristle"][-1], abs=1e-3)


# ---- encoders
def test_the_encoder_reads_the_table_or_the_motor_in_counts():
    place = AxisPosition(position=1.26e-4, motor=9.9e-5)
    assert axis_encoder(axis_encoder.params, place) == pytest.approx(1.3e-4, abs=1e-12)
    assert axis_encoder(axis_encoder(on_table=False).params, place) == pytest.approx(1.0e-4, abs=1e-12)
    assert axis_encoder(axis_encoder(resolution=0.0).params, place) == 1.26e-4


def read(block, places, dt=1e-3):
    p, s, found = block.prepare(block.params, dt), block.state, []
    for place in places:
        s, y = block.step(p, s, place)
        found.append(y)
    return found


def test_both_encoders_together_show_the_motor_at_once_and_the_table_after_the_lag():
    """The motor jumps by 3, the table by 1: the reading starts at 3 and nears 1 as exp(-t / lag)."""
    places = [AxisPosition(1.0, 3.0)] * 6
    found = read(dual_encoder(lag=2e-3, resolution=0.0), places)
    assert found == pytest.approx([1.0 + 2.0 * math.exp(-0.5 * (k + 1)) for k in range(6)], rel=1e-12)
    assert read(dual_encoder(lag=0.0, resolution=0.0), places) == [1.0] * 6
    assert read(dual_encoder(lag=1e9, resolution=0.5), [AxisPosition(1.0, 3.2)]) == pytest.approx([3.0], abs=1e-9)


def test_both_encoders_settle_without_denormal_numbers():
    found = read(dual_encoder(lag=1e-3, resolution=0.0), [AxisPosition(1.0, 2.0)] + [AxisPosition(2.0, 2.0)] * 100)
    assert found[-1] == 2.0


@pytest.mark.slow
@pytest.mark.parametrize(("on_table", "stays_um"), [(False, 1.0), (True, 0.0)], ids=["motor", "table"])
def test_closed_on_the_motor_half_of_the_play_stays_and_closed_on_the_table_it_does_not(on_table, stays_um):
    """A sine of 1 mm at 4 kHz: error of the table far from the reversals, half of the difference of both ways."""
    v = 2.0 * math.pi / 1.5923
    loop = Loop(
        reference=sine_motion(amplitude=1.0), controller=TUNINGS["ours.pd_dob_fixed"](travel_per_rad=1.5923),
        plant=play_in_motion(ballscrew_play(travel_per_rad=1.5923), v), sensor=axis_encoder(on_table=on_table),
        period=2.5e-4, metrics={}, method="rodas", rtol=1e-6, atol=1e-12,
    )  # fmt: skip
    run = loop.run(1.2, ("true_error",))
    e = 1e3 * run["true_error"]
    ahead, back = e[(run.time > 0.95) & (run.time < 1.05)].mean(), e[(run.time > 0.45) & (run.time < 0.55)].mean()
    assert 0.5 * (ahead - back) == pytest.approx(stays_um, abs=0.01)


@pytest.mark.sweep
@pytest.mark.parametrize("plant", [ballscrew_play, ballscrew_backlash], ids=lambda p: p.name)
def test_all_engines_give_the_same_bits(plant):
    loop = opened(plant, options={"method": "sdirk3", "substeps": 20}, amplitude=14.0, frequency=20.0)
    plain = loop.run(0.015, ("plant",), engine="python")
    assert np.ptp(plain["plant.table"]) > 0.0
    for engine in ("llvm", runnable("c")):
        fast = loop.run(0.015, ("plant",), engine=engine)
        assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)
