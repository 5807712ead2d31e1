"""Files of other programs: Parquet, MATLAB and Octave, LinuxCNC's halscope and halsampler, and our own runs."""

import json
import shutil
import subprocess

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.io import savemat

from leadscrew.export import hal_run
from leadscrew.logs import read_axis_log, read_table
from leadscrew.util.errors import DataError
from tests.logs.records import moves
from tests.tools import missing

TIME, DRIVE, POSITION, COMMAND = moves()


def same(table, **columns):
    for name, values in columns.items():
        np.testing.assert_array_equal(table.columns[name], values)


def test_parquet_keeps_numbers_words_truth_values_times_and_units(tmp_path):
    stamps = pa.array(1_700_000_000_000_000_000 + 1_000_000 * np.arange(3), pa.timestamp("ns"))
    fields = {
        "when": stamps, "x": pa.array([1, 2, None], pa.int32()), "on": pa.array([True, False, True]),
        "phase": pa.array(["up", None, "down"]), "list": pa.array([[1], [2], [3]]),
        "pos [mm]": pa.array([0.1, 0.2, 0.3]),
    }  # fmt: skip
    schema = pa.schema([pa.field(n, a.type, metadata={"unit": "um"} if n == "x" else None) for n, a in fields.items()])
    pq.write_table(pa.table(fields, schema=schema), tmp_path / "a.parquet")
    shutil.copy(tmp_path / "a.parquet", tmp_path / "renamed.log")
    for name in ("a.parquet", "renamed.log"):
        table = read_table(tmp_path / name)
        same(table, x=[1.0, 2.0, np.nan], on=[1.0, 0.0, 1.0])
        np.testing.assert_allclose(table.columns["when"], [0.0, 0.001, 0.002], atol=1e-12)
        assert table.texts == {"phase": ["up", "", "down"]} and table.units == {
            "when": "s",
            "x": "um",
            "pos [mm]": "mm",
        }
        assert table.notes == ["left out, being neither numbers nor words: list"]


@pytest.mark.parametrize("version", ["5", "4"])
def test_matlab_vectors_are_columns_and_single_numbers_constants(tmp_path, version):
    held = {"t": TIME[:, None], "qm": POSITION[None, :], "vir": DRIVE, "Ts": 1e-3, "odd": np.arange(7.0)}
    savemat(tmp_path / "a.mat", held, format=version)
    table = read_table(tmp_path / "a.mat")
    same(table, t=TIME, qm=POSITION, vir=DRIVE)
    assert table.constants == {"Ts": 1e-3} and table.period == 1e-3
    assert table.notes == ["'odd' has 7 values where the others have 3000: left out"]


def test_a_matlab_structure_is_looked_into_and_its_period_makes_the_times(tmp_path):
    inside = {"pos": POSITION, "u": DRIVE, "who": "me"}
    savemat(
        tmp_path / "a.mat", {"log": inside, "Ts": 1e-3, "both": np.column_stack([TIME, DRIVE])}, do_compression=True
    )
    table = read_table(tmp_path / "a.mat")
    same(table, **{"log.pos": POSITION, "log.u": DRIVE, "both_1": TIME, "both_2": DRIVE})
    assert any("log.who" in note for note in table.notes)
    log = read_axis_log(tmp_path / "a.mat", {"position": "log.pos", "drive": "log.u"})
    np.testing.assert_allclose(log.time, TIME, atol=1e-12)


@pytest.mark.slow
def test_a_broken_matlab_file_and_one_of_version_7_3_are_refused_with_the_fix(tmp_path):
    savemat(tmp_path / "a.mat", {"x": np.arange(500.0)})
    whole = (tmp_path / "a.mat").read_bytes()
    (tmp_path / "cut.mat").write_bytes(whole[:900])
    with pytest.raises(DataError, match=r"cut\.mat: is no MATLAB file that can be read"):
        read_table(tmp_path / "cut.mat")
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + b"\0" * 8 + b"\x00\x02IM"
    (tmp_path / "new.mat").write_bytes(head + b"\x89HDF\r\n\x1a\n" + b"\0" * 600)
    with pytest.raises(DataError, match=r"new\.mat: (is a MATLAB file of version 7\.3 .* '-v7'|cannot be read)"):
        read_table(tmp_path / "new.mat")
    savemat(tmp_path / "words.mat", {"name": "only words"})
    with pytest.raises(DataError, match="holds no vectors of numbers, only name"):
        read_table(tmp_path / "words.mat")


@pytest.mark.slow
@pytest.mark.parametrize("form", ["-v7", "-v6", "-text"])
def test_octave_writes_what_is_read(tmp_path, form):
    if shutil.which("octave") is None:
        missing("octave", "octave is not installed")
    program = "t = (0:99)'/1000; s.pos = t.^2; u = sin(t); Ts = 0.001; save('%s', 'a.mat', 't', 's', 'u', 'Ts');"
    subprocess.run(
        ["octave", "-q", "--eval", program % form], cwd=tmp_path, check=True, timeout=60, capture_output=True
    )
    if form == "-text":
        with pytest.raises(DataError, match="is no MATLAB file"):
            read_table(tmp_path / "a.mat")
        return
    t = np.arange(100) / 1000
    table = read_table(tmp_path / "a.mat")
    np.testing.assert_allclose(table.columns["s.pos"], t**2, rtol=1e-14)
    np.testing.assert_allclose(table.columns["u"], np.sin(t), rtol=1e-14)
    assert table.period == 0.001


def test_halscope_of_linuxcnc_2_9_gives_names_and_period(tmp_path):
    lines = [f"{u:.14f};{x:.14f};{c:.14f}" for u, x, c in zip(DRIVE, POSITION, COMMAND, strict=True)]
    head = "# Sampling period is 1000000 ns\njoint.0.torque;joint.0.motor-pos-fb;joint.0.motor-pos-cmd\n"
    for name, more in (("a.csv", ""), ("b.csv", "# Position: 0.5;0.5;0.5\n# Scale: 0;0;0\n")):
        (tmp_path / name).write_text(head + more + "\n".join(lines) + "\n")
        table = read_table(tmp_path / name)
        assert table.form == "LinuxCNC halscope" and table.period == pytest.approx(1e-3) and table.rows == 3000
        log = read_axis_log(tmp_path / name, units={"drive": "N"})
        np.testing.assert_allclose(log.position, POSITION, atol=1e-14)
        np.testing.assert_allclose(log.command, COMMAND, atol=1e-14)
        assert log.time[-1] == pytest.approx(2.999)


@pytest.mark.parametrize("word", ["nSec ", "ns "])
def test_an_older_halscope_names_its_channels_in_every_row(tmp_path, word):
    rows = [f"axis.0.fb {x:+.14f} pid.0.output {u:+.14f} " for x, u in zip(POSITION, DRIVE, strict=True)]
    (tmp_path / "a.log").write_text(f"Sampling period is 1000000 {word}\n\n" + "\n".join(rows))
    table = read_table(tmp_path / "a.log")
    assert table.form == "LinuxCNC halscope" and table.period == pytest.approx(1e-3)
    np.testing.assert_allclose(table.columns["pid.0.output"], DRIVE, atol=1e-13)
    assert read_axis_log(tmp_path / "a.log").time[-1] == pytest.approx(2.999)


def test_halsampler_has_no_header_and_its_lost_samples_are_refused(tmp_path):
    rows = [f"{k} {u:f} {x * 1e3:f} " for k, (u, x) in enumerate(zip(DRIVE, POSITION, strict=True))]
    path = tmp_path / "a.txt"
    path.write_text("\n".join(rows))
    told = {"time": "c1", "drive": "c2", "position": "c3"}, {"time": "0.001 s", "position": "mm", "drive": "N"}
    log = read_axis_log(path, *told)
    np.testing.assert_allclose(log.position, POSITION, atol=1e-9)
    assert log.period == pytest.approx(1e-3)
    path.write_text("\n".join([*rows[:1000], "overrun", *rows[1200:]]))
    assert read_table(path).lost == (1000,)
    with pytest.raises(DataError, match=r"a gap of 0\.201 s before row 1002 .* --start 1\.2 --end 2\.999"):
        read_axis_log(path, *told)
    untagged = [row.split(" ", 1)[1] for row in rows]
    path.write_text("\n".join([*untagged[:1000], "overrun", *untagged[1200:]]))
    with pytest.raises(DataError, match=r"lost samples 1 times \('overrun'\), first before row 1002"):
        read_axis_log(path, {"drive": "c1", "position": "c2"}, {"position": "mm"}, period=1e-3)


@pytest.mark.slow
def test_a_real_halsampler_writes_what_is_read():
    if reason := hal_run.lacking():
        missing("linuxcnc", reason)
    lines = [
        "loadrt threads name1=servo period1=1000000", "loadrt siggen", "loadrt sampler depth=4000 cfg=ffb",
        "addf siggen.0.update servo", "addf sampler.0 servo", "net a siggen.0.sine => sampler.0.pin.0",
        "net b siggen.0.cosine => sampler.0.pin.1", "setp siggen.0.frequency 2", "start",
        "loadusr -w halsampler -t -n 1000 {place}/fifo/sampled.txt",
    ]  # fmt: skip
    with hal_run.workplace() as place:
        hal_run.run(place, "\n".join(lines).format(place=place) + "\n", speed=1)
        table = read_table(place / "fifo" / "sampled.txt")
    assert list(table.columns) == ["c1", "c2", "c3", "c4"] and table.rows == 1000
    np.testing.assert_array_equal(np.diff(table.columns["c1"]), 1.0)
    # Printed with six digits behind the point.
    np.testing.assert_allclose(table.columns["c2"] ** 2 + table.columns["c3"] ** 2, 1.0, atol=3e-6)


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    signals = {"time": TIME, "command.position": 1e3 * COMMAND, "feedback": 1e3 * POSITION, "output": DRIVE}
    pq.write_table(pa.table({**signals, "applied": DRIVE, "actual": 1e3 * POSITION}), folder / "signals.parquet")
    units = {"plant": "mm", "controller": "N m", "sensor": "mm"}
    (folder / "run.json").write_text(json.dumps({"units": units, "period_s": 1e-3, "parameters": {}}))
    return folder


def test_a_folder_of_simulate_needs_nothing_told(run_folder):
    for path in (run_folder, run_folder / "run.json", str(run_folder)):
        log = read_axis_log(path)
        assert log.unit == ("m", "N m") and log.period == pytest.approx(1e-3)
        np.testing.assert_allclose(log.position, POSITION, atol=1e-15)
        np.testing.assert_allclose(log.command, COMMAND, atol=1e-15)


def test_a_folder_that_is_none_of_simulate_is_refused(tmp_path):
    with pytest.raises(DataError, match=r"is a folder without signals\.parquet"):
        read_table(tmp_path)


def test_a_folder_whose_blocks_name_a_python_file_does_not_run_it(run_folder, tmp_path):
    shutil.copytree(run_folder, tmp_path / "a")
    python = tmp_path / "evil.py"
    python.write_text(f"open({str(tmp_path / 'ran')!r}, 'w').close()\n")
    blocks = dict.fromkeys(("plant", "controller", "reference", "sensor", "disturbance"), f"{python}:block")
    (tmp_path / "a" / "run.json").write_text(json.dumps({"blocks": blocks, "parameters": {}}))
    assert "feedback" not in read_table(tmp_path / "a").units
    assert not (tmp_path / "ran").exists()
