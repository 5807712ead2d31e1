"""``leadscrew identify friction``: what it prints and writes, and what it refuses with nothing written."""

import math

import pytest

from leadscrew import controller_file, resolve
from leadscrew.friction.lugre import LuGre
from leadscrew.identify import friction_file
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from tests.cli.conftest import strict_json
from tests.identify.friction_records import record, write_csv


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """The sines, as a machine with a scale in rad logs them."""
    return write_csv(tmp_path_factory.mktemp("log") / "sines.csv", *record("sines"))


@pytest.mark.slow
def test_the_table_shows_values_errors_and_what_is_not_identifiable(call, log):
    said = call("identify", "friction", log).stdout
    rows = {line.split()[0]: line for line in said.splitlines() if line[:1].isalpha()}
    assert "N m/rad" in rows["stiffness"] and "%" in rows["stiffness"]
    assert "not identifiable" in rows["static"] and "not identifiable" not in rows["coulomb"]
    assert "not identifiable from this log: static, stribeck_speed" in said


def test_json_and_controller_file_hold_the_same_values(call, log, tmp_path):
    out = tmp_path / "stage.toml"
    found = strict_json(call("identify", "friction", log, "-o", out, "--json").stdout)
    assert found["schema_version"] == 1 and found["out"] == str(out)
    block = resolve.from_controller_file(out)
    own = CONTROLLERS["ours.pd_dob"].params.hat
    for name, entry in found["parameters"].items():
        value = entry["value"] if entry["identifiable"] else getattr(own, name)
        assert getattr(block.params.hat, name) == value
    assert not found["parameters"]["stribeck_speed"]["identifiable"]
    assert abs(found["parameters"]["coulomb"]["value"] / LuGre().coulomb - 1.0) < 1e-3
    assert block.params.inertia == found["inertia"]["value"]
    read = controller_file.read(out)
    assert (read.study, read.controller) == ("fsmc_ballscrew", "ours.pd_dob")
    assert "not identifiable from the log, so the controller's own: static, stribeck_speed" in read.tuning["notes"]
    assert not {"hat.static", "hat.stribeck_speed"} & set(read.parameters)


@pytest.mark.slow
def test_simulate_takes_the_file(call, log, tmp_path):
    out = tmp_path / "stage.toml"
    call("identify", "friction", log, "-o", out)
    args = ["fsmc_ballscrew", "-s", "sine_fast", "--duration", 2.5, "--json"]
    own = strict_json(call("simulate", *args, "-c", out).stdout)["metrics"]["max_error"]
    before = strict_json(call("simulate", *args, "-c", "ours.pd_dob").stdout)["metrics"]["max_error"]
    assert own < before


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (["--torque", "feedback", "--position", "output"], "backwards|swapped|Coulomb"),
        (["--torque", "torqe"], "has no column 'torqe'"),
        (["--torque", "feedback"], "expected three columns"),
        (["--travel-per-rad", 0], "travel_per_rad = 0"),
        (["--inertia", -1], "inertia = -1"),
        pytest.param(["-c", "ours.pid"], "believes no LuGre friction|has no controller", marks=pytest.mark.slow),
    ],
)
def test_what_is_refused_leaves_no_file_and_no_traceback(call, log, tmp_path, more, says):
    import re

    out = tmp_path / "stage.toml"
    done = call("identify", "friction", log, "-o", out, *more, code=2)
    assert re.search(says, done.output) and "Traceback" not in done.output
    assert not out.exists() and not list(tmp_path.iterdir())


def test_a_file_that_is_there_is_not_overwritten(call, log, tmp_path):
    out = tmp_path / "stage.toml"
    out.write_text("mine", encoding="utf-8")
    call("identify", "friction", log, "-o", out, code=2)
    assert out.read_text(encoding="utf-8") == "mine"


@pytest.mark.slow
def test_the_folder_of_a_run_brings_its_own_unit(call, tmp_path):
    """The study's table moves in mm: taken for radians, the friction would be that of another stage."""
    folder = tmp_path / "test"
    asked = ("simulate", "fsmc_ballscrew", "-c", "ours.pd_test", "-s", "friction_test", "--out", str(folder))
    call(*asked)
    found = strict_json(call("identify", "friction", folder, "--json").stdout)["parameters"]
    assert found["stiffness"]["value"] == pytest.approx(1e5, rel=0.01)
    assert found["static"]["value"] == pytest.approx(9.36, rel=0.01)


def test_times_torques_and_angles_are_read_in_the_units_of_their_headers(tmp_path, monkeypatch):
    taken = {}
    monkeypatch.setattr(friction_file, "fit_friction", lambda t, u, q, **more: taken.update(t=t, u=u, q=q))
    rows = "\n".join(f"{k},{100 * k},{90 * k}" for k in range(5))
    (tmp_path / "log.csv").write_text("time [ms],torque [N mm],angle [deg]\n" + rows)
    friction_file.identify_file(tmp_path / "log.csv", torque="torque", position="angle")
    for name, step in (("t", 1e-3), ("u", 0.1), ("q", math.pi / 2)):
        assert taken[name].tolist() == pytest.approx([step * k for k in range(5)])


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ("time,output [N],feedback [rad]", "'output [N]': is in N; expected a torque in N m; for a force use"),
        ("time,output [A],feedback [rad]", "'output [A]': is in A; expected a torque in N m"),
        ("time,output [Nm],feedback [mm]", "'feedback [mm]': is in mm; expected an angle, or --travel-per-rad, mm for"),
        ("time [mm],output,feedback", "'time [mm]': 'mm' is no unit of time"),
    ],
)
def test_a_force_or_a_length_is_not_taken_for_a_torque_or_an_angle(refused, tmp_path, header, says):
    (tmp_path / "log.csv").write_text(header + "\n" + "\n".join(f"{k / 1000},{k % 7},{k % 5}" for k in range(99)))
    assert says in refused("identify", "friction", tmp_path / "log.csv")
