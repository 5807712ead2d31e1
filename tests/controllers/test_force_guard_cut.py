"""The guard in the cut: a hard spot, a load cell that breaks, all engines, and NaN inside a compiled loop."""

from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.controllers._guard import HOLDING, RUNNING, Clock, force_guard
from leadscrew.controllers._guard.watching import NOT_FINITE, STUCK, CellChecks, Levels, Seen, looked
from leadscrew.disturbances._hard_spot import hard_spot
from leadscrew.kernel.block import controller
from leadscrew.kernel.engines import ENGINES
from leadscrew.kernel.loop import Loop
from leadscrew.plants._turning import turning
from leadscrew.references._cutting_program import cutting_program
from leadscrew.sensors._faulty_load_cell import faulty_load_cell
from leadscrew.sensors._load_cell import CutReading, lathe_reading
from leadscrew.studies.grey_turning.tunings import TUNINGS
from tests.tools import runnable

TFC = TUNINGS["corrected.tfc_stfc"]
TRIED = [pytest.param(e, marks=pytest.mark.slow) if e == "c" else e for e in ENGINES]
SIGNALS = ("feedback", "output", "actual", "controller")


def cutting(block, fast=False, **more):
    """A cut of 1 mm at 150 N on plant F."""
    rate = {"period": 0.001} if fast else {"period": 0.02, "substeps": 20}
    given = {
        "reference": cutting_program,
        "controller": block,
        "plant": turning,
        "sensor": lathe_reading,
        "metrics": {},
    }
    return Loop(**(given | rate | more))


@pytest.fixture(scope="module")
def fast():
    """The guard looks in every millisecond; ``controller.clock.looks`` = 20 makes it the slow one."""
    return cutting(force_guard(TFC, clock=Clock(every=20)), fast=True, disturbance=hard_spot)


@pytest.fixture(scope="module")
def breaking():
    return cutting(force_guard(TFC), sensor=faulty_load_cell)


def first(rows):
    """Where each row is first true."""
    assert rows.any(axis=1).all()
    return rows.argmax(axis=1)


@pytest.mark.slow
@pytest.mark.parametrize(("looks", "most_ms"), [(1, 0), (20, 20)])
def test_a_hard_spot_that_doubles_the_force_holds_the_feed_within_40_ms_and_the_cut_goes_on(fast, looks, most_ms):
    """At 1 ms resolution, without noise, at every phase of the sampling; the loop is back at its force at the end."""
    start = 1.5 + 0.001 * np.arange(20)
    many = fast.using({"sensor.noise_n": 1e-6, "controller.clock.looks": looks}).batch(
        4.5, {"disturbance.start": start}, record=SIGNALS
    )
    crossed = first(many["feedback.raw"] > 180.0)
    held = first((many["output"] == 0.0) & (many.time > 1.0))
    late = held - crossed
    assert late.min() >= 0 and late.max() <= most_ms < 40
    assert (many["controller.guard.mode"][:, -1] == RUNNING).all()
    assert np.abs(many["actual.force"][:, -500:] - 150.0).max() < 4.0
    axis = many["actual.feed"]
    assert (axis[np.arange(20), held + 100] < 0.02 * axis[np.arange(20), held]).all()


def test_the_peak_comes_all_the_same_but_lower(fast):
    changes = {"controller.levels.hold_n": [180.0, 1e6], "controller.levels.reduce_n": [165.0, 1e5],
               "controller.cell.range_n": [1000.0, 1e7]}  # fmt: skip
    guarded, free = fast.batch(2.5, changes, record=SIGNALS)["actual.force"].max(axis=1)
    assert free > 1.75 * 150.0 and 1.4 * 150.0 < guarded < 0.95 * free


BROKEN = (("constant", 0.0, 0.1), ("saturated", 1000.0, 0.0), ("saturated", -1000.0, 0.0),
          ("error_code", 8388607.0, 0.0), ("jump", 400.0, 0.0))  # fmt: skip
"""Faults, with their size in N, and the time within which the feed is to be held."""


@pytest.mark.slow
@pytest.mark.parametrize("from_s", [0.1, 1.5])
def test_a_broken_load_cell_leads_to_feed_hold_within_its_time_and_never_to_more_feed(breaking, from_s):
    changes = {"sensor.fault": [b[0] for b in BROKEN], "sensor.size_n": [b[1] for b in BROKEN],
               "sensor.from_s": [from_s] * len(BROKEN)}  # fmt: skip
    run = breaking.batch(4.0, changes, record=SIGNALS)
    at = round(from_s / 0.02)
    for mode, output, (_, _, most_s) in zip(run["controller.guard.mode"], run["output"], BROKEN, strict=True):
        held = at + round(most_s / 0.02)
        assert mode[at - 1] == RUNNING and (mode[held:] == HOLDING).all() and (output[held:] == 0.0).all()
        assert output[at:].max() <= output[:at].max() + 0.06
    assert run["controller.guard.cause"][0, -1] == STUCK


@pytest.mark.slow
def test_a_dead_load_cell_gives_no_more_than_the_feed_of_air_and_a_sound_one_lets_it_come_back(breaking):
    changes = {"sensor.fault": ["dead", "error_code"], "sensor.size_n": [0.0, 9999.0],
               "sensor.until_s": [1e9, 1.6]}  # fmt: skip
    run = breaking.batch(6.0, changes, record=SIGNALS)
    assert run["output"][0, 80:].max() <= 0.3 and run["actual.force"][0].max() < 190.0
    assert run["controller.guard.holds"][1].max() == 1 and abs(run["actual.force"][1, -50:] - 150.0).max() < 4.0


@pytest.mark.sweep
@pytest.mark.parametrize("engine", [e for e in TRIED if e != "llvm"])
@pytest.mark.parametrize("which", [pytest.param("fast", marks=pytest.mark.slow), "breaking"])
def test_all_engines_give_the_same_bits(request, which, engine):
    loop = request.getfixturevalue(which)
    if which == "breaking":
        loop = loop.using({"sensor.fault": "error_code", "sensor.until_s": 1.6})
    seconds = 2.2
    one = loop.run(seconds, record=SIGNALS, engine="llvm")
    other = loop.run(seconds, record=SIGNALS, engine=runnable(engine))
    assert one["controller.guard.mode"].max() == HOLDING
    assert all(np.array_equal(one[name], other[name]) for name in one.signals)


class ProbeParams(NamedTuple):
    """The guard's own."""

    levels: Levels = Levels()
    cell: CellChecks = CellChecks()


class ProbeState(NamedTuple):
    """What was seen."""

    seen: Seen = Seen()


@controller(ProbeParams(), ProbeState())
def poisoned(p, s, command, feedback, t, dt):
    """Looks at NaN from 0.2 s on, at infinity from 0.4 s on; both are made inside, so no signal carries them."""
    nothing = feedback.raw - feedback.raw
    nan = nothing / nothing
    big = 1.0 / nothing
    raw = feedback.raw if t < 0.2 else nan if t < 0.4 else big
    shown = CutReading(feedback.force, raw, feedback.travel, feedback.turns)
    seen = looked(p.levels, p.cell, 10.0, s.seen, shown, command.force, True, 0.2, True, dt)
    return ProbeState(seen), 0.2


@pytest.mark.slow
@pytest.mark.parametrize("engine", TRIED)
def test_nan_and_infinity_are_seen_by_every_engine_and_go_no_further(engine):
    run = cutting(poisoned).run(0.6, record=SIGNALS, engine=runnable(engine))
    assert run.diverged is None
    cause = run["controller.seen.cause"]
    assert set(cause[:10]) == {0} and set(cause[10:]) == {NOT_FINITE}
    assert np.ptp(run["controller.seen.raw"][9:]) == 0.0
