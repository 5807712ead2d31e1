"""What the tests of many runs share."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.experiment import Experiment
from leadscrew.tune.job import Job
from leadscrew.tune.measure import Samples
from tests.tune.noisy_loop import NAME

PROGRAM = "from leadscrew.cli import main; main()"


def job(*scenarios: str, duration: float | None = None, controller: str = "p", **more: Any) -> Job:
    """A job on the noisy loop."""
    return Job(Experiment(NAME, controller, **more), scenarios or ("small",), duration)


def lathe(duration: float = 0.2) -> Job:
    """A job on the lathe's servo."""
    return Job(Experiment("vud_lathe", "corrected.vud_beta_e"), ("fig11a_step_m50",), duration)


def same(a: Samples, b: Samples) -> bool:
    """Whether two samples have the same bits."""

    def bits(s: Samples) -> dict[str, bytes]:
        return {k: np.asarray(v).tobytes() for k, v in s.as_columns().items() if k != "scenario"}

    return bits(a) == bits(b) and a.scenarios == b.scenarios


def stopped_after(chunks: int, number: int) -> str:
    """The command line as a program that sends itself a signal as soon as it has kept so many chunks."""
    return f"""
import os, time
from leadscrew.tune.checkpoints import Journal
put, left = Journal.put, [{chunks}]
def put_and_stop(self, *args):
    put(self, *args)
    left[0] -= 1
    if left[0] == 0:
        os.kill(os.getpid(), {int(number)})
        time.sleep(5)
Journal.put = put_and_stop
{PROGRAM}
"""


def process(*args: str, program: str = PROGRAM) -> subprocess.Popen[bytes]:
    """The command line as a process."""
    return subprocess.Popen(
        [sys.executable, "-c", program, *args], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment()
    )


def environment() -> dict[str, str]:
    """The environment for a process that must find these tests' files and this program."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}


def waited(what: Callable[[], Any], seconds: float = 30.0) -> Any:
    """What ``what`` gives as soon as it gives something."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := what():
            return found
        time.sleep(0.005)
    raise AssertionError("waited too long")


KERNEL = """
import threadpoolctl
print(*{i["architecture"] for i in threadpoolctl.threadpool_info() if i["internal_api"] == "openblas"})
"""


def on_kernels(program: str, *options: str) -> dict[str, str]:
    """What a program prints, by the kernel of OpenBLAS that does the linear algebra of NumPy and SciPy."""
    import pytest

    found = {}
    for kernel in ("Haswell", "Prescott", "SkylakeX"):
        done = subprocess.run(
            [sys.executable, "-c", program + KERNEL, *options], capture_output=True, text=True, timeout=600,
            env={**environment(), "OPENBLAS_CORETYPE": kernel},
        )  # fmt: skip
        *said, name = done.stdout.strip().splitlines() or [""]
        if done.returncode == 0 and name and " " not in name:  # one that this processor lacks is killed
            found[name] = "\n".join(said)
    if len(found) < 2:
        pytest.skip("openblas: needs a processor and a NumPy with several kernels of it")
    return found


@contextmanager
def dask(folder: Path, workers: int) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A scheduler and workers as processes on loopback; gives the address and the workers."""
    import json

    started: list[subprocess.Popen[bytes]] = []

    def start(module: str, *args: str) -> subprocess.Popen[bytes]:
        with (folder / f"{len(started)}.log").open("wb") as log:
            command = [sys.executable, "-m", f"distributed.cli.{module}", *args]
            started.append(subprocess.Popen(command, stdout=log, stderr=log, env=environment(), cwd=folder))
        return started[-1]

    told = folder / "scheduler.json"
    try:
        start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(told))

        def address() -> str:
            try:
                return str(json.loads(told.read_text())["address"])
            except (OSError, ValueError, KeyError):
                return ""

        found = waited(address)
        options = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1", "--memory-limit", "0")
        made = [start("dask_worker", found, *options) for _ in range(workers)]
        logs = [folder / f"{number}.log" for number in range(1, workers + 1)]
        waited(lambda: all("Registered to" in log.read_text() for log in logs), 120)
        yield found, made
    finally:
        for process in reversed(started):
            process.kill()
            process.wait(30)
