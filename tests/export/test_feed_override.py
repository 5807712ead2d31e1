"""The exported feed override in the real HAL: the simulation's bits, force steps, broken load cells, NaN, rapids."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from leadscrew.controllers._guard import FeedCommand
from leadscrew.export import hal, hal_check, hal_run
from leadscrew.export.controller import export_controller
from leadscrew.export.folder import write
from leadscrew.export.hal_check import Stream
from leadscrew.sensors._load_cell import CutReading
from tests.controllers.guarded import Stepped
from tests.export.hal_bench import needed

EXAMPLES = Path(__file__).parents[2] / "examples"
CALLS = 1200
NO_LIMITS = ("max-following-error", "max-wrong-way")


def example():
    """The example of the docs page."""
    sys.path.insert(0, str(EXAMPLES))
    try:
        import turning_guard
    finally:
        sys.path.remove(str(EXAMPLES))
    return turning_guard


class Machine:
    """Both forms of the example, each installed in the workplace when it is first used."""

    def __init__(self, place, folder):
        self.place, self.folder, self.made = place, folder, {}

    def installed(self, name):
        """Manifest and loop of a form."""
        if name not in self.made:
            loop = {"guard_slow": example().loop, "guard_fast": example().fast}[name]
            core, record = export_controller(loop, 0.1, name=name, title=name)
            write(core, record, "hal", self.folder / name, loop=loop)
            hal_run.install(self.place, self.folder / name, name)
            self.made[name] = (core.manifest, loop)
        return self.made[name]

    def pins(self, name):
        return hal.pins((p["name"], p["role"]) for p in self.installed(name)[0]["inputs"])

    def stream(self, name, rows, bits=None, thread_ns=1_000_000, setup=()):
        """What the component makes of rows of inputs, its machine limits off."""
        own = f"{hal.component(name)}.0"
        off = [f"setp {own}.{limit} 0" for limit in NO_LIMITS]
        inputs = {pin: rows[:, i] for i, pin in enumerate(self.pins(name))}
        given = Stream(inputs, bits=bits or {}, setup=[*off, *setup], thread_ns=thread_ns)
        got = hal_check.replay(self.place, self.installed(name)[0], given)
        return got.outputs[:, 0], got.faults

    def expected(self, name, rows):
        """The same rows through the controller as plain Python."""
        loop = self.installed(name)[1]
        block = loop.blocks["controller"]
        stepped = Stepped(block, period=loop.period)
        with np.errstate(all="ignore"):
            return np.array([stepped.take(CutReading(*row[6:]), FeedCommand(*row[:6])) for row in rows.tolist()])


@pytest.fixture(scope="module")
def machine(tmp_path_factory):
    needed()
    with hal_run.workplace() as place:
        yield Machine(place, tmp_path_factory.mktemp("guard"))


def rows_of(raw, rapid=0.0, feed=120.0, seed=1):
    """Inputs for a raw force by call, some noise on it."""
    raw = np.asarray(raw, dtype=float)
    noisy = raw + np.random.default_rng(seed).normal(0.0, 1.0, len(raw))
    k = np.arange(len(raw))
    ones = np.ones(len(raw))
    columns = [150.0 * ones, ones, ones, 1e9 * ones, feed * ones, rapid * ones, noisy, noisy, 1e-3 * k, 0.02 * k]
    return np.column_stack(columns)


def step_at(call, before=150.0, after=260.0, calls=CALLS):
    return np.where(np.arange(calls) < call, before, after)


def test_a_force_step_holds_the_feed_in_the_same_millisecond_with_the_bits_of_the_simulation(machine):
    rows = rows_of(step_at(700))
    found, faults = machine.stream("guard_fast", rows)
    assert (found[:700] > 0.0).sum() > 650 and (found[700:] == 0.0).all() and not faults.any()
    assert np.array_equal(found, machine.expected("guard_fast", rows))


@pytest.mark.slow
def test_in_a_thread_of_1_ms_the_guard_of_20_ms_holds_the_feed_within_20_ms(machine):
    """The component then works at every 20th call; the force step falls anywhere between two of them."""
    for call in (700, 701, 713, 719):
        found, _ = machine.stream("guard_slow", rows_of(step_at(call)))
        held = int(np.flatnonzero(found > 0.0)[-1]) + 1
        assert 0 <= held - call < 20 and held % 20 == 0


@pytest.mark.slow
def test_after_the_force_has_gone_the_feed_comes_back_in_hal_as_in_the_simulation(machine):
    raw = step_at(400)
    raw[450:] = 50.0
    rows = rows_of(raw)
    found, _ = machine.stream("guard_fast", rows)
    assert (found[400:500] == 0.0).all() and found[-1] > 0.0
    assert np.array_equal(found, machine.expected("guard_fast", rows))


@pytest.mark.parametrize(("pin", "bad"), [
    pytest.param(pin, bad, marks=() if (pin, repr(bad)) == (7, "nan") else pytest.mark.slow)
    for pin in (6, 7, 8, 9) for bad in (math.nan, math.inf, -math.inf)
])  # fmt: skip
def test_a_number_that_is_not_finite_on_any_pin_stops_the_feed_until_enable_is_taken_away(machine, pin, bad):
    rows = rows_of(np.full(600, 140.0))
    rows[300, pin] = bad
    enable = np.ones(600, dtype=bool)
    enable[450] = False
    found, faults = machine.stream("guard_fast", rows, bits={"enable": enable})
    assert (found[100:300] > 0.0).all() and (found[300:451] == 0.0).all() and (found[460:] > 0.0).all()
    assert set(faults[300:450]) == {1} and not faults[450:].any()


@pytest.mark.slow
def test_the_guard_itself_sees_a_nan_in_c(machine, tmp_path):
    """Without the layer of the machine around it: the bare step of the exported C, compiled and called."""
    from tests.export.bare_step import stepped

    rows = rows_of(np.full(60, 140.0))
    rows[30, 7] = math.nan
    rows[31, 6] = math.inf
    found = stepped(example().loop, rows, tmp_path)
    assert np.array_equal(found, machine.expected("guard_slow", rows))
    assert (found[5:30] > 0.0).all() and (found[30:] == 0.0).all()


@pytest.mark.slow
@pytest.mark.parametrize(("number", "late_ms"), [(1000.0, 0), (-1000.0, 0), (8388607.0, 0), (500.0, 0), (None, 100)])
def test_a_broken_load_cell_holds_the_feed_in_hal(machine, number, late_ms):
    rows = rows_of(np.full(700, 140.0))
    rows[300:, 7] = rows[299, 7] if number is None else number
    found, faults = machine.stream("guard_fast", rows)
    assert (found[100:300] > 0.0).all() and (found[300 + late_ms :] == 0.0).all() and not faults.any()
    assert found.max() <= found[:301].max()


def test_rapids_get_one_and_a_hold_stops_them(machine):
    rows = rows_of(step_at(500, 5.0, 400.0), rapid=1.0)
    found, _ = machine.stream("guard_fast", rows)
    assert set(found[:500]) == {1.0} and set(found[500:]) == {0.0}


def test_whatever_comes_in_the_override_stays_between_0_and_1_and_has_the_bits_of_the_simulation(machine):
    rng = np.random.default_rng(5)
    rows = rows_of(rng.uniform(-100.0, 200.0, 2000))
    for column in range(10):
        hit = rng.uniform(size=2000) < 0.03
        rows[hit, column] = rng.choice([0.0, -1.0, 1e-300, -1e30, 1e30, 5.0], hit.sum())
    found, faults = machine.stream("guard_fast", rows)
    assert ((found >= 0.0) & (found <= 1.0)).all() and not faults.any()
    assert np.array_equal(found, machine.expected("guard_fast", rows))
