"""``leadscrew identify friction-force`` as it is typed."""

from __future__ import annotations

import json
import tomllib

import numpy as np
import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.identify.friction_force import force_record, identify_friction_force
from tests.identify.friction_force_logs import log


def typed(*words):
    return CliRunner().invoke(app, ["identify", *map(str, words)])


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    t, x, force = log(noise=0.01, strokes=((0.2e-3, 0.8), (0.05e-3, 0.2), (0.4e-3, 0.4)))
    path = tmp_path_factory.mktemp("log") / "contact.csv"
    np.savetxt(path, np.column_stack([t, 1e3 * x, 1e3 * force, 2.0 * force]), delimiter=",",
               header="t [s],pos [mm],friction [mN],torque [V]", comments="")  # fmt: skip
    return path


@pytest.mark.slow
def test_a_report_is_written_and_the_same_is_printed(file, tmp_path):
    done = typed("friction-force", file, "--out", tmp_path / "out", "--json")
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert found["schema_version"] == 1 and found["training_samples"] == found["samples"] - found["samples"] // 2
    lugre = next(m for m in found["models"] if m["name"] == "LuGre")
    assert lugre["parameters"]["friction.forward.coulomb"]["value"] == pytest.approx(3.0, rel=0.01)
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == [
        "friction.toml", "friction_force.json", "friction_force.png", "report.html",
    ]  # fmt: skip
    values = tomllib.loads((tmp_path / "out" / "friction.toml").read_text(encoding="utf-8"))["set"]["plant"]["friction"]
    assert values["stiffness"] == pytest.approx(lugre["parameters"]["friction.stiffness"]["value"], rel=1e-6)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "Maxwell slip" in page and "http" not in page.replace("http://www.w3.org", "")
    again = typed("friction-force", file, "--out", tmp_path / "out")
    assert again.exit_code == 2 and "exists already" in again.stderr


@pytest.mark.slow
def test_identify_friction_with_a_measured_force_is_the_same(file):
    one = typed("friction-force", file, "--holdout", 0.5, "--json")
    two = typed("friction", file, "--force", "friction", "--position", "pos", "--time", "t", "--json")
    assert one.exit_code == two.exit_code == 0, two.output
    assert json.loads(one.stdout) == json.loads(two.stdout)


@pytest.mark.slow
def test_units_of_the_header_and_units_told_are_the_same(file, tmp_path):
    text = file.read_text(encoding="utf-8")
    plain = tmp_path / "plain.csv"
    plain.write_text(text.replace(" [mm]", "").replace(" [mN]", ""), encoding="utf-8")
    told = typed("friction-force", plain, "--unit", "force=mN", "--unit", "position=mm", "--json")
    known = json.loads(typed("friction-force", file, "--json").stdout)
    assert json.loads(told.stdout)["models"] == known["models"]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--force", "torque"], "is in V; a friction force is in N or N m"),
        (["--force", "pos"], "is no unit of the drive"),
        (["--force", "nowhere"], "has no column 'nowhere'"),
        (["--unit", "force"], "expected ROLE=UNIT"),
        (["--unit", "lorce=N"], "lorce = 'N': allowed are"),
        (["--sign", "2"], "--sign 2: allowed are auto, 1 and -1"),
        (["--holdout", "1"], "allowed range is [0, 0.8]"),
        (["--load", "coefficient"], "has no normal force"),
        (["--start", "1000"], "nothing of it lies from 1000"),
        (["--example"], "exists already; --example overwrites nothing"),
    ],
)
def test_what_is_refused_is_said_in_one_sentence(file, words, sentence):
    done = typed("friction-force", file, *words)
    assert done.exit_code == 2 and sentence in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_options_of_a_measured_force_need_one(file):
    done = typed("friction", file, "--normal", "x")
    assert done.exit_code == 2 and "go with --force" in done.stderr


@pytest.mark.slow
def test_the_example_has_the_friction_that_it_says(tmp_path):
    from leadscrew.identify.friction_force.example import COUNT, NOISE, TRUTH, example_arrays, example_text

    done = typed("friction-force", tmp_path / "made.csv", "--example")
    assert done.exit_code == 0 and (tmp_path / "made.csv").read_text(encoding="utf-8") == example_text()
    assert f"stiffness {TRUTH.stiffness:g} N/m" in example_text()
    t, x, force = example_arrays()
    assert np.abs(x / COUNT - np.round(x / COUNT)).max() < 1e-6
    fit = identify_friction_force(force_record(t, force, position=x))
    assert fit.chosen.holdout_rms == pytest.approx(NOISE, rel=0.1)
    assert fit.chosen.friction.stiffness == pytest.approx(TRUTH.stiffness, rel=0.005)
    assert fit.chosen.friction.damping == pytest.approx(TRUTH.damping, rel=0.05)
