"""The ball screw between motor and table: what each of its errors does, and what the two sensors see of it."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.controllers._vud import vud_beta_e
from leadscrew.kernel.loop import Loop
from leadscrew.plants._lathe_screw import LatheScrewPosition, lathe_screw
from leadscrew.plants._lathe_servo import lathe_servo
from leadscrew.references._step import step
from leadscrew.sensors._counts import grating_count, screw_encoder
from leadscrew.util.errors import ValueRefused
from tests.tools import runnable

ALL = {"lead_error": 4e-5, "cyclic_error_mm": 0.003, "backlash_mm": 0.006, "warming_K": 3.0}


def driven(duties, parts=1, **errors):
    """Table, lagged table and nut at the start of every period of 1 ms, and after the last one."""
    block = lathe_screw(**errors)
    dt = 1e-3 / parts
    p, s = block.prepare(block.params, dt), block.state
    shown = [block.output(p, s)]
    for u in duties:
        for _ in range(parts):
            s = block.step(p, s, u, dt)
        shown.append(block.output(p, s))
    return LatheScrewPosition(*np.array(shown).T)


def to_and_fro():
    return np.concatenate([np.full(200, -0.4), np.zeros(150), np.full(120, 0.5), np.zeros(150)])


def closed(plant, sensor=grating_count):
    return Loop(
        reference=step(target=-50.0), controller=vud_beta_e, plant=plant, sensor=sensor, period=1e-3, metrics={}
    )


def test_a_perfect_screw_is_the_axis_without_one_to_the_last_bit():
    kept = ("actual.position", "actual.reading", "output")
    plain = closed(lathe_servo).run(1.0, record=kept, engine="python")
    screw = closed(lathe_screw).run(1.0, record=kept, engine="python")
    assert all(np.array_equal(plain[name], screw[name]) for name in kept)


def test_lead_error_and_warmth_stretch_the_way_of_the_table():
    """12 um per 300 mm and 3 K of 11.7 um/(m K): 7.51 um more on 100 mm."""
    seen = driven(to_and_fro(), lead_error=12e-3 / 300.0, warming_K=3.0)
    assert seen.position - seen.motor == pytest.approx(seen.motor * (4e-5 + 3.51e-5), abs=1e-12)
    assert abs(seen.motor).max() > 20.0


def test_the_table_stands_still_while_the_nut_crosses_the_backlash():
    seen = driven(to_and_fro(), backlash_mm=0.006)
    lost = seen.motor - seen.position
    assert lost[150:300] == pytest.approx(0.003, abs=1e-12)  # pushed up, the table is half the play behind
    assert lost[-100:] == pytest.approx(-0.003, abs=1e-12)
    still = np.abs(np.diff(seen.position)) < 1e-12
    moving = np.abs(np.diff(seen.motor)) > 1e-9
    assert abs(np.diff(seen.motor)[still & moving][5:]).sum() <= 0.006


def test_the_cyclic_error_repeats_every_turn():
    seen = driven(to_and_fro(), cyclic_error_mm=0.002, lead_mm=5.0)
    assert seen.position - seen.motor == pytest.approx(0.002 * np.sin(2 * np.pi * seen.motor / 5.0), abs=1e-12)


def test_the_grating_lags_the_table_and_not_the_nut():
    """(4) by SciPy over the way of the table, all errors on: far closer than a count of 0.625 um."""
    duties = to_and_fro()
    seen, table = driven(duties, **ALL), dense_table(duties, 20)
    end = 1e-3 * len(duties)
    every = np.linspace(0.0, end, len(table))
    lag = solve_ivp(lambda t, g: (np.interp(t, every, table) - g) / 0.006, (0.0, end), [0.0], t_eval=every[::20],
                    max_step=2e-4, rtol=1e-9, atol=1e-9)  # fmt: skip
    assert seen.reading == pytest.approx(lag.y[0], abs=5e-5)


def dense_table(duties, parts):
    block = lathe_screw(**ALL)
    p, s = block.prepare(block.params, 1e-3 / parts), block.state
    table = [0.0]
    for u in np.repeat(duties, parts):
        s = block.step(p, s, u, 1e-3 / parts)
        table.append(block.output(p, s).position)
    return np.array(table)


def test_a_turning_point_inside_a_period_costs_what_the_docs_say():
    """Full reversals, the worst there is: below a h^2 / 8 = 4.3 um of table at a = 2 x 289 / 17 ms."""
    slammed = np.sign(np.sin(np.arange(200) / 7.0))
    coarse, fine = driven(slammed, **ALL), driven(slammed, parts=50, **ALL)
    worst = abs(coarse.position - fine.position).max()
    assert 1e-4 < worst < (2 * 289.0 / 0.017) * 1e-6 / 8
    assert abs(coarse.motor - fine.motor).max() < 1e-10


def test_the_encoder_counts_the_nut_and_misses_the_screw():
    seen = driven(to_and_fro(), **ALL)
    for k in range(0, len(seen.motor), 7):
        shown = LatheScrewPosition(seen.position[k], seen.reading[k], seen.motor[k])
        feedback = screw_encoder.step(screw_encoder.prepare(screw_encoder.params, 1e-3), shown)
        assert abs(feedback - seen.motor[k]) <= 0.0005 * (1 + 1e-9)
        assert feedback / 0.001 == pytest.approx(round(feedback / 0.001), abs=1e-6)
    with pytest.raises(ValueRefused, match="counts_per_turn"):
        screw_encoder(counts_per_turn=0)


def test_the_same_counts_on_half_the_lead_see_twice_as_fine():
    block = screw_encoder(lead_mm=5.0)
    feedback = block.step(block.prepare(block.params, 1e-3), LatheScrewPosition(motor=0.0012))
    assert feedback == pytest.approx(0.001) and math.isclose(block.prepare(block.params, 1e-3).resolution_mm, 0.0005)


@pytest.mark.sweep
@pytest.mark.parametrize("engine", ["llvm", "c"])
def test_compiled_and_plain_python_give_the_same_bits(engine):
    loop = closed(lathe_screw(**ALL), screw_encoder)
    plain = loop.run(0.7, record=("actual", "plant", "output"), engine="python")
    fast = loop.run(0.7, record=("actual", "plant", "output"), engine=runnable(engine))
    assert all(np.array_equal(plain[name], fast[name]) for name in plain.signals)
