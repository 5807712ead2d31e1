"""A log played on its model: does the simulated axis move as the equations say, and as published on EMPS?"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from leadscrew.identify.axis.cascade import Cascade, best_difference, cascade_from, reproduced
from leadscrew.identify.axis.simulation import rms, simulate_closed, simulate_open
from leadscrew.logs.arrays import axis_log
from leadscrew.util.errors import DataError, LeadscrewError, ValueRefused
from tests.fuzzy.formats_systems import shared
from tests.identify.axis_exact import KP, KV, PERIOD, VALUES, Exact, recorded, replay, strokes

GTAU = 35.15065
PUBLISHED = {
    "mass": 95.109, "friction.forward.viscous": 203.50, "friction.forward.coulomb": 20.394, "offset": -3.165,
}  # fmt: skip
KNOWN = Cascade(kp=160.18, kv=243.45, over=2)


@cache
def emps() -> Any:
    from scipy.io import loadmat

    d = {k: v.ravel() for k, v in loadmat(shared("data/emps") / "DATA_EMPS.mat").items() if not k.startswith("_")}
    return axis_log(d["t"], d["vir"], d["qm"], d["qg"], drive_unit="V", force_per_drive=GTAU, source="EMPS")


@cache
def record(seconds: float = 3.0) -> Any:
    command = strokes(seconds)
    motor, _, drive = recorded(Exact(), command)
    return axis_log(np.arange(len(command)) * PERIOD, drive, motor, command)


def pushed(n: int = 2500) -> np.ndarray:
    """A drive that slides, sticks and turns the axis."""
    t = np.arange(n) * PERIOD
    return 60.0 * np.sin(9.0 * t) * (np.sin(1.7 * t) ** 2) + np.where(t % 0.7 < 0.1, 10.0, 0.0)


@pytest.mark.parametrize("delay", [0.0, 0.4, 2.25])
def test_the_axis_under_a_logged_drive_moves_as_the_exact_solution_with_stops_and_a_late_drive(delay: float) -> None:
    drive = pushed()
    exact = replay(Exact(), drive, delay)
    assert np.ptp(exact) > 0.01 and np.mean(np.diff(exact) == 0.0) > 0.05
    log = axis_log(np.arange(len(drive)) * PERIOD, drive, exact)
    simulated = simulate_open(log, VALUES, delay * PERIOD, start_state=(0.0, 0.0))
    # the plant stops where the straight line between two speeds is zero: some nanometres a stop
    assert np.max(np.abs(simulated - exact)) < 1e-5 * np.ptp(exact)


def test_a_run_that_starts_in_motion_starts_where_the_log_was_and_as_fast() -> None:
    log = record()
    part = log.part(1.0)
    assert rms(simulate_open(part, VALUES), part.position) < 2e-5 * np.ptp(part.position)


@pytest.mark.slow
def test_friction_by_direction_reaches_the_simulated_axis() -> None:
    log = record()
    both = simulate_open(log, VALUES, start_state=(0.0, 0.0))
    unlike = simulate_open(log, {**VALUES, "friction.backward.coulomb": 25.0}, start_state=(0.0, 0.0))
    going_back = np.flatnonzero(np.diff(both) < 0.0)[0]
    assert going_back > 100 and np.array_equal(both[:going_back], unlike[:going_back])
    assert np.max(np.abs(both - unlike)) > 1e-3


@pytest.mark.slow
def test_the_closed_loop_repeats_the_record_that_the_same_cascade_made() -> None:
    log = record()
    simulated = simulate_closed(log, VALUES, Cascade(KP, KV, over=2))
    assert np.max(np.abs(simulated - log.position)) < 2e-7


def test_the_gains_of_a_cascade_are_read_from_its_log() -> None:
    found = cascade_from(record())
    assert found.obeys and found.law.over == 2
    assert found.law.kp == pytest.approx(KP, rel=1e-9) and found.law.kv == pytest.approx(KV, rel=1e-9)
    assert best_difference(record(), Cascade(KP, KV)).law.over == 2


def test_a_law_that_was_not_active_is_said_not_to_give_the_drive() -> None:
    assert not reproduced(record(), Cascade(KP, 0.5 * KV, over=2)).obeys


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda log: simulate_open(log, {**VALUES, "inertia": 1.0}), "there is no parameter 'inertia'"),
        (lambda log: simulate_open(log, {"mass": 1.0}), "friction.forward.coulomb is missing"),
        (lambda log: simulate_open(log, VALUES, -1e-3), "a drive cannot act before it is given"),
        (lambda log: Cascade(kp=-1.0, kv=1.0), "cascade.kp = -1: must be above 0"),
        (lambda log: simulate_closed(log, VALUES, Cascade(KP, KV), 0.02), "delay_s = 0.02"),
    ],
)
def test_what_cannot_be_simulated_is_refused_in_one_sentence(change: Any, says: str) -> None:
    with pytest.raises(LeadscrewError, match=says):
        change(record())


def test_a_closed_loop_needs_a_command() -> None:
    log = record()
    bare = axis_log(log.time, log.drive, log.position)
    with pytest.raises(DataError, match="has no command"):
        simulate_closed(bare, VALUES, Cascade(KP, KV))
    with pytest.raises(ValueRefused, match=r"over = 9"):
        Cascade(KP, KV, over=9)


@pytest.mark.slow
def test_published_parameters_of_emps_simulate_as_published() -> None:
    """5.28 mm open loop and 3.04 um closed loop (Janot, Gautier, Brunot 2019)."""
    log = emps()
    y = log.position
    opened = simulate_open(log, PUBLISHED, start_state=(y[0], (y[1] - y[0]) / log.period))
    assert 1e3 * rms(opened, y) == pytest.approx(5.28, abs=0.02)
    assert 1e6 * rms(simulate_closed(log, PUBLISHED, KNOWN), y) < 3.04
    assert 1e6 * rms(simulate_closed(log, PUBLISHED, Cascade(160.18, 243.45)), y) < 3.04


def test_the_cascade_of_emps_gives_its_logged_drive() -> None:
    log = emps()
    assert reproduced(log, KNOWN).percent < 0.3
    assert reproduced(log, Cascade(160.18, 243.45)).percent > 3.0
    found = cascade_from(log).law
    assert (
        found.over == 2 and found.kp == pytest.approx(160.18, rel=1e-3) and found.kv == pytest.approx(243.45, rel=1e-3)
    )
