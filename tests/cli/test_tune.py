"""``leadscrew tune`` and ``compare``."""

from __future__ import annotations

import json
import os
import shlex
import signal
import tomllib

import pyarrow.parquet as pq
import pytest

from tests.budget import in_every_run
from tests.cli.conftest import strict_json
from tests.tune.shared import dask, process, stopped_after, waited

STEPS = ("-s", "fig11a_step_m50", "-s", "fig11b_step_m170", "--duration", "2.2")
VARY = ("--vary", "controller.output_gain=0.5:4:log", "--vary", "controller.tau=0.3:1.5")
OVER = ("--over", "plant.full_duty_speed_mm_s=259:334", "--plants", "4", "--held-out", "6")
WANTED = ("--minimise", "mean:rms_error", "--subject-to", "overshoot<=0.02", "--seed", "3")
LATHE = ("tune", "vud_lathe", "-c", "corrected.vud_beta_e", *STEPS, *VARY, *OVER, *WANTED)
SMALL = (*LATHE, "--budget", "40")


def test_tunes_writes_and_the_file_is_a_controller(call, tmp_path):
    out, report = tmp_path / "t.toml", tmp_path / "report"
    said = call(*SMALL, "-o", out, "--report", report).stdout
    assert "tuned, held out" in said and "keeps the constraint on the 4 plants" in said
    assert sorted(p.name for p in tmp_path.iterdir()) == ["report", "t.toml"], "the journal is gone"
    file = tomllib.loads(out.read_text())
    assert file["kind"] == "controller" and file["tuning"]["budget"] == 40 and file["tuning"]["seed"] == 3
    assert set(file["tuning"]["trained"]) == set(file["tuning"]["held_out"])
    names = {p.name for p in report.iterdir()}
    assert {"report.html", "tune.json", "search.png", "held_out.png", "held_out_tuned.parquet"} <= names
    assert pq.read_table(report / "held_out_tuned.parquet").num_rows == 12
    found = strict_json(
        call("simulate", "vud_lathe", "-c", out, "-s", "fig11a_step_m50", "--duration", "2.2", "--json").stdout
    )
    assert found["metrics"]["overshoot"] <= 0.02 and found["controller"] == str(out)
    call("export", "vud_lathe", "-c", out, "-t", "c99", "--out", tmp_path / "c", "--duration", "0.1")
    shown = call("list", out).stdout
    assert f"{out}: a controller of vud_lathe, corrected.vud_beta_e with these settings" in shown
    assert "output_gain" in shown and "floor" not in shown, "what is set, not what is not"
    assert "40 evaluations by cma, seed 3" in shown and "keeps the constraint on the 4 plants" in shown
    listed = strict_json(call("list", out, "--json").stdout)
    assert {p["key"]: p["value"] for p in listed["parameters"] if p["set"]} == file["set"]
    assert listed["tuning"]["held_out"] == file["tuning"]["held_out"]
    again = strict_json(call(*SMALL[:3], out, *SMALL[4:], "--json").stdout)
    assert again["present"]["controller.tau"] == file["set"]["tau"]
    call(*shlex.split(file["tuning"]["command"])[1:], "-o", tmp_path / "same.toml")
    assert tomllib.loads((tmp_path / "same.toml").read_text())["set"] == file["set"], "the file's own command"


def test_json_has_everything_and_is_the_same_on_one_and_two_threads(call):
    found = [strict_json(call(*SMALL, "--threads", n, "--json").stdout) for n in (1, 2)]
    for f in found:
        del f["wall_s"], f["crew"]
    assert found[0] == found[1]
    assert {"values", "before", "trained", "held_out", "history", "verdict", "versions"} <= set(found[0])


@pytest.mark.slow
def test_values_at_the_ends_of_their_ranges_are_noted_everywhere(call, tmp_path):
    narrow = ("--vary", "controller.output_gain=0.5:0.6", "--minimise", "rms_error", "--budget", "20", "--seed", "1")
    asked = ("tune", "vud_lathe", "-c", "corrected.vud_beta_e", *STEPS, *narrow)
    words = "is at the upper end of its range 0.5:0.6: the best may lie beyond it"
    done = call(*asked, "-o", tmp_path / "t.toml", "--report", tmp_path / "r")
    assert done.stderr.startswith("leadscrew: note: controller.output_gain = ") and done.stderr.endswith(f"{words}\n")
    assert words in tomllib.loads((tmp_path / "t.toml").read_text())["tuning"]["notes"][0]
    assert words in json.loads((tmp_path / "r" / "tune.json").read_text())["notes"][0]
    assert words in (tmp_path / "r" / "report.html").read_text()
    named = ("-c", "ours.pd", *STEPS, "--vary", "corrected.vud_beta_e:controller.output_gain=0.5:0.6", *narrow[2:])
    compared = (*asked[:1], *asked[1:4], *named, "--unseen", "3")
    done = call("compare", *compared[1:], "--report", tmp_path / "c")
    assert "leadscrew: note: corrected.vud_beta_e: controller.output_gain = " in done.stderr
    assert any(words in note for note in json.loads((tmp_path / "c" / "compare.json").read_text())["notes"])
    assert words in (tmp_path / "c" / "report.html").read_text()


@pytest.mark.slow
def test_several_goals_give_a_front_as_table_and_picture(call, tmp_path):
    said = call(*SMALL, "--minimise", "overshoot", "--report", tmp_path / "r").stdout
    assert " taken" in said and "mean:rms_error, held out" in said
    assert (tmp_path / "r" / "front.png").stat().st_size > 10_000
    assert tomllib.loads((tmp_path / "r" / "front_1.toml").read_text())["kind"] == "controller"


def test_more_than_the_controller_gives_an_experiment_file_too(call, tmp_path):
    said = call(*SMALL, "--vary", "sensor.resolution_mm=0.0005:0.001", "-o", tmp_path / "t.toml", code=None).stdout
    assert "t_experiment.toml: the whole loop, because more than the controller varied" in said
    call("simulate", tmp_path / "t_experiment.toml")


def test_exit_code_1_where_nothing_keeps_the_constraints(call, tmp_path):
    result = call(*SMALL, "--subject-to", "settling_2um<=0.1", "-o", tmp_path / "t.toml", code=1)
    assert "NO" in result.stdout
    assert result.stderr.startswith("leadscrew: no setting of the") and result.stderr.count("\n") == 1
    assert tomllib.loads((tmp_path / "t.toml").read_text())["tuning"]["feasible"] is False


@pytest.mark.slow
def test_after_a_kill_resume_gives_the_identical_file(tmp_path, call):
    whole, out = tmp_path / "whole.toml", tmp_path / "t.toml"
    long = (*LATHE, "--budget", "300", "--threads", "1")
    call(*long, "-o", whole)
    journal = tmp_path / "t.toml.journal"
    with process(*long, "-o", str(out), program=stopped_after(10, signal.SIGKILL)) as running:
        assert running.wait(120) == -signal.SIGKILL
    assert not out.exists() and journal.exists()
    first = call(*long, "-o", out, code=2).stderr
    assert "--resume goes on with them" in first
    call(*long, "-o", out, "--resume")
    assert out.read_text() == whole.read_text()
    assert not journal.exists()


BAD = (*SMALL[:4], *STEPS[:2], "--duration", "0.05", *VARY, *OVER, "--minimise", "settling_2um", "--budget", "10")
"""Of no run can settling be judged."""


def test_a_question_that_has_no_answer_leaves_nothing_in_the_way_of_a_better_one(call, refused, tmp_path):
    out = tmp_path / "t.toml"
    assert "could be judged" in refused(*BAD, "-o", out)
    assert list(tmp_path.iterdir()) == [], "the default journal is gone, though it had chunks"
    assert "could be judged" in refused(*BAD, "-o", out, "--journal", tmp_path / "mine")
    assert list((tmp_path / "mine").glob("chunk_*")), "one that was named stays"
    call(*SMALL, "-o", out)


def test_a_command_that_ends_before_a_chunk_is_done_leaves_no_journal(refused, tmp_path, monkeypatch):
    from leadscrew.tune import job as jobs
    from leadscrew.util.errors import ValueRefused

    def refuse(self, chunk, threads=1):
        raise ValueRefused("no such plant")

    monkeypatch.setattr(jobs.Job, "run", refuse)
    compared = ("compare", "vud_lathe", "-c", "ours.pd", "-c", "corrected.vud_beta_e", *STEPS, *WANTED)
    for asked in ((*SMALL, "-o", tmp_path / "t.toml"), (*compared, "--report", tmp_path / "c1")):
        for journal in ((), ("--journal", tmp_path / "mine")):
            assert refused(*asked, *journal).endswith("no such plant\n")
            assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("place", in_every_run(["chunk", "file", "report"], ["file"]))
def test_a_full_disk_keeps_what_is_done_and_says_how_to_go_on(call, refused, tmp_path, monkeypatch, place):
    from leadscrew.report import tuned as folder
    from leadscrew.tune import checkpoints, tuned
    from leadscrew.util import atomic
    from leadscrew.util.errors import DataError

    out, report, count = tmp_path / "t.toml", tmp_path / "report", iter(range(1000))

    def full(*args, **kwargs):
        if place != "chunk" or next(count) > 3:
            raise DataError("it cannot be written: No space left on device")
        atomic.atomic_write(*args, **kwargs)

    with monkeypatch.context() as patch:
        module, name = {"chunk": (checkpoints, "atomic_write"), "file": (tuned, "save"), "report": (folder, "write")}[
            place
        ]
        patch.setattr(module, name, full)
        said = refused(*SMALL, "-o", out, "--report", report)
    kept = tmp_path / "t.toml.journal"
    assert said.endswith(
        f"No space left on device; {kept} keeps what is done: the same command with --resume goes on\n"
    )
    assert [p.name for p in tmp_path.iterdir()] == [kept.name], "no half of the answer"
    call(*SMALL, "-o", out, "--report", report, "--resume")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["report", "t.toml"]


@pytest.mark.slow
def test_a_lost_cluster_keeps_what_is_done(refused, call, tmp_path):
    out = tmp_path / "t.toml"
    with dask(tmp_path, 1) as (address, workers):
        running = process(*LATHE, "--budget", "100000", "-o", str(out), "--cluster", address)
        waited(lambda: len(list(tmp_path.glob("t.toml.journal/chunk_*"))) > 3, 120)
        from leadscrew.tune.executors import crew

        with crew(address) as cluster:
            os.kill(cluster.client.run_on_scheduler(os.getpid), signal.SIGKILL)
            _, stderr = running.communicate(timeout=120)
    assert running.returncode == 2
    said = stderr.decode()
    assert said.splitlines()[-1].startswith(f"leadscrew: the Dask scheduler at {address} is gone")
    assert said.endswith(f"{out}.journal keeps what is done: the same command with --resume goes on\n")
    assert workers


def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(tmp_path):
    journal = tmp_path / "t.toml.journal"
    asked = (*LATHE, "--budget", "100000", "-o", str(tmp_path / "t.toml"))
    running = process(*asked, program=stopped_after(6, signal.SIGINT))
    _, stderr = running.communicate(timeout=120)
    assert running.returncode == 130
    assert stderr.decode().splitlines() == [
        f"leadscrew: interrupted; {journal} keeps what is done: the same command with --resume goes on"
    ]
    assert len(list(journal.glob("chunk_*.npz"))) >= 6


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--vary", "controller.floor=2:1"), ("controller.floor", "2:1 is empty")),
        (("--vary", "controller.florr=1:2"), ("'controller.florr'", "did you mean")),
        (("--minimise", "speed"), ("there is no metric 'speed'",)),
        (("--subject-to", "overshoot<0.1"), ("METRIC<=VALUE",)),
        (("--subject-to", "overshoot>=1"), ("contradict each other",)),
        (("--cluster", "tcp://127.0.0.1:9"), ("no Dask scheduler answers at tcp://127.0.0.1:9",)),
        (("--cluster", "here"), ("local:N or tcp://HOST:PORT",)),
        (("--optimiser", "cma", "--minimise", "overshoot"), ("takes one goal, not 2",)),
        (("--resume",), ("--resume needs the journal",)),
        (("-o", "x.txt"), ("ends in .toml",)),
        (("-o", "/proc/none/t.toml"), ("/proc/none/t.toml", "cannot be written")),
        (("-s", "fig12"), ("no scenario 'fig12'",)),
    ],
)  # fmt: skip
def test_what_cannot_be_is_one_sentence(refused, more, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = refused(*SMALL, *more)
    for word in words:
        assert word in said
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_there_is_not_overwritten(refused, tmp_path):
    (tmp_path / "t.toml").write_text("mine")
    assert "exists already" in refused(*SMALL, "-o", tmp_path / "t.toml")


def test_a_controller_is_asked_for(refused):
    assert "controller is missing" in refused("tune", "vud_lathe", *VARY, *WANTED)


def test_compare_prints_ranking_and_sentence(call, tmp_path):
    asked = (
        "compare", "vud_lathe", "-c", "corrected.vud_beta_e", "-c", "ours.pd", *STEPS, *OVER[:4], *WANTED, "--budget",
        "30", "--unseen", "20", "--vary", "ours.pd:controller.kp=0.01:1:log",
    )  # fmt: skip
    said = call(*asked, "--report", tmp_path / "r").stdout
    assert "rank" in said and "20 simulated plants that no tuning saw" in said
    names = {p.name for p in (tmp_path / "r").iterdir()}
    assert {"report.html", "compare.json", "compare.png"} <= names
    assert [n for n in names if n.endswith("ours.pd.toml")]
    kept = json.loads((tmp_path / "r" / "compare.json").read_text())
    found = strict_json(call(*asked, "--json").stdout)
    assert found["ranking"] == kept["ranking"] and found["pairs"] == kept["pairs"]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["r"]


def test_compare_refuses(refused):
    base = ("compare", "vud_lathe", "-c", "ours.pd", *STEPS, *OVER[:2], *WANTED)
    assert "two controllers or more" in refused(*base)
    assert "expected NAME:KEY" in refused(*base, "-c", "paper.vud", "--vary", "controller.kp=0:1")
