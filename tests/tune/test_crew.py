"""Who does the work: the same bits by one thread, two, or a cluster, and whoever dies."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys

import numpy as np
import pytest

from leadscrew.tune.executors import CrewLost, Threads, crew
from leadscrew.tune.montecarlo import montecarlo
from leadscrew.tune.space import Space
from leadscrew.util.errors import LeadscrewError, ValueRefused
from tests.tune.shared import dask, environment, job, lathe, same, waited

SPACE = Space.of(["plant.full_duty_speed_mm_s=259:334", "plant.mechanical_lag_s=normal:0.017:0.002"])
NOISY = Space.of(["plant.lag_s=0.02:0.08"])


@pytest.mark.slow
def test_one_thread_and_two_give_the_same_bits():
    for j, space, runs in ((lathe(2.0), SPACE, 2500), (job("small", "large", duration=1.0), NOISY, 5000)):
        one, two, five = (montecarlo(j, space, runs, crew=Threads(n)).samples for n in (1, 2, 5))
        assert same(one, two) and same(one, five)
        assert len(np.unique(one.metrics[j.where[0]]["rms_error"])) > runs / 2


@pytest.mark.slow
def test_a_killed_worker_loses_nothing(tmp_path):
    j, runs = lathe(2.0), 15_000
    alone = montecarlo(j, SPACE, runs, crew=Threads(2)).samples
    with dask(tmp_path, 2) as (address, workers), crew(address) as cluster:
        cluster.client.wait_for_workers(2, timeout=30)
        seen: list[int] = []

        def progress(done: int, total: int) -> None:
            seen.append(done)
            if len(seen) == 4:
                os.kill(workers[0].pid, signal.SIGKILL)

        found = montecarlo(j, SPACE, runs, crew=cluster, progress=progress).samples
        assert workers[0].wait(10) == -signal.SIGKILL and workers[1].poll() is None
        assert len(cluster.client.scheduler_info()["workers"]) == 1
    assert len(seen) > 4 and seen[-1] == runs and seen == sorted(seen)
    assert same(alone, found)


@pytest.mark.slow
def test_a_cluster_of_this_machine_gives_the_same_bits_and_the_same_refusals(tmp_path):
    j = job("small", "large", duration=1.0, changes={"controller.kp": 15.0})
    with crew("local:2") as cluster:
        assert cluster.name == "local:2"
        found = montecarlo(j, NOISY, 4000, crew=cluster).samples
        chunk = (0, type("Chunk", (), {})())
        from leadscrew.tune.job import Chunk

        chunk = (0, Chunk("small", {"plant.lag_s": np.array([-1.0])}, 0))
        with pytest.raises(ValueRefused, match=r"plant\.lag_s = -1\.0"):
            list(cluster.results(j, [chunk]))
    assert same(found, montecarlo(j, NOISY, 4000, crew=Threads(1)).samples)


def test_a_scheduler_that_is_not_there_is_said_at_once():
    with socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{closed.getsockname()[1]}"
    refused = rf"no Dask scheduler answers at {address} \(ConnectionRefusedError\)"  # not one that was waited for
    with pytest.raises(LeadscrewError, match=refused), crew(address):
        pass
    with pytest.raises(LeadscrewError, match="no Dask scheduler answers"), crew("tcp://no.such.host.invalid:8786"):
        pass


def test_something_else_at_the_address_is_no_scheduler(monkeypatch):
    monkeypatch.setattr("leadscrew.tune.executors.PATIENCE_S", 0.5)
    with socket.socket() as mute:
        mute.bind(("127.0.0.1", 0))
        mute.listen()
        address = f"tcp://127.0.0.1:{mute.getsockname()[1]}"
        with pytest.raises(LeadscrewError, match="no Dask scheduler answers"), crew(address):
            pass


@pytest.mark.slow
def test_a_scheduler_that_greets_in_a_crowd_is_asked_again(tmp_path, monkeypatch):
    import distributed

    real, asked = distributed.Client, []

    def crowded(address, **options):
        asked.append(address)
        assert len(asked) > 1
        return real(address, **options)

    monkeypatch.setattr(distributed, "Client", crowded)
    with dask(tmp_path, 1) as (address, _), crew(address) as cluster:
        assert cluster.client.run_on_scheduler(os.getpid)
    assert len(asked) == 2


@pytest.mark.slow
def test_a_scheduler_without_workers_is_said(tmp_path, monkeypatch):
    with dask(tmp_path, 0) as (address, _):
        monkeypatch.setattr("leadscrew.tune.executors.PATIENCE_S", 2.0)
        with pytest.raises(LeadscrewError, match="has no workers"), crew(address):
            pass


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"cluster": "local"}, "expected local:N or tcp://HOST:PORT"),
        ({"cluster": "local:0"}, "1 to 1024 workers"),
        ({"cluster": "http://host:1"}, "expected local:N"),
        ({"cluster": "local:2", "threads": 2}, "exclude each other"),
        ({"threads": 0}, "threads"),
    ],
)
def test_what_is_no_crew_is_refused(options, words):
    with pytest.raises(ValueRefused, match=words), crew(**options):
        pass


@pytest.mark.slow
def test_a_scheduler_that_dies_is_said_and_not_waited_for(tmp_path):
    with dask(tmp_path, 1) as (address, _), crew(address) as cluster:
        scheduler = cluster.client.run_on_scheduler(os.getpid)
        with pytest.raises(CrewLost, match=f"the Dask scheduler at {address} is gone"):
            montecarlo(lathe(2.0), SPACE, 15_000, crew=cluster, progress=lambda *_: os.kill(scheduler, signal.SIGKILL))


@pytest.mark.slow
@pytest.mark.parametrize(("stopped", "words"), [("scheduler", "is gone"), ("worker", "has lost all of its workers")])
def test_a_silent_cluster_is_not_waited_for(tmp_path, monkeypatch, stopped, words):
    monkeypatch.setattr("leadscrew.tune.executors.LOOK_S", 0.2)
    monkeypatch.setattr("leadscrew.tune.executors.LOST_S", 2.0)
    with dask(tmp_path, 1) as (address, workers), crew(address) as cluster:
        pid = workers[0].pid
        if stopped == "scheduler":
            pid = cluster.client.run_on_scheduler(os.getpid)
        with pytest.raises(CrewLost, match=words):
            how = signal.SIGSTOP if stopped == "scheduler" else signal.SIGKILL
            montecarlo(lathe(2.0), SPACE, 15_000, crew=cluster, progress=lambda *_: os.kill(pid, how))


SCRIPT = """
from leadscrew.experiment import Experiment
from leadscrew.tune.executors import crew
from leadscrew.tune.job import Job
from leadscrew.tune.montecarlo import montecarlo
from leadscrew.tune.space import Space

print("once")
job = Job(Experiment("vud_lathe", "corrected.vud_beta_e"), ("fig11a_step_m50",), 0.2)
with crew("local:2") as workers:
    found = montecarlo(job, Space.of(["plant.full_duty_speed_mm_s=259:334"]), 100, crew=workers)
    print(len(found.samples), "runs")
    DIE
"""


@pytest.mark.slow
def test_a_script_without_a_main_guard_may_take_workers_of_this_machine(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT.replace("DIE", ""))
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120,
                          env=environment())  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (0, "once\n100 runs\n", "")


@pytest.mark.slow
def test_workers_of_this_machine_leave_when_their_script_is_killed(tmp_path):
    killed = "import os; print(workers.client.cluster.scheduler_address, flush=True); os.kill(os.getpid(), 9)"
    (tmp_path / "script.py").write_text(SCRIPT.replace("DIE", killed))
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120,
                          env=environment())  # fmt: skip
    assert done.returncode == -signal.SIGKILL, done.stderr
    address = done.stdout.split()[-1]
    waited(lambda: not subprocess.run(["pgrep", "-f", address], capture_output=True, check=False).stdout, 60.0)


def test_workers_that_do_not_start_are_said(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(LeadscrewError, match="the 2 workers on this machine did not start"), crew("local:2"):
        pass
