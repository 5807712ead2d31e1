"""Monte Carlo: yields and percentiles of runs, tolerances, the worst runs run again to the same bits."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy import stats

from leadscrew import experiment
from leadscrew.kernel.loop import DivergenceWarning
from leadscrew.report.montecarlo import alike, independence, without_value
from leadscrew.tune.executors import Threads
from leadscrew.tune.montecarlo import montecarlo, sobol_indices
from leadscrew.tune.parameter_drift import envelope
from leadscrew.tune.space import Space
from leadscrew.tune.worst import worst, write
from leadscrew.util.errors import LeadscrewError, NameUnknown, ValueRefused
from tests.tune.noisy_loop import DIVERGING
from tests.tune.shared import job, same

SPACE = Space.of(["plant.lag_s=0.02:0.08", "controller.kp=normal:4:0.5", "controller.stages=1:3:int"])
CREW = Threads(2)


@pytest.fixture(scope="module")
def found():
    """Two scenarios, two tolerances, some runs that diverge."""
    space = Space.of(["plant.lag_s=0.0002:0.08:log", "controller.stages=1:3:int"])
    wanted = ("max_error@small<=1.01", "overshoot<=0.03", "settling>=0.001")
    return montecarlo(job("small", "large"), space, 600, seed=4, tolerances=wanted, crew=CREW)


def test_yields_are_counted_run_by_run(found):
    samples = found.samples
    alive = np.isnan(samples.diverged_at["small"]) & np.isnan(samples.diverged_at["large"])
    assert 0 < found.diverged.sum() < 600 and np.array_equal(found.diverged, ~alive)
    small, large = samples.metrics["small"], samples.metrics["large"]
    with np.errstate(invalid="ignore"):
        kept = (
            alive & (small["max_error"] <= 1.01) & (small["overshoot"] <= 0.03) & (large["overshoot"] <= 0.03)
            & (small["settling"] >= 0.001) & (large["settling"] >= 0.001)
        )  # fmt: skip
    assert found.joint.passed == kept.sum() and 0 < kept.sum() < 600
    assert found.yields["max_error@small<=1.01"].passed == (small["max_error"] <= 1.01).sum()
    theirs = stats.binomtest(int(kept.sum()), 600).proportion_ci(0.95, "exact")
    assert (found.joint.low, found.joint.high) == pytest.approx((theirs.low, theirs.high))


def test_percentiles_are_of_the_runs_with_a_value(found):
    row = next(s for s in found.spreads if (s.scenario, s.metric) == ("large", "settling"))
    values = found.samples.metrics["large"]["settling"]
    assert row.runs == 600 and row.diverged + row.without == np.isnan(values).sum()
    assert [q.value for q in row.quantiles] == pytest.approx(np.nanpercentile(values, [1, 5, 25, 50, 75, 95, 99]))


def test_the_parameter_that_matters_stands_out():
    m = montecarlo(job(), SPACE, 800, crew=CREW)
    rms = {c.key: c for c in m.correlations if c.metric == "rms_error"}
    assert rms["plant.lag_s"].value > 0.5 > abs(rms["controller.kp"].value)
    assert rms["controller.stages"].partial < -0.8
    rows = {s.key: s for s in sobol_indices(m, 128, crew=CREW) if s.metric == "rms_error"}
    assert rows["plant.lag_s"].total > rows["controller.kp"].total
    assert 0.8 < sum(s.first for s in rows.values()) < 1.2


@pytest.mark.parametrize("method", ["lhs", "sobol", "random"])
def test_the_same_question_has_the_same_answer(method):
    a, b, c = (montecarlo(job(), SPACE, 100, seed=s, method=method, crew=CREW).samples for s in (1, 1, 2))
    assert same(a, b) and not same(a, c)


def test_without_a_space_the_noise_alone_differs():
    m = montecarlo(job(), Space(()), 50, crew=CREW)
    assert m.samples.columns == {} and len(np.unique(m.samples.metrics["small"]["rms_error"])) == 50
    alone = job().loop("small").run(0.1, every=0, replicate=17)
    assert alone.metrics["rms_error"] == m.samples.metrics["small"]["rms_error"][17]
    assert m.correlations == ()


def test_what_is_given_plainly_is_the_same_question(tmp_path):
    plain = {"plant.lag_s": (0.02, 0.08), "controller.kp": "normal:4:0.5", "controller.stages": "1:3:int"}
    asked = {"seed": 3, "tolerances": ["rms_error<=0.3"]}
    want = montecarlo(job(), SPACE, 100, crew=CREW, **asked)
    assert same(want.samples, montecarlo(job(), plain, 100, **asked).samples)
    assert montecarlo(job(), None, 3).samples.columns == {} == montecarlo(job(), (), 3).samples.columns
    kept = montecarlo(job(), plain, 100, journal=tmp_path / "runs", **asked)
    with pytest.raises(ValueRefused, match="--resume goes on"):
        montecarlo(job(), plain, 100, journal=tmp_path / "runs", **asked)
    with pytest.raises(ValueRefused, match="different: runs"):
        montecarlo(job(), plain, 99, journal=tmp_path / "runs", resume=True, **asked)
    told = []
    again = montecarlo(
        job(), plain, 100, journal=tmp_path / "runs", resume=True, progress=lambda *x: told.append(x), **asked
    )
    assert same(kept.samples, again.samples) and told == [(100, 100)]
    for more in ({}, {"resume": True}):
        rows = sobol_indices(kept, 16, journal=tmp_path / "sobol", **more)
        assert rows == sobol_indices(want, 16, crew=CREW)


def test_runs_that_are_all_the_same_run_have_no_intervals():
    quiet = job(changes={"sensor.noise_mm": 0.0})
    found = montecarlo(quiet, None, 20, tolerances=["rms_error<=10"], crew=CREW)
    assert found.alike and (found.joint.passed, found.joint.value) == (20, 1.0)
    ends = [(y.low, y.high) for y in (found.joint, *found.yields.values())]
    ends += [(q.low, q.high) for s in found.spreads for q in s.quantiles]
    assert np.isnan(ends).all() and "all 20 runs are the same run" in alike(found)
    life = envelope(found, {"plant.lag_s": "x1:x2"}, steps=2)
    assert all(np.isnan(y.low) and y.value == 1.0 for y in life.yields)
    # One draw, one bit of noise, or one run alone: an interval again.
    for other in (
        montecarlo(job(), None, 20),
        montecarlo(quiet, {"plant.lag_s": (0.02, 0.08)}, 20),
        montecarlo(quiet, None, 1),
    ):
        assert not other.alike and alike(other) == "" and other.joint.low == other.joint.low


def test_a_metric_that_runs_give_no_value_for_says_in_how_many_and_why():
    """At a gain of 0.5 the slide is at 5 mm (1 - exp(-0.2 / 0.1)) in 0.2 s, 0.7 mm short; at 1 mm the same share."""
    found = montecarlo(job("large", changes={"controller.kp": 0.5}), None, 3, crew=CREW)
    (row,) = found.without_value
    assert (row.metric, row.runs, row.first) == ("settling", 3, 0)
    assert row.reason == "the error is outside ±0.1 at the end of the run"
    assert without_value(found) == [f"settling has no value in 3 of 3 runs; run 0: {row.reason}"]
    some = montecarlo(job("large"), {"controller.kp": (0.1, 2.0)}, 8, crew=CREW)
    lost = np.isnan(some.samples.metric("settling")[0])
    few = some.without_value[0]
    assert 0 < few.runs < 8 and (few.runs, few.first) == (lost.sum(), np.flatnonzero(lost)[0])


def test_intervals_say_what_they_rest_on():
    space = {"plant.lag_s": (0.02, 0.08)}
    said = {m: independence(montecarlo(job(), space, 4, method=m)) for m in ("lhs", "sobol", "random")}
    assert "Latin hypercube" in said["lhs"] and "Sobol points" in said["sobol"] and not said["random"]
    assert independence(montecarlo(job(), None, 4)) == ""


def test_every_file_of_the_worst_gives_the_very_run_again(found, tmp_path):
    rows = worst(found, 3)
    files = write(found, rows, tmp_path)
    assert len(set(files)) == len(rows) == 12
    for row, file in zip(rows, files, strict=True):
        asked = experiment.read(file)
        assert asked.replicate == row.run and asked.scenario == row.scenario
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DivergenceWarning)
            again = asked.loop().run(asked.seconds(), every=0, replicate=asked.replicate)
        if row.of == "diverged":
            assert again.diverged is not None and again.diverged.time == row.value
            continue
        metrics = found.samples.metrics[row.scenario]
        for name, values in metrics.items():
            assert np.float64(again.metrics[name]).tobytes() == values[row.run].tobytes()


def test_the_worst_are_the_worst(found):
    rows = worst(found, 2)
    value = {f"{w.of}_{w.rank}": w.value for w in rows}
    metrics = found.samples.metrics
    assert value["max_error_small_1"] == np.nanmax(metrics["small"]["max_error"])
    assert value["overshoot_1"] == np.nanmax([metrics[s]["overshoot"] for s in metrics])
    assert value["diverged_1"] == np.nanmin([found.samples.diverged_at[s] for s in metrics]) <= value["diverged_2"]
    # Runs that never settled are worse than any that did.
    assert np.isnan(value["settling_1"])
    plain = montecarlo(job(), SPACE, 50, crew=CREW)
    assert {w.of for w in worst(plain, 1)} == {"rms_error", "max_error", "overshoot", "settling"}
    assert worst(plain, 0) == ()


def test_a_seed_and_changes_come_along(tmp_path):
    changed = job(seed=11, changes={"scenario.target_mm": 2.0, "controller.on": False, "sensor.noise_mm": 0.05})
    m = montecarlo(changed, SPACE, 20, crew=CREW)
    (row, *_) = rows = worst(m, 1)
    asked = experiment.read(write(m, rows, tmp_path)[0])
    assert asked.seed == 11 and asked.changes["controller.on"] is False
    assert isinstance(asked.changes["controller.stages"], int)
    assert asked.loop().run(asked.seconds(), every=0, replicate=asked.replicate).metrics[row.of] == row.value


def test_all_runs_may_diverge():
    m = montecarlo(job(), Space.of(DIVERGING), 40, tolerances=("max_error<=1",), crew=CREW)
    assert m.diverged.all() and m.joint.passed == 0 and m.yields["max_error<=1"].value == 0.0
    assert all(s.diverged == 40 and np.isnan(s.mean) for s in m.spreads)
    assert all(np.isnan(c.value) for c in m.correlations)
    assert [w.of for w in worst(m, 2)] == ["diverged"] * 2


@pytest.mark.parametrize(
    ("over", "wanted", "words"),
    [
        (["plant.lag_s=0.1:0.1"], (), "the range 0.1:0.1 is empty"),
        (["plant.lag=0.1:0.2"], (), "did you mean plant.lag_s"),
        (["plant.lag_s=-1:0.2"], (), r"plant\.lag_s = -1\.0"),
        (["controller.on=0:1"], (), "only numbers vary"),
        ([], ("overshot<=1",), "did you mean overshoot"),
        ([], ("overshoot@smal<=1",), "did you mean small"),
        ([], ("overshoot<=1", "overshoot>=2"), "overshoot<=1 and overshoot>=2 contradict each other"),
        ([], ("overshoot@small>=2", "overshoot<=1"), "contradict each other"),
    ],
)
def test_what_makes_no_sense_is_one_sentence(over, wanted, words):
    with pytest.raises((ValueRefused, NameUnknown), match=words) as said:
        montecarlo(job(), Space.of(over), 10, tolerances=wanted, crew=CREW)
    assert "\n" not in str(said.value) and isinstance(said.value, LeadscrewError)


def test_no_runs_are_refused():
    with pytest.raises(ValueRefused, match="runs"):
        montecarlo(job(), SPACE, 0, crew=CREW)
