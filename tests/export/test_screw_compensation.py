"""LinuxCNC's screw-compensation table: its rows by hand, a screw put right by it, and the real LinuxCNC behind it."""

import json
import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from leadscrew.analysis.positioning import positioning
from leadscrew.export import hal_run
from leadscrew.export.screw_compensation import ini_lines, screw_compensation
from leadscrew.util.errors import DataError, ValueRefused
from tests.export.compensation_table import read_compensation
from tests.export.linuxcnc_machine import seen_by
from tests.tools import missing

TARGETS = (-40.0, -12.5, 3.0, 31.0, 60.0)
UP = (2.0, -1.0, 0.5, 4.0, 6.5)
DOWN = (5.0, 1.5, 4.0, 6.5, 11.0)


def measured(up=UP, down=DOWN, targets=TARGETS):
    """A test without scatter: every run gives the same deviations, in um."""
    return positioning(targets, np.array([up, up]).T, None if down is None else np.array([down, down]).T)


def test_rows_are_those_worked_by_hand():
    positions, trims = (screw_compensation(measured(), kind).splitlines() for kind in (0, 1))
    assert positions[0] == "-40.000000 -39.998000 -39.995000"
    assert positions[-1] == "60.000000 60.006500 60.011000"
    assert trims[0] == "-40.000000 -0.002000 -0.005000"
    assert trims[1] == "-12.500000 0.001000 -0.001500"
    assert len(positions) == len(trims) == 5


def test_both_types_of_file_ask_for_the_same_correction():
    found = [read_compensation(screw_compensation(measured(), kind), kind) for kind in (0, 1)]
    for field in ("nominal", "forward", "reverse"):
        np.testing.assert_allclose(getattr(found[0], field), getattr(found[1], field), atol=1e-12)


def test_a_machine_in_inches_gets_inches():
    rows = screw_compensation(measured(), 1, "inch").splitlines()
    nominal, forward, reverse = map(float, rows[3].split())
    assert nominal * 25.4 == pytest.approx(31.0, abs=2e-6)
    assert forward * 25.4 == pytest.approx(-0.004, abs=2e-6)
    assert reverse * 25.4 == pytest.approx(-0.0065, abs=2e-6)


def test_the_file_has_nothing_that_linuxcnc_would_stop_at():
    for kind in (0, 1):
        for line in screw_compensation(measured(), kind).splitlines():
            assert len([float(x) for x in line.split()]) == 3
            assert len(line) < 255


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("# nominal forward reverse\n0 0 0\n", "line 1"),
        ("0 0 0\n1 1\n", "line 2"),
        ("0 0 0\n1 1 nan\n", "line 2"),
        ("0 0 0\n0 1 1\n", "line 2"),
        ("", "0 points"),
        ("\n".join(f"{k} 0 0" for k in range(257)), "257 points"),
    ],
)
def test_a_file_that_linuxcnc_would_not_read_whole_is_refused(text, where):
    with pytest.raises(DataError, match=where):
        read_compensation(text)


def test_a_table_of_256_points_is_the_longest_that_linuxcnc_reads():
    many = np.arange(256.0)
    text = screw_compensation(measured(many, many, many))
    assert len(read_compensation(text).nominal) == 256


def test_what_cannot_become_a_table_is_refused():
    with pytest.raises(ValueRefused, match="both directions"):
        screw_compensation(measured(down=None))
    many = np.arange(257.0)
    with pytest.raises(ValueRefused, match="257 targets"):
        screw_compensation(measured(many, many, many))
    with pytest.raises(ValueRefused, match="COMP_FILE_TYPE = 2"):
        screw_compensation(measured(), 2)
    with pytest.raises(ValueRefused, match="'cm'"):
        screw_compensation(measured(), 0, "cm")


# ---- a simulated screw, put right
PLAY_MM, SLOPE, CYCLE_MM, LEAD_MM = 0.005, 4e-5, 0.001, 10.0


def screw(motor_mm, upwards):
    """Where the table is for a motor position: lead error, cyclic error, half the play behind the motor."""
    return (
        motor_mm * (1.0 + SLOPE)
        + CYCLE_MM * np.sin(2.0 * math.pi * motor_mm / LEAD_MM)
        - (0.5 if upwards else -0.5) * PLAY_MM
    )


def deviations_um(positions, correction=None):
    """Deviations in both directions, the joint's position going to the motor with or without a correction."""
    found = []
    for upwards in (True, False):
        added = 0.0 if correction is None else correction.at(positions, upwards)
        found.append(1000.0 * (screw(positions + added, upwards) - positions))
    return found


@pytest.mark.parametrize("kind", [0, 1])
def test_a_screw_with_known_errors_is_right_at_the_targets_and_cyclic_between_them(kind):
    targets = np.array([7.0, 41.5, 83.0, 127.3, 160.8, 204.1, 251.9])
    scatter = np.array([-0.4, -0.2, 0.0, 0.2, 0.4])
    before = positioning(targets, *(x[:, None] + scatter for x in deviations_um(targets)))
    table = read_compensation(screw_compensation(before, kind), kind)
    after = positioning(targets, *(x[:, None] + scatter for x in deviations_um(targets, table)))
    # The rest at the targets: the file's nanometre, and the slope of the error times a correction of some um.
    assert after.both.systematic < 0.02 < 1.0 < before.both.systematic
    assert after.both.reversal < 0.02 < 4.9 < before.both.reversal
    assert after.both.accuracy == pytest.approx(before.compensated().both.accuracy, abs=0.02)
    # Between the targets stays what the points cannot carry: up to the cyclic error, and what it gave the points.
    between = np.linspace(targets[0], targets[-1], 2001)
    left = np.concatenate(deviations_um(between, table))
    assert 500.0 * CYCLE_MM < np.abs(left).max() <= 2050.0 * CYCLE_MM
    assert np.abs(left).max() < 0.25 * np.abs(np.concatenate(deviations_um(between))).max()


def test_the_other_sign_would_double_the_error():
    targets = np.array(TARGETS)
    before = positioning(targets, *(np.stack([x, x], axis=1) for x in deviations_um(targets)))
    right = read_compensation(screw_compensation(before, 1), 1)
    wrong = right._replace(forward=-right.forward, reverse=-right.reverse)
    assert np.abs(np.concatenate(deviations_um(targets, wrong))).max() == pytest.approx(
        2.0 * np.abs(np.concatenate(deviations_um(targets))).max(), rel=0.01
    )


# ---- the real LinuxCNC
SIMULATOR = Path(__file__).with_name("linuxcnc_sim")


def needed():
    """Skips, or fails where it is required, on a machine that cannot run LinuxCNC; its compiler is not needed here."""
    tools = [t for t in ("linuxcnc", "halrun", "unshare", "mount", "setpriv") if not shutil.which(t)]
    if tools or not hal_run.MODULES.is_dir():
        missing("linuxcnc", f"{', '.join(tools) or hal_run.MODULES} not found: install linuxcnc-uspace")
    if subprocess.run([*hal_run.SEPARATE, "true"], capture_output=True, check=False).returncode:
        missing("linuxcnc", "no permission to make namespaces (unshare): run this as root")
    if subprocess.run([hal_run.PYTHON, "-c", "import hal"], capture_output=True, check=False).returncode:
        missing("linuxcnc", f"{hal_run.PYTHON} has no module hal: install linuxcnc-uspace")


def simulated(table, kind, positions, more=""):
    """What LinuxCNC told the motor at positions that its first joint went to in turn, with a table for that joint."""
    needed()
    with hal_run.workplace() as place:
        machine = place / "machine"
        shutil.copytree(SIMULATOR, machine, ignore=shutil.ignore_patterns("__pycache__"))
        ini = (machine / "axis.ini").read_text(encoding="utf-8")
        ours = ini_lines("x.comp", kind, "0") + more
        (machine / "axis.ini").write_text(ini.replace("[JOINT_0]\n", ours), encoding="utf-8")
        (machine / "x.comp").write_text(table, encoding="utf-8")
        (machine / "positions.hal").replace(machine / "axis.hal")
        (machine / "positions.py").replace(machine / "drive.py")
        (machine / "positions.json").write_text(json.dumps(positions), encoding="utf-8")
        return seen_by(machine, place)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [0, 1])
def test_the_real_linuxcnc_adds_the_correction_of_the_direction_that_it_moves_in(kind):
    text = screw_compensation(measured(), kind)
    table = read_compensation(text, kind)
    # On a point, between points, beyond the ends; upwards, then back down.
    way = [-60.0, -40.0, -12.5, -3.0, 20.0, 60.0, 75.0, 60.0, 20.0, -3.0, -12.5, -40.0, -60.0]
    found = simulated(text, kind, way)
    assert found["homed"]
    assert found["errors"] == []
    for i, (at, (rest, joint, motor, offset, feedback)) in enumerate(zip(way, found["seen"], strict=True)):
        upwards = at > (way[i - 1] if i else 0.0)
        assert rest and joint == pytest.approx(at, abs=1e-9) and feedback == pytest.approx(at, abs=1e-6)
        assert motor - offset - joint == pytest.approx(float(table.at(at, upwards)), abs=1e-6), f"at {at}, {upwards}"
    # The same by hand for two of them: 20 mm lies between 3 and 31 mm.
    there = {
        (at, i > 6): motor - offset - at
        for i, (at, (_, _, motor, offset, _)) in enumerate(zip(way, found["seen"], strict=True))
    }
    assert there[20.0, False] == pytest.approx(-0.001 * (0.5 + 17.0 / 28.0 * 3.5), abs=1e-6)
    assert there[-40.0, True] == pytest.approx(-0.005, abs=1e-6)


@pytest.mark.slow
def test_a_joint_with_a_table_does_not_use_its_backlash():
    text = screw_compensation(measured(), 1)
    _, down, _, up = (
        m - o - j for _, j, m, o, _ in simulated(text, 1, [31.0, 3.0, -12.5, 3.0], "BACKLASH = 0.3\n")["seen"]
    )
    assert down == pytest.approx(-0.004, abs=1e-6)
    assert up == pytest.approx(-0.0005, abs=1e-6)


@pytest.mark.slow
def test_linuxcnc_stops_reading_at_a_comment_without_a_word():
    """Why the file has no header: behind one, LinuxCNC runs without any correction."""
    found = simulated("# nominal forward reverse\n" + screw_compensation(measured(), 1), 1, [31.0])
    assert found["errors"] == []
    ((_, joint, motor, offset, _),) = found["seen"]
    assert motor - offset - joint == pytest.approx(0.0, abs=1e-9)
