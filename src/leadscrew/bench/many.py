"""Rows of many runs: a batch, a Monte Carlo with its report, until settled, two by two, and on two Dask workers."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from typing import Any

from leadscrew.bench.measuring import load, row
from leadscrew.bench.threads import IDLE
from leadscrew.experiment import Experiment
from leadscrew.tune.executors import Threads, crew
from leadscrew.tune.job import Job
from leadscrew.tune.measure import measure
from leadscrew.tune.space import Space
from leadscrew.util.errors import LeadscrewError

STUDY, CONTROLLER, SCENARIO = "vud_lathe", "corrected.vud_beta_e", "fig11a_step_m50"
OVER = ("plant.full_duty_speed_mm_s=259:334",)
LATHE = "lathe servo under VUD A+"
LONG = 20.0
"""Seconds that a job lasts at least on one Dask worker."""
FRESH = """
import json
from leadscrew.bench import many
from leadscrew.util.system import peak_memory
print(json.dumps(many.{what}({arguments}) | {{"memory": peak_memory()}}))
"""
COMMAND = """
import json, tempfile, time
from pathlib import Path
from leadscrew.bench.many import CONTROLLER, OVER, SCENARIO, STUDY, job
from leadscrew.cli.montecarlo_work import Asked, Work
from leadscrew.util.system import peak_memory
runs, seconds = {arguments}
job(seconds).compile(SCENARIO)
with tempfile.TemporaryDirectory() as folder:
    limits = ("rms_error<=45", "overshoot<=0.04")
    asked = Asked(STUDY, CONTROLLER, (SCENARIO,), OVER, runs, limits, "lhs", 0, (), 11, 90.0, 3, seconds, (), 1, None,
                  None, Path(folder) / "out", None, False, True)
    began = time.perf_counter()
    Work(asked).done()
    print(json.dumps({{"wall": time.perf_counter() - began, "memory": peak_memory()}}))
"""
"""What ``leadscrew montecarlo`` does after its options are read: runs, metrics, sensitivities and report."""


def job(seconds: float) -> Job:
    """The lathe's servo on a step."""
    return Job(Experiment(STUDY, CONTROLLER), (SCENARIO,), seconds)


def batch(runs: int, seconds: float) -> dict[str, float]:
    """Seconds of the runs alone, on all cores, compiled before."""
    asked, space = job(seconds), Space.of(OVER)
    columns = space.sample(runs, seed=1)
    asked.compile(SCENARIO)
    measure(asked, space.sample(256, seed=2), Threads())
    began = time.perf_counter()
    measure(asked, columns, Threads())
    return {"wall": time.perf_counter() - began}


def sensors() -> dict[str, float]:
    """Seconds of the lathe study's 200 drawn axes, two sensors by two controllers, both steps; compiled before."""
    from leadscrew import resolve
    from leadscrew.studies.lab import Lab
    from leadscrew.studies.vud_lathe.axes import errors_um
    from leadscrew.studies.vud_lathe.scenarios import STEPS

    cells = [(c, s.scenario, sensor) for c in ("ours.original_fit", CONTROLLER) for s in STEPS.values()
             for sensor in ("encoder", "grating")]  # fmt: skip
    for _ in range(2):  # the first time compiles
        lab, began = Lab(resolve.study(STUDY)), time.perf_counter()
        for cell in cells:
            errors_um(lab, *cell)
    return {"wall": time.perf_counter() - began}


def in_fresh(what: str, *arguments: float) -> dict[str, float]:
    """One of these in a process of its own, so that its memory is its own."""
    code = (COMMAND if what == "report" else FRESH).format(what=what, arguments=", ".join(map(repr, arguments)))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def rows(quick: bool = False) -> list[dict[str, Any]]:
    """The rows; ``quick`` takes a tenth of the runs, judges nothing and leaves Dask out."""
    before = load()
    idle = before is not None and before < IDLE
    said = f"load {before:.2f} before" if before is not None else "load unknown"
    runs = 10_000 if quick else 100_000
    settled = 1_000 if quick else 10_000
    measured = {
        "batch": in_fresh("batch", runs, 0.2),
        "report": in_fresh("report", runs, 0.2),
        "settled": in_fresh("batch", settled, 2.0),
        "sensors": in_fresh("sensors"),
    }
    made = []
    for name, what, target in (
        ("batch", f"{runs} runs of 200 periods, metrics alone", 2.0),
        ("report", f"{runs} runs of 200 periods, Monte Carlo with report", 6.0),
    ):
        wall, memory = measured[name]["wall"], measured[name]["memory"]
        made.append(
            row("many runs", f"{LATHE}: {what}", wall, "s", at_most=None if quick else target,
                judged=idle or wall <= target, remark=f"{runs / wall:,.0f} runs/s, {said}")
        )  # fmt: skip
        made.append(
            row("many runs", f"{LATHE}: {what}, peak memory", memory, "MiB", at_most=None if quick else 1024.0)
        )  # fmt: skip
    wall = measured["settled"]["wall"]
    remark = f"{wall:.2f} s, {measured['settled']['memory']:.0f} MiB, {said}"
    made.append(
        row("many runs", f"{LATHE}: {settled} runs of 2 s, to settling", settled / wall, "runs/s", remark=remark)
    )
    wall = measured["sensors"]["wall"]
    made.append(
        row("many runs", "sensor and controller, two by two: 200 axes, 8 batches of 4 s", wall, "s",
            at_most=None if quick else 5.0, judged=idle or wall <= 5.0, remark=said)
    )  # fmt: skip
    return made if quick else [*made, *cluster_rows()]


def cluster_rows() -> list[dict[str, Any]]:
    """One Dask worker and two on the same job, which lasts :data:`LONG` seconds or more on one."""
    asked, space = job(0.2), Space.of(OVER)
    asked.compile(SCENARIO)
    before = load()
    said = "unknown" if before is None else f"{before:.2f}"
    runs = 1_000_000
    walls: dict[int, float] = {}
    try:
        while not walls or walls[1] < LONG:
            if walls:
                runs = int(runs * 1.2 * LONG / walls[1])
            walls = {1: on_workers(asked, space, runs, 1)}
        walls[2] = on_workers(asked, space, runs, 2)
    except LeadscrewError as error:
        return [row("many runs", "two Dask workers beside one", remark=str(error))]
    what = f"{LATHE}: {runs} runs of 200 periods"
    idle = before is not None and before < IDLE
    ratio = walls[1] / walls[2]
    return [
        row("many runs", f"{what}, 1 Dask worker", walls[1], "s", remark=f"load {said} before"),
        row("many runs", f"{what}, 2 Dask workers", walls[2], "s", ratio=ratio, at_least=1.5,
            judged=idle or ratio >= 1.5, remark=f"load {said} before"),
    ]  # fmt: skip


def on_workers(asked: Job, space: Space, runs: int, workers: int) -> float:
    """Seconds of a job on worker processes that have compiled it before."""
    with crew(f"local:{workers}") as cluster:
        measure(asked, space.sample(40_000 * workers, seed=2), cluster)
        columns = space.sample(runs, seed=1, method="random")
        began = time.perf_counter()
        measure(asked, columns, cluster)
        return time.perf_counter() - began
