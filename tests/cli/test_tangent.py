"""``leadscrew tangent``: from a drawing to the second piece, as a user types it, and what is refused."""

from __future__ import annotations

import csv
import math
from itertools import pairwise

import numpy as np
import pytest

from tests.cli.conftest import left, strict_json

SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="120mm" viewBox="0 0 400 240">
  <g transform="translate(40,40) rotate(8) scale(1.5,1.2)">
    <path d="M 0,60 C 30,-20 90,-20 120,40 S 180,110 200,60 Q 170,130 110,110 A 60 35 20 0 1 0,60 Z"/>
  </g>
  <rect x="250" y="20" width="120" height="60" rx="20"/>
</svg>
"""
LINE = """G21 G90
G0 X0 Y0 Z5 C0
G1 Z-1 F600
G1 X60 F3000 C0
G3 X70 Y10 J10 C90
G1 Y40 C90
G0 Z5
M2
"""


@pytest.fixture
def svg(tmp_path):
    path = tmp_path / "leaf.svg"
    path.write_text(SVG, encoding="utf-8")
    return path


@pytest.fixture
def line(tmp_path):
    """A program of others."""
    path = tmp_path / "line.ngc"
    path.write_text(LINE, encoding="utf-8")
    return path


def rms_of(call, *args):
    return strict_json(call("tangent", "cut", *args, "--json").stdout)["rms_error_deg"]


def test_the_second_piece_of_a_real_drawing_has_a_third_of_the_error_of_the_first(call, svg, tmp_path):
    one, two = tmp_path / "one.ngc", tmp_path / "two.ngc"
    shown = call("tangent", "gcode", svg, "-o", one).stdout
    assert "3 strokes, 549.0 mm" in shown and "C from −720.0 to −126.2°" in shown
    first = rms_of(call, one, "-o", tmp_path / "one.csv", "--seed", 1)
    found = strict_json(
        call("tangent", "compensate", one, "--measured", tmp_path / "one.csv", "-o", two, "--json").stdout
    )
    assert found["before_rms_deg"] == pytest.approx(first, rel=0.02)
    assert found["predicted_rms_deg"] < 0.1 and 3.0 < found["largest_offset_deg"] < 15.0
    assert rms_of(call, two, "-o", tmp_path / "two.csv", "--seed", 2) < first / 3.0
    assert "(offsets: compensated)" in two.read_text(encoding="utf-8")


@pytest.mark.slow
def test_so_does_a_third_piece_from_the_drawing_after_the_second_s_program_with_a_noisy_scan(call, svg, tmp_path):
    files = [tmp_path / f"{k}.ngc" for k in (1, 2, 3)]
    call("tangent", "gcode", svg, "-o", files[0], "--feed", 2400, "--axis", "A", "--clockwise")
    errors = []
    for k, (before, after) in enumerate(pairwise(files), start=1):
        scan = tmp_path / f"{k}.csv"
        cut = call("tangent", "cut", before, "-o", scan, "--seed", k, "--noise", 0.05, "--placed", "20,-7,33").stdout
        errors.append(float(cut.split("error of its tangent ")[1].split("°")[0]))
        marks = [word for row in cut.splitlines() if row.startswith("mark: ") for word in row.split()[1:]]
        args = ("tangent", "compensate", svg, "--after", before, "--measured", scan, "-o", after, *marks)
        turned = call(*args).stdout.split("turned by ")[1].split()[0]
        assert float(turned.split("°")[0]) == pytest.approx(33.0, abs=0.1)
        assert "feed = 2400.0" in after.read_text(encoding="utf-8") and " A" in after.read_text(encoding="utf-8")
    errors.append(rms_of(call, files[2], "-o", tmp_path / "3.csv", "--seed", 3))
    assert max(errors[1:]) < errors[0] / 3.0


@pytest.mark.slow
def test_show_says_lengths_corners_and_what_the_blade_has_to_do(call, svg, tmp_path):
    found = strict_json(call("tangent", "show", svg, "--json", "--plot", tmp_path / "p.png").stdout)
    assert found["unit"] == "mm" and found["paths"] == 2 and found["lifted"] == 2
    rectangle = found["strokes"][-1]
    assert rectangle["length_mm"] == pytest.approx(2 * 40 + 2 * 10 + 20 * math.pi, abs=1e-6) and rectangle["closed"]
    # A radius of 10 mm at 50 mm/s.
    assert rectangle["peak_swivel_deg_s"] == pytest.approx(math.degrees(5.0), rel=1e-6)
    assert rectangle["feed_limit_mm_min"] == pytest.approx(7200 * math.pi * 10 * 60 / 10 / 180, rel=1e-6)
    assert (tmp_path / "p.png").read_bytes()[:4] == b"\x89PNG"
    shown = call("tangent", "show", svg, "--max-swivel-rate", 100).stdout
    assert "leaf.svg: 2 paths, 549.0 mm, unit mm; 3 corners, of which 2 above 20°: 3 strokes" in shown
    assert "the blade is too slow in stroke 2, 3: gcode lowers the feed there" in shown


def test_a_program_of_others_is_cut_and_compensated_with_its_own_moves(call, line, tmp_path):
    scan, out = tmp_path / "cut.csv", tmp_path / "out.ngc"
    first = call("tangent", "cut", line, "-o", scan, "-m", "leather")
    assert "not of leadscrew tangent" in first.stderr
    rows = list(csv.DictReader(scan.read_text(encoding="utf-8").splitlines()))
    assert float(rows[-1]["travel_mm"]) == pytest.approx(90.0 + 5.0 * math.pi, abs=1e-3)
    call("tangent", "compensate", line, "--measured", scan, "-o", out, "--plot", tmp_path / "p.svg")
    text = out.read_text(encoding="utf-8")
    assert "G1 Z-1 F600" in text and "I0 J10" in text and "(d " in text
    assert (tmp_path / "p.svg").read_text(encoding="utf-8").count("<svg") == 1


def test_the_file_of_a_cut_is_its_line(call, line, tmp_path):
    scan = tmp_path / "cut.csv"
    call("tangent", "cut", line, "-o", scan, "--noise", 0.02)
    rows = list(csv.DictReader(scan.read_text(encoding="utf-8").splitlines()))
    assert list(rows[0]) == ["stroke", "x_mm", "y_mm"]
    x, y = (np.array([float(r[k]) for r in rows]) for k in ("x_mm", "y_mm"))
    assert x[0] == pytest.approx(0.0, abs=0.1) and y[-1] == pytest.approx(40.0, abs=2.0)


@pytest.mark.parametrize(
    ("table", "why"),
    [
        ("", "is empty; expected a header line with x_mm, y_mm"),
        ("x_mm,y_mm\n", "has a header but no rows"),
        ("x_mm,y_mm\n1,2\n3,nan\n", "row 3, column 'y_mm': 'nan' is not a finite number"),
        ("x_mm,y_mm\n1,2\n3\n", "row 3: has 1 cells; column 'y_mm' is missing"),
        ("1,2\n3,4\n", "the header is 1, 2; expected x_mm and y_mm, or travel_mm and error_deg"),
        ("x_yd,y_yd\n1,2\n", "the header is x_yd, y_yd; expected x_mm and y_mm"),
        ("x (ell),y (ell)\n1,2\n", "'x (ell)': expected a unit of mm, cm, m, inch, in"),
        ("stroke,x_mm,y_mm\n1.5,2,3\n", "row 2: stroke 1.5: expected a whole number"),
        ("stroke,x_mm,y_mm\n1e300,2,3\n", "row 2: stroke 1e+300: expected a whole number"),
        ("x_mm,y_mm\n1e200,2\n", "row 2: lies 1e+200 mm away; expected up to 1e+06 mm"),
        ("x_mm;y_mm\n1,5;2\n", "row 1: cells are divided by semicolons; expected commas, and a decimal point"),
        ("x_mm,y_mm\n1,5,2,5\n", "row 2: has 4 cells, the header 2; a decimal comma? expected a point"),
        ("stroke,x_mm,y_mm\n" + "".join(f"4,{k},0\n" for k in range(60)), "the program has 1 stroke only"),
        ("x_mm,y_mm\n" + "".join(f"{k},0\n" for k in range(60)), "does not cover the path: it is 59.0 mm long"),
    ],
)
def test_a_measured_file_that_is_none_is_refused_and_nothing_is_written(call, line, tmp_path, table, why):
    scan = tmp_path / "scan.csv"
    scan.write_text(table, encoding="utf-8")
    result = call("tangent", "compensate", line, "--measured", scan, "-o", tmp_path / "out.ngc", code=2)
    assert why in result.stderr and result.stdout == ""
    assert left(tmp_path) == ["line.ngc", "scan.csv"]


def test_a_picture_is_not_written_over_what_it_is_made_of(refused, svg, line):
    before = svg.read_bytes()
    assert "--plot" in refused("tangent", "show", svg, "--plot", svg)
    said = refused("tangent", "compensate", line, "--measured", svg, "-o", line.with_name("o.ngc"), "--plot", svg)
    assert "--plot" in said and "is read by this command; write to another file" in said
    assert svg.read_bytes() == before


@pytest.mark.slow
def test_what_a_program_says_itself_is_not_overruled(call, refused, svg, line, tmp_path):
    ours = tmp_path / "ours.ngc"
    call("tangent", "gcode", svg, "-o", ours)
    for option in (("--zero", 90), ("--clockwise",)):
        assert "the head of" in refused("tangent", "cut", ours, "-o", tmp_path / "c.csv", *option)
    assert "its unit stands in it" in refused(
        "tangent", "compensate", line, "--measured", line, "-o", tmp_path / "o.ngc", "--drawing-unit", "in"
    )
    assert "are about a program that was cut" in refused(
        "tangent", "compensate", svg, "--measured", line, "-o", tmp_path / "o.ngc", "--zero", 90
    )
    assert "a program that is cut ends in .ngc" in refused("tangent", "cut", svg, "-o", tmp_path / "c.csv")


def test_a_program_that_a_new_one_would_cut_otherwise_is_not_compensated(call, tmp_path):
    file, scan = tmp_path / "flat.ngc", tmp_path / "cut.csv"
    file.write_text("G21 G90\nG0 X0 Y0 C0\nG1 X100 C0 F1000\nM2\n", encoding="utf-8")
    call("tangent", "cut", file, "-o", scan)
    result = call("tangent", "compensate", file, "--measured", scan, "-o", tmp_path / "o.ngc", code=2)
    assert "cannot be written anew: it has no Z word, and a new program would move Z" in result.stderr
    assert left(tmp_path) == ["cut.csv", "flat.ngc"]


def test_the_plunge_of_a_program_of_others_is_kept_and_what_is_not_is_said(call, tmp_path):
    file, scan, out = tmp_path / "slow.ngc", tmp_path / "cut.csv", tmp_path / "o.ngc"
    file.write_text(LINE.replace("F600", "F150").replace("M2", "G0 X0 Y0\nM2"), encoding="utf-8")
    call("tangent", "cut", file, "-o", scan)
    result = call("tangent", "compensate", file, "--measured", scan, "-o", out)
    assert "G1 Z-1 F150\n" in out.read_text(encoding="utf-8")
    assert "slow.ngc: moves above the work that lead to no cut are not kept (line 8)" in result.stderr


def test_options_that_make_no_sense_are_refused(refused, line, svg, tmp_path):
    out = tmp_path / "o.ngc"
    assert "is read by this command" in refused("tangent", "compensate", line, "--measured", line, "-o", line)
    assert "a program ends in .ngc" in refused("tangent", "gcode", svg, "-o", tmp_path / "o.txt")
    assert "axis = 'B'" in refused("tangent", "gcode", svg, "-o", out, "--axis", "b")
    assert "expected DX,DY,DEG" in refused("tangent", "cut", line, "-o", tmp_path / "c.csv", "--placed", "1,2")
    assert "--noise -1" in refused("tangent", "cut", line, "-o", tmp_path / "c.csv", "--noise", -1)
    assert "material 'felt'" in refused("tangent", "cut", line, "-o", tmp_path / "c.csv", "-m", "felt")
    assert "expected X,Y=X,Y" in refused("tangent", "compensate", line, "--measured", line, "-o", out, "--mark", "1,2")
    assert "there is no file" in refused("tangent", "show", tmp_path / "no.svg")
    assert "give the one that was cut as PATH" in refused(
        "tangent", "compensate", line, "--after", line, "--measured", line, "-o", out
    )
    assert not out.exists()


def test_the_example_is_written_once_and_plain_g_code_gets_its_words(call, refused, tmp_path):
    file = tmp_path / "a.svg"
    assert "next: leadscrew tangent show" in call("tangent", "show", file, "--example").stdout
    assert "overwrites nothing" in refused("tangent", "show", file, "--example")
    assert "leave the other options" in refused("tangent", "show", tmp_path / "b.svg", "--example", "--json")
    plain = tmp_path / "plain.ngc"
    plain.write_text("\n".join(x.split(" C")[0] for x in LINE.splitlines()), encoding="utf-8")
    call("tangent", "gcode", plain, "-o", tmp_path / "words.ngc")
    assert "G3 X70 Y10 I0 J10 C90" in (tmp_path / "words.ngc").read_text(encoding="utf-8")


def test_a_program_with_words_that_a_new_one_would_lose_is_not_compensated(call, tmp_path):
    file = tmp_path / "spun.ngc"
    file.write_text("M3 S900\n" + LINE, encoding="utf-8")
    scan = tmp_path / "cut.csv"
    call("tangent", "cut", file, "-o", scan)
    result = call("tangent", "compensate", file, "--measured", scan, "-o", tmp_path / "o.ngc", code=2)
    assert "words that a new program would lose (line 1: M3; line 1: S900)" in result.stderr


def test_a_program_that_is_not_of_the_drawing_is_refused(call, svg, line, tmp_path):
    result = call("tangent", "compensate", svg, "--after", line, "--measured", line, "-o", tmp_path / "o.ngc", code=2)
    assert "is not a program of" in result.stderr and "it has 1 strokes of 105.7 mm" in result.stderr
