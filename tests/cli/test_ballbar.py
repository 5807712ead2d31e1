"""``leadscrew ballbar``: on loops, on a measured file, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from leadscrew.analysis.circular.file import read_circles
from leadscrew.analysis.circular.quantities import quantities
from tests.cli.conftest import left, strict_json

MEASURED = Path(__file__).parents[2] / "examples" / "ballbar.csv"
FILE = ("ballbar", MEASURED, "--radius", 100, "--feed", 1000)
TWO_AXES = """
from typing import NamedTuple

from leadscrew import Loop
from leadscrew.kernel.block import controller, plant
from leadscrew.references._path import line, path


class Pair(NamedTuple):
    x: float = 0.0
    y: float = 0.0


class Gains(NamedTuple):
    x: float = 40.0
    y: float = 25.0


def shown(s):
    return s


@plant(Pair(), Pair(), output=shown, unit="mm")
def table(p, s, u):
    return Pair(u.x, u.y)


@controller(Gains())
def gains(p, command, feedback):
    return Pair(p.x * (command.x.position - feedback.x), p.y * (command.y.position - feedback.y))


@controller(Gains())
def crossed(p, command, feedback):
    return Pair(p.x * (command.y.position - feedback.x), p.y * (command.x.position - feedback.y))


def loop(controller=gains):
    way = path([line((0.0, 0.0, 0.0), (10.0, 0.0, 0.0), 1000.0)])
    return Loop(reference=way, controller=controller, plant=table, period=1e-3)


def swapped():
    return loop(crossed)
"""
ONE_AXIS = """
from typing import NamedTuple

from leadscrew import Loop
from leadscrew.kernel.block import controller, plant
from leadscrew.references._sine import sine


class Gain(NamedTuple):
    gain: float = 40.0


class Place(NamedTuple):
    position: float = 0.0


@plant(Gain(), Place(), unit="mm")
def axis(p, s, u):
    return Place(u)


@controller(Gain())
def gain(p, command, feedback):
    return p.gain * (command - feedback)


def loop():
    return Loop(reference=sine, controller=gain, plant=axis, period=1e-3)
"""


@pytest.fixture
def two_axes(tmp_path):
    (tmp_path / "two.py").write_text(TWO_AXES, encoding="utf-8")
    return f"{tmp_path / 'two.py'}:loop"


@pytest.fixture
def one_axis(tmp_path):
    (tmp_path / "one.py").write_text(ONE_AXIS, encoding="utf-8")
    return f"{tmp_path / 'one.py'}:loop"


def row(shown, name):
    return next(x for x in shown.splitlines() if x.startswith(name)).replace("−", "-").split()


# ---- a measured file
@pytest.mark.slow
def test_the_tables_of_a_file_show_what_the_library_computes(call):
    shown = call(*FILE).stdout
    found = quantities(read_circles(MEASURED, 100.0, 1000.0))
    assert row(shown, "bi-directional circular error")[-1] == f"{found.both.circular:.3f}"
    assert row(shown, "mean bi-directional radial error")[-1] == f"{found.both.mean_radial:.3f}"
    assert row(shown, "circular error, CW")[-1] == f"{found.cw.circular:.3f}"
    for word in ("radius 100 mm, feed 1000 mm/min", "counter-clockwise and clockwise", "axes X and Y",
                 "start point at 0 degrees", "1800 points ccw", "a measured file", "was not at hand"):  # fmt: skip
        assert word in shown
    assert "backlash X" in shown and "lead 9.999 mm" in shown and "µrad" in shown
    assert len([x for x in shown.splitlines() if x.startswith(("X+", "X-", "Y+", "Y-"))]) == 8


@pytest.mark.slow
def test_editions_name_their_quantities(call):
    old, new = call(*FILE, "--edition", "1996").stdout, call(*FILE, "--edition", "2005").stdout
    assert "circular hysteresis" in old and "H_XY" in old and "G(b)" not in old and "D_XY" not in old
    assert "bi-directional circular deviation" in new and "hysteresis" not in new and "ISO 230-4:2005" in new


def test_json_is_one_strict_object_with_conditions_and_everything(call):
    found = strict_json(call(*FILE, "--json", "--encoder").stdout)
    assert found["conditions"]["radius_mm"] == 100 and found["conditions"]["feed_mm_min"] == 1000
    assert found["conditions"]["points"] == {"ccw": 1800, "cw": 1800} and found["conditions"]["axes"] == ["X", "Y"]
    assert found["conditions"]["source"] == "encoder" and any("encoder signals" in n for n in found["notes"])
    assert found["standard"] == "ISO 230-4:2022" and found["standard_at_hand"] is False
    assert found["all_um"]["both"]["circular"] == pytest.approx(7.86, abs=0.01)
    squareness = next(f for f in found["diagnosis"]["faults"] if f["name"] == "squareness")
    assert squareness["more"]["urad"] == pytest.approx(-25.0, abs=1.0)
    assert found["bar"] is None and found["report"] is None and len(found["reversals"]) == 8


@pytest.mark.slow
def test_the_report_opens_offline_and_its_json_is_the_command_s(call, tmp_path):
    out = tmp_path / "report"
    call(*FILE, "--out", out)
    assert left(out) == ["ballbar.json", "ballbar.png", "report.html"]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "bi-directional circular error" in page and "data:image/" in page and "Reversals" in page
    assert "http" not in page.replace("http://www.w3.org", "")
    saved = json.loads((out / "ballbar.json").read_text(encoding="utf-8"))
    assert saved["quantities_um"] == strict_json(call(*FILE, "--json").stdout)["quantities_um"]


def test_the_example_is_written_once_and_is_the_one_of_the_repository(call, refused, tmp_path):
    shown = call("ballbar", tmp_path / "made.csv", "--example").stdout
    assert "an example" in shown and "--radius 100 --feed 1000" in shown
    assert (tmp_path / "made.csv").read_bytes() == MEASURED.read_bytes()
    assert "overwrites nothing" in refused("ballbar", tmp_path / "made.csv", "--example")
    assert "--example only writes" in refused("ballbar", tmp_path / "new.csv", "--example", "--json")
    assert "ends in .csv" in refused("ballbar", tmp_path / "made.py", "--example")


# ---- loops
@pytest.mark.slow
def test_a_loop_of_two_axes_draws_the_circle_itself_and_the_bar_reads_it(call, two_axes):
    shown = call("ballbar", two_axes, "--radius", 50, "--feed", 300, "--bar", "--set", "bar.centring_x_um=5").stdout
    # The lags of both loops, 25 and 40 ms, at 5 mm/s.
    assert float(row(shown, "servo mismatch")[2]) == pytest.approx(-75.0, abs=0.002) and "−15 ms" in shown
    true, read = (float(v) for v in row(shown, "bi-directional circular error")[-2:])
    assert true == pytest.approx(75.0, abs=0.01) and read == pytest.approx(75.0, abs=0.3)
    assert float(row(shown, "radial error, CCW, set-up centre")[-1]) == pytest.approx(37.5 + 3.5, abs=1.0)
    assert "resolution 0.1 um, sphericity 0.05 um, centring (5, 0) um" in shown
    assert "second turn" in shown and "the true path" in shown


def test_parameters_change_one_direction_is_one_and_few_points_are_noted(call, two_axes):
    equal = call("ballbar", two_axes, "--set", "controller.y=40", "--direction", "cw", "--points", "400")
    assert float(row(equal.stdout, "circular error, CW")[-1]) == pytest.approx(0.0, abs=0.002)
    assert "bi-directional" not in equal.stdout and "400 points a turn where 1800 are usual" in equal.stderr
    assert "clockwise only" in equal.stderr and "cannot be distinguished" in equal.stderr


def test_two_loops_of_one_axis_are_a_machine(call, one_axis, tmp_path, monkeypatch):
    found = strict_json(
        call("ballbar", one_axis, "--y", one_axis, "--radius", 10, "--feed", 100, "--set", "y.controller.gain=30",
             "--json").stdout
    )  # fmt: skip
    assert found["subject"].count("one.py:loop") == 2
    faults = {f["name"]: f for f in found["diagnosis"]["faults"]}
    # 1/40 s - 1/30 s = -8.33 ms.
    assert faults["servo mismatch"]["more"]["ms"] == pytest.approx(-8.33, abs=0.01)
    assert abs(faults["squareness"]["um"]) < 0.001
    monkeypatch.chdir(tmp_path)  # Python that a file names runs from here
    (tmp_path / "machine.toml").write_text(f'schema_version = 1\nstudy = "{one_axis}"\n[set]\ncontroller.gain = 30.0\n')
    other = strict_json(
        call("ballbar", one_axis, "--y", tmp_path / "machine.toml", "--radius", 10, "--feed", 100, "--json").stdout
    )
    assert other["all_um"] == found["all_um"]


def test_a_loop_that_diverges_ends_with_3(call, two_axes):
    result = call("ballbar", two_axes, "--set", "controller.x=2500", code=3)
    assert result.stdout == "" and "on the circle" in result.stderr


# ---- refused: one line, code 2, nothing written
def test_bad_input_is_one_line_and_leaves_nothing(refused, two_axes, one_axis, tmp_path):
    before = left(tmp_path)
    out = ("--out", tmp_path / "report")
    assert "radius = 0.0 mm" in refused("ballbar", two_axes, "--radius", "0", *out)
    assert "feed = nan" in refused("ballbar", two_axes, "--feed", "nan", *out)
    assert "has not two axes" in refused("ballbar", one_axis, *out)
    assert "has both axes already" in refused("ballbar", two_axes, "--y", one_axis, *out)
    assert "are the axes swapped" in refused("ballbar", two_axes.replace(":loop", ":swapped"), *out)
    assert "expected 36 to" in refused("ballbar", two_axes, "--points", "2", *out)
    assert "give --bar" in refused("ballbar", two_axes, "--set", "bar.seed=3", *out)
    assert "no parameter 'plant.z'" in refused("ballbar", two_axes, "--set", "plant.z=3", *out)
    assert "--edition 2010" in refused("ballbar", two_axes, "--edition", "2010", *out)
    assert "--centre is about a measured file" in refused("ballbar", two_axes, "--centre", "0,0", *out)
    assert "--radius is missing" in refused("ballbar", MEASURED, *out)
    assert "--bar is about a loop" in refused(*FILE, "--bar", *out)
    assert "expected two numbers, X,Y" in refused(*FILE, "--centre", "1;2", *out)
    assert "these points show cyclic errors" in refused(*FILE, "--lead-x", "0.01", *out)
    assert "exists already" in refused(*FILE, "--out", tmp_path)
    assert left(tmp_path) == before


def measured(tmp_path, change):
    """The made measurement with its lines of points changed."""
    lines = MEASURED.read_text(encoding="utf-8").splitlines()
    head, points = lines[:5], lines[5:]
    (tmp_path / "changed.csv").write_text("\n".join([*head, *change(points)]) + "\n", encoding="utf-8")
    return tmp_path / "changed.csv"


def mirrored(line):
    """The point with its axes swapped: the angle counts from +y towards +x."""
    angle, rest = line.split(",", 1)
    return f"{90.0 - float(angle):g},{rest}"


@pytest.mark.parametrize("centre", ["1e9,0", "0,-1e9", "nan,0", "0,inf"])
def test_a_centre_with_one_coordinate_that_is_no_place_on_a_machine_is_refused(refused, centre):
    assert f"--centre {centre}: expected two finite numbers below 1e9 mm" in refused(*FILE, "--centre", centre)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda p: p[:1500], "the points cover 299.8 degrees; expected a full turn of 360"),
        (lambda p: [p[0], p[1]], "2 points; a circle needs at least 36"),
        (lambda p: [mirrored(x) for x in p], "are the axes x and y swapped"),
        (lambda p: [*p[:300], "60,45.0,ccw", *p[301:]], "row 306: the radius jumps by"),
        (lambda p: [*p[:300], "60,nan,ccw", *p[301:]], "row 306, column 'deviation_um': 'nan' is not a finite number"),
        (lambda p: [], "has a header but no rows of data"),
    ],
    ids=["part of a turn", "two points", "swapped", "encoder jump", "not finite", "empty"],
)  # fmt: skip
def test_a_measured_file_that_is_no_circle_is_refused(refused, tmp_path, change, said):
    file = measured(tmp_path, change)
    assert said in refused("ballbar", file, "--radius", 100, "--out", tmp_path / "report")
    assert left(tmp_path) == ["changed.csv"]
