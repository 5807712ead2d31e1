"""Files that are too large, nested too deep, or broken on purpose: refused in a sentence, within bounded memory."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from leadscrew import replay, toml_file
from leadscrew.analysis.circular.file import read_circles
from leadscrew.analysis.following import read_logs
from leadscrew.analysis.positioning import read_positioning
from leadscrew.fuzzy import formats
from leadscrew.identify.cutting_force_table import read_force_table
from leadscrew.logs import read_table
from leadscrew.neural.performance import read_net
from leadscrew.panel.hal import file as hal_file
from leadscrew.paths.read import read_drawing
from leadscrew.tangent.measurement import read_measured
from leadscrew.tune.checkpoints import Journal
from leadscrew.util import parquet, reading
from leadscrew.util import separate_process as apart
from leadscrew.util.errors import DataError, LeadscrewError, ValueRefused

CORPUS = Path(__file__).with_name("corpus") / "0.1.0"
READERS = {
    "a.toml": toml_file.read, "b.toml": hal_file.read, "a.ngc": read_drawing, "a.svg": read_drawing,
    "a.dxf": read_drawing, "positioning.csv": read_positioning, "circles.csv": lambda path: read_circles(path, 100.0),
    "force.csv": read_force_table, "measured.csv": read_measured, "net.json": read_net, "log.csv": read_table,
    "log.mat": read_table, "log.parquet": read_table, "a.fll": formats.read,
}  # fmt: skip
"""Each by the name of a file that it takes."""


@pytest.mark.parametrize("name", READERS)
def test_a_file_of_many_gigabytes_is_refused_before_it_is_read(tmp_path, name):
    with (tmp_path / name).open("wb") as file:
        file.truncate(20_000_000_000)
    with pytest.raises(DataError, match=rf"{name}: 20 GB; .* --file-limits \d+ \(in Python: LEADSCREW_FILE_LIMITS=\d+"):
        READERS[name](tmp_path / name)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.toml", "a." * 20_000 + "a = 1"),
        ("a.toml", "a = " + "[" * 200_000),
        ("a.toml", "a = " + "{a = " * 500),
        ("a.toml", f"a = {'9' * 400}"),
        ("a.toml", "a = 99999999999999999999"),
        ("net.json", "[" * 200_000),
        ("net.json", '{"a":' * 500 + "1" + "}" * 500),
        ("net.json", '{"format": ' + "9" * 400 + "}"),
        ("net.json", '{"format": "\\ud800"}'),
    ],
)
def test_settings_that_nest_too_deep_or_hold_what_no_machine_does_are_refused(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    with pytest.raises(DataError, match=r"cannot be read as TOML|is not JSON"):
        READERS[name](tmp_path / name)


def test_a_pipe_is_read_no_further_than_a_file_may_be_long():
    with pytest.raises(DataError, match="settings up to 8 MB are read"):
        toml_file.read(Path("/dev/zero"))


def test_the_limits_are_raised_by_a_factor_and_a_wrong_one_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "a.toml"
    path.write_text("# " + "-" * 9_000_000 + "\na = 1\n")
    with pytest.raises(DataError, match="--file-limits 2 "):
        toml_file.read(path)
    monkeypatch.setenv(reading.VARIABLE, "2")
    assert toml_file.read(path) == {"a": 1}
    for wrong in ("0.5", "much", "nan", "1e9"):
        monkeypatch.setenv(reading.VARIABLE, wrong)
        with pytest.raises(ValueRefused, match="expected a number from 1 to 1000"):
            toml_file.read(path)


@pytest.mark.slow
def test_a_small_parquet_file_that_stands_for_gigabytes_is_refused(tmp_path):
    """Lists are left out unread; a word of a megabyte that stands in every row is counted before it is written out."""
    rows = 20_000
    long = pa.DictionaryArray.from_arrays(pa.array(np.zeros(rows, np.int32)), pa.array(["x" * 1_000_000]))
    lists = pa.ListArray.from_arrays(
        np.linspace(0, 20_000_000, rows + 1).astype(np.int32), pa.nulls(20_000_000, pa.int8())
    )
    pq.write_table(pa.table({"t": np.arange(float(rows)), "l": lists}), tmp_path / "lists.parquet")
    pq.write_table(pa.table({"t": np.arange(float(rows)), "w": long}), tmp_path / "words.parquet")
    assert (tmp_path / "lists.parquet").stat().st_size < 10_000_000
    assert parquet.read(tmp_path / "lists.parquet").other == ["l"]
    with pytest.raises(DataError, match="more than 100 million characters"):
        parquet.read(tmp_path / "words.parquet")


@pytest.mark.parametrize(
    ("key", "odd"),
    [
        ("parameters", []), ("record", 3), ("run", "x"), ("every", None), ("duration_s", []), ("engine", {}),
        ("origin", 7), ("seed", "x"), ("study", True), ("controller", 3), ("scenario", []), ("changes", [1]),
        ("changes", {"a": {}}),
    ],
)  # fmt: skip
def test_a_run_whose_manifest_holds_odd_things_is_refused_in_a_sentence(tmp_path, key, odd):
    whole = CORPUS / "runs" / "sampled"
    said = json.loads((whole / "run.json").read_text())
    (tmp_path / "signals.parquet").write_bytes((whole / "signals.parquet").read_bytes())
    (said if key in said else said["origin"])[key] = odd
    (tmp_path / "run.json").write_text(json.dumps(said))
    with pytest.raises(LeadscrewError, match=r"run\.json"):
        replay.replay(tmp_path)


@pytest.mark.parametrize("text", ["[]", "3", "null", "{}", '{"schema_version": 1}'])
def test_a_manifest_that_is_none_is_refused_in_a_sentence(tmp_path, text):
    (tmp_path / "signals.parquet").write_bytes((CORPUS / "runs" / "sampled" / "signals.parquet").read_bytes())
    (tmp_path / "run.json").write_text(text)
    with pytest.raises(DataError, match=r"run\.json"):
        replay.replay(tmp_path)


def test_a_run_that_says_it_is_longer_than_its_signals_is_not_run(tmp_path):
    whole = CORPUS / "runs" / "sampled"
    said = json.loads((whole / "run.json").read_text())
    (tmp_path / "signals.parquet").write_bytes((whole / "signals.parquet").read_bytes())
    (tmp_path / "run.json").write_text(json.dumps({**said, "duration_s": 1e9}))
    with pytest.raises(DataError, match="rows"):
        replay.replay(tmp_path)


def test_a_chunk_of_a_journal_that_is_compressed_counts_as_none(tmp_path):
    journal = Journal(tmp_path / "j", {"q": 1})
    journal.put(0, {"x": np.arange(3.0)})
    assert journal.get(0) is not None
    np.savez_compressed(journal.path(1), x=np.zeros(1_000_000))
    assert journal.get(1) is None


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("line.ngc", "G21 G90\nG0 X0 Y0\nG1 X99999999 Y5 F1000\n"),
        ("digits.ngc", f"G21 G90\nG0 X0 Y0\nG1 X{'9' * 308} F1000\nG1 Y{'9' * 308}\n"),
        ("curve.svg", '<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9">'
                      '<path d="M0 0 C4e6 0 4e6 4e6 0 4e6"/></svg>'),
    ],
)  # fmt: skip
def test_a_line_as_long_as_a_country_is_refused_before_its_places_are_computed(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    with pytest.raises(DataError, match="a coordinate beyond 1 km: is the unit right"):
        read_drawing(tmp_path / name)


def test_a_header_of_many_brackets_and_a_log_of_one_row_or_of_no_size_are_said_and_soon(tmp_path):
    rows = "\n".join(f"{k / 1000},{k},{k}" for k in range(300))
    for header in (f"time,position({'a' * 200_000},drive", "# " + "a [ " * 100_000 + "\ntime,position,drive"):
        (tmp_path / "log.csv").write_text(f"{header}\n{rows}\n")
        began = time.process_time()
        read_table(tmp_path / "log.csv")
        assert time.process_time() - began < 10.0
    (tmp_path / "one.csv").write_text("time,command,actual\n0,1,2\n")
    with pytest.raises(DataError, match="1 row of data: three or more"):
        read_logs([tmp_path / "one.csv"])
    (tmp_path / "none.csv").write_text("time,x\n" + "".join(f"{k}e-320,{k}\n" for k in range(300)))
    with pytest.raises(DataError, match=r"largest value is 2\.99\d*e-318"):
        read_table(tmp_path / "none.csv").numbers("time")


# ---- the process that reads
def test_a_module_that_lies_in_the_working_folder_is_not_run_by_reading_data(tmp_path):
    for module in ("pyarrow", "numpy", "scipy", "json"):
        (tmp_path / f"{module}.py").write_text("open('ran', 'w')\n")
    signals = CORPUS / "runs" / "sampled" / "signals.parquet"
    done = subprocess.run(
        [sys.executable, "-P", "-m", "leadscrew", "log", signals],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "rows" in done.stdout and not (tmp_path / "ran").exists(), done.stderr


def test_after_a_file_that_kills_its_reader_the_next_one_is_read(tmp_path):
    for module, said in (
        ("killed", "is broken so that its reader crashes"),
        ("hoards", "memory"),
    ):
        with pytest.raises(DataError, match=said):
            apart.run(f"tests.apart_{module}", tmp_path / "a", tmp_path / "out")
        assert parquet.read(CORPUS / "runs" / "sampled" / "signals.parquet").rows > 0


def test_a_file_that_is_not_read_in_time_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr(apart, "SECONDS", 0.2)
    monkeypatch.setattr(apart, "_idle", [])
    with pytest.raises(DataError, match=r"was not read after 0\.2 s"):
        apart.run("tests.apart_hangs", tmp_path / "a", tmp_path / "out")


@pytest.mark.slow
def test_files_within_the_limits_that_ask_for_much_memory_stay_below_two_gigabytes(tmp_path):
    """Each in a process of its own; what they take is the most that any of them or their readers took."""
    files = {
        "positioning.csv": "\n" * 19_900_000, "circles.csv": "1,2\n" * 4_900_000, "a.toml": "[[a]]\n" * 1_300_000,
        "net.json": "[" + "[]," * 10_000_000 + "1]", "a.ngc": "X1\n" * 10_000_000, "log.csv": "\n" * 50_000_000,
        "a.svg": "<svg>" + "<g/>" * 4_000_000 + "</svg>", "a.fll": "\n" * 31_000_000,
    }  # fmt: skip
    for name, text in files.items():
        (tmp_path / name).write_text(text)
        code = (
            "import sys; from pathlib import Path; from tests.test_reading import READERS\n"
            "from leadscrew.util.errors import LeadscrewError\n"
            "try: READERS[sys.argv[2]](Path(sys.argv[1]) / sys.argv[2])\n"
            "except LeadscrewError as refused: print(refused)\n"
            "import resource; print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
        )
        done = subprocess.run(
            [sys.executable, "-c", code, str(tmp_path), name], capture_output=True, text=True, check=False,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr[-2000:]
        assert int(done.stdout.splitlines()[-1]) * 1024 < 2 * 1024**3, name
