"""Files of other programs, and broken ones, as captures: drawn over what runs, or refused in a sentence."""

import zlib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from leadscrew.operate import capture_files, captures
from leadscrew.operate.captures import FORMATS, Capture
from leadscrew.util.errors import DataError, LeadscrewError, ValueRefused

BYTES = settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
HALSCOPE = "# Sampling period is 1000000 ns\n" + "joint.0.pos-cmd;pid.output\n" + "1.0;0.5\n" * 3 + "2.5;-0.5\n" * 7


def text(tmp_path, content, name="x.csv"):
    (tmp_path / name).write_text(content)
    return tmp_path / name


def test_a_file_of_halscope_is_laid_over_on_its_own_period(tmp_path):
    seen = captures.load(text(tmp_path, HALSCOPE))
    assert seen.columns == ("time", "joint.0.pos-cmd", "pid.output") and seen.period_s == 1e-3
    assert seen.signal("joint.0.pos-cmd").tolist() == [1.0] * 3 + [2.5] * 7
    assert seen.signal("time")[-1] == pytest.approx(9e-3) and seen.about["form"] == "LinuxCNC halscope"
    assert (seen.first_period, seen.trigger_row, seen.name) == (0, 0, "x")


def test_times_are_taken_in_their_unit_and_names_without_theirs(tmp_path):
    rows = "".join(f"{20 + 0.5 * k},{k * 0.1},{k}\n" for k in range(50))
    seen = captures.load(text(tmp_path, f"t (ms),command [mm],x_mm\n{rows}"))
    assert seen.columns == ("time", "command", "x_mm") and seen.units["command"] == "mm"
    assert seen.period_s == pytest.approx(0.0005) and seen.first_period == 40
    assert seen.signal("time")[0] == pytest.approx(0.02)


def test_a_run_folder_of_ours_is_a_capture(tmp_path):
    import leadscrew as ls

    run = ls.Experiment("npid_xytable", "paper.pid", "spindle_1000").loop().run(0.05, engine="python")
    seen = captures.load(run.save(tmp_path / "run"))
    assert np.array_equal(seen.signal("command"), run.signals["command"])
    assert seen.period_s == pytest.approx(run.loop.period)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("", "is empty"),
        ("a,b\n1,2\n2,3\n3,4\n", "neither a column of times nor a sampling period"),
        ("time,x\n0,1\n1,2\n", "three or more"),
        ("time;x\n0;1\n;2\n2;3\n3;4\n", "is no time"),
        ("time,x\n" + "".join(f"{k + 5 * (k > 5)},1\n" for k in range(20)), "from 11 s to 24 s"),
        ("time (parsec),x\n0,1\n1,2\n2,3\n", ""),
        ("time [parsec],x\n0,1\n1,2\n2,3\n", "parsec"),
        ("time,x\n0,one\n0.1,2\n0.2,3\n0.3,4\n", "is not a number"),
        ("hello world, how are you", "table"),
    ],
)
def test_what_is_wrong_with_a_log_is_said_in_one_sentence(content, says, tmp_path):
    try:
        captures.load(text(tmp_path, content))
    except DataError as refused:
        assert says in str(refused) and "\n" not in str(refused)
    else:
        assert not says


def test_what_is_not_there_is_said(tmp_path):
    for path in (tmp_path / "none.csv", tmp_path, tmp_path / "a\0b"):
        with pytest.raises(DataError):
            captures.load(path)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    rows = np.random.default_rng(0).normal(size=(60, 2))
    taken = Capture("one", ("time", "a"), {"a": "mm"}, 1e-3, 5, 20, rows, {"study": "x"})
    return {form: captures.save(taken, folder, "one", form).read_bytes() for form in FORMATS}


CHANGES = {
    "form": st.sampled_from(FORMATS),
    "places": st.lists(st.tuples(st.floats(0.0, 1.0), st.integers(0, 255)), max_size=8),
    "kept": st.one_of(st.just(1.0), st.floats(0.0, 1.0)),
}


def changed(whole, tmp_path, form, places, kept):
    data = bytearray(whole[form])
    for share, byte in places:
        data[int(share * (len(data) - 1))] = byte
    folder = tmp_path / "folder"
    held = captures.names(folder)
    try:
        seen = captures.received(folder, f"x.{form}", bytes(data[: int(kept * len(data))]), replace=True)
    except LeadscrewError as refused:
        assert str(refused) and "\n" not in str(refused) and str(tmp_path) not in str(refused)
        assert captures.names(folder) == held, "nothing of it is kept, nothing else is lost"
    else:
        assert seen.rows.dtype == np.float64 and seen.rows.shape[1] == len(seen.columns) and seen.period_s > 0.0


@settings(BYTES, max_examples=20)
@given(**{**CHANGES, "form": st.sampled_from(["csv", "parquet"])})
def test_a_capture_with_bytes_changed_or_cut_off_is_read_or_refused(whole, tmp_path, form, places, kept):
    changed(whole, tmp_path, form, places, kept)


@pytest.mark.slow
@settings(BYTES, max_examples=25)
@given(**{**CHANGES, "form": st.just("mat")})
def test_a_matlab_file_with_bytes_changed_is_read_or_refused_even_where_it_crashes_scipy(
    whole, tmp_path, form, places, kept
):
    changed(whole, tmp_path, form, places, kept)


@pytest.mark.slow
@settings(BYTES, max_examples=1500)
@given(**{**CHANGES, "form": st.sampled_from(["csv", "parquet"])})
def test_many_captures_with_bytes_changed_are_read_or_refused(whole, tmp_path, form, places, kept):
    changed(whole, tmp_path, form, places, kept)


SAID = ("name", "columns", "units", "period_s", "first_period", "trigger_row", "rows", "about")
VALUES = st.recursive(st.none() | st.booleans() | st.floats() | st.text(max_size=5), lambda x: st.lists(x, max_size=3))


@settings(BYTES, max_examples=40)
@given(said=VALUES, key=st.sampled_from(SAID))
def test_a_header_that_says_anything_is_read_or_refused(whole, tmp_path, said, key):
    import json

    lines = whole["csv"].decode().split("\n")
    at = next(k for k, line in enumerate(lines) if line.startswith("# leadscrew_capture: "))
    head = json.loads(lines[at].partition(": ")[2])
    lines[at] = f"# leadscrew_capture: {json.dumps({**head, key: said})}"
    try:
        captures.load(text(tmp_path, "\n".join(lines)))
    except DataError as refused:
        assert "x.csv" in str(refused) and "\n" not in str(refused)


@pytest.mark.parametrize(
    ("about", "why"), [("[" * 900 + "]" * 900, "nested"), (f'["{"x" * 5_000_000}"]', "up to 4 MB")]
)
def test_a_capture_that_says_too_much_of_itself_is_refused(whole, tmp_path, about, why):
    """Whoever shows it would run out of stack, or send it to every page."""
    content = whole["csv"].decode().replace('"about": {"study": "x"}', f'"about": {{"x": {about}}}')
    assert about in content
    with pytest.raises(DataError, match=why):
        captures.load(text(tmp_path, content), apart=True)


def test_a_small_matlab_file_that_inflates_to_much_is_refused_before_it_is_read(tmp_path):
    import struct

    packed = zlib.compress(bytes(60_000_000), 9)
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x0100) + b"IM"
    path = tmp_path / "bomb.mat"
    path.write_bytes(head + struct.pack("<II", 15, len(packed)) + packed)
    assert path.stat().st_size < 500_000
    with pytest.raises(DataError, match="MB of values"):
        captures.load(path)


def test_a_matlab_file_that_crashes_its_reader_is_refused_and_the_process_goes_on(whole, tmp_path):
    data = bytearray(whole["mat"])
    at = data.index(b"time") + 4  # The type of the first variable's values, 9 for doubles.
    assert data[at : at + 4] == b"\x09\0\0\0"
    data[at] = 255
    (tmp_path / "x.mat").write_bytes(bytes(data))
    with pytest.raises(DataError, match=r"x.mat: is broken so that its reader crashes"):
        captures.load(tmp_path / "x.mat")


@pytest.mark.slow
def test_a_large_log_is_read_in_a_process_of_its_own_to_the_same_bits(tmp_path, monkeypatch):
    rows = "".join(f"{k / 1000:.3f},{float(np.sin(k))!r}\n" for k in range(12_000))
    path = text(tmp_path, f"time (s),x [mm]\n{rows}")
    assert path.stat().st_size > capture_files.SMALL
    apart = captures.load(path)
    monkeypatch.setattr(capture_files, "SMALL", 1e9)
    here = captures.load(path)
    assert apart.rows.tobytes() == here.rows.tobytes() and apart.rows.shape == (12_000, 2)
    assert {**apart.__dict__, "rows": 0} == {**here.__dict__, "rows": 0}


def test_a_log_of_very_many_columns_is_refused_at_once(tmp_path):
    path = text(tmp_path, ",".join(f"c{k}" for k in range(1500)) + "\n" + ("1," * 1500 + "\n") * 4)
    with pytest.raises(DataError, match="has 1500 columns"):
        captures.load(path)


def test_a_small_parquet_file_of_very_many_rows_is_refused_before_it_is_read(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    path = tmp_path / "long.parquet"
    pq.write_table(pa.table({"time": np.zeros(7_000_000), "x": np.zeros(7_000_000)}), path)
    assert path.stat().st_size < 50_000_000
    with pytest.raises(DataError, match="MB of values"):
        captures.load(path)


def test_a_file_that_is_sent_is_kept_under_its_name_as_it_was(tmp_path):
    seen = captures.received(tmp_path, "scope of x.csv", HALSCOPE.encode())
    assert seen.name == "scope of x" and (tmp_path / "scope of x.csv").read_text() == HALSCOPE
    with pytest.raises(DataError, match="exists already"):
        captures.received(tmp_path, "scope of x.csv", HALSCOPE.encode())
    for name in ("x", "x.exe", "x.csv.exe", "../x.csv"):
        with pytest.raises(ValueRefused, match="allowed are"):
            captures.received(tmp_path, name, HALSCOPE.encode())
    assert [x.name for x in captures.names(tmp_path)] == ["scope of x.csv"]
