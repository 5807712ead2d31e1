"""``leadscrew log``: what a person sees, what a program gets, and the exit codes."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from tests.fuzzy.formats_systems import shared
from tests.logs.records import moves

TIME, DRIVE, POSITION, _ = moves()


@pytest.fixture
def file(tmp_path):
    def write(position=POSITION, header="t [s],pos [mm],u [N],phase", rows=3000):
        sampled = list(zip(TIME, position, DRIVE, strict=True))[:rows]
        rows = [f"{t:.3f},{1e3 * x:.3f},{u:.4f},up" for t, x, u in sampled]
        path = tmp_path / "axis.csv"
        path.write_text("\n".join([header, *rows]))
        return path

    return write


def ran(*args, code=0):
    result = CliRunner().invoke(app, ["log", *map(str, args)])
    assert result.exit_code == code, result.output + result.stderr
    return result


def test_a_sound_log_is_shown_with_its_columns_and_its_sampling(file):
    said = ran(file()).stdout
    lines = said.splitlines()
    assert "axis.csv: text, commas, 3000 rows" in " ".join(said.split())
    row = next(line for line in lines if line.startswith("pos [mm]")).split()
    assert row[2:4] == ["mm", "position"] and row[-3:] == ["steps", "of", "0.001"]
    assert "3000 samples every 0.001 s (1000 Hz), from 0 to 2.999 s; position in m, drive in N" in said
    assert "words: up" in said and lines[-1] == "nothing is wrong with it that shows in a log"


def test_a_refused_log_is_shown_all_the_same_and_exits_with_2(file):
    path = file(POSITION + np.where(TIME >= 1.0, 1e-3, 0.0))
    said = ran(path, code=2).stdout
    assert "pos [mm]" in said and "refused: the position jumps once, by +0.001 m at row 1002 (1 s)" in said
    assert "refused:" not in ran(path, "--start", 1.0).stdout


def test_what_is_ambiguous_shows_the_columns_and_the_question(file):
    path = file(header="t [s],x_pos,y_pos,phase", rows=1000)
    said = ran(path, code=2).stdout
    assert "refused: no column is the drive by its name; there are t [s], x_pos, y_pos; name it" in said
    told = ("--column", "drive=y_pos", "--unit", "drive=N", "--unit", "position=mm")
    assert "refused:" not in ran(path, *told).stdout


def test_json_has_all_of_it_on_one_line(file):
    found = json.loads(ran(file(), "--json").stdout)
    assert found["schema_version"] == 1 and found["rows"] == 3000 and found["findings"] == []
    assert found["roles"] == {"time": "t [s]", "drive": "u [N]", "position": "pos [mm]"}
    assert found["log"]["period_s"] == pytest.approx(1e-3) and found["log"]["encoder_step"] == pytest.approx(1e-6)
    assert {c["name"]: c["kind"] for c in found["columns"]}["phase"] == "words"
    found = json.loads(ran(file(0.0 * POSITION), "--json", code=2).stdout)
    assert [f["kind"] for f in found["findings"] if f["severity"] == "refused"] == ["standstill"]


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["--column", "pos"], "--column 'pos': expected ROLE=HEADER with a role of time, drive"),
        (["--unit", "force=N"], "role = 'force': allowed are time, drive"),
        (["--unit", "drive=N", "--unit", "drive=V"], "--unit drive: given twice"),
        (["--unit", "position=furlong"], "'furlong' is no unit of position"),
        (["--column", "position=x"], "has no column 'x'"),
        (["--period", "0"], "period = 0.0: allowed range is (0, inf) s"),
    ],
)
def test_a_wrong_option_is_refused_in_one_line(file, args, said):
    result = ran(file(rows=30), *args, code=2)
    assert said in result.stderr and result.stderr.count("\n") == 1


def test_a_file_that_is_not_there_is_refused_in_one_line(tmp_path):
    result = ran(tmp_path / "none.csv", code=2)
    assert "none.csv: cannot be read" in result.stderr and result.stderr.count("\n") == 1


@pytest.mark.slow
def test_emps_and_umich_are_shown():
    said = ran(shared("data/emps/DATA_EMPS.mat"), "--unit", "drive=V").stdout
    assert "constants: gtau = 35.150652, kp = 160.18, kv = 243.45" in said and "warning" not in said
    said = ran(shared("data/cnc_mill_umich/experiment_01.csv"), code=2).stdout
    assert "refused: 12 columns could be the drive: X1_CurrentFeedback, X1_OutputCurrent" in said
    assert "words: Starting, Prep, Layer 1 Up" in said
