"""The page on linear models: its log, its commands, its tables."""

import re
import runpy

import pytest
from scipy.io import loadmat
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.identify.linear.fit import identify_linear
from leadscrew.identify.linear.record import linear_record
from leadscrew.plants._xy_table import XYTableParams
from leadscrew.studies.vud_lathe.laws import TABLE_1
from tests.docs import sessions
from tests.docs.snippets import ROOT, blocks, python_of
from tests.fuzzy.formats_systems import shared
from tests.identify.test_linear import noisy_loop

PAGE = ROOT / "docs" / "identify_linear.md"
TEXT = PAGE.read_text(encoding="utf-8")
WORDS = " ".join(TEXT.split())


@pytest.mark.slow
def test_the_command_of_the_page_prints_what_it_shows_and_finds_the_truth(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "page.py").write_text(python_of(PAGE), encoding="utf-8")
    runpy.run_path("page.py")
    step = sessions.steps_of(PAGE)[0]
    done = CliRunner().invoke(app, step.command.split()[1:])
    assert done.exit_code == 0, done.output
    assert done.stderr == ""
    sessions.assert_shown(step, done.stdout)
    cells = (re.split(r"\s\s+", line) for line in step.shown)
    rows = {c[0]: [float(x.replace(",", "")) for x in c[1:4]] for c in cells if c[0] in ("b0", "a0", "a1", "delay")}
    p = XYTableParams()
    for name, value in {"b0": p.gain, "a1": p.damping, "a0": p.stiffness, "delay": 0.775e-3}.items():
        assert rows[name][1] <= value <= rows[name][2]
    again = CliRunner().invoke(app, ["simulate", "xy.toml", "-c", "ours.pid", "-s", "step"])
    assert again.exit_code == 0, again.output


@pytest.mark.slow
def test_the_numbers_of_the_noisy_loop_are_those_of_the_fit():
    t, u, y, r = noisy_loop()
    said = re.search(
        r"finds (-[\d.]+) 1/s for a pole at -30, and says \+-([\d.]+); .* it is (-[\d.]+) \+-([\d.]+)\.", WORDS
    )
    assert said is not None
    found = []
    for command in (None, r):
        fit = identify_linear(linear_record(t, u, y, command), structure=(1, 0, 0), delay=0.0, holdout=0.0)
        pole = fit.parameters["pole 1"]
        found += [pole.value, 0.5 * (pole.high - pole.low)]
    assert [float(x) for x in said.groups()] == pytest.approx(found, abs=0.15)


@pytest.mark.slow
def test_the_table_of_emps_is_what_the_fit_finds():
    data = loadmat(shared("data/emps/DATA_EMPS.mat"))
    t, volts, position = (data[name].ravel() for name in ("t", "vir", "qm"))
    fit = identify_linear(linear_record(t, volts, position), structure=(2, 0, 1))
    rows = {c[0]: c[-1] for line in TEXT.splitlines() if len(c := [x.strip() for x in line.strip("|").split("|")]) == 3}
    b0, a1 = fit.coefficients["b0"], fit.coefficients["a1"]
    newton = data["gtau"].item()
    assert rows["simulated position, training, mm"] == f"{1e3 * fit.stretches[0].rms:.2f}"
    assert rows["simulated position, hold-out, mm"] == f"{1e3 * fit.stretches[1].rms:.2f}"
    assert rows["mass, kg"] == f"{newton / b0.value:.1f}"
    assert rows["viscous, N s/m"] == f"{newton * a1.value / b0.value:.1f}"
    assert f"{newton / b0.high:.1f} to {newton / b0.low:.1f} kg" in WORDS
    axis = (ROOT / "docs" / "identify_axis.md").read_text(encoding="utf-8")
    fitted, unseen = (re.search(rf"\| drive to position, {part}, mm rms \|(.*)\|", axis) for part in
                      ("data of the fit", "validation half"))  # fmt: skip
    said = [found[1].split("|")[2].strip() for found in (fitted, unseen) if found]
    assert f"leaves {said[0]} mm there and {said[1]} mm on the validation half" in WORDS
    chosen = identify_linear(linear_record(t, volts, position))
    assert chosen.structure == (4, 2, 0)
    assert f"{1e3 * chosen.stretches[1].rms:.2f} mm on the hold-out" in WORDS


def test_the_command_of_the_lathe_prints_what_the_page_shows():
    lines = next(body for _, body in blocks(PAGE, ("text",)) if "servo-gain" in body[0])
    options = [
        "--input",
        "rho",
        "--position",
        "e",
        "--time",
        "k",
        "--split",
        "r",
        "--unit",
        "k=0.1 s",
        "--unit",
        "e=-190 mm",
    ]
    lags = ["--lag", "0.0008", "--lag", "0.0015", "--lag", "0.017"]
    assert re.sub(r"[\"\\\\]", "", " ".join(lines[:2])).split()[5:] == " ".join([*options, *lags]).split()
    done = CliRunner().invoke(app, ["identify", "servo-gain", str(TABLE_1), *options, *lags])
    assert done.exit_code == 0, done.output
    sessions.assert_shown(sessions.Step("servo-gain", [], lines[2:]), done.stdout)
