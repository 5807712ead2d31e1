"""``leadscrew montecarlo``: its report, its refusals, its exit codes; and the worst runs run again."""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys

import numpy as np
import pyarrow.parquet as pq
import pytest

from leadscrew.cli.montecarlo_work import Asked
from leadscrew.util.errors import DataError, ValueRefused
from leadscrew.util.system import peak_memory
from tests.cli.conftest import strict_json
from tests.tune.noisy_loop import DIVERGING, FILE, NAME


@pytest.fixture
def asked(tmp_path, monkeypatch):
    """The start of a command line."""
    monkeypatch.chdir(tmp_path)
    return ("montecarlo", NAME, "-c", "p", "-s", "small", "--over", "plant.lag_s=0.02:0.08", "--runs", "200")


@pytest.mark.slow
def test_a_report_with_everything(call, asked, tmp_path):
    more = (
        "-s", "large", "--over", "controller.kp=normal:4:0.5", "--tolerance", "rms_error@small<=0.3", "--tolerance",
        "overshoot<=0.1", "--sobol", "16", "--wear", "plant.lag_s=x1:x2", "--life", "3", "--worst", "2", "-o", "out",
    )  # fmt: skip
    out = call(*asked, *more).stdout
    for words in (
        "rms_error@small<=0.3",
        "all together",
        "which runs fail",
        "rank correlation",
        "Sobol",
        "of the life",
        "runs/s",
        "MiB",
    ):
        assert words in out, words
    shown = {p.name for p in (tmp_path / "out").iterdir()}
    assert {"report.html", "samples.parquet", "summary.json", "worst", "sensitivity.png", "sobol.png"} <= shown
    assert {"rms_error.png", "life_rms_error.png", "life_yield.png"} <= shown
    assert not (tmp_path / "out.journal").exists()
    page = (tmp_path / "out" / "report.html").read_text()
    assert (tmp_path / "out" / "fails_rms_error_small_at_most_0.3.png").exists()
    assert (
        page.count("data:image/") == 4 + 1 + 2 + 5 and "<script" not in page and "http" not in page.split("<body>")[1]
    )
    table = pq.read_table(tmp_path / "out" / "samples.parquet")
    assert table.num_rows == 400 and {"run", "scenario", "plant.lag_s", "rms_error", "diverged_at"} <= {
        *table.column_names
    }
    said = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert said["runs"] == 200 and said["metrics"][0]["unit"] == "mm" and len(said["sobol"]) == 2 * 2 * 4
    values = table.column("rms_error").to_numpy()[:200]
    assert said["yields"][0]["passed"] == (values <= 0.3).sum()
    failed, lag = values > 0.3, table.column("plant.lag_s").to_numpy()[:200]
    (row,) = [f for f in said["failures"] if f["key"] == "plant.lag_s"]
    assert (row["failed"], row["low"]) == (failed.sum(), lag[failed].min()) and "Which runs fail" in page
    assert f"{row['failed']} of {row['inside']} fail" in page and f"{row['failed']} of {row['inside']} fail" in out
    assert "Latin hypercube" in said["notes"][0] and page.count("derived for independent runs") == 3
    assert {s["total_known"] for s in said["sobol"]} <= {True, False}
    for row in said["worst"]:
        assert row["command"] in out
        again = call(*shlex.split(row["command"])[1:], "--trust", "--json", code=None)
        assert json.loads(again.stdout)["metrics"][row["of"].removesuffix("_small")] == row["value"]


@pytest.mark.slow
def test_json_is_strict_and_the_same_for_any_crew(call, asked):
    one, two = (strict_json(call(*asked, "--threads", n, "--json", "--no-figures").stdout) for n in (1, 2))
    assert one.pop("cost")["crew"] == "1 thread" and two.pop("cost")["crew"] == "2 threads"
    assert one == two and one["joint"]["value"] == 1.0 and one["report"].endswith("noisy.py:STUDY") is False
    assert one["report"] == "report/STUDY_montecarlo/report.html"


@pytest.mark.slow
def test_runs_that_are_one_run_are_said_to_be(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    quiet = ("montecarlo", NAME, "-c", "p", "-s", "small", "--set", "sensor.noise_mm=0", "--runs", "20")
    done = call(*quiet, "--tolerance", "rms_error<=10", "--wear", "plant.lag_s=x1:x100", "--life", "2", "-o", "out")
    assert "all 20 runs are the same run" in done.stderr and done.stderr.count("\n") == 1
    assert "100 %  –" in done.stdout and "95 %:" not in done.stdout and "20 of 20" in done.stdout
    page = (tmp_path / "out" / "report.html").read_text()
    assert "All 20 runs are the same run" in page and "95 %:" not in page
    said = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert "the same run" in said["notes"][0] and said["joint"]["low"] is None
    assert call(*quiet[:-1], "1", "-o", "one").stderr == ""


@pytest.mark.slow
def test_sobol_indices_that_nobody_can_know_are_not_shown(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # At the shortest lags the error grows a hundredfold, yet nothing diverges.
    wild = ("--over", "plant.lag_s=0.0016:0.08:log", "--over", "controller.kp=3:4", "--duration", "0.05")
    done = call("montecarlo", NAME, "-c", "p", *wild, "--runs", "50", "--sobol", "8", "-o", "out")
    said = json.loads((tmp_path / "out" / "summary.json").read_text())
    lost = [s for s in said["sobol"] if not s["total_known"]]
    assert lost and all(s["total_width"] > 1 for s in lost) and "take a larger N than 8" in done.stdout
    assert "not known" in done.stdout and "take a larger N than 8" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.slow
def test_a_worst_run_knows_its_controller_file(call, refused, asked, tmp_path):
    file = tmp_path / "tuned.toml"
    text = f'schema_version = 1\nkind = "controller"\nstudy = "{NAME}"\ncontroller = "p"\n[set]\nkp = 4.5\n'
    file.write_text(text)
    call("montecarlo", NAME, "-c", "tuned.toml", *asked[4:], "-o", "out", "--no-figures", "--worst", "1")
    row = json.loads((tmp_path / "out" / "summary.json").read_text())["worst"][0]
    again = ("simulate", "out/" + row["file"], "--trust")
    assert strict_json(call(*again, "--json", "--out", "run").stdout)["metrics"][row["of"]] == row["value"]
    file.write_text(text.replace("4.5", "4.6"))
    said = refused(*again)
    assert f"{file} has changed since" in said and "put the old file back" in said and "[files]" in said
    assert "has changed since" in refused("montecarlo", *again[1:], "--runs", "2", "-o", "more")
    # A run folder holds every parameter: it is the same run still, and would say so if it were not.
    assert "identical" in call("replay", "run", "--trust").stdout
    assert call(*again, "-c", "p").stderr == ""
    file.write_text(text)
    assert strict_json(call(*again, "--json").stdout)["metrics"][row["of"]] == row["value"]
    file.unlink()
    assert "tuned.toml" in refused(*again)


def test_what_a_killed_process_left_is_cleared_and_nothing_else(call, asked, tmp_path):
    (tmp_path / "reports").mkdir()
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    kill = """
import os, signal, sys
from leadscrew.report.montecarlo import placed
with placed(sys.argv[1]) as beside:
    (beside / "half.txt").write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""
    out = tmp_path / "reports" / "out"
    assert subprocess.run([sys.executable, "-c", kill, out], check=False).returncode == -signal.SIGKILL
    (left,) = out.parent.iterdir()
    machine = left.name.removeprefix(".out-").split("-")[0]
    kept = {
        f".out-{machine}-{os.getpid()}-0123abcd.partial", f".out-elsewhere-{dead.pid}-0123abcd.partial",
        ".out-mine.partial", f".output-{machine}-{dead.pid}-0123abcd.old", f".out-{machine}-{dead.pid}-0123abcd.txt",
    }  # fmt: skip
    for name in kept:
        (out.parent / name).mkdir()
    (out.parent / f".out-{machine}-{dead.pid}-0123abcd.old").mkdir()
    call(*asked, "-o", out, "--no-figures")
    assert {p.name for p in out.parent.iterdir()} == {"out", *kept}


def test_an_older_report_is_replaced_and_other_folders_are_not(call, refused, asked, tmp_path):
    call(*asked, "-o", "out", "--no-figures", "--seed", 1)
    call(*asked, "-o", "out", "--no-figures", "--seed", 2)
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["seed"] == 2
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("mine")
    assert "choose another folder" in refused(*asked, "-o", "mine")
    (tmp_path / "file").write_text("")
    assert "not a folder" in refused(*asked, "-o", "file")


def test_a_journal_of_ones_own_stays_and_is_gone_on_with(call, refused, asked, tmp_path):
    call(*asked, "--journal", "kept", "--no-figures", "-o", "a")
    assert (tmp_path / "kept" / "chunk_0000000.npz").exists()
    assert "--resume" in refused(*asked, "--journal", "kept", "-o", "a")
    assert "(different: runs)" in refused(*asked, "--runs", "201", "--journal", "kept", "--resume", "-o", "a")
    assert "(different: over)" in refused(*asked, "--over", "controller.kp=3:4", "--journal", "kept", "-o", "a")
    found = strict_json(call(*asked, "--journal", "kept", "--resume", "--no-figures", "-o", "b", "--json").stdout)
    assert found["cost"]["runs"] == 0


def test_what_may_be_mended_keeps_what_is_done_and_what_would_come_again_does_not(
    call, refused, asked, tmp_path, monkeypatch
):
    def raising(error):
        def fail(*_):
            raise error

        monkeypatch.setattr("leadscrew.cli.montecarlo_work.write_report", fail)

    raising(DataError("out cannot be written: No space left on device"))
    said = refused(*asked, "-o", "out")
    assert "No space left on device; 200 runs are kept in " in said
    command = shlex.split(said.partition("go on with: leadscrew ")[2])
    assert (tmp_path / "out.journal" / "chunk_0000000.npz").exists()
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    assert strict_json(call(*command, "--no-figures", "--json").stdout)["cost"]["runs"] == 0
    assert not (tmp_path / "out.journal").exists()
    raising(ValueRefused("no"))
    refused(*asked, "-o", "other")
    assert not (tmp_path / "other.journal").exists()


def test_when_every_run_diverges_the_exit_code_says_so(call, asked, tmp_path):
    result = call(*asked[:-4], "--over", DIVERGING[0], "--runs", "20", "-o", "out", code=3)
    assert "all 20 runs diverged, the first at 0.00" in result.stderr and result.stderr.count("\n") == 1
    assert "20" in result.stdout and (tmp_path / "out" / "worst" / "diverged_1.toml").exists()
    again = call("simulate", tmp_path / "out" / "worst" / "diverged_1.toml", "--trust", code=3)
    assert "diverged" in again.stderr


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--over", "controller.kp=4:3"), "the range 4:3 is empty"),
        (("--over", "controller.kp=fast"), "expected LOW:HIGH"),
        (("--over", "controller.kq=3:4"), "did you mean controller.kp"),
        (("--over", "plant.lag_s=3:4"), "given twice"),
        (("--tolerance", "overshot<=1"), "did you mean overshoot"),
        (("--tolerance", "overshoot<=1", "--tolerance", "overshoot>=2"), "contradict each other"),
        (("--tolerance", "overshoot=1"), "expected METRIC<=VALUE"),
        (("--sampling", "halton"), "no sampling 'halton'"),
        (("--runs", "0"), "runs"),
        (("--sobol", "100"), "powers of two"),
        (("--wear", "plant.lag_s=0.1:0.2"), "is distributed as well"),
        (("--wear", "controller.kp=4:2", "--life", "1"), "--life"),
        (("--level", "100"), "--level 100"),
        (("-s", "smal"), "did you mean small"),
        (("-c", "q"), "no controller 'q'"),
        (("--set", "controller.kp=x"), "expected a number"),
        (("--duration", "0"), "duration"),
        (("--cluster", "local"), "expected local:N or tcp://HOST:PORT"),
        (("--cluster", "local:2", "--threads", "2"), "exclude each other"),
        (("--cluster", "tcp://127.0.0.1:1"), "no Dask scheduler answers at tcp://127.0.0.1:1"),
    ],
)
def test_what_makes_no_sense_is_one_sentence(refused, asked, tmp_path, more, words):
    assert words in refused(*asked, *more)
    assert [p.name for p in tmp_path.iterdir()] in ([], ["report"])


def test_a_loop_and_an_experiment_file_will_do(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call("montecarlo", f"{FILE}:LOOP", "--duration", "0.05", "--runs", "20", "--no-figures", "-o", "loop")
    again = call("simulate", "loop/worst/rms_error_1.toml", "--trust", "--json").stdout
    worst = json.loads((tmp_path / "loop" / "summary.json").read_text())["worst"][0]
    assert (
        strict_json(again)["metrics"]["rms_error"] == worst["value"] and strict_json(again)["replicate"] == worst["run"]
    )
    (tmp_path / "e.toml").write_text(
        f'schema_version = 1\nstudy = "{NAME}"\ncontroller = "p"\nscenario = "large"\nduration = 0.1\nseed = 5\n'
    )
    found = strict_json(call("montecarlo", "e.toml", "--trust", "--runs", "20", "--no-figures", "--json").stdout)
    assert found["scenarios"] == ["large"] and found["duration_s"] == [0.1] and found["seed"] == 5


def test_the_noise_of_a_run_is_named_by_its_number(call, refused, tmp_path):
    asked = ("simulate", NAME, "-c", "p", "-s", "small", "--json")
    values = [strict_json(call(*asked, "--replicate", k).stdout)["metrics"]["rms_error"] for k in (0, 7)]
    assert values[0] == strict_json(call(*asked).stdout)["metrics"]["rms_error"] != values[1]
    (tmp_path / "e.toml").write_text(
        f'schema_version = 1\nstudy = "{NAME}"\ncontroller = "p"\nscenario = "small"\nreplicate = 7\n'
    )
    assert strict_json(call("simulate", tmp_path / "e.toml", "--json").stdout)["metrics"]["rms_error"] == values[1]
    out = tmp_path / "saved"
    call("simulate", tmp_path / "e.toml", "--out", out)
    call("replay", out)
    assert "replicate" in refused(*asked, "--replicate", "-1")


def test_the_command_of_a_report_asks_for_it_again():
    asked = Asked(
        "s", "c", ("a", "b"), ("k=1:2",), 10, ("m<=1",), "sobol", 8, ("w=x1:x2",), 5, 90.0, 2, 0.5, ("p=1",), 3, 2,
        None, None, None, False, False,
    )  # fmt: skip
    assert asked.command(resume=True) == (
        "leadscrew montecarlo s -c c -s a -s b --over k=1:2 --runs 10 --tolerance 'm<=1' --sampling sobol --sobol 8 "
        "--wear w=x1:x2 --life 5 --level 90 --worst 2 --duration 0.5 --set p=1 --seed 3 --threads 2 --no-figures "
        "--resume"
    )
    assert peak_memory() is None or (10 < peak_memory() < 100_000 and np.isfinite(peak_memory()))
