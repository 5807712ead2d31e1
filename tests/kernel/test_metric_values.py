"""The metrics of a whole run: which part of it they judge, and why one has no value."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew import Loop, controller, plant
from leadscrew.disturbances._step_load import step_load
from leadscrew.figures.formats import metric_rows
from leadscrew.kernel import metrics
from leadscrew.references._sine import sine
from leadscrew.references._step import step
from leadscrew.replay import _other_end

RATE, PERIOD = 40.0, 1e-3


class Gain(NamedTuple):
    rate: float = RATE


@controller(Gain())
def approach(p, command, feedback):
    return p.rate * (command - feedback)


class Position(NamedTuple):
    x: float = 0.0


@plant(None, Position(), output="x", unit="mm")
def slide(s, u):
    return Position(u)


def loop(reference=None, **changes):
    return Loop(reference=reference or step(target=10.0), controller=approach, plant=slide, period=PERIOD, **changes)


def error_at(k, rate=RATE):
    """The error k periods after a step of 10: the held speed takes the share rate * period of it in each period."""
    return 10.0 * (1.0 - rate * PERIOD) ** k


def test_a_loop_that_settled_reports_the_error_of_its_last_tenth_not_of_its_start():
    run = loop().run(0.5)
    assert run.metrics.max_error == 10.0 and run.metrics.settling_time < 0.2
    assert run.metrics.steady_state_error == pytest.approx(error_at(450), rel=1e-9)


@pytest.mark.parametrize(
    ("window", "first"), [({"last_percent": 40.0}, 300), ({"last_percent": 100.0}, 0), ({"from_time": 0.2}, 200)]
)
def test_the_window_of_the_steady_state_error_can_be_set(window, first):
    blocks = {"peak": metrics.steady_state_error(**window), "mean": metrics.mean_steady_state_error(**window)}
    run = loop(metrics=blocks).run(0.5)
    assert run.metrics.peak == pytest.approx(error_at(first), rel=1e-9)
    assert run.metrics.mean == pytest.approx(np.mean([error_at(k) for k in range(first, 500)]), rel=1e-9)


def test_a_batch_and_the_python_engine_judge_the_same_last_tenth():
    one = loop(metrics={"peak": metrics.steady_state_error})
    varied = {"controller.rate": [20.0, 40.0], "metrics.peak.last_percent": [10.0, 50.0]}
    many = one.batch(0.5, varied).metrics["peak"]
    assert many.tolist() == pytest.approx([error_at(450, 20.0), error_at(250, 40.0)], rel=1e-9)
    assert one.run(0.5, engine="python").metrics == one.run(0.5).metrics


def test_a_live_loop_whose_end_is_unknown_says_so_instead_of_judging_its_start():
    live = loop().start()
    run = live.advance(100)
    assert math.isnan(run.metrics.steady_state_error)
    assert run.metrics_without_value["steady_state_error"].endswith("so it has no last part: set from_time")
    live.set("metrics.steady_state_error.from_time", 0.1)
    assert live.advance(100).metrics.steady_state_error == pytest.approx(error_at(100), rel=1e-9)


@pytest.mark.parametrize(
    ("reference", "rate", "seconds", "metric", "reason"),
    [
        (None, 1.0, 0.5, metrics.settling_time,
         "the error is outside ±0.2 (2 % of the last move) at the end of the run"),
        (None, 1.0, 0.5, metrics.settling_time(band=1.5), "the error is outside ±1.5 at the end of the run"),
        (None, 1.0, 0.5, metrics.rise_time, "after the last move the response does not pass 90 % of it from below"),
        (sine(), 1.0, 0.5, metrics.settling_time, "the command still changes at the end of the run"),
        (sine(), 1.0, 0.5, metrics.rise_time, "the command still changes at the end of the run"),
        (sine(), 1.0, 0.5, metrics.overshoot, "the command still changes at the end of the run"),
        (step(target=0.0), 1.0, 0.5, metrics.overshoot, "the command never changes in this run"),
        (step(target=0.0), 1.0, 0.5, metrics.rise_time, "the command never changes in this run"),
        (None, 1.0, 0.5, metrics.rms_error(from_time=2.0),
         "its window holds no sample: from_time = 2 s, and the run ends at 0.5 s"),
        (None, 1.0, 0.5, metrics.overshoot(from_time=2.0),
         "its window holds no sample: from_time = 2 s, and the run ends at 0.5 s"),
        (None, 1.0, 0.5, metrics.chatter(from_time=0.499),
         "its window holds fewer than two samples: from_time = 0.499 s, and the run ends at 0.5 s"),
    ],
)  # fmt: skip
def test_a_metric_without_a_value_says_why(reference, rate, seconds, metric, reason):
    run = loop(reference, metrics={"m": metric}).using({"controller.rate": rate}).run(seconds, every=0, engine="python")
    assert math.isnan(run.metrics.m) and run.metrics_without_value == {"m": reason}
    assert metric_rows(run)[0].reason == reason and reason in run._repr_html_()
    assert run.manifest["metrics"] == {"m": None} and run.manifest["metrics_without_value"] == {"m": reason}


def test_a_disturbed_loop_at_rest_has_a_settling_time_only_with_a_band_in_units():
    rest = loop(step(target=0.0), metrics={"m": metrics.settling_time}, disturbance=step_load(size=1.0, time=0.0)).run(
        0.1, every=0, engine="python"
    )
    assert rest.metrics_without_value["m"] == (
        "the command never changes in this run, so 2 % of its last move is a band of width 0: set band"
    )


@pytest.mark.filterwarnings("ignore::leadscrew.kernel.loop.DivergenceWarning")
def test_every_metric_of_a_run_that_diverged_says_when():
    run = loop(bound=100.0).using({"controller.rate": 2100.0}).run(1.0, engine="python")
    assert run.diverged is not None and list(run.metrics_without_value) == list(metrics.STANDARD)
    assert set(run.metrics_without_value.values()) == {f"the run diverged at t = {run.diverged.time:g} s"}


def test_the_replay_of_an_older_run_does_not_differ_where_only_a_metric_lost_its_meaning():
    run = loop(sine(), metrics={"m": metrics.overshoot}).run(0.1, engine="python")
    older = {"diverged": None, "metrics": {"m": 0.001}}
    assert _other_end(older, run) == ""
    assert _other_end(older | {"metrics_without_value": {}}, run) == "metric m: saved 0.001, now None"
