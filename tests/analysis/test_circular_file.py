"""The door for measured circles: what it takes, and what it refuses with which words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from leadscrew.analysis.circular import synthetic as made
from leadscrew.analysis.circular.diagnosis import diagnose
from leadscrew.analysis.circular.file import read_circles
from leadscrew.analysis.circular.quantities import quantities
from leadscrew.util.errors import DataError, ValueRefused

EXAMPLES = Path(__file__).parents[2] / "examples"
PHI = 2.0 * np.pi * np.arange(720) / 720


def path_of(phi, radius=100.0):
    """10 urad out of square, and some scatter that is always the same."""
    grown = radius + 1e-4 * np.sin(977.0 * np.arange(phi.size))
    return grown * np.cos(phi) + 1e-5 * radius * np.sin(phi), grown * np.sin(phi)


def g_of(x, y):
    """Largest less smallest radius about the circle that SciPy fits, um."""
    p = least_squares(lambda p: np.hypot(x - p[0], y - p[1]) - p[2], (0.0, 0.0, 99.0), xtol=1e-15, ftol=1e-15).x
    return 1000.0 * np.ptp(np.hypot(x - p[0], y - p[1]))


def write(tmp_path, header, columns, name="circle.csv"):
    rows = "\n".join(",".join(str(v) for v in row) for row in zip(*columns, strict=True))
    file = tmp_path / name
    file.write_text(f"# how it was measured\n{header}\n{rows}\n", encoding="utf-8")
    return file


def both_ways(tmp_path, change=None, header="x_mm,y_mm,direction", words=("ccw", "cw")):
    x, y = (np.concatenate(pair) for pair in zip(path_of(PHI), path_of(-PHI), strict=True))
    if change is not None:
        change(x, y)
    said = [words[0]] * PHI.size + [words[1]] * PHI.size
    return write(tmp_path, header, (map(repr, map(float, x)), map(repr, map(float, y)), said))


def test_points_in_x_and_y_of_both_directions(tmp_path):
    found = quantities(read_circles(both_ways(tmp_path), 100.0, 1000.0))
    assert found.ccw.circular == pytest.approx(g_of(*path_of(PHI)), abs=1e-4)
    assert found.cw.circular == pytest.approx(g_of(*path_of(-PHI)), abs=1e-4)
    assert read_circles(both_ways(tmp_path), 100.0).feed_mm_min is None


@pytest.mark.parametrize(
    ("header", "factors"),
    [("x_um,y_um,d", (1000.0, 1000.0)), ("x_in,y_in,d", (1 / 25.4, 1 / 25.4)), ("x_mm,y_mm,d", (1.0, 1.0))],
)
def test_units_are_those_of_the_header_and_directions_are_seen_without_a_column(tmp_path, header, factors):
    def scale(x, y):
        x *= factors[0]
        y *= factors[1]

    plain, other = (read_circles(both_ways(tmp_path, *a), 100.0) for a in ((), (scale, header)))
    # The first point of the way back belongs to neither way.
    assert (other.ccw.x_mm.size, other.cw.x_mm.size) == (720, 719)
    assert other.ccw.x_mm == pytest.approx(plain.ccw.x_mm, abs=1e-9)
    assert other.cw.y_mm == pytest.approx(plain.cw.y_mm[1:], abs=1e-9)


def test_clockwise_first_is_clockwise(tmp_path):
    x, y = (np.concatenate(pair) for pair in zip(path_of(-PHI), path_of(PHI), strict=True))
    found = read_circles(write(tmp_path, "x_mm,y_mm", (x, y)), 100.0)
    assert found.cw.y_mm[1] < 0.0 < found.ccw.y_mm[1]


@pytest.mark.parametrize(
    ("header", "angles", "lengths"),
    [("angle_deg,radius_mm", np.degrees(PHI), np.hypot(*path_of(PHI))),
     ("angle_rad,deviation_um", PHI, 1000.0 * (np.hypot(*path_of(PHI)) - 100.0))],
)  # fmt: skip
def test_angle_with_radius_or_deviation(tmp_path, header, angles, lengths):
    found = quantities(read_circles(write(tmp_path, header, (angles, lengths)), 100.0))
    assert found.ccw.circular == pytest.approx(g_of(*path_of(PHI)), abs=1e-4) and found.cw is None


def test_the_last_full_turn_counts(tmp_path):
    phi = 2.0 * np.pi * np.arange(1800) / 720
    x, y = path_of(phi)
    x[:900] += 0.5 * np.exp(-np.arange(900) / 60.0)
    found = read_circles(write(tmp_path, "x_mm,y_mm", (x, y)), 100.0)
    assert found.ccw.x_mm.size == 720 and quantities(found).ccw.circular < 1.3
    assert found.start_deg == pytest.approx(180.0, abs=0.6)


def test_a_centre_elsewhere_is_given(tmp_path):
    def move(x, y):
        x += 250.0
        y -= 40.0

    file = both_ways(tmp_path, move)
    with pytest.raises(DataError):
        read_circles(file, 100.0)
    assert quantities(read_circles(file, 100.0, centre_mm=(250.0, -40.0))).both.circular < 1.3


def test_angles_have_their_own_centre(tmp_path):
    file = write(tmp_path, "angle_deg,deviation_um", (np.degrees(PHI), np.zeros(720)))
    with pytest.raises(DataError, match="centre of their own"):
        read_circles(file, 100.0, centre_mm=(1.0, 0.0))


# ---- refused
@pytest.mark.parametrize("size_mm", [0.05, -0.02])
@pytest.mark.parametrize("first", [100, 200, 1000])
def test_an_encoder_jump_is_refused_with_its_row(tmp_path, size_mm, first):
    """X loses counts at one point and never finds them again; away from a reversal."""

    def jump(x, y):
        x[first:] += size_mm

    # Two lines stand above the first point.
    with pytest.raises(DataError, match=rf"row {first + 3}: the (radius|path) jumps .*an encoder jump\?"):
        read_circles(both_ways(tmp_path, jump), 100.0)


def test_a_spike_is_refused_too(tmp_path):
    def spike(x, y):
        x[300] += 0.03
        y[300] -= 0.02

    with pytest.raises(DataError, match=r"row 303.*an encoder jump"):
        read_circles(both_ways(tmp_path, spike), 100.0)


def test_play_and_scatter_are_no_jump(tmp_path):
    def play(x, y):
        way = np.sign(np.roll(x, -1) - np.roll(x, 1))
        x -= 0.02 * way

    found = diagnose(read_circles(both_ways(tmp_path, play), 100.0), floor_um=9.0)
    assert found["backlash X+"].um == pytest.approx(40.0, abs=0.1)


def test_a_point_measured_twice_is_no_jump_and_a_turn_that_drifts_is_noted(tmp_path):
    x, y = (np.repeat(v, np.where(np.arange(720) == 50, 2, 1)) for v in path_of(PHI))
    assert read_circles(write(tmp_path, "x_mm,y_mm", (x, y)), 100.0).ccw.x_mm.size == 721
    angle = PHI + 0.6
    warm = 100.0 + 0.05 * PHI / (2.0 * np.pi)
    found = read_circles(write(tmp_path, "x_mm,y_mm", (warm * np.cos(angle), warm * np.sin(angle))), 100.0)
    assert found.open_um == pytest.approx(50.0, rel=0.01)
    assert "does not close" in " ".join(found.notes()) and "drifted" in " ".join(found.notes())


def test_less_than_a_turn_a_gap_two_points_and_swapped_axes(tmp_path):
    phi = np.radians(np.arange(0.0, 290.1, 0.5))
    with pytest.raises(DataError, match=r"circle.csv: direction ccw: the points cover 290\.0 degrees; expected a full"):
        read_circles(write(tmp_path, "x_mm,y_mm", path_of(phi)), 100.0)
    gap = np.delete(PHI, np.arange(300, 320))
    with pytest.raises(DataError, match=r"10\.5 degrees without a point before 160\.0 degrees"):
        read_circles(write(tmp_path, "x_mm,y_mm", path_of(gap)), 100.0)
    with pytest.raises(DataError, match="2 points; a circle needs at least 36"):
        read_circles(write(tmp_path, "x_mm,y_mm", ([100, 99], [0, 1])), 100.0)
    with pytest.raises(DataError, match="are the axes x and y swapped"):
        read_circles(both_ways(tmp_path, header="y_mm,x_mm,direction"), 100.0)


@pytest.mark.parametrize(
    ("header", "cells", "said"),
    [("x_mm,y_mm", ("nan", "0"), "row 4, column 'x_mm': 'nan' is not a finite number"),
     ("x_mm,y_mm", ("1", "inf"), "row 4, column 'y_mm'"),
     ("x_mm,y_mm", ("1", "one"), "'one' is not a number"),
     ("x,y", ("1", "0"), "the column 'x' says no unit"),
     ("x_mm;y_mm,c", ("1", "0"), "not separated by commas"),
     ("angle_deg,length_mm", ("1", "0"), "expected the columns x_mm and y_mm, or angle_deg"),
     ("x_mm,x_mm", ("1", "0"), "appears 2 times")],
)  # fmt: skip
def test_a_cell_or_column_that_is_wrong_is_named(tmp_path, header, cells, said):
    x, y = ([str(v) for v in column] for column in path_of(PHI))
    x[1], y[1] = cells
    with pytest.raises(DataError, match=said):
        read_circles(write(tmp_path, header, (x, y)), 100.0)


def test_a_file_that_is_none_and_a_direction_that_is_none(tmp_path):
    with pytest.raises(DataError, match="cannot be read"):
        read_circles(tmp_path / "none.csv", 100.0)
    (tmp_path / "empty.csv").write_text("# nothing\n")
    with pytest.raises(DataError, match="is empty"):
        read_circles(tmp_path / "empty.csv", 100.0)
    with pytest.raises(DataError, match="'left'; expected ccw or cw"):
        read_circles(both_ways(tmp_path, words=("left", "cw")), 100.0)
    with pytest.raises(ValueRefused, match="radius = 0"):
        read_circles(both_ways(tmp_path), 0.0)


# ---- the example
def test_the_example_in_the_repository_is_the_one_that_is_made():
    assert (EXAMPLES / "ballbar.csv").read_text(encoding="utf-8") == made.example()


@pytest.mark.slow
def test_the_example_s_faults_come_back_within_what_the_bar_of_its_recipe_can_show():
    test = read_circles(EXAMPLES / "ballbar.csv", made.RADIUS_MM, made.FEED_MM_MIN)
    found = diagnose(test)
    wanted = {
        "squareness": -2.5, "scale X": -1.8, "scale Y": -1.2, "servo mismatch": 2.0, "backlash X+": 3.0,
        "backlash X-": 3.0, "cyclic error X": 0.6, "stick motion Y": 2.4, "centring X": -4.0, "centring Y": 6.0,
    }  # fmt: skip
    for fault in found.faults:
        # Two balls that are out of round by 0.05 um, and the ± of the scatter.
        assert fault.um == pytest.approx(wanted.get(fault.name, 0.0), abs=0.1), fault
