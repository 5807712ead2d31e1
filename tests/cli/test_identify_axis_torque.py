"""A drive in N m on a screw: the force is that of the lead and the gear, and nothing is fitted without them."""

import json
import math

import numpy as np
import pytest

from leadscrew import machine
from leadscrew.identify.axis.fit import identify_axis
from leadscrew.logs import axis_log, read_axis_log
from leadscrew.report import identified_axis as tables
from leadscrew.util.errors import DataError, ValueRefused

MASS, VISCOUS, STEP = 50.0, 400.0, 1e-3
LEAD, GEAR = 10.0, 2.0
FORCE = 2.0 * math.pi * 2.0 / 0.01
"""1256.6 N for 1 N m: two revolutions of the motor, 4 pi rad, move the screw by 10 mm."""


def moved():
    """Time, force and position of a mass with viscous friction, exact for a force that is held over each step."""
    t = STEP * np.arange(3000)
    force = 300.0 * np.sign(np.sin(2.0 * np.pi * 1.3 * t)) + 150.0 * np.sin(2.0 * np.pi * 0.7 * t)
    decay, rate = math.exp(-VISCOUS / MASS * STEP), VISCOUS / MASS
    x, v = np.zeros(3000), np.zeros(3000)
    for k in range(2999):
        end = force[k] / VISCOUS
        x[k + 1] = x[k] + end * STEP + (v[k] - end) * (1.0 - decay) / rate
        v[k + 1] = end + (v[k] - end) * decay
    return t, force, x


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """A log in s, N m at the motor, and mm."""
    t, force, x = moved()
    path = tmp_path_factory.mktemp("log") / "screw.csv"
    rows = np.column_stack([t, force / FORCE, 1e3 * x])
    np.savetxt(path, rows, delimiter=",", header="time,torque [N m],position [mm]", comments="", fmt="%.9g")
    return path


def identified(read, **more):
    return identify_axis(read, model="coulomb", symmetric=True, refine="none", delay=0.0, holdout=0.0, **more)


def test_a_torque_is_not_taken_for_a_force_where_the_lead_of_the_screw_is_known(log):
    found = identified(read_axis_log(log, lead_mm=LEAD, gear=GEAR))
    assert found.values["mass"] == pytest.approx(MASS, rel=1e-3) and found.parameters["mass"].unit == "kg"
    assert found.values["friction.forward.viscous"] == pytest.approx(VISCOUS, rel=1e-2)
    assert any("1 N m of the drive is 1256.64 N, by a lead of 10 mm and a gear of 2" in n for n in found.notes)


def test_the_machine_of_a_torque_keeps_the_torque_as_its_drive_and_has_the_force_of_it(log, tmp_path):
    found = identified(read_axis_log(log, lead_mm=LEAD, gear=GEAR))
    machine.write(tmp_path / "m.toml", machine.from_axis(found, "m"))
    read = machine.read(tmp_path / "m.toml")
    assert read.drive_unit == "N m" and read.drive == pytest.approx(450.0 / FORCE, rel=0.05)
    assert read.parameters["force_per_drive"] == pytest.approx(FORCE, rel=1e-12)
    parameter = json.loads(json.dumps(found.as_dict()["parameters"]["force_per_drive"]))
    assert parameter["value"] == pytest.approx(FORCE, rel=1e-12) and parameter["unit"] == "N/N m"
    text = (tmp_path / "m.toml").read_text()
    (tmp_path / "m.toml").write_text(text.replace(f"force_per_drive = {read.parameters['force_per_drive']!r}\n", ""))
    with pytest.raises(DataError, match=r"drive_unit = 'N m' with position_unit = 'mm': set\.force_per_drive must be"):
        machine.read(tmp_path / "m.toml")


def test_a_motor_constant_and_a_lead_make_the_force_of_an_ampere(log):
    read = read_axis_log(log, units={"drive": "A"}, lead_mm=LEAD, gear=GEAR, force_per_drive=0.5)
    assert read.force_per_drive == pytest.approx(0.5 * FORCE, rel=1e-12)


def test_a_torque_with_a_length_or_a_force_with_an_angle_is_refused_with_the_option_that_decides(log, call, refused):
    assert "give the lead of the screw, --lead MM (and --gear), or --force-per-drive" in refused(
        "identify", "axis", log
    )
    said = refused("identify", "axis", log, "--unit", "drive=N", "--unit", "position=rad")
    assert "the drive is a force in N, the position an angle: give --force-per-drive, N m for 1 N" in said
    assert "warning: the drive is a torque in N m, the position a length" in call("log", log).stdout
    assert "by a lead of 10 mm and a gear of 1" in call("log", log, "--lead", 10).stdout


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"lead_mm": 0.0}, "lead = 0"),
        ({"lead_mm": 10.0, "gear": -1.0}, "gear = -1"),
        ({"gear": 2.0}, "gear = 2: needs the lead"),
        ({"lead_mm": 10.0, "units": {"drive": "N"}}, "the drive is a force, so no torque is converted"),
        ({"lead_mm": 10.0, "units": {"position": "rad"}}, "the position is an angle, so no torque is converted"),
        ({"lead_mm": 10.0, "units": {"drive": "A"}}, "give --force-per-drive, the motor's N m for one unit"),
    ],
)
def test_a_lead_that_cannot_be_or_converts_nothing_is_refused(log, more, says):
    with pytest.raises(ValueRefused, match=says):
        read_axis_log(log, **more)


def test_a_machine_whose_position_has_no_noise_beyond_its_counts_has_noise_0_and_says_so(tmp_path):
    t, force, x = moved()
    found = identified(axis_log(t, force, 1e-6 * np.round(x / 1e-6)))
    machine.write(tmp_path / "m.toml", machine.from_axis(found, "m"))
    read = machine.read(tmp_path / "m.toml")
    # Third differences of the rounding of a smooth motion are no more than 1 um / sqrt(12).
    assert found.noise == pytest.approx(1e-6 / math.sqrt(12.0), rel=1e-6)
    assert read.noise == 0.0 and "noise = 0.0\n" in (tmp_path / "m.toml").read_text()
    assert read.identified["noise"] == "none beyond the rounding to steps of 0.001 mm"
    assert found.as_dict()["noise_beyond_step"] == 0.0
    rows = dict(tables.record_table(found).rows)
    assert rows["noise of the position, rms"].endswith(", none beyond the rounding to the encoder's steps")
