"""The batch's driver, run by plain Python against its own machine code and against single runs."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.kernel.block import make
from leadscrew.kernel.loop import DivergenceWarning, Loop
from leadscrew.kernel.metrics import STANDARD
from leadscrew.kernel.program import Program
from leadscrew.util.errors import NameUnknown, ValueRefused
from tests.kernel import zoo

FULL = {
    "reference": zoo.sine, "controller": zoo.history, "plant": zoo.loaded_mass, "sensor": zoo.ruler,
    "actuator": zoo.limits, "disturbance": zoo.push, "output_disturbance": zoo.drift, "substeps": 2, "seed": 7,
    "computation_delay": 0.0005, "transport_delay": 0.001,
}  # fmt: skip
PLAIN = {"reference": zoo.sine, "controller": zoo.pid, "plant": zoo.mass}
ERRORS = {k: STANDARD[k] for k in ("rms_error", "max_error")}


@pytest.fixture
def both_ways(monkeypatch):
    """The same batch from the compiled driver and from the driver's own lines in plain Python."""
    entry = Program.entry

    def run(loop: Loop, *args, **more):
        compiled = loop.batch(*args, **more)
        with monkeypatch.context() as patch:
            patch.setattr(Program, "entry", lambda self, name, engine: entry(self, name, "python"))
            plain = loop.batch(*args, **{**more, "threads": 1})
        return compiled, plain

    return run


def agree(a, b) -> None:
    assert set(a.signals) == set(b.signals) and set(a.metrics) == set(b.metrics)
    for name in a.signals:
        assert np.array_equal(a.signals[name].view(np.int64), b.signals[name].view(np.int64)), name
    for name in a.metrics:
        np.testing.assert_array_equal(a.metrics[name], b.metrics[name], err_msg=name)
    np.testing.assert_array_equal(a.diverged_at, b.diverged_at)


def test_the_compiled_batch_does_what_its_driver_says_with_arrays_delays_and_noise(both_ways):
    loop = Loop(**FULL, metrics=ERRORS)
    rng = np.random.default_rng(5)
    varied = {"controller.weights": rng.uniform(0.1, 0.5, (19, 4)), "actuator.most": np.linspace(0.2, 0.6, 19)}
    every = ("output", "actual", "feedback", "applied", "controller", "disturbance")
    compiled, plain = both_ways(loop, 0.012, varied, record=every, every=3, first=4)
    agree(compiled, plain)
    assert compiled["output"].shape == (19, 4) and compiled.time.tolist() == [k * 0.001 for k in (0, 3, 6, 9)]
    for k in (0, 15, 16, 18):
        changes = {"controller.weights": varied["controller.weights"][k], "actuator.most": varied["actuator.most"][k]}
        single = loop.using(changes).run(0.012, replicate=4 + k, every=3, record=every, engine="python")
        for name in single.signals:
            np.testing.assert_array_equal(single.signals[name], plain.signals[name][k], err_msg=f"{name} of run {k}")
        assert single.metrics.rms_error == plain.metrics["rms_error"][k]


def test_one_lane_that_diverges_leaves_its_neighbours_alone(both_ways):
    loop = Loop(**PLAIN, substeps=2, metrics=ERRORS, bound=50.0)
    gains = np.full(18, 1.0)
    gains[[3, 17]] = 1e6
    compiled, plain = both_ways(loop, 0.06, {"controller.kp": gains})
    agree(compiled, plain)
    assert np.flatnonzero(np.isfinite(plain.diverged_at)).tolist() == [3, 17]
    with pytest.warns(DivergenceWarning):
        alone = loop.using({"controller.kp": 1e6}).run(0.06, engine="python")
    assert alone.diverged is not None and plain.diverged_at[3] == alone.diverged.time
    assert np.isnan(plain.metrics["max_error"][3])
    healthy = loop.using({"controller.kp": 1.0}).run(0.06).metrics.max_error
    assert (np.delete(plain.metrics["max_error"], [3, 17]) == healthy).all()
    text = repr(compiled)
    assert "18 runs of 0.06 s, 2 diverged" in text and f"max_error {healthy:.4g}" in text
    assert compiled._repr_html_().count("<tr>") == 1 + len(ERRORS)
    compiled.loop.name = "<script>"
    assert "<script>" not in compiled._repr_html_()


class Start(NamedTuple):
    at: np.ndarray = np.array([1.0, 2.0])
    gain: float = 1.0
    taps: int = 1


class Kept(NamedTuple):
    past: np.ndarray
    level: float = 0.0


def begin(p):
    """The array at the start comes from the parameters."""
    return Kept(p.at * p.gain, p.gain)


def recall(p, s, command):
    """Shows one number of its memory, which it doubles."""
    s.past[p.taps] = s.past[p.taps] * 2.0
    return Kept(s.past, s.level + 1.0), s.past[p.taps] + s.level


def ready(p, dt):
    """Nothing changes at the validate."""
    return p


RECALL = make("controller", recall, Start(), Kept(np.zeros(2)), prepare=ready, initial=begin)


def test_the_array_that_a_state_starts_from_can_differ_in_every_lane(both_ways):
    loop = Loop(reference=zoo.sine, controller=RECALL, plant=zoo.mass, metrics={})
    gains = np.arange(1.0, 6.0)
    starts = np.column_stack([gains, 10.0 * gains])
    varied = {"controller.gain": gains, "controller.at": starts, "controller.taps": [0, 1, 0, 1, 0]}
    compiled, plain = both_ways(loop, 0.003, varied, record="output")
    agree(compiled, plain)
    for k in range(5):
        first = starts[k, k % 2] * gains[k]
        want = [2 * first + gains[k], 4 * first + gains[k] + 1, 8 * first + gains[k] + 2]
        assert compiled["output"][k].tolist() == want


class Pair(NamedTuple):
    x: zoo.PIDParams = zoo.PIDParams()
    y: zoo.PIDParams = zoo.PIDParams()


def scaled(p, dt):
    """Gains a period."""
    return p._replace(x=p.x._replace(ki=p.x.ki * dt))


def pair_step(p, command):
    """Both gains."""
    return p.x.kp * command + p.x.ki + 100.0 * p.y.kp


def test_a_nested_parameter_of_a_prepared_block_varies_as_it_does_alone(both_ways):
    block = make("controller", pair_step, Pair(), prepare=scaled)
    loop = Loop(reference=zoo.sine, controller=block, plant=zoo.mass, metrics={})
    varied = {"controller.x.ki": [1.0, 2.0, 3.0], "controller.y.kp": [0.0, 1.0, 2.0]}
    compiled, plain = both_ways(loop, 0.002, varied, record="output")
    agree(compiled, plain)
    assert compiled["output"][:, 0].tolist() == pytest.approx([0.001, 100.002, 200.003], rel=1e-15)


def test_the_python_engine_gives_the_batch_that_machine_code_gives():
    loop = Loop(**FULL, metrics=ERRORS)
    weights = np.random.default_rng(2).uniform(0.1, 0.5, (3, 4))
    varied = {"controller.weights": weights, "controller.taps": [4, 3, 4], "plant.mass": [1.0, 2.0, 3.0]}
    a, b = (loop.batch(0.02, varied, record=("output", "actual"), every=4, engine=e) for e in ("llvm", "python"))
    agree(a, b)
    assert len(b) == 3 and b.run(1).max_error == a.metrics["max_error"][1]


def test_a_run_that_diverged_is_cut_off_with_nan_on_the_python_engine():
    loop = Loop(**PLAIN, substeps=1, metrics=ERRORS, bound=50.0)
    with pytest.warns(DivergenceWarning):
        batch = loop.batch(0.06, {"controller.kp": [1.0, 1e6]}, record="actual", engine="python")
    lost = round(batch.diverged_at[1] / loop.period)
    assert np.isfinite(batch["actual"][0]).all() and np.isnan(batch.diverged_at[0])
    assert np.isfinite(batch["actual"][1, : lost - 1]).all() and np.isnan(batch["actual"][1, lost:]).all()


def test_a_batch_of_two_axes_is_read_by_the_name_of_the_signal_and_says_what_was_not_recorded():
    loop = Loop(reference=zoo.circle, controller=zoo.two_pids, plant=zoo.table, metrics={})
    batch = loop.batch(0.01, {"controller.x.kp": [1.0, 2.0]}, record="actual")
    assert batch["actual"] is batch.signals["actual.x"] and len(batch) == 2
    with pytest.raises(NameUnknown, match="'command' was not recorded"):
        batch["command"]
    assert "2 runs" in repr(batch)


def test_a_metric_that_is_nan_in_every_run_is_shown_as_such():
    loop = Loop(**PLAIN, substeps=1, metrics=ERRORS, bound=1e-9)
    batch = loop.batch(0.01, {"controller.kp": [1.0, 2.0]})
    assert "2 diverged" in repr(batch) and "nan" in batch._repr_html_() and "rms_error" not in repr(batch)
    assert math.isnan(batch.run(0).rms_error)


def test_threads_share_the_runs_and_report_their_progress():
    loop = Loop(**PLAIN, metrics=ERRORS)
    kp = np.linspace(0.5, 2.0, 200)
    seen: list[float] = []
    a = loop.batch(0.01, {"controller.kp": kp}, threads=2, progress=seen.append)
    b = loop.batch(0.01, {"controller.kp": kp}, threads=1)
    agree(a, b)
    assert seen == sorted(seen) and seen[-1] == 1.0 and len(seen) > 1


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"controller.taps": [3.5]}, r"controller.taps = 3.5 \(batch\): expected a whole number"),
        ({"controller.weights": [[1.0, 2.0]]}, r"expected the shape \(runs, 4\)"),
        ({"controller.weights": [[1.0, 2.0, 3.0, math.nan]]}, "not finite"),
    ],
)
def test_a_value_that_one_run_could_not_have_is_refused_for_the_batch(changes, says):
    with pytest.raises(ValueRefused, match=says):
        Loop(**FULL, metrics={}).batch(0.01, changes)


@pytest.mark.slow
def test_one_array_for_all_runs_is_one_row():
    loop = Loop(**FULL, metrics={})
    batch = loop.batch(0.01, {"controller.weights": [0.1, 0.2, 0.3, 0.4]}, runs=2, record="output")
    assert batch.varied["controller.weights"].shape == (2, 4)
    single = loop.using({"controller.weights": [0.1, 0.2, 0.3, 0.4]}).run(0.01, replicate=1)
    np.testing.assert_array_equal(batch["output"][1], single["output"])


def test_a_continuous_loop_cannot_run_as_a_batch():
    through = make("controller", follow)
    with pytest.raises(ValueRefused, match="a batch needs a control period"):
        Loop(reference=zoo.sine, controller=through, plant=zoo.mass, period=None, metrics={}).batch(0.1, runs=3)


def follow(command):
    """The command."""
    return command
