"""What is captured is kept to the last bit, under names that cannot lead out of the folder."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from typer.testing import CliRunner

from leadscrew.logs import read_table
from leadscrew.operate import capture_files, captures
from leadscrew.operate.captures import FORMATS, Capture
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

MANY = ["parquet", "csv", pytest.param("mat", marks=pytest.mark.slow)]
SHARED = settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def capture(rows=None, columns=("time", "command", "plant.x1", "end"), **changed):
    rows = np.arange(200.0)[:, None] / 7.0 * np.array([1.0, 1e-3, -1e9, 0.1]) if rows is None else rows
    held = {
        "name": "capture 1", "columns": columns, "units": {"time": "s", "command": "mm", "end": "V s/mm"},
        "period_s": 0.0005, "first_period": 12_345, "trigger_row": min(40, len(rows) - 1), "rows": rows,
        "about": {"study": "npid_xytable", "values": {"controller.kp": 1.32}, "trigger": {"signal": "command"}},
    }  # fmt: skip
    return Capture(**{**held, **changed})


@pytest.mark.parametrize("form", FORMATS)
def test_a_capture_comes_back_as_it_was(form, tmp_path):
    taken = capture()
    path = captures.save(taken, tmp_path, "step 1", form)
    back = captures.load(path)
    assert path.name == f"step 1.{form}" and back.rows.tobytes() == taken.rows.tobytes()
    assert {**back.__dict__, "rows": 0} == {**taken.__dict__, "rows": 0}
    assert [p.name for p in tmp_path.iterdir()] == [path.name], "nothing is left beside it"


@pytest.mark.parametrize("form", MANY)
@settings(SHARED, max_examples=15)
@given(rows=arrays.arrays(np.float64, st.tuples(st.integers(1, 8), st.just(3)), elements=st.floats(allow_nan=True)))
def test_every_double_comes_back_bit_for_bit(form, rows, tmp_path):
    rows = np.where(np.isnan(rows), np.nan, rows)  # One kind of NaN: text has no other.
    taken = capture(rows, ("time", "a", "b"), units={})
    back = capture_files.read_own(captures.save(taken, tmp_path, "x", form, replace=True))
    assert back.rows.tobytes() == rows.tobytes()


NAMES = st.lists(
    st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), min_size=1, max_size=90).filter(
        lambda s: s[0] != "#"
    ),
    min_size=1,
    max_size=5,
    unique=True,
)


@pytest.mark.parametrize("form", MANY)
@settings(SHARED, max_examples=15)
@given(names=NAMES, unit=st.text(max_size=8), said=st.text(max_size=40))
def test_any_names_units_and_words_come_back(form, names, unit, said, tmp_path):
    rows = np.random.default_rng(1).normal(size=(5, len(names)))
    taken = capture(
        rows, tuple(names), units={names[0]: unit}, name=said, about={"a": said, said: [1, None, {"b": 2.5}]}
    )
    back = capture_files.read_own(captures.save(taken, tmp_path, "x", form, replace=True))
    assert {**back.__dict__, "rows": 0} == {**taken.__dict__, "rows": 0} and back.rows.tobytes() == rows.tobytes()


@pytest.mark.parametrize("form", FORMATS)
def test_other_programs_read_it_as_a_plain_log(form, tmp_path):
    taken = capture(
        columns=("time", "command", "feedback", "output"), units={"time": "s", "command": "mm", "output": "V"}
    )
    table = read_table(captures.save(taken, tmp_path, "log", form))
    assert table.rows == 200
    for at, name in enumerate(taken.columns):
        assert np.array_equal(table.columns[table.name(name)], taken.rows[:, at])
    if form == "mat":
        assert table.period == 0.0005
    else:
        assert table.units[table.name("command")] == "mm" and table.units[table.name("time")] == "s"


def test_the_log_command_shows_a_capture(tmp_path):
    from leadscrew.cli import app

    time = np.arange(400) * 0.0005
    rows = np.column_stack([time, np.sin(40 * time), np.sin(40 * time - 0.01), np.cos(40 * time)])
    taken = capture(
        rows, ("time", "command", "feedback", "output"), units={"time": "s", "feedback": "mm", "output": "V"}
    )
    shown = CliRunner().invoke(app, ["log", str(captures.save(taken, tmp_path, "log", "csv"))])
    assert shown.exit_code == 0, shown.output
    assert "400 rows" in " ".join(shown.output.split()) and "refused" not in shown.output and "feedback" in shown.output


def test_matlab_finds_the_names_and_units(tmp_path):
    from scipy.io import loadmat

    taken = capture(columns=("time", "plant.x", "plant_x", "end"), units={"plant.x": "mm"})
    held = loadmat(captures.save(taken, tmp_path, "m", "mat"), simplify_cells=True)
    said = held["leadscrew_capture"]
    assert said["names"] == {"time": "time", "plant_x": "plant.x", "plant_x_2": "plant_x", "x_end": "end"}
    assert said["units"]["plant_x"] == "mm" and said["period_s"] == 0.0005
    assert json.loads(said["json"])["about"]["study"] == "npid_xytable"
    assert np.array_equal(held["plant_x_2"], taken.rows[:, 2])


def test_what_json_cannot_hold_is_kept_in_words(tmp_path):
    values = {"gains": np.array([1.0, 2.5]), "n": np.int64(3), "worst": np.inf, "none": None, "who": Path("a")}
    back = captures.load(captures.save(capture(about=values), tmp_path, "x"))
    assert back.about == {"gains": [1.0, 2.5], "n": 3, "worst": "inf", "none": None, "who": "a"}


@pytest.mark.slow
def test_a_capture_without_times_gets_them_in_the_file_only(tmp_path):
    taken = capture(np.ones((4, 2)), ("a", "b"), first_period=100, period_s=0.25, units={})
    for form in FORMATS:
        path = captures.save(taken, tmp_path, "x", form)
        assert next(iter(read_table(path).columns.values())).tolist() == [25.0, 25.25, 25.5, 25.75]
        assert capture_files.read_own(path).columns == ("a", "b")


@pytest.mark.parametrize(
    "name",
    ["", ".", "..", "é", "a:b", "../x", "a/b", "a\\b", "/etc/passwd", ".hidden", " x", "-x", "x\0", "x\n", "a..b",
     "a.", "a ", "x" * 65, "%2e%2e", None, 3, b"x", "C:x", "a*", "~x"],
)  # fmt: skip
def test_no_name_leads_out_of_the_folder(name, tmp_path):
    folder = tmp_path / "captures"
    (tmp_path / "x.parquet").write_bytes(b"secret")
    refusals = (
        lambda: captures.save(capture(), folder, name),
        lambda: captures.find(folder, name),
        lambda: captures.received(folder, name, b"time,x\n0,1\n"),
    )
    for refused in refusals:
        with pytest.raises((ValueRefused, NameUnknown), match=r"^name = ") as said:
            refused()
        assert "\n" not in str(said.value) and len(str(said.value)) < 300
    assert sorted(p.name for p in tmp_path.iterdir()) == ["x.parquet"]


@settings(SHARED, max_examples=80)
@given(name=st.text(st.sampled_from("a0._- /\\\0\n:%~\u2215é"), max_size=12))
def test_any_name_stays_in_the_folder_or_is_refused(name, tmp_path):
    folder = tmp_path / "captures"
    try:
        path = captures.save(capture(np.ones((2, 1)), ("a",)), folder, name, replace=True)
    except ValueRefused:
        return
    assert path.resolve().parent == folder.resolve() and path.is_file()
    assert captures.find(folder, path.name) == path


def test_links_are_not_followed_out_of_the_folder(tmp_path):
    outside = captures.save(capture(), tmp_path / "outside", "secret")
    folder = tmp_path / "captures"
    folder.mkdir()
    (folder / "link.parquet").symlink_to(outside)
    with pytest.raises(NameUnknown, match="no capture 'link'"):
        captures.find(folder, "link")
    before = outside.read_bytes()
    for replace in (False, True):
        with pytest.raises(DataError, match="link or a folder"):
            captures.save(capture(np.zeros((2, 4))), folder, "link", replace=replace)
    assert outside.read_bytes() == before and captures.names(folder) == []


def test_an_existing_name_is_refused_unless_told_to_replace(tmp_path):
    first = captures.save(capture(), tmp_path, "x")
    before = first.read_bytes()
    with pytest.raises(DataError, match=r"x.parquet exists already"):
        captures.save(capture(np.zeros((2, 4))), tmp_path, "x")
    assert first.read_bytes() == before
    captures.save(capture(np.zeros((2, 4))), tmp_path, "x", replace=True)
    assert len(captures.load(first).rows) == 2


def test_listing_says_size_and_when_newest_first(tmp_path):
    import os

    old = captures.save(capture(), tmp_path, "old", "csv")
    os.utime(old, (1e9, 1e9))
    new = captures.save(capture(), tmp_path, "new")
    (tmp_path / "notes.md").write_text("no capture")
    (tmp_path / "sub.csv").mkdir()
    listed = captures.names(tmp_path)
    assert [x.name for x in listed] == ["new.parquet", "old.csv"]
    assert listed[0].bytes == new.stat().st_size and listed[1].when == "2001-09-09T01:46:40+00:00"
    assert captures.names(tmp_path / "none") == []


def test_a_name_that_fits_two_files_is_asked_for_in_full(tmp_path):
    one = captures.save(capture(), tmp_path, "x", "csv")
    captures.save(capture(), tmp_path, "x", "mat")
    with pytest.raises(NameUnknown, match=r"x.csv, x.mat"):
        captures.find(tmp_path, "x")
    assert captures.find(tmp_path, "x.csv") == one
    with pytest.raises(NameUnknown, match=r"did you mean x.csv|x.mat"):
        captures.find(tmp_path, "x.cvs")


def test_a_full_folder_and_a_capture_that_is_too_large_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(captures, "MOST_FILES", 2)
    captures.save(capture(), tmp_path, "a")
    captures.save(capture(), tmp_path, "b")
    with pytest.raises(DataError, match="holds 2 captures"):
        captures.save(capture(), tmp_path, "c")
    captures.save(capture(), tmp_path, "b", replace=True)
    with pytest.raises(ValueRefused, match="56 MB; up to 50 MB"):
        captures.save(capture(np.zeros((1_000_000, 7)), tuple("abcdefg")), tmp_path, "a", replace=True)
    monkeypatch.setattr(captures, "MOST_BYTES", 5000)
    with pytest.raises(ValueRefused, match="save it as parquet"):
        captures.save(capture(), tmp_path / "other", "a", "csv")
    with pytest.raises(DataError, match="are read: cut it into parts"):
        captures.load(captures.find(tmp_path, "a"))


@pytest.mark.parametrize("wrong", [np.zeros((0, 1)), np.zeros((3, 2)), np.zeros((3, 1), np.float32), np.zeros(3)])
def test_rows_that_are_no_capture_are_refused(wrong, tmp_path):
    with pytest.raises(ValueRefused, match="row"):
        captures.save(capture(wrong, ("a",), trigger_row=0), tmp_path, "x")
    for column in ("", " a", "a\nb", "#a", "a\u2028b"):
        with pytest.raises(ValueRefused, match="names of columns"):
            captures.save(capture(np.ones((2, 1)), (column,)), tmp_path, "x")
    with pytest.raises(ValueRefused, match=r"format = 'xlsx'.*parquet, csv, mat"):
        captures.save(capture(), tmp_path, "x", "xlsx")
    assert not list(tmp_path.iterdir())
