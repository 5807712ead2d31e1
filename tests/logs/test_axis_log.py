"""The log of an axis: roles and units as they stand in the file or as told, in SI; the user's data stay as they are."""

import csv
import hashlib

import numpy as np
import pytest

from leadscrew.logs import axis_log, look_at, read_axis_log, read_table
from leadscrew.logs.roles import role_of, roles
from leadscrew.logs.text import table_of
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused
from tests.logs.records import arrays, moves

TIME, DRIVE, POSITION, COMMAND = moves()


def save(path, **columns):
    with path.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(columns)
        out.writerows(zip(*([repr(float(x)) for x in values] for values in columns.values()), strict=True))
    return path


NAMES = {
    "time": ["t", "Time", "Time [s]", "time_s", "Timestamp", "TIME (ms)", "Zeit [s]"],
    "position": ["pos", "qm", "feedback", "X1_ActualPosition", "joint.0.motor-pos-fb", "Actual Position [mm]", "ActPos",
                 "actual.position", "Encoder", "log.pos", "Lage_mm"],
    "drive": ["u", "vir", "torque_cmd", "output", "X1_CurrentFeedback", "motor current (A)", "pid.0.output",
              "MotorTorque", "Force [N]", "log.u"],
    "command": ["qg", "cmd", "X1_CommandPosition", "joint.0.motor-pos-cmd", "reference", "Setpoint [mm]", "command",
                "command.position", "Sollposition"],
    "velocity": ["vel", "X1_ActualVelocity", "speed [mm/s]", "v", "joint.0.vel-fb"],
    "": ["X1_ActualAcceleration", "X1_CommandVelocity", "error", "Machining_Process", "X1_OutputPower", "Normal [uN]",
         "following_error", "c1", "true_error"],
}  # fmt: skip


@pytest.mark.parametrize(("role", "name"), [(role, name) for role, names in NAMES.items() for name in names])
def test_a_column_is_known_by_its_name(role, name):
    assert (role_of(name) or ("", 0))[0] == role


def test_where_no_name_says_it_the_only_column_with_such_a_unit_is_taken():
    rows = "0,1,2,5\n1,2,1,5\n2,2,3,5\n"
    found = {"time": "t (s)", "position": "x (mm)", "drive": "F (N)"}
    assert roles(table_of("t (s),x (mm),F (N),bore (mm)\n" + rows, "x")) == found
    with pytest.raises(DataError, match=r"2 columns could be the position: x \(mm\), z \(mm\); name it"):
        roles(table_of("t (s),x (mm),z (mm),F (N)\n" + "0,1,2,5\n1,2,1,6\n2,2,3,5\n", "x"))
    with pytest.raises(DataError, match="no column is the position by its name"):
        roles(table_of("t (s),u (V),error (mm)\n" + "0,1,2\n1,2,1\n2,2,3\n", "x"))


def test_a_table_without_a_header_is_asked_for_all_its_columns_at_once(tmp_path):
    """As halsampler -t writes it: number of the sample, command, position, drive."""
    command = 1e3 * COMMAND
    table = np.column_stack([np.arange(len(TIME)) + 1, command, 1e3 * POSITION, DRIVE])
    np.savetxt(tmp_path / "a.txt", table, fmt="%.6f")
    with pytest.raises(DataError, match="no header names the columns c1, c2, c3, c4: name them") as error:
        read_axis_log(tmp_path / "a.txt")
    told = "--column time=c1 --unit 'time=0.001 s' --column position=c2 --column drive=c4"
    assert str(error.value).endswith(told)


def test_counts_are_not_taken_as_metres_and_a_torque_in_nm_keeps_its_unit(tmp_path):
    path = save(tmp_path / "a.csv", time=TIME, torque_Nm=DRIVE, encoder_counts=np.round(POSITION / 1e-6))
    with pytest.raises(ValueRefused, match=r"column 'encoder_counts': position in counts: .* --unit position='5e-8 m'"):
        read_axis_log(path)
    found = read_axis_log(path, units={"position": "1e-6 rad"})
    assert found.unit == ("rad", "N m") and found.position[-1] == pytest.approx(POSITION[-1])


def test_what_is_ambiguous_or_missing_is_refused_with_the_candidates():
    table = table_of("t,x_pos,y_pos,u\n" + "0,1,2,3\n" * 3, "a.csv")
    with pytest.raises(
        DataError, match=r"a\.csv: 2 columns could be the position: x_pos, y_pos; name it, .*position=x_pos"
    ):
        roles(table)
    assert roles(table, {"position": "y_pos"}) == {"time": "t", "drive": "u", "position": "y_pos"}
    with pytest.raises(DataError, match="no column is the drive by its name; there are t, q; name it"):
        roles(table_of("t,q\n" + "0,1\n" * 3, "x"))
    # What is proposed could be it: neither the times nor what is known to be something else.
    with pytest.raises(DataError, match=r"no column is the position by its name; .* --column position=w"):
        roles(table_of("t,v,w,u\n" + "0,1,0,2\n1,0,3,1\n2,1,1,4\n", "x"))
    with pytest.raises(ValueRefused, match="column 'u' is named for drive and velocity"):
        roles(table, {"position": "x_pos", "drive": "u", "velocity": "u"})
    with pytest.raises(NameUnknown, match="has no column 'posx'"):
        roles(table, {"position": "posx"})
    with pytest.raises(ValueRefused, match="role = 'force': allowed are time, drive"):
        roles(table, {"force": "u"})


def test_one_axis_named_chooses_the_other_columns_of_that_axis():
    names = [f"{a}1_{n}" for a in "XY" for n in ("ActualPosition", "CommandPosition", "CurrentFeedback")]
    table = table_of(",".join(names) + "\n" + ",".join("123456") + "\n7,8,9,1,2,3\n", "x")
    found = roles(table, {"position": "Y1_ActualPosition"}, timed=False)
    assert found == {"position": "Y1_ActualPosition", "command": "Y1_CommandPosition", "drive": "Y1_CurrentFeedback"}


UNITS = {
    "m": 1.0, "mm": 1e3, "um": 1e6, "\u00b5m": 1e6, "in": 1.0 / 0.0254, "5e-8 m": 2e7, "0.5 mm": 2e3,
}  # fmt: skip


@pytest.mark.parametrize("unit", UNITS)
def test_every_unit_of_position_is_the_same_length(unit):
    size = UNITS[unit]
    found = axis_log(TIME, DRIVE, size * POSITION, size * COMMAND, position_unit=unit)
    np.testing.assert_allclose(found.position, POSITION, rtol=1e-12, atol=1e-15)
    assert found.command is not None
    np.testing.assert_allclose(found.command, COMMAND, rtol=1e-12, atol=1e-15)


def test_angles_turns_and_drives_come_to_rad_and_to_their_own_unit():
    for unit, size in (("rad", 1.0), ("deg", 180.0 / np.pi), ("rev", 0.5 / np.pi), ("\u00b0", 180.0 / np.pi)):
        found = axis_log(TIME, DRIVE, size * POSITION, position_unit=unit, drive_unit="Nm")
        np.testing.assert_allclose(found.position, POSITION, rtol=1e-12, atol=1e-15)
        assert found.unit == ("rad", "N m")
    for unit, kept, size in (
        ("kN", "N", 1e-3),
        ("%", "1", 100.0),
        ("mV", "V", 1e3),
        ("A", "A", 1.0),
        ("10 V", "V", 0.1),
    ):
        found = axis_log(TIME, size * DRIVE, POSITION, drive_unit=unit)
        np.testing.assert_allclose(found.drive, DRIVE, rtol=1e-12)
        assert found.unit.drive == kept


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({"position_unit": "furlong"}, "'furlong' is no unit of position; known are m, cm, mm"),
        ({"position_unit": "counts"}, "give the size of one count as its unit"),
        ({"drive_unit": "mm"}, "'mm' is no unit of the drive"),
        ({"position_unit": "0 mm"}, "factor of a unit must be a finite number other than 0"),
    ],
)
def test_a_unit_that_is_not_known_is_refused(told, said):
    with pytest.raises(ValueRefused, match=said):
        axis_log(TIME, DRIVE, POSITION, **told)


def test_units_come_from_the_header_and_what_is_told_goes_first(tmp_path):
    path = save(tmp_path / "a.csv", **{"t [ms]": 1e3 * TIME, "pos [mm]": 1e3 * POSITION, "u_kN": DRIVE / 1e3})
    found = read_axis_log(path)
    np.testing.assert_allclose(found.position, POSITION, atol=1e-15)
    np.testing.assert_allclose(found.drive, DRIVE, rtol=1e-12)
    assert found.findings == [] and found.unit == ("m", "N") and found.source == str(path)
    with pytest.raises(DataError, match="unit is wrong"):
        read_axis_log(path, units={"position": "m"})
    with pytest.raises(ValueRefused, match="the log has no velocity"):
        read_axis_log(path, units={"velocity": "m/s"})
    with pytest.raises(ValueRefused, match=r"a\.csv, column 'pos \[mm\]': 'V' is no unit of position"):
        read_axis_log(path, units={"position": "V"})


def test_units_that_nobody_names_are_si_and_the_log_says_so(tmp_path):
    path = save(tmp_path / "a.csv", t=TIME, pos=POSITION, tau_m=DRIVE, vel_fb=np.gradient(POSITION, 1e-3))
    found = read_axis_log(path)
    assert [f.severity for f in found.findings] == ["note"] * 3 and found.unit == ("m", "1")
    assert found.findings[1].sentence.startswith("column 'tau_m' names no unit: taken as its own unit")
    np.testing.assert_array_equal(found.velocity, np.gradient(POSITION, 1e-3))


def test_velocity_and_command_may_have_units_of_their_own(tmp_path):
    rate = np.gradient(POSITION, 1e-3)
    path = save(
        tmp_path / "a.csv", **{"t": TIME, "pos": 1e3 * POSITION, "u": DRIVE, "v [m/min]": 60.0 * rate, "ref": COMMAND}
    )
    found = read_axis_log(path, units={"position": "mm", "command": "m"})
    np.testing.assert_allclose(found.velocity, rate, atol=1e-12)
    np.testing.assert_allclose(found.command, COMMAND, atol=1e-15)
    with pytest.raises(ValueRefused, match="position is in mm, the velocity in rpm"):
        read_axis_log(path, units={"position": "mm", "command": "m", "velocity": "rpm"})


def test_a_file_without_times_needs_a_period(tmp_path):
    path = save(tmp_path / "a.csv", pos=POSITION, u=DRIVE)
    with pytest.raises(DataError, match=r"no column of times and names no period; say --period"):
        read_axis_log(path)
    assert read_axis_log(path, period=1e-3).time[-1] == pytest.approx(2.999)
    with pytest.raises(ValueRefused, match=r"period = -1\.0"):
        read_axis_log(path, period=-1.0)


def test_dates_serve_as_times(tmp_path):
    stamps = np.datetime64("2024-05-01T12:00:00", "us") + np.arange(500) * np.timedelta64(1000, "us")
    rows = [
        f"{str(s).replace('T', ' ')},{x!r},{u!r}"
        for s, x, u in zip(stamps, POSITION.tolist(), DRIVE.tolist(), strict=False)
    ]
    (tmp_path / "a.csv").write_text("when,pos,u\n" + "\n".join(rows))
    found = read_axis_log(tmp_path / "a.csv", {"time": "when"})
    assert found.period == pytest.approx(1e-3) and found.time[0] == 0.0
    with pytest.raises(DataError, match="column 'when': holds words such as '2024-05-01 12:00:00"):
        read_axis_log(tmp_path / "a.csv", {"time": "pos", "position": "when"})


def test_a_part_of_the_time_is_taken_and_a_part_without_the_fault_passes(tmp_path):
    broken = POSITION + np.where(TIME >= 1.0, 5e-4, 0.0)
    path = save(tmp_path / "a.csv", **{"t [s]": TIME, "pos [m]": broken, "u [N]": DRIVE})
    with pytest.raises(
        DataError, match=r"a\.csv: the position jumps once, .* at row 1002 \(1 s\).* --start 1 --end 2\.999"
    ):
        read_axis_log(path)
    found = read_axis_log(path, start=1.0, end=2.0)
    assert found.time[[0, -1]] == pytest.approx([1.0, 2.0]) and found.source.endswith("a.csv from 1 to 2 s")
    assert found.part(1.2, 1.3).time[[0, -1]] == pytest.approx([1.2, 1.3])
    with pytest.raises(DataError, match="fewer than three samples"):
        found.part(5.0)
    with pytest.raises(DataError, match=r"nothing of it lies from 7 to 2\.999 s"):
        read_axis_log(path, start=7.0)


def test_rows_are_named_as_an_editor_counts_them(tmp_path):
    path = save(tmp_path / "a.csv", **{"t [s]": TIME, "pos [m]": POSITION, "u [N]": DRIVE})
    lines = path.read_text().splitlines()
    cells = lines[100].split(",")
    lines[100] = f"{cells[0]},,{cells[2]}"
    path.write_text("# a comment\n\n" + "\n".join(lines))
    with pytest.raises(DataError, match=r"row 103: the position is empty or no number"):
        read_axis_log(path)
    assert read_axis_log(path, start=0.2).findings == []


def test_neither_the_file_nor_the_arrays_are_changed(tmp_path):
    given = {role: values.copy() for role, values in arrays().items()}
    held = {role: values.copy() for role, values in given.items()}
    found = axis_log(**given, position_unit="m")
    for role, values in given.items():
        np.testing.assert_array_equal(values, held[role])
        assert not np.shares_memory(values, getattr(found, role))
        with pytest.raises(ValueError, match="read-only"):
            getattr(found, role)[0] = 1.0
    path = save(tmp_path / "a.csv", t=TIME, pos=POSITION, u=DRIVE)
    before = hashlib.sha256(path.read_bytes()).hexdigest()
    table = read_table(path)
    kept = {name: values.copy() for name, values in table.columns.items()}
    look_at(path, units={"position": "mm"}, table=table)
    assert hashlib.sha256(path.read_bytes()).hexdigest() == before
    for name, values in kept.items():
        np.testing.assert_array_equal(table.columns[name], values)


def test_arrays_that_do_not_fit_are_refused():
    with pytest.raises(DataError, match="expected arrays of one length, not time 3000, drive 3000, position 2999"):
        axis_log(TIME, DRIVE, POSITION[1:])
    with pytest.raises(DataError, match=r"drive has the shape \(3000, 2\)"):
        axis_log(TIME, np.column_stack([DRIVE, DRIVE]), POSITION)
    with pytest.raises(DataError, match="position is not an array of numbers"):
        axis_log(TIME, DRIVE, ["a"] * 3000)
    assert len(axis_log(TIME[:, None], DRIVE[None, :], POSITION.tolist()).time) == 3000


def test_the_force_of_the_drive_is_kept_and_the_drive_stays_in_volts(tmp_path):
    path = save(tmp_path / "a.csv", **{"t [s]": TIME, "pos [m]": POSITION, "u [V]": DRIVE / 35.0})
    found = read_axis_log(path, force_per_drive=35.0)
    assert found.force_per_drive == 35.0 and found.unit.drive == "V"
    np.testing.assert_allclose(found.drive, DRIVE / 35.0, rtol=1e-15)
    with pytest.raises(ValueRefused, match="force_per_drive = 0"):
        read_axis_log(path, force_per_drive=0.0)
