"""``leadscrew tangent gcode`` and ``train``: what is refused, what is said, and where files go."""

from __future__ import annotations

import pytest

from tests.cli.conftest import strict_json

PLAIN = """G21 G90
G0 X0 Y0
G1 X40 Y0 F1000
G3 X{0} Y{1} J{1}
G1 X{0} Y40
M2
"""


@pytest.fixture
def plain(tmp_path):
    """A line, a rounding of a radius, a line."""

    def make(radius):
        path = tmp_path / "plain.ngc"
        path.write_text(PLAIN.format(40.0 + radius, radius), encoding="utf-8")
        return path

    return make


def test_a_knife_that_lifts_below_the_sheet_or_cuts_above_it_is_refused(refused, plain, tmp_path):
    args = ("tangent", "gcode", plain(5.0), "-o", tmp_path / "o.ngc")
    assert "lift = -0.5: expected above 0 mm, the top of the sheet" in refused(*args, "--lift", -0.5, "--depth", -1)
    assert "lift = 0: expected above 0 mm" in refused(*args, "--lift", 0)
    assert "depth = 0.2: expected 0 mm, the top of the sheet, or below" in refused(*args, "--depth", 0.2)
    assert not (tmp_path / "o.ngc").exists()


def test_a_link_stays_a_link_and_its_file_gets_the_program(call, plain, tmp_path):
    far, link = tmp_path / "far.ngc", tmp_path / "link.ngc"
    far.write_text("old", encoding="utf-8")
    link.symlink_to(far)
    call("tangent", "gcode", plain(5.0), "-o", link)
    assert link.is_symlink() and far.read_text(encoding="utf-8").startswith("(leadscrew tangent 1)")


def test_a_rounding_that_is_turned_at_depth_is_said_and_a_corner_is_not(call, plain, tmp_path):
    for radius, strokes, tight in ((0.003, 2, 0), (0.3, 1, 1), (5.0, 1, 0)):
        done = call("tangent", "gcode", plain(radius), "-o", tmp_path / "o.ngc", "--json")
        found = strict_json(done.stdout)
        assert found["strokes"] == strokes and len(found["tight"]) == tight
        assert ("draw a sharp corner there" in str(found["notes"])) == bool(tight) and done.stderr == ""
        if tight:
            assert found["tight"][0]["turn"] == pytest.approx(90.0, abs=1e-3)
            assert found["tight"][0]["length"] == pytest.approx(0.4712, abs=1e-3)


def test_inch_is_a_unit_of_a_drawing(call, tmp_path):

    file = tmp_path / "a.svg"
    file.write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M0,0 L3,0"/></svg>', encoding="utf-8")
    for unit in ("inch", "in"):
        shown = call("tangent", "gcode", file, "-o", tmp_path / "o.ngc", "--unit", unit).stdout
        assert "1 stroke, 76.2 mm" in shown


@pytest.mark.slow
def test_a_network_that_knows_the_table_less_well_than_asked_is_written_with_exit_code_1(call, tmp_path):
    out = tmp_path / "net.json"
    done = call("tangent", "train", "--generations", 5, "--tries", 1, "-o", out, code=1)
    assert "not met: " in done.stderr and out.exists()
    assert float(done.stdout.split("RMSE, levels")[1].split()[0]) > 0.65
