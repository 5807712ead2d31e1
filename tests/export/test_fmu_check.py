"""The check of an exported FMU: what it finds equal, what it finds different, what it cannot run."""

import dataclasses
import shutil
import zipfile

import numpy as np
import pytest

from leadscrew.export import fmu_check
from leadscrew.export.core import Record, expected_outputs
from leadscrew.export.verdict import DIFFERENT, FAILED, IDENTICAL, NOT_RUN
from tests.export.fmu_sample import core, exported, manifest, record
from tests.tools import needed

VERSIONS = pytest.mark.parametrize("version", [2, 3])


def importers():
    needed("fmpy", "verify")
    needed("ecospy", "verify")


def verdicts(folder, of):
    return {v.target.split(" ", 1)[1]: v for v in fmu_check.check(folder, manifest(of))}


@VERSIONS
@pytest.mark.parametrize("real", ["double", pytest.param("float", marks=pytest.mark.slow)])
def test_both_importers_give_the_golden_bits(version, real, tmp_path):
    importers()
    of = core(real)
    found = verdicts(exported(tmp_path, of, version, record(3000, real)), of)
    assert list(found) == ["FMPy", "FMPy, compiled from its own sources", "ecos"]
    assert [(v.verdict, v.cycles, v.worst) for v in found.values()] == [(IDENTICAL, 3000, 0.0)] * 3
    assert all(v.target.startswith(f"fmu{version} ") for v in found.values())
    assert "0.3." in found["FMPy"].note


@pytest.mark.slow
@VERSIONS
def test_a_knob_one_ulp_off_is_different_in_every_importer(version, tmp_path):
    importers()
    other = core(KP=float(np.nextafter(0.25, 1.0)))
    found = verdicts(exported(tmp_path, other, version, record()), other)
    assert {v.verdict for v in found.values()} == {DIFFERENT}
    assert all(0 < v.worst < 1e-12 for v in found.values())


@pytest.mark.slow
def test_a_forgotten_sign_or_limit_is_different(tmp_path):
    importers()
    of = core()
    folder = exported(tmp_path, of, 2, record())
    wrong = {**manifest(of), "sense": 1}
    assert fmu_check.check(folder, wrong)[0].verdict == DIFFERENT
    free = {**manifest(of), "limits": {"max_output": 0.0}}
    assert fmu_check.check(folder, free)[0].verdict == DIFFERENT


def test_a_fault_in_the_golden_run_is_told(tmp_path):
    importers()
    of = dataclasses.replace(core(), limits=dataclasses.replace(core().limits, max_error=0.5))
    from leadscrew.export.machine import machine_files

    of.files.update(machine_files(of))
    found = verdicts(exported(tmp_path, of, 3, record()), of)
    assert {v.verdict for v in found.values()} == {DIFFERENT}
    assert all("fault_code 2" in v.note for v in found.values())


def test_a_unit_without_a_binary_is_compiled_and_otherwise_not_run(tmp_path):
    importers()
    of = core()
    found = verdicts(exported(tmp_path, of, 3, record(100), compiler=None), of)
    assert found["FMPy"].verdict == found["ecos"].verdict == NOT_RUN
    assert "sources only" in found["ecos"].note
    assert found["FMPy, compiled from its own sources"].verdict == IDENTICAL


def test_a_missing_importer_is_told(tmp_path, monkeypatch):
    of = core()
    folder = exported(tmp_path, of, 2, record(10))
    monkeypatch.setattr(fmu_check.importlib.util, "find_spec", lambda name: None)
    found = fmu_check.check(folder, manifest(of))
    assert {v.verdict for v in found} == {NOT_RUN}
    assert found[0].note == "fmpy is not installed: pip install leadscrew[verify]"


def test_a_binary_that_crashes_does_not_take_us_along(tmp_path):
    importers()
    crashing = core()
    source = crashing.files["sample.c"].replace("s->last_error = error;", "s->last_error = error; abort();")
    crashing.files["sample.c"] = "#include <stdlib.h>\n" + source
    found = verdicts(exported(tmp_path, crashing, 2, record(10)), crashing)
    assert {v.verdict for v in found.values()} == {FAILED}
    assert "signal 6" in found["FMPy"].note


def test_a_refused_step_is_a_failure_with_the_reason(tmp_path):
    importers()
    of = core()
    folder = exported(tmp_path, of, 2, record(10))
    found = fmu_check.check(folder, {**manifest(of), "period_s": 0.0015})
    assert [v.verdict for v in found] == [FAILED, FAILED, DIFFERENT], "ecos goes on after a refused step"
    assert "0.0015 s is not a whole multiple of the control period of 0.001 s" in found[0].note


def test_findings_of_the_validation_are_a_failure(tmp_path):
    importers()
    of = core()
    folder = exported(tmp_path, of, 2, record(10))
    bad = tmp_path / "bad.fmu"
    with zipfile.ZipFile(folder / "sample.fmu") as good, zipfile.ZipFile(bad, "w") as into:
        for name in good.namelist():
            into.writestr(name, good.read(name).replace(b'<Unit name="mm">', b'<Unit name="inch">'))
    shutil.move(bad, folder / "sample.fmu")
    assert fmu_check.check(folder, manifest(of))[0].verdict == FAILED


def test_what_is_no_unit_is_a_failure(tmp_path):
    of = core()
    (tmp_path / "sample.fmu").write_text("no zip")
    assert fmu_check.check(tmp_path, manifest(of))[0].verdict == FAILED
    (tmp_path / "sample.fmu").unlink()
    assert "No such file" in fmu_check.check(tmp_path, manifest(of))[0].note


def test_expected_outputs_agree_with_the_core():
    run = Record(np.zeros((4, 3)), np.array([[0.5], [-2.0], [0.0], [7.0]]))
    of = core()
    assert expected_outputs(manifest(of), run.outputs).tolist() == of.machine_outputs(run).tolist()
