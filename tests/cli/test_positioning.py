"""``leadscrew positioning``."""

from __future__ import annotations

import json

import pytest

from leadscrew.analysis.positioning import example, read_positioning
from tests.cli.conftest import strict_json
from tests.export.compensation_table import read_compensation


@pytest.fixture
def file(tmp_path):
    """The made test."""
    path = tmp_path / "made.csv"
    path.write_text(example(), encoding="utf-8")
    return path


def test_the_table_shows_what_the_library_computes(call, file):
    both = read_positioning(file).both
    shown = call("positioning", file).stdout
    assert f"A = {both.accuracy:.2f} µm" in shown and f"R = {both.repeatability:.2f} µm" in shown
    row = next(x for x in shown.splitlines() if x.startswith("accuracy"))
    assert row.split()[-2:] == [f"{both.accuracy:.2f}", "µm"]
    assert sum(x.strip().startswith(("11.3 ", "431.5 ")) for x in shown.splitlines()) == 2


def test_json_is_one_strict_object_with_everything(call, file, tmp_path):
    found = strict_json(call("positioning", file, "--json", "--compensation", tmp_path / "x.comp").stdout)
    test = read_positioning(file)
    assert found["bidirectional"]["accuracy"] == test.both.accuracy
    assert found["deviations_um"]["up"] == test.up_um.tolist()
    assert found["standard"] == "ISO 230-2:2014" and found["uncertainty"] is None
    assert found["compensation"] == str(tmp_path / "x.comp") and found["report"] is None


def test_the_report_opens_offline_and_its_json_is_the_command_s(call, file, tmp_path):
    out = tmp_path / "report"
    call("positioning", file, "--out", out)
    assert sorted(x.name for x in out.iterdir()) == ["positioning.json", "positioning.png", "report.html"]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Bidirectional accuracy of positioning" in page and "data:image/svg+xml" in page
    assert "http" not in page.replace("http://www.w3.org", "")
    saved = json.loads((out / "positioning.json").read_text(encoding="utf-8"))
    assert saved["bidirectional"] == strict_json(call("positioning", file, "--json").stdout)["bidirectional"]


@pytest.mark.parametrize("kind", [0, 1])
def test_the_compensation_takes_the_means_away(call, file, tmp_path, kind):
    shown = call("positioning", file, "--compensation", tmp_path / "x.comp", "--type", kind).stdout
    assert f"COMP_FILE = x.comp\nCOMP_FILE_TYPE = {kind}" in shown
    table = read_compensation((tmp_path / "x.comp").read_text(encoding="utf-8"), kind)
    test = read_positioning(file)
    assert 1000.0 * table.forward == pytest.approx(-test.up.mean, abs=0.001)
    assert 1000.0 * table.reverse == pytest.approx(-test.down.mean, abs=0.001)


def test_one_direction_is_evaluated_and_said_but_makes_no_table(call, refused, file, tmp_path):
    file.write_text("".join(x for x in example().splitlines(True) if ",-," not in x), encoding="utf-8")
    result = call("positioning", file)
    assert "unidirectional accuracy of positioning" in result.stdout and "bidirectional accuracy" not in result.stdout
    assert "one direction only" in result.stderr
    assert "needs both directions" in refused("positioning", file, "--compensation", tmp_path / "x.comp")
    assert not (tmp_path / "x.comp").exists()


def test_fewer_runs_than_the_standard_asks_for_are_noted(call, file):
    lines = [x for x in example().splitlines(True) if x.split(",")[2:3] not in (["4"], ["5"])]
    file.write_text("".join(lines), encoding="utf-8")
    assert call("positioning", file).stderr.strip() == (
        "leadscrew: note: 3 runs in each direction where the standard asks for 5"
    )


def test_the_example_is_written_once(call, refused, tmp_path):
    call("positioning", tmp_path / "made.csv", "--example")
    assert (tmp_path / "made.csv").read_text(encoding="utf-8") == example()
    assert "overwrites nothing" in refused("positioning", tmp_path / "made.csv", "--example")


def test_bad_input_is_one_line_and_leaves_nothing(refused, file, tmp_path):
    assert "nothing.csv: cannot be read" in refused("positioning", tmp_path / "nothing.csv")
    assert "--type is about the table" in refused("positioning", file, "--type", "1")
    assert "--unit is about the table" in refused("positioning", file, "--unit", "inch")
    assert "COMP_FILE_TYPE = 3" in refused("positioning", file, "--compensation", tmp_path / "x.comp", "--type", "3")
    assert "--example only writes" in refused("positioning", tmp_path / "new.csv", "--example", "--json")
    assert "exists already" in refused("positioning", file, "--out", tmp_path)
    assert [x.name for x in tmp_path.iterdir()] == ["made.csv"]
