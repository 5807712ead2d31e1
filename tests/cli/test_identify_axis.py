"""``leadscrew identify axis``: what it prints and writes, what it hands to the fit, and what it refuses."""

import json

import numpy as np
import pytest

from leadscrew.identify.axis import fit as fitter
from leadscrew.machine.file import read
from leadscrew.report import identified_axis as page
from tests.cli.conftest import strict_json
from tests.report.axis_fits import made_up, stretch

NAME = ("identify", "axis")


@pytest.fixture
def log(tmp_path):
    """A log of a second, back and forth; ``qm`` in mm without its unit."""
    t = 1e-3 * np.arange(1001)
    q = 30.0 * np.sin(2.0 * np.pi * t)
    table = np.column_stack([t, np.sin(2.0 * np.pi * t + 0.3), q])
    path = tmp_path / "stage.csv"
    np.savetxt(path, table, delimiter=",", header="time (s),drive (V),qm", comments="", fmt="%.9g")
    return path


@pytest.fixture
def fitted(monkeypatch):
    """The fit is made up; what the command asked of it is kept."""
    asked = {}

    def identify(log, *, progress=None, **options):
        asked.update(options, log=log)
        progress("fitting", 0.5)
        return made_up(judged=[stretch("training", 0.0, 1.6e-5, samples=400), stretch(samples=400)])

    monkeypatch.setattr(fitter, "identify_axis", identify)
    return asked


def test_tables_and_sentences_are_printed_and_the_log_is_in_si(call, log, fitted):
    said = call(*NAME, log, "--column", "position=qm", "--unit", "position=mm")
    lines = said.stdout.splitlines()
    assert any(x.split()[:5] == ["mass", "20", "19.9", "20.1", "kg"] for x in lines)
    assert any(x.startswith("hold-out") and "20 µm" in x for x in lines)
    assert "that is 1.25 times the error on the data of the fit" in lines
    assert "to measure next: move faster backwards" in lines
    assert "leadscrew: note: the drive stands at its limit in 3 samples" in said.stderr
    assert np.ptp(fitted["log"].position) == pytest.approx(0.06, rel=1e-3)
    assert fitted["log"].unit == ("m", "V")
    assert {k: v for k, v in fitted.items() if k != "log"} == {
        "symmetric": None, "model": "auto", "holdout": 0.5, "delay": None, "refine": "auto", "given": {},
        "cascade": None,
    }  # fmt: skip


def test_every_option_reaches_the_fit(call, log, fitted):
    call(*NAME, log, "--column", "position=qm", "--unit", "position=mm", "--by-direction", "--model", "coulomb",
         "--holdout", 0.3, "--delay", 0.002, "--given", "mass=95.1", "--given", "friction.forward.viscous=200",
         "--refine", "none", "--cascade", "kp=160.18,kv=243.45,over=2", "--force-per-drive", 35.15, "--start", 0.1,
         "--end", 0.9)  # fmt: skip
    assert fitted["symmetric"] is False and fitted["model"] == "coulomb" and fitted["holdout"] == 0.3
    assert fitted["delay"] == 0.002 and fitted["refine"] == "none"
    assert fitted["given"] == {"mass": 95.1, "friction.forward.viscous": 200.0}
    assert (fitted["cascade"].kp, fitted["cascade"].kv, fitted["cascade"].over) == (160.18, 243.45, 2)
    assert fitted["log"].force_per_drive == 35.15
    assert (fitted["log"].time[0], fitted["log"].time[-1]) == pytest.approx((0.1, 0.9))


def test_a_log_without_times_takes_its_period_from_the_option(call, tmp_path, log, fitted):
    rows = [line.split(",", 1)[1] for line in log.read_text(encoding="utf-8").splitlines()]
    bare = tmp_path / "bare.csv"
    bare.write_text("\n".join(rows) + "\n", encoding="utf-8")
    call(*NAME, bare, "--column", "position=qm", "--unit", "position=mm", "--period", 0.002)
    assert fitted["log"].period == pytest.approx(0.002)


def test_machine_file_and_report_hold_what_was_found(call, log, fitted, tmp_path, monkeypatch):
    monkeypatch.setattr(page, "pictures", lambda fit: {})  # they have tests of their own, and take seconds
    out, report = tmp_path / "axis.toml", tmp_path / "report"
    said = call(*NAME, log, "--column", "position=qm", "--unit", "position=mm", "-o", out, "--report", report,
                "--cascade", "kp=40,kv=400,ki=3")  # fmt: skip
    machine = read(out)
    assert machine.name == "axis" and machine.parameters["mass"] == 20.0 and machine.drive_unit == "V"
    assert dict(machine.cascade) == pytest.approx({"kp": 40.0, "kv": 0.4, "ki": 1.2}), "mm; ki is that of the drive"
    assert dict(read(report / "axis.toml").parameters) == dict(machine.parameters)
    assert json.loads((report / "axis.json").read_text(encoding="utf-8"))["kind"] == "leadscrew identify axis"
    assert f"{out}: the machine; next: leadscrew simulate {out} -c ours.cascade_model -s move" in said.stdout
    assert f"{report}: the report: report.html" in said.stdout


def test_json_is_one_object_with_the_findings_of_the_log(call, log, fitted):
    log.write_text(log.read_text(encoding="utf-8").replace("drive (V)", "drive"), encoding="utf-8")
    found = strict_json(call(*NAME, log, "--column", "position=qm", "--unit", "position=mm", "--json").stdout)
    assert found["schema_version"] == 1 and found["parameters"]["mass"]["value"] == 20.0
    assert found["judged"][1]["what"] == "hold-out" and found["out"] is None
    assert any("'drive' names no unit" in f["sentence"] and f["severity"] == "note" for f in found["findings"])


def test_what_cannot_be_is_refused_before_the_log_is_read(refused, tmp_path):
    nothing = tmp_path / "nothing.csv"
    assert "--model 'karnopp': allowed are auto" in refused(*NAME, nothing, "--model", "karnopp").replace(" = ", " ")
    assert "--holdout 0.9: allowed range is [0, 0.8]" in refused(*NAME, nothing, "--holdout", 0.9)
    assert "ends in .toml" in refused(*NAME, nothing, "-o", tmp_path / "axis.json")
    assert "--given mass=heavy: expected a number" in refused(*NAME, nothing, "--given", "mass=heavy")
    assert "--given 'mass': expected KEY=VALUE" in refused(*NAME, nothing, "--given", "mass")
    assert "--column position: given twice" in refused(*NAME, nothing, "--column", "position=a", "--column",
                                                       "position=b")  # fmt: skip
    assert "expected kp=X,kv=Y" in refused(*NAME, nothing, "--cascade", "kp=3")
    assert "--cascade kv = -1: must have the sign" in refused(*NAME, nothing, "--cascade", "kp=3,kv=-1")
    there = tmp_path / "axis.toml"
    there.write_text("mine", encoding="utf-8")
    assert "exists already" in refused(*NAME, nothing, "-o", there)
    assert there.read_text(encoding="utf-8") == "mine"
    assert "nothing.csv" in refused(*NAME, nothing)


def test_a_refused_log_is_one_sentence_and_exit_2(refused, tmp_path):
    still = tmp_path / "still.csv"
    rows = "\n".join(f"{k / 1000},0.1,5" for k in range(500))
    still.write_text(f"time (s),drive (V),position (mm)\n{rows}\n", encoding="utf-8")
    assert str(still) in refused(*NAME, still)
