"""One record of 7.5 s of a ball-screw stage, from the file a machine writes to the bristles of its friction."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.logs import read_axis_log
from leadscrew.plants._ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD
from tests.identify.friction_records import record, write_csv

UNITS = {"position": f"{1.0 / TRAVEL_MM_PER_RAD:.15g} rad", "drive": "N m"}
"""Of a file with mm of travel: the angle of the screw."""


@pytest.mark.slow
def test_a_file_with_stick_slip_gives_stiffness_and_damping_within_two_percent(tmp_path):
    """Truth: stiffness 100000 N m/rad, damping its root, of Shams and Safdari (2010)."""
    time, torque, angle = record("test")
    path = write_csv(tmp_path / "test.csv", time, torque, angle * TRAVEL_MM_PER_RAD)
    before = path.read_bytes()
    said = read_axis_log(path, units=UNITS).findings
    assert [(f.kind, f.severity) for f in said] == [("unit", "note"), ("slip", "warning")]
    assert "it did before 11 of 11" in said[1].sentence

    units = [word for role, unit in UNITS.items() for word in ("--unit", f"{role}={unit}")]
    asked = ["identify", "axis", str(path), "--model", "lugre", "--holdout", "0", *units, "--json"]
    done = CliRunner().invoke(app, asked)
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    found = {key: p["value"] for key, p in told["parameters"].items()}
    assert told["model"] == "lugre"
    assert found["friction.stiffness"] == pytest.approx(1e5, rel=0.02)
    assert found["friction.damping"] == pytest.approx(1e5**0.5, rel=0.02)
    assert found["friction.forward.static"] == pytest.approx(9.36, rel=0.02)
    assert found["friction.forward.stribeck_speed"] == pytest.approx(1e-3, rel=0.02)
    assert found["mass"] == pytest.approx(INERTIA, rel=0.02)
    assert path.read_bytes() == before
