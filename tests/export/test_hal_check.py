"""The check of a HAL component in the real LinuxCNC: what it calls identical, different, failed and not run."""

import os
import time
from pathlib import Path

import numpy as np
import pytest

from leadscrew.export import hal_check, hal_run
from tests.export import hal_sample
from tests.export.hal_bench import needed


def exported(tmp_path, rows=3000, **more):
    needed()
    core = hal_sample.core("demo_down", sense=-1, **more)
    return hal_sample.export(core, tmp_path / "exported", rows), hal_sample.manifest(core)


@pytest.mark.parametrize("real", ["double", "float"])
def test_golden_vectors_come_back_identical_from_halrun(tmp_path, real):
    (verdict,) = hal_check.check(*exported(tmp_path, real=real))
    assert (verdict.verdict, verdict.cycles, verdict.worst) == ("identical", 3000, 0.0), verdict
    assert "LinuxCNC 2." in verdict.note


def test_the_check_leaves_no_module_and_no_folder_behind(tmp_path):
    needed()
    before = sorted(hal_run.MODULES.iterdir())
    hal_check.check(*exported(tmp_path, rows=20))
    assert sorted(hal_run.MODULES.iterdir()) == before


def test_a_golden_number_that_is_off_by_one_bit_is_found(tmp_path):
    folder, manifest = exported(tmp_path, rows=100)
    lines = (folder / "golden.csv").read_text().splitlines()
    cells = lines[51].split(",")
    cells[3] = repr(float(np.nextafter(float(cells[3]), np.inf)))
    (folder / "golden.csv").write_text("\n".join([*lines[:51], ",".join(cells), *lines[52:]]) + "\n")
    (verdict,) = hal_check.check(folder, manifest)
    assert verdict.verdict == "different"
    assert 0 < verdict.worst < 1e-15


def test_a_component_that_does_not_compile_fails_with_the_compiler_s_first_error(tmp_path):
    folder, manifest = exported(tmp_path, rows=20)
    source = folder / "demo_down.c"
    source.write_text(source.read_text().replace("state->started = 1;", "state->begun = 1;"))
    (verdict,) = hal_check.check(folder, manifest)
    assert verdict.verdict == "failed"
    assert "demo_down.c:21" in verdict.note
    assert "begun" in verdict.note


def test_a_folder_without_the_component_or_with_other_columns_fails(tmp_path):
    folder, manifest = exported(tmp_path, rows=20)
    (verdict,) = hal_check.check(folder, {**manifest, "inputs": manifest["inputs"][::-1]})
    assert verdict.verdict == "failed"
    assert "columns" in verdict.note
    (folder / "demo_down.comp").unlink()
    (verdict,) = hal_check.check(folder, manifest)
    assert verdict.verdict == "failed"
    assert "there is no demo_down.comp" in verdict.note


def test_without_root_or_tools_the_check_says_not_run(tmp_path, monkeypatch):
    monkeypatch.setattr("os.geteuid", lambda: 1000)
    (verdict,) = hal_check.check(tmp_path, {})
    assert verdict.verdict == "not run"
    monkeypatch.setattr("shutil.which", lambda tool: None)
    (verdict,) = hal_check.check(tmp_path, {})
    assert verdict.verdict == "not run"
    assert "halrun" in verdict.note


def test_a_run_that_hangs_is_ended_with_all_its_processes():
    needed()
    with hal_run.workplace() as place:
        with pytest.raises(hal_run.HalFailed, match="halrun was not done within 2 s"):
            hal_run.run(place, "loadrt threads period1=1000000\nloadusr -w sleep 10000000\n", timeout=2)
        end = time.monotonic() + 10
        while processes_of(place) and time.monotonic() < end:
            time.sleep(0.05)
        assert not processes_of(place)


def processes_of(place):
    """Processes that know the workplace by their environment."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if os.fsencode(place) in (process / "environ").read_bytes():
                found.append(process.name)
        except OSError:
            continue
    return found


def test_a_failing_script_is_reported_with_its_line():
    needed()
    with (
        hal_run.workplace() as place,
        pytest.raises(hal_run.HalFailed, match=r"run\.hal:1: parameter or pin 'nothing\.0' not found"),
    ):
        hal_run.run(place, "setp nothing.0 1\n")


@pytest.mark.parametrize(("fails", "speeds"), [(0, [300]), (1, [300, 30]), (2, [300, 30])])
def test_what_a_busy_machine_cannot_do_fast_is_done_once_more_slowly(tmp_path, monkeypatch, fails, speeds):
    seen = []

    def run(place, script, speed, timeout):
        seen.append(speed)
        if len(seen) <= fails:
            raise hal_run.HalFailed("busy")
        return "done"

    monkeypatch.setattr(hal_run, "run", run)
    monkeypatch.setattr(hal_run, "faketime", lambda: "there")
    if fails < 2:
        assert hal_check.ran(tmp_path, ["start"], 250_000, 10, 300) == "done"
    else:
        with pytest.raises(hal_run.HalFailed, match="busy"):
            hal_check.ran(tmp_path, ["start"], 250_000, 10, 300)
    assert seen == speeds
