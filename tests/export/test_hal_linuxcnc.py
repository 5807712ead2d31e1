"""The exported controller in the whole of LinuxCNC, without a screen: homing and G-code moves behind it."""

import shutil
from pathlib import Path

import pytest

from leadscrew.export import hal, hal_run
from tests.export import hal_sample
from tests.export.hal_bench import needed
from tests.export.linuxcnc_machine import seen_by

MACHINE = Path(__file__).with_name("linuxcnc_sim")


def simulated(core, folder, seconds=90.0):
    """What ``drive.py`` saw of a machine with the controller's own example in place of ``pid`` on its X axis."""
    needed()
    exported = hal_sample.export(core, folder, rows=10)
    with hal_run.workplace() as place:
        hal_run.install(place, exported, core.name)
        machine = place / "machine"
        shutil.copytree(MACHINE, machine, ignore=shutil.ignore_patterns("__pycache__"))
        (machine / "controller.hal").write_text(hal.files(core)[f"{core.name}_example.hal"], encoding="utf-8")
        return seen_by(machine, place, seconds)


@pytest.mark.slow
@pytest.mark.parametrize("sense", [-1, 1])
def test_linuxcnc_homes_and_moves_an_axis_behind_the_exported_controller(tmp_path, sense):
    found = simulated(hal_sample.core("demo_axis", sense=sense), tmp_path / "exported")
    assert found["homed"]
    assert found["enabled"]
    assert found["errors"] == []
    commanded, reached = zip(*found["ends"], strict=True)
    assert commanded == pytest.approx([20.0, -15.0, 3.5], abs=1e-9)
    assert reached == pytest.approx(commanded, abs=1e-5)
    assert found["travel"] == pytest.approx([-15.0, 20.0], abs=0.2)
    assert 0.1 < found["largest following error"] < 2.0


@pytest.mark.slow
def test_a_faulting_controller_takes_the_machine_down(tmp_path):
    core = hal_sample.core("demo_axis", sense=-1)
    tight = hal_sample.replace(core, limits=hal_sample.Limits(hal_sample.MAX_OUTPUT, 0.1, 5.0))
    found = simulated(tight, tmp_path / "exported")
    assert not found["enabled"]
    assert any("amplifier fault" in e for e in found["errors"])
