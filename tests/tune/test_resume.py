"""A job that is killed, stopped or runs out of disk goes on to the identical result."""

from __future__ import annotations

import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from tests.tune.noisy_loop import NAME
from tests.tune.shared import PROGRAM, environment, process, stopped_after, waited

pytestmark = pytest.mark.skipif(os.name != "posix", reason="posix: signals")
COMMAND = (
    "montecarlo", NAME, "-c", "p", "-s", "small", "-s", "large", "--over", "plant.lag_s=0.02:0.08", "--over",
    "controller.kp=normal:4:0.5", "--tolerance", "overshoot<=0.05", "--no-figures", "--wear", "plant.lag_s=x1:x1.5",
    "--life", "3", "--runs", "2500", "--duration", "2",
)  # fmt: skip


def asked(folder: Path, *more: str) -> tuple[str, ...]:
    """The command line with its report and its journal."""
    return (*COMMAND, "-o", str(folder / "report"), "--journal", str(folder / "journal"), *more)


def finished(folder: Path, *more: str) -> dict[str, bytes]:
    """Runs to the end; gives the files of the report without what differs from run to run."""
    done = CliRunner().invoke(app, [*asked(folder, *more)])
    assert done.exit_code == 0, done.output
    return answer(folder / "report")


def answer(report: Path) -> dict[str, bytes]:
    """What a report says, without how it was made."""
    found = json.loads((report / "summary.json").read_text())
    del found["cost"]
    for row in found["worst"]:
        del row["command"]
    files = {p.name: p.read_bytes() for p in report.glob("worst/*.toml")}
    return {**files, "summary": json.dumps(found).encode(), "samples": (report / "samples.parquet").read_bytes()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The answer of a job that nobody disturbed."""
    return finished(tmp_path_factory.mktemp("whole"))


@pytest.fixture(scope="module")
def took(tmp_path_factory, whole):
    """Seconds between the start and the end of a job that nobody disturbed."""
    folder = tmp_path_factory.mktemp("took")
    with process(*asked(folder)) as p:
        waited(lambda: (folder / "journal" / "question.json").exists())
        began = time.monotonic()
        assert p.wait(120) == 0
    assert answer(folder / "report") == whole
    return time.monotonic() - began


def killed_and_resumed(folder: Path, expected, moment: float) -> int:
    """Kills a job after so many seconds, resumes it, compares; gives how many chunks were kept."""
    with process(*asked(folder)) as p:
        waited(lambda: (folder / "journal" / "question.json").exists())
        time.sleep(moment)
        p.send_signal(signal.SIGKILL)
        p.wait(30)
    shown = [q for q in folder.rglob("*") if not q.name.startswith(".") and ".partial" not in str(q)]
    assert all(re.fullmatch(r"journal|question\.json|chunk_\d{7}\.npz", q.name) or "report" in q.parts for q in shown)
    if (folder / "report").exists():
        assert answer(folder / "report") == expected
    kept = len(list(folder.glob("journal/chunk_*")))
    assert finished(folder, "--resume") == expected
    assert not list(folder.glob("journal/.*"))
    return kept


@pytest.mark.slow
@pytest.mark.parametrize("chunks", [1, 4])
def test_a_killed_job_goes_on_to_the_identical_result(tmp_path, whole, chunks):
    with process(*asked(tmp_path), program=stopped_after(chunks, signal.SIGKILL)) as p:
        assert p.wait(120) == -signal.SIGKILL
    assert len(list(tmp_path.glob("journal/chunk_*"))) >= chunks and not (tmp_path / "report").exists()
    assert finished(tmp_path, "--resume") == whole
    assert not list(tmp_path.glob("journal/.*"))


@pytest.mark.sweep
def test_random_kills_all_give_the_identical_result(tmp_path, whole, took):
    seed = random.randrange(2**32)
    moments = random.Random(seed)
    print(f"seed {seed}")
    kept = []
    for k in range(20):
        (tmp_path / str(k)).mkdir()
        kept.append(killed_and_resumed(tmp_path / str(k), whole, took * moments.uniform(0.0, 1.1)))
    assert min(kept) < max(kept)


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(tmp_path, whole):
    with process(*asked(tmp_path), program=stopped_after(2, signal.SIGINT)) as p:
        _, said = p.communicate(timeout=120)
        assert p.returncode == 130
    lines = said.decode().splitlines()
    assert len(lines) == 1 and re.match(r"leadscrew: interrupted; [1-9]\d* runs are kept in ", lines[0]), lines
    assert "go on with: leadscrew montecarlo" in lines[0] and lines[0].endswith("--resume")
    assert finished(tmp_path, "--resume") == whole


@pytest.mark.slow
def test_a_disk_that_takes_no_more_is_one_sentence(tmp_path, whole):
    limited = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))\n" + PROGRAM
    done = subprocess.run(
        [sys.executable, "-c", limited, *asked(tmp_path)], capture_output=True, text=True, timeout=60, env=environment()
    )
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.count("\n") == 1 and "cannot be written: File too large" in done.stderr
    assert not (tmp_path / "report").exists()
    assert not [p for p in tmp_path.rglob("*") if p.name.startswith(".")]
    assert finished(tmp_path, "--resume") == whole
