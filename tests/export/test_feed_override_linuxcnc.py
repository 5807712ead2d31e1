"""The force guard's example in the whole of LinuxCNC, without a screen: which moves a hold stops, and which not."""

import shutil

import pytest

from leadscrew.export import hal_run
from leadscrew.export.controller import export_controller
from leadscrew.export.folder import write
from tests.export.hal_bench import needed
from tests.export.linuxcnc_machine import seen_by
from tests.export.test_feed_override import EXAMPLES, example
from tests.export.test_hal_linuxcnc import MACHINE

pytestmark = pytest.mark.slow
FULL = 10.0
"""Programmed speed, mm/s."""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What ``guard.py`` saw: moves of every kind, a force of 250 N in the middle of each."""
    needed()
    folder = tmp_path_factory.mktemp("guard") / "exported"
    core, record = export_controller(example().fast, 0.1, name="force_override", title="guard")
    write(core, record, "hal", folder, loop=example().fast)
    with hal_run.workplace() as place:
        hal_run.install(place, folder, core.name)
        machine = place / "machine"
        shutil.copytree(MACHINE, machine, ignore=shutil.ignore_patterns("__pycache__"))
        (machine / "guard.hal").replace(machine / "axis.hal")
        (machine / "guard.py").replace(machine / "drive.py")
        shutil.copyfile(EXAMPLES / "turning_guard.hal", machine / "turning_guard.hal")
        seen = seen_by(machine, place, 150.0)
    assert seen["homed"] and seen["seen"]["feed"]
    assert all(v["ready"] for v in seen["seen"].values() if isinstance(v, dict) and "ready" in v)
    return seen["seen"]


@pytest.mark.parametrize(("move", "end"), [("G1", 15.0), ("G2", -20.0)])
def test_a_cut_stops_at_a_force_above_the_limit_and_goes_on_after_it(found, move, end):
    cut = found[move]
    assert cut["override"] == 1.0 and cut["before"] == pytest.approx(FULL, rel=0.05)
    assert cut["held"] == 0.0 and cut["during"] == 0.0 and cut["fault"] == 0
    assert cut["done"] and cut["where"][0] == pytest.approx(end)


def test_a_rapid_has_its_own_speed_and_a_hold_stops_it_too(found):
    rapid = found["G0"]
    assert rapid["override"] == 1.0 and rapid["before"] > 2.0 * FULL
    assert rapid["held"] == 0.0 and rapid["during"] == 0.0
    assert rapid["done"] and rapid["where"][0] == pytest.approx(-30.0)


def test_a_feed_per_revolution_is_held_as_well(found):
    cut = found["G95"]
    assert cut["before"] == pytest.approx(FULL, rel=0.1)
    assert cut["held"] == 0.0 and cut["during"] == 0.0 and cut["done"]


def test_a_thread_is_not_stopped_by_a_hold(found):
    """Why threading is excluded: the guard holds, and LinuxCNC cuts on."""
    thread = found["G33"]
    assert thread["held"] == 0.0 and thread["during"] == pytest.approx(FULL, rel=0.1)
    assert thread["done"] and thread["where"][2] == pytest.approx(15.0, abs=0.01)


def test_jogs_are_free_while_the_feed_is_held(found):
    """How the tool gets out."""
    jogs = found["jogs"]
    assert jogs["held"] == 0.0 and [jogs["joint"], jogs["teleop"]] == pytest.approx([5.0, 5.0], rel=0.05)


def test_without_m52_the_guard_has_no_hold_on_the_machine(found):
    free = found["M52 P0"]
    assert free["held"] == 0.0 and free["during"] == pytest.approx(FULL, rel=0.05)


def test_a_force_that_is_no_number_stops_the_cut_with_a_fault(found):
    broken = found["not a number"]
    assert broken["before"] == pytest.approx(FULL, rel=0.05)
    assert broken["fault"] == 1 and broken["held"] == 0.0 and broken["during"] == 0.0
