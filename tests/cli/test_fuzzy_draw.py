"""``leadscrew fuzzy surface``, ``activity``, ``bench``: pictures, tables and rows of a system, and what is refused."""

from __future__ import annotations

import sys
import types
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.explanation import activity
from tests.cli.conftest import left, strict_json
from tests.fuzzy.systems import sugeno


# ---- surface
def test_surface_tables_are_what_the_system_computes(call, servo, tmp_path):
    for suffix, between in (("csv", ","), ("fld", None)):
        out = tmp_path / f"table.{suffix}"
        assert "u over e and de; 49 points" in call("fuzzy", "surface", servo, "--points", 7, "-o", out).stdout
        head, *lines = out.read_text().splitlines()
        assert head.split(between) == ["e", "de", "u"]
        rows = np.array([[float(x) for x in line.split(between)] for line in lines])
        assert np.array_equal(rows[:, 2], compiled(sugeno()).many(rows[:, :2]))
        assert rows[1, 0] == rows[0, 0] and rows[1, 1] > rows[0, 1]


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_surface_pictures(call, servo, tmp_path, suffix):
    out = tmp_path / f"s.{suffix}"
    found = call("fuzzy", "surface", servo, "--x", "de", "--points", 11, "--kind", "map", "-o", out, "--json")
    found = strict_json(found.stdout)
    assert found["inputs"] == ["de", "e"] and found["points"] == 121 and found["without_value"] == 0
    assert out.read_bytes()[:4] in (b"\x89PNG", b"<?xm", b"%PDF")


def test_surface_of_one_input_says_how_much_has_no_value(call, feeder, tmp_path):
    out = call("fuzzy", "surface", feeder, "--points", 11, "-o", tmp_path / "s.csv").stdout
    assert "feed over gap; 11 points" in out and "3 of 11 points have no value" in out


def test_surface_refusals_leave_no_file(refused, servo, tmp_path):
    out = tmp_path / "s.png"
    for args, words in (
        (("--x", "f"), "no input 'f'"),
        (("--output", "v"), "no output 'v'"),
        (("--at", "e=1"), "the input e is drawn"),
        (("--at", "e"), "--at 'e': expected NAME=VALUE"),
        (("--points", 1), "allowed are 2 to"),
        (("--kind", "flat"), "there are both, map, 3d"),
    ):
        assert words in refused("fuzzy", "surface", servo, "-o", out, *args)
    assert left(tmp_path) == ["servo.fll"]


@pytest.mark.slow
def test_a_file_is_never_there_in_part(refused, servo, tmp_path, monkeypatch):
    out = tmp_path / "s.csv"
    out.write_text("before")

    def full(self, target):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    for name in ("s.csv", "s.png", "s.fld"):
        said = refused("fuzzy", "surface", servo, "--points", 5, "-o", tmp_path / name)
        assert "cannot be written: No space left on device" in said
    assert left(tmp_path) == ["s.csv", "servo.fll"] and out.read_text() == "before"
    monkeypatch.undo()
    assert "cannot be written" in refused("fuzzy", "surface", servo, "--points", 5, "-o", out / "below" / "s.csv")


# ---- activity
@pytest.fixture
def run(tmp_path: Path) -> Path:
    """What ``leadscrew simulate --out`` writes, as far as it matters here."""
    t = np.arange(40) * 0.01
    folder = tmp_path / "run"
    folder.mkdir()
    error = 50.0 * np.exp(-5.0 * t)
    pq.write_table(pa.table({"time": t, "error": error, "output": 0.01 * error}), folder / "signals.parquet")
    return folder


def test_activity_counts_the_rules_of_a_run(call, servo, run):
    args = ("fuzzy", "activity", servo, run, "--map", "e=0.02*error", "--map", "de = 0.2*change(error)")
    found = strict_json(call(*args, "--json").stdout)
    error = pq.read_table(run / "signals.parquet").column("error").to_numpy()
    x = np.column_stack([0.02 * error, 0.2 * np.diff(error, prepend=error[0])])
    strengths = activity(sugeno(), x)
    assert found["rows"] == 40 and found["unit"] == "s" and found["no_rule_fires"] == 0.0
    assert found["map"] == {"e": "0.02*error", "de": "0.2*change(error)"}
    for rule, w in zip(found["rules"], strengths.T, strict=True):
        assert rule["seconds"] == pytest.approx(0.01 * (w > 0.0).sum())
        assert rule["strongest"] == w.max()
    fired = int(strengths.any(axis=0).sum())
    out = call(*args).stdout
    assert f"sugeno49: {fired} of 49 rules fired in 40 rows" in out
    assert f"never fired: {49 - fired}" in out and "   1  if e is NB and de is NB then u is NB" in out
    table = [line for line in out.splitlines() if " if e is" in line and "." in line.split("if")[0]]
    longest = [float(line.split()[1]) for line in table]
    assert len(longest) == fired and longest == sorted(longest, reverse=True)


def test_rate_is_the_change_over_time(call, feeder, tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("# a log\nclock,x\n0,1\n0.5,3\n1.5,6\n")
    out = tmp_path / "a.csv"
    call("fuzzy", "activity", feeder, path, "--map", "gap=-2*rate(x)", "--time", "clock", "-o", out)
    assert out.read_text().splitlines() == [
        "time,gap,rule 1,rule 2", "0.0,-0.0,1.0,0.0", "0.5,-8.0,1.0,0.0", "1.5,-6.0,1.0,0.0",
    ]  # fmt: skip


def test_a_run_without_times_is_counted_in_rows(call, feeder, tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("gap\n0\n5\n10\n")
    out = call("fuzzy", "activity", feeder, path, "-o", tmp_path / "a.png").stdout
    assert "no rule fired in 33.3 % of the rows" in out and "fired (rows)" in out
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ((), "no column 'e' for the input e; say where it comes from: --map e=COLUMN, columns are time, error, output"),
        (("--map", "e=err", "--map", "de=error"), "the column 'err' is missing; did you mean error"),
        (("--map", "e=big*error", "--map", "de=error"), "scale = 'big': expected a number"),
        (("--map", "f=error"), "no input 'f'"),
        (("--map", "e"), "--map 'e': expected NAME=VALUE"),
        (("--map", "e=error", "--map", "de=error", "--time", "output"), "the times must rise"),
        (("-o", "x.txt"), "allowed are .png, .svg, .pdf, .csv"),
    ],
)
def test_activity_refusals(refused, servo, run, args, words):
    assert words in refused("fuzzy", "activity", servo, run, *args)


# ---- bench
def test_bench_prints_the_rows_it_gets(call, refused, servo, monkeypatch):
    seen = []

    def bench_file(system, points=100_000):
        seen.append((system.name, points))
        return [
            {"name": "llvm", "what": "one point", "value": 512.25, "unit": "ns", "ratio": 1.0, "remark": ""},
            {"name": "python", "what": "one point", "value": None, "unit": "us", "ratio": None, "remark": "not here"},
        ]

    made = types.ModuleType("leadscrew.bench.fuzzy")
    made.bench_file = bench_file
    monkeypatch.setitem(sys.modules, "leadscrew.bench.fuzzy", made)
    out = call("fuzzy", "bench", servo, "--points", 1000).stdout
    assert "512.2" in out and "not here" in out and "ratio" in out
    found = strict_json(call("fuzzy", "bench", servo, "--json").stdout)
    assert found["points"] == 100_000 and found["rows"][1]["value"] is None
    assert seen == [("sugeno49", 1000), ("sugeno49", 100_000)]
    assert "--points 0" in refused("fuzzy", "bench", servo, "--points", 0)
