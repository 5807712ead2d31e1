"""The same bits from every engine, for everything that a loop can be made of."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from leadscrew.kernel.loop import Loop
from leadscrew.kernel.metrics import STANDARD
from tests.budget import in_every_run
from tests.kernel import zoo

LOOPS = {
    "pid": {"reference": zoo.sine, "controller": zoo.pid, "plant": zoo.mass, "substeps": 4},
    "everything": {
        "reference": zoo.sine, "controller": zoo.history, "plant": zoo.loaded_mass, "sensor": zoo.ruler,
        "actuator": zoo.limits, "disturbance": zoo.push, "output_disturbance": zoo.drift, "substeps": 5, "seed": 7,
    },
    "delays": {
        "reference": zoo.sine, "controller": zoo.pid(kp=0.3), "plant": zoo.mass, "substeps": 4,
        "computation_delay": 0.00125, "transport_delay": 0.0025, "disturbance": zoo.push,
    },
    "two axes": {"reference": zoo.circle, "controller": zoo.two_pids, "plant": zoo.table,
                 "substeps": 2, "computation_delay": 0.001},
    "two axes late": {
        "reference": zoo.circle, "controller": zoo.two_pids(**{"x.kp": 0.3, "y.kp": 0.3}), "plant": zoo.table,
        "transport_delay": 0.003,
    },
    "cascade": {"reference": zoo.sine, "controller": zoo.cascade, "plant": zoo.shown_mass},
    "observer": {"reference": zoo.sine, "controller": zoo.observed, "plant": zoo.mass, "disturbance": zoo.push},
    "stiff fixed": {"reference": zoo.sine, "controller": zoo.pid, "plant": zoo.loaded_mass, "method": "sdirk3"},
    "stiff adaptive": {"reference": zoo.sine, "controller": zoo.pid, "plant": zoo.loaded_mass, "method": "rodas"},
}  # fmt: skip


METRICS = {k: STANDARD[k] for k in ("rms_error", "settling_time", "chatter")}


def made(name: str) -> Loop:
    return Loop(**LOOPS[name], metrics=METRICS if name in ("pid", "two axes") else {})


def same(a: np.ndarray, b: np.ndarray) -> bool:
    return np.array_equal(a.view(np.int64), b.view(np.int64))


@pytest.mark.parametrize("name", in_every_run(LOOPS, set(LOOPS) - {"stiff fixed", "two axes", "pid"}))
def test_python_and_machine_code_give_the_same_bits_on_every_signal_and_state(name):
    loop = made(name)
    every_column = loop.program.plan.columns
    a = loop.run(0.3, record=every_column, engine="python")
    b = loop.run(0.3, record=every_column, engine="llvm")
    assert a.diverged is None
    for column in every_column:
        assert same(a[column], b[column]), column
    assert np.abs(b["true_error"]).max() > 0
    assert dict(a.metrics) == dict(b.metrics) or all(
        x == y or (np.isnan(x) and np.isnan(y)) for x, y in zip(a.metrics.values(), b.metrics.values(), strict=True)
    )


@pytest.mark.parametrize("name", in_every_run(LOOPS, ("pid", "two axes late", "everything", "stiff adaptive")))
def test_a_single_run_and_its_lane_in_a_batch_give_the_same_bits(name):
    loop = made(name)
    key = next(
        k
        for k in ("controller.kp", "controller.gain", "controller.x.kp", "controller.outer.kp", "controller.inner.kp")
        if k in loop.sheet
    )
    values = np.linspace(0.2, 0.9, 21)
    batch = loop.batch(0.1, {key: values}, record=None, threads=2, first=3)
    for k in (0, 7, 16, 20):
        run = loop.using({key: float(values[k])}).run(0.1, replicate=3 + k)
        for column in run.signals:
            assert same(run.signals[column], batch.signals[column][k]), (column, k)
        for metric, value in run.metrics.items():
            assert value == batch.metrics[metric][k] or (np.isnan(value) and np.isnan(batch.metrics[metric][k])), metric


def test_noise_differs_from_run_to_run_and_repeats_with_the_seed():
    loop = made("everything")
    batch = loop.batch(0.05, runs=20, record="feedback")
    assert len({row.tobytes() for row in batch["feedback"]}) == 20
    again = loop.batch(0.05, runs=20, record="feedback", threads=1)
    assert same(batch["feedback"], again["feedback"])
    other = loop.using(seed=8).batch(0.05, runs=20, record="feedback")
    assert not same(batch["feedback"], other["feedback"])


def test_the_python_engine_runs_the_users_own_lines_so_that_a_debugger_stops_in_them():
    seen: set[tuple[str, int]] = set()

    def trace(frame, event, _):
        if event == "line":
            seen.add((frame.f_code.co_filename, frame.f_lineno))
        return trace

    loop = made("pid")
    live = loop.start(engine="python")
    before = sys.gettrace()
    sys.settrace(trace)
    try:
        live.advance(3)
    finally:
        sys.settrace(before)
    lines = Path(zoo.__file__).read_text().splitlines()
    mine = {lines[n - 1].strip() for file, n in seen if file == zoo.__file__}
    assert "integral = s.integral + error * dt" in mine
    assert "return PIDState(integral, error), output" in mine


def test_a_breakpoint_of_pdb_holds_in_the_users_file(tmp_path):
    program = tmp_path / "mine.py"
    program.write_text(
        "import sys\nsys.path.insert(0, sys.argv[1])\n"
        "from leadscrew.kernel.loop import Loop\nfrom tests.kernel import zoo\n"
        "loop = Loop(reference=zoo.sine, controller=zoo.pid, plant=zoo.mass, metrics={})\n"
        "loop.run(0.003, engine='python')\n"
    )
    root = str(Path(__file__).parents[2])
    line = next(
        i for i, text in enumerate(Path(zoo.__file__).read_text().splitlines(), 1) if "integral = s.integral" in text
    )
    talk = f"import sys; sys.path.insert(0, {root!r})\nbreak {zoo.__file__}:{line}\ncontinue\n"
    talk += "print('error is', error)\nquit\n"
    done = subprocess.run(
        [sys.executable, "-m", "pdb", str(program), root],
        input=talk,
        capture_output=True,
        text=True,
        timeout=120,
        cwd=root,
    )
    assert f"zoo.py({line})pid()" in done.stdout and "error is 0.0" in done.stdout, done.stdout + done.stderr
