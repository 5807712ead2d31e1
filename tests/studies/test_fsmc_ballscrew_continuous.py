"""The laws in continuous time against reference vectors, against SciPy's Radau, and what is read from their runs."""

import math
from functools import lru_cache

import numpy as np
import pytest

from leadscrew.kernel.block import controller, reference
from leadscrew.kernel.loop import Loop
from leadscrew.plants._ballscrew_stage import ballscrew_stage
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.scenarios import SCENARIOS, build
from leadscrew.studies.fsmc_ballscrew.tracking import at_rest, elsewhere, place_of_largest, reversal
from tests.fuzzy.formats_systems import shared
from tests.studies import stage_oracle as oracle

VECTORS = "papers/fsmc_ballscrew_vectors"
NM_PER_RAD = 1e6 * oracle.TRAVEL
FINE = {"rtol": 1e-8, "atol": 1e-13}


def known(name):
    return np.loadtxt(shared(f"{VECTORS}/reference_{name}.csv"), delimiter=",", skiprows=1)


# ---- the stage by itself
@reference()
def push(t):
    """11 N m at 2.5 Hz."""
    return 11.0 * math.sin(2.0 * math.pi * 2.5 * t)


@reference()
def ramps(t):
    """0.8 F_S up in 10 s, down to its negative in 20 s, up again in 20 s."""
    up = 0.7488 * min(t, 10.0)
    return up - 0.7488 * min(max(t - 10.0, 0.0), 20.0) + 0.7488 * max(t - 30.0, 0.0)


@controller()
def through(command):
    """What is asked for."""
    return command


def test_a_held_torque_moves_the_stage_as_in_the_vectors():
    """400 holds of 1 ms: within 1e-9 rad, of 0.2 rad that the screw turns by."""
    loop = Loop(reference=push, controller=through, plant=ballscrew_stage, period=1e-3, metrics={}, method="rodas",
                rtol=1e-7, atol=1e-12)  # fmt: skip
    rows, run = known("openloop_zoh"), loop.run(0.4, record=("plant", "output"))
    assert run["output"] == pytest.approx(rows[:400, 1], abs=1e-12)
    assert np.abs(run["plant.angle"] - rows[:400, 2]).max() < 1e-9
    assert np.abs(run["plant.bristle"] - rows[:400, 4]).max() < 1e-9


def test_slow_ramps_below_break_away_bend_the_stuck_stage_as_in_the_vectors():
    loop = Loop(reference=ramps, controller=through, plant=ballscrew_stage, period=None, sample=0.2, metrics={},
                rtol=1e-8, atol=1e-14)  # fmt: skip
    rows, run = known("presliding_ramp"), loop.run(50.2, record=("plant", "output"))
    assert run["output"] == pytest.approx(rows[:251, 1], abs=1e-9)
    assert np.abs(run["plant.angle"] - rows[:251, 2]).max() < 1e-10
    at = [1e6 * run["plant.angle"][round(t / 0.2)] for t in (10, 30, 50)]
    assert at == pytest.approx([150.576, -54.971, 150.576], abs=5e-4)


# ---- the loops
def ideal(law, scenario, at_rest=False, sample=1e-3, **options):
    """The study's loop; ``at_rest``: all bristles unbent at the start, as in the vectors."""
    loop = build(CONTROLLERS[law], SCENARIOS[scenario], sample=sample, **options)
    if at_rest:
        for slot in ("plant", "controller"):
            loop.blocks[slot] = loop.blocks[slot].starting(bristle=0.0)
    return loop


CLOSED = [
    ("corrected.smc", "sine_fast", "closedloop_sin2pi_SMCconv"), ("paper.csmc", "sine_fast", "closedloop_sin2pi_CSMC"),
    ("paper.smc", "sine_fast", "closedloop_sin2pi_SMClit"), ("paper.smc", "sine_wide", "closedloop_5sin_SMClit"),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("law", "scenario", "name"), CLOSED, ids=[c[2] for c in CLOSED])
def test_every_state_of_the_loop_is_that_of_the_vectors(law, scenario, name):
    rows = known(name)
    run = ideal(law, scenario, at_rest=True, **FINE).run(1e-3 * len(rows), record=("plant", "controller"))
    assert NM_PER_RAD * np.abs(run["plant.angle"] - rows[:, 1]).max() < 2e-4
    assert np.abs(run["plant.speed"] - rows[:, 2]).max() < 1e-6
    for column, signal in ((3, "plant.bristle"), (4, "controller.xi"), (5, "controller.bristle")):
        assert np.abs(run[signal] - rows[:, column]).max() < 1e-10


@lru_cache
def solved(law, scenario, seconds):
    """Angles by Radau at rtol 1e-10, every ms, from the study's start."""
    times = 1e-3 * np.arange(round(1e3 * seconds))
    return oracle.radau(law, oracle.sine(scenario), oracle.sliding_start(scenario), times)[:, 0]


def apart_nm(law, scenario, seconds):
    run = ideal(law, scenario, **FINE).run(seconds, record="plant")
    return NM_PER_RAD * np.abs(run["plant.angle"] - solved(law, scenario, seconds))


SMOOTH = [
    ("corrected.smc", "sine_wide"), ("paper.csmc", "sine_wide"), ("corrected.fsmc", "sine_wide"),
    ("paper.fsmc", "sine_wide"), ("paper.csmc", "sine_slow"), ("corrected.fsmc", "sine_slow"),
    ("corrected.fsmc", "sine_fast"), ("paper.fsmc", "sine_fast"),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("law", "scenario"), SMOOTH)
def test_through_a_reversal_it_follows_radau_to_a_picometre(law, scenario):
    assert apart_nm(law, scenario, 0.6 if scenario == "sine_fast" else 2.0).max() < 1e-3


# ---- the oracle's own fuzzy system
@pytest.mark.parametrize(
    ("s", "s_c", "k"),
    [(0.2, 0, -0.120690), (0.2, 0.2, -0.279412), (1, 0, -0.5), (0.5, -0.5, 0), (0.3, -0.2, -0.044326)],
)
def test_the_oracles_centroid_is_the_fine_numeric_one(s, s_c, k):
    assert oracle.surface(s, s_c) == pytest.approx(k, abs=6e-7)


# ---- what is read from a run
def made(time, error_um, output=None):
    still = np.zeros_like(time) if output is None else output
    return {"time": time, "true_error": 1e-3 * error_um, "output": still}


def test_a_reversals_peak_and_recovery_are_those_of_a_made_up_error():
    """5 sin t turns at 3 pi / 2: a jump to 40 nm there, gone with a time constant of 10 ms, on a lag of 2 nm."""
    t = np.arange(0.0, 8.4, 1e-4)
    since = t - 1.5 * math.pi
    error = np.where(since >= 0.0, 2.0 + 38.0 * np.exp(-np.maximum(since, 0.0) / 0.01), -2.0)
    found = reversal(made(t, -1e-3 * error), "sine_wide")
    assert found.peak == pytest.approx(40.0, rel=0.01) and found.after == pytest.approx(2.0, abs=1e-3)
    assert found.first == pytest.approx(0.01 * math.log(38.0 / 4.0), abs=3e-4)
    assert found.settled == pytest.approx(found.first, abs=2e-4) and found.swing == pytest.approx(0.0, abs=1e-6)


def test_an_error_largest_at_full_speed_is_found_half_way_between_the_reversals():
    t = np.arange(0.0, 8.4, 1e-4)
    run = made(t, 0.14 * np.cos(t))
    assert place_of_largest(run, "sine_wide") == pytest.approx(0.5, abs=1e-3)
    assert elsewhere(run, "sine_wide") == pytest.approx(140.0, rel=1e-3)


def test_at_rest_a_limit_cycle_has_no_mean_and_a_constant_torque_no_swing():
    t = np.arange(0.0, 0.8, 1e-5)
    cycle = at_rest(made(t, 0.09 * np.sin(170.0 * t), 4.6 * np.sin(170.0 * t)))
    assert abs(cycle.mean) < 0.01 and cycle.swing == pytest.approx(4.6, rel=1e-4)
    assert cycle.error == pytest.approx(0.09, rel=1e-4) and cycle.variation == pytest.approx(
        4.6 * 340.0 / math.pi, rel=0.03
    )
    still = at_rest(made(t, np.full_like(t, -0.17), np.full_like(t, -6.4)))
    assert still.swing == 0.0 and still.mean == pytest.approx(-6.4) and still.variation == 0.0
