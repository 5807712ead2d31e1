"""The program as a process: what it imports, pipes, Ctrl-C, SIGKILL."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from leadscrew.kernel.run import load
from leadscrew.util.errors import DataError
from leadscrew.util.escape import terminal
from tests.cli.conftest import FILE

HEAVY = ("numpy", "llvmlite", "scipy", "matplotlib", "pyarrow", "jinja2", "leadscrew.experiment_file")


def program(*args, **options):
    return subprocess.run([sys.executable, *args], capture_output=True, text=True, timeout=60, **options)


@pytest.mark.parametrize("args", ["--help", "simulate --help", "--version", "cache info"])
def test_help_imports_nothing_heavy(args):
    code = (
        "import sys\nfrom leadscrew.cli import app\n"
        f"try:\n    app({args.split()!r})\nexcept SystemExit as stop:\n    assert not stop.code\n"
        f"print(sorted({set(HEAVY)!r} & set(sys.modules)))"
    )
    done = program("-c", code)
    assert done.stdout.splitlines()[-1] == "[]", done.stdout + done.stderr


def test_bad_input_ends_with_code_2_and_one_line():
    done = program("-m", "leadscrew", "list", "no\nsuch \udcff thing")
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.startswith("leadscrew: ") and done.stderr.count("\n") == 1
    assert "Traceback" in program("-m", "leadscrew", "--debug", "list", "nothing").stderr


def test_a_fault_of_ours_is_not_mistaken_for_a_missed_target():
    fault = "from leadscrew import cli, catalogue\ncatalogue.study_names = None\n"
    done = program("-c", fault + "import sys\nsys.argv = ['leadscrew', 'list']\ncli.main()")
    assert done.returncode == 70 and "Traceback" in done.stderr


@pytest.mark.skipif(os.name != "posix", reason="posix: pipes and signals")
def test_a_closed_pipe_is_quiet():
    with subprocess.Popen(
        [sys.executable, "-m", "leadscrew", "list", "step"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        process.stdout.close()
        said = process.stderr.read()
        code = process.wait(60)
    assert said == b"" and code == 141


@pytest.mark.skipif(os.name != "posix", reason="posix: pipes and signals")
def test_ctrl_c_is_quiet(tmp_path):
    slow = tmp_path / "slow.py"
    slow.write_text("import time\nprint('there', flush=True)\ntime.sleep(60)\n")
    with subprocess.Popen(
        [sys.executable, "-m", "leadscrew", "list", f"{slow}:x"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        assert process.stdout.readline() == b"there\n"
        process.send_signal(signal.SIGINT)
        said = process.stderr.read()
        code = process.wait(60)
    assert said == b"" and code == 130


TITLE, COVER = "\x1b]0;owned\x07", "\x1b[2J\u202e"


@pytest.mark.slow
def test_names_in_files_do_not_command_the_terminal(tmp_path):
    rows = "\n".join(f"{k / 1000},{k * k},{k}" for k in range(200))
    (tmp_path / "log.csv").write_text(f"time,position{TITLE},drive{COVER}\n{rows}\n", encoding="utf-8")
    fll = f"Engine: a{TITLE}\nInputVariable: x\n  range: 0.0 1.0\n  term: {COVER} Triangle 0.0 0.5 1.0\n"
    (tmp_path / "a.fll").write_text(fll, encoding="utf-8")
    for asked in (["log", "log.csv"], ["fuzzy", "show", "a.fll"]):
        done = subprocess.run(
            [sys.executable, "-m", "leadscrew", *asked], cwd=tmp_path, capture_output=True, encoding="utf-8"
        )
        assert r"\x1b]0;owned" in done.stdout, done.stderr
        assert not set("\x1b\x07\u202e") & {*done.stdout, *done.stderr}, asked


def test_colours_of_tables_and_line_ends_stay():
    assert terminal("\x1b[32mreproduced\x1b[0m\t1\r\n") == "\x1b[32mreproduced\x1b[0m\t1\r\n"
    assert terminal("a\rb\x1b[8m\x9b2J") == r"a\rb\x1b[8m\x9b2J"


@pytest.mark.skipif(os.name != "posix", reason="posix: signals")
def test_ctrl_c_ends_a_compiled_run_that_would_take_days(tmp_path):
    told = tmp_path / "told.py"  # says when the machine code is about to run
    told.write_text(
        "import sys\nfrom leadscrew.kernel.live import Live\nrun = Live._in_slices\n"
        "def told(self, *given):\n    print('running', flush=True)\n    return run(self, *given)\n"
        "Live._in_slices = told\nsys.argv = ['leadscrew', *sys.argv[1:]]\n"
        "from leadscrew.cli import main\nmain()\n"
    )
    loop = ["simulate", "vud_lathe", "-c", "paper.vud", "-s", "step_p50"]
    days = ["--duration", "1e10", "--every", "1000000000"]
    with subprocess.Popen(
        [sys.executable, told, *loop, *days], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout.readline() == b"running\n"
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=120)
    assert process.returncode == 130


BATCH = """
import numpy as np
from leadscrew.experiment import Experiment
from leadscrew.kernel import batch
started = batch.Thread.start
def told(self):
    started(self)
    print("running", flush=True)
batch.Thread.start = told
loop = Experiment("vud_lathe", "paper.vud", "step_p50").loop()
loop.batch(1e10, runs=64, record=(), threads=2)
"""


@pytest.mark.skipif(os.name != "posix", reason="posix: signals")
def test_ctrl_c_ends_a_batch_that_would_take_years():
    with subprocess.Popen([sys.executable, "-c", BATCH], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"running\n"
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=120)[1]
    assert b"KeyboardInterrupt" in said


SAVING = f"""
import sys
sys.path.insert(0, {str(FILE.parent)!r})
from plain_study import LOOP
run = LOOP.run(0.2)
run.save(f"{{sys.argv[1]}}/run")
print("ready", flush=True)
for k in range(100_000):
    run.save(f"{{sys.argv[1]}}/run{{k}}")
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="posix: no SIGKILL")
def test_a_killed_save_leaves_nothing_that_passes_for_a_whole_run(tmp_path):
    whole = 0
    for attempt, delay in enumerate((0.011, 0.037, 0.083)):
        folder = tmp_path / str(attempt)
        with subprocess.Popen([sys.executable, "-c", SAVING, str(folder)], stdout=subprocess.PIPE) as process:
            assert process.stdout.readline() == b"ready\n"
            time.sleep(delay)
            process.kill()
            process.wait(60)
        for path in folder.iterdir() if folder.exists() else ():
            if path.name.startswith("run"):
                manifest, signals = load(path)
                assert manifest["duration_s"] == 0.2 and len(signals["time"]) == 200
                whole += 1
            else:
                with pytest.raises(DataError):
                    load(path)
    assert whole > 3
