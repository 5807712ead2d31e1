"""Masses under each friction model against SciPy, hand-worked motion, and each other."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.kernel.block import controller, reference
from leadscrew.kernel.loop import Loop
from leadscrew.plants._mass_dahl import mass_dahl
from leadscrew.plants._mass_lugre import MassLuGreParams, MassLuGreState, mass_lugre, mass_lugre_jacobian
from leadscrew.plants._mass_maxwell_slip import mass_maxwell_slip, with_elements
from leadscrew.plants._mass_stribeck import mass_stribeck
from leadscrew.references._ramp import ramp
from leadscrew.util.errors import ValueRefused
from tests.tools import runnable

TIGHT = {"method": "rodas", "rtol": 1e-9, "atol": 1e-13}
PLANTS = (mass_stribeck, mass_dahl, mass_lugre, mass_maxwell_slip)
UNEQUAL = {"friction.backward.coulomb": 0.7, "friction.backward.static": 0.9, "friction.backward.viscous": 0.8}


class PushParams(NamedTuple):
    """A sine and a constant."""

    amplitude: float = 0.0
    constant: float = 0.0


@reference(PushParams())
def push(p, t):
    """The force of an open loop."""
    return p.amplitude * math.sin(2.0 * math.pi * 2.0 * t) + p.constant


@controller()
def through(command):
    """What is asked for."""
    return command


def opened(plant, period=1e-3, options=TIGHT, **changes):
    own = "dt" in plant.signals and options is TIGHT
    return Loop(
        reference=push(**changes), controller=through, plant=plant, period=period, metrics={},
        **({"substeps": 100} if own else options),
    )  # fmt: skip


def test_under_coulomb_friction_a_push_gives_a_parabola_and_then_a_stop_for_good():
    """2 N against 1 N on 1 kg for 1 s, then nothing: 1 m/s and 0.5 m, then 0.5 m more."""
    dry = mass_stribeck(
        **{f"friction.{side}.{name}": value for side in ("forward", "backward")
           for name, value in (("static", 1.0), ("viscous", 0.0))}
    )  # fmt: skip
    loop = Loop(reference=ramp(initial=2.0, rate=-1e9, start=1.0, duration=2e-9), controller=through, plant=dry,
                period=1e-2, metrics={})  # fmt: skip
    run = loop.run(4.0, record=("plant", "output"))
    k = np.searchsorted(run.time, 1.0 + 1e-9)
    pushed = np.count_nonzero(run["output"] > 0.0) * 1e-2
    assert run["plant.speed"][k] == pytest.approx(pushed - (run.time[k] - pushed), abs=1e-9)
    assert run["plant.position"][-1] == pytest.approx(pushed**2, abs=1e-9)
    assert np.all(run["plant.speed"][run.time > 2.0 * pushed + 1e-9] == 0.0)


def test_a_stuck_mass_does_not_creep_under_static_friction():
    run = opened(mass_stribeck, amplitude=1.49).run(2.0, record="plant")
    assert np.all(run["plant.position"] == 0.0) and np.all(run["plant.speed"] == 0.0)


def test_sliding_under_the_stribeck_map_follows_scipy_with_the_order_of_the_step():
    def rates(_, x):
        return [x[1], 1.6 - 1.0 - 0.5 * math.exp(-((x[1] / 1e-3) ** 2)) - 0.4 * x[1]]

    there = solve_ivp(rates, (0.0, 0.2), [0.0, 0.0], method="Radau", rtol=1e-10, atol=1e-14).y[:, -1]
    errors = []
    for substeps in (10, 20, 40):
        run = opened(mass_stribeck, options={"substeps": substeps}, constant=1.6).run(0.201, record="plant")
        errors.append(abs(run["plant.position"][-1] - there[0]))
    assert errors[2] < 2e-3 * there[0]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1) and errors[1] / errors[2] == pytest.approx(2.0, rel=0.1)


@pytest.mark.slow
def test_dahl_is_lugre_without_stribeck_and_bristle_damping():
    plain = {f"friction.{side}.static": 1.0 for side in ("forward", "backward")} | {"friction.damping": 0.0}
    one = opened(mass_dahl, amplitude=1.8).run(0.4, record="plant")
    other = opened(mass_lugre(**plain), amplitude=1.8).run(0.4, record="plant")
    assert np.ptp(one["plant.position"]) > 0.01
    assert np.abs(one["plant.position"] - other["plant.position"]).max() < 1e-9
    assert np.abs(one["plant.force"] - 1e5 * other["plant.bristle"]).max() < 1e-5


@pytest.mark.slow
def test_unequal_lugre_follows_scipy():
    def rates(_, x, u):
        ahead = x[1] >= 0.0
        fc, fs, s2 = (1.0, 1.5, 0.4) if ahead else (0.7, 0.9, 0.8)
        level = fc + (fs - fc) * math.exp(-min((x[1] / 1e-3) ** 2, 700.0))
        dz = x[1] - abs(x[1]) * x[2] * 1e5 / level
        return [x[1], u - 1e5 * x[2] - math.sqrt(1e5) * dz - s2 * x[1], dz]

    x, rows = np.zeros(3), []
    for k in range(300):
        rows.append(x)
        u = 1.8 * math.sin(2.0 * math.pi * 2.0 * (k * 1e-3))
        x = solve_ivp(rates, (0.0, 1e-3), x, args=(u,), method="Radau", rtol=1e-9, atol=1e-14).y[:, -1]
    run = opened(mass_lugre(**UNEQUAL), amplitude=1.8).run(0.3, record="plant")
    assert np.ptp(np.array(rows)[:, 0]) > 0.005
    assert np.abs(run["plant.position"] - np.array(rows)[:, 0]).max() < 1e-9


def test_shaken_evenly_a_mass_creeps_to_the_side_of_less_friction():
    for plant in (mass_lugre, mass_stribeck):
        drift = [opened(p, amplitude=1.8).run(2.001, record="plant")["plant.position"][[1000, 2000]]
                 for p in (plant, plant(**UNEQUAL))]  # fmt: skip
        assert abs(np.diff(drift[0])[0]) < 1e-6 and np.diff(drift[1])[0] < -0.01


def test_the_jacobian_is_the_one_of_finite_differences():
    p = MassLuGreParams()
    for state in ((0.1, 2e-3, 8e-6), (0.0, -4e-4, 7e-6), (0.0, 0.3, 1e-5)):
        rows = np.array(mass_lugre_jacobian(p, MassLuGreState(*state)))
        for column, nudge in enumerate((1e-6, 1e-7 * abs(state[1]), 1e-10)):
            up, down = (
                np.array(mass_lugre.step(p, MassLuGreState(*shifted), 1.0))
                for shifted in (
                    tuple(x + side * nudge * (i == column) for i, x in enumerate(state)) for side in (1.0, -1.0)
                )
            )
            assert rows[:, column] == pytest.approx((up - down) / (2.0 * nudge), rel=1e-4, abs=1e-3)


def hybrid(seconds, dt):
    """Two elements under a held sine of force, by SciPy from event to event: the published rules, written out again."""
    k, share, attraction, damping = np.array([4e4, 1e4]), np.array([0.6, 0.4]), 100.0, 100.0
    x, slips, rows = np.zeros(4), np.zeros(2), []

    def level(v):
        return 1.0 + 0.5 * math.exp(-min((v / 1e-3) ** 2, 700.0))

    def rates(_, x, u, slips):
        v, s = x[1], level(x[1])
        pull = [k[i] * v if slips[i] == 0.0 else slips[i] * attraction * (share[i] - slips[i] * x[2 + i] / s)
                for i in range(2)]  # fmt: skip
        stuck = k[slips == 0.0].sum() / k.sum()
        return [v, u - x[2] - x[3] - (damping * stuck + 0.4) * v, *pull]

    for n in range(round(seconds / dt)):
        rows.append(x.copy())
        u, t = 2.0 * math.sin(2.0 * math.pi * 2.0 * (n * dt)), 0.0
        while t < dt:
            events = [lambda _, x, u, slips, i=i: abs(x[2 + i]) - share[i] * level(x[1]) for i in range(2)]
            events.append(lambda _, x, u, slips: x[1])
            going = solve_ivp(rates, (t, dt), x, args=(u, slips), method="Radau", rtol=1e-9, atol=1e-13,
                              dense_output=True)  # fmt: skip
            first, what = dt, None
            for i, event in enumerate(events):
                values = np.array([event(0, y, u, slips) for y in going.y.T])
                wanted = slips[i] == 0.0 if i < 2 else bool(slips.any())
                crossed = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0)) if i < 2 else np.flatnonzero(
                    values[:-1] * values[1:] < 0.0)  # fmt: skip
                if wanted and crossed.size:
                    a, b = going.t[crossed[0]], going.t[crossed[0] + 1]
                    for _ in range(60):
                        m = 0.5 * (a + b)
                        same = event(0, going.sol(m), u, slips) * event(0, going.sol(a), u, slips) > 0.0
                        a, b = (m, b) if same else (a, m)
                    if b < first:
                        first, what = b, i
            x = going.sol(first) if what is not None else going.y[:, -1]
            t = first
            if what == 2:
                slips = np.zeros(2)
            elif what is not None:
                slips = slips.copy()
                slips[what] = math.copysign(1.0, x[1])
    return np.array(rows)


@pytest.mark.slow
def test_maxwell_slip_follows_the_rules_solved_from_event_to_event_by_scipy():
    two = with_elements([0.6, 0.4], [4e4, 1e4], **{"friction.damping": 100.0})
    there = hybrid(0.4, 1e-3)
    assert np.ptp(there[:, 0]) > 0.005 and there[:, 1].min() < -0.02
    errors = []
    for substeps in (250, 1000):
        run = opened(two, options={"substeps": substeps}, amplitude=2.0).run(0.4, record="plant")
        errors.append(np.abs(run["plant.position"] - there[:, 0]).max())
    assert errors[1] < 1e-4 * np.ptp(there[:, 0])
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.3)


def test_elements_that_do_not_fit_are_refused_when_the_loop_starts():
    with pytest.raises(ValueRefused, match="shares of all elements must sum to 1"):
        opened(mass_maxwell_slip(**{"friction.share": np.full(6, 0.2)})).run(0.01)
    with pytest.raises(ValueRefused, match=r"share has the shape \(1,\), friction.stiffness \(2,\)"):
        with_elements([1.0], [1.0, 2.0])


@pytest.mark.sweep
@pytest.mark.parametrize("plant", PLANTS, ids=lambda p: p.name)
def test_all_engines_give_the_same_bits(plant):
    loop = opened(plant, amplitude=3.0, options={"method": "sdirk3", "substeps": 10} if "dt" not in plant.signals
                  else {"substeps": 10})  # fmt: skip
    plain = loop.run(0.05, record=("plant",), engine="python")
    assert np.ptp(plain["plant.position"]) > 1e-6
    for engine in ("llvm", runnable("c")):
        fast = loop.run(0.05, record=("plant",), engine=engine)
        assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


@pytest.mark.sweep
def test_a_batch_of_maxwell_slip_has_the_bits_of_its_single_runs():
    loop = opened(mass_maxwell_slip, options={"substeps": 20}, amplitude=2.0)
    pushes = [1.4, 1.8, 2.2]
    many = loop.batch(0.1, {"reference.amplitude": np.array(pushes)}, record="actual")
    for i, amplitude in enumerate(pushes):
        alone = opened(mass_maxwell_slip, options={"substeps": 20}, amplitude=amplitude).run(0.1)
        assert np.array_equal(many["actual"][i], alone["actual"])
