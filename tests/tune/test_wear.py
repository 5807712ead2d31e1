"""Wear: what drifts, how the rest stays, and where the yield falls below a level."""

from __future__ import annotations

import numpy as np
import pytest

from leadscrew.tune.executors import Threads
from leadscrew.tune.measure import measure
from leadscrew.tune.montecarlo import montecarlo
from leadscrew.tune.parameter_drift import Wear, envelope, falls_below, wear, wears
from leadscrew.tune.space import Space
from leadscrew.tune.statistics import quantiles
from leadscrew.util.errors import NameUnknown, ValueRefused
from tests.tune.shared import job

CREW = Threads(2)
SPACE = Space.of(["controller.kp=normal:4:0.5"])


@pytest.mark.parametrize(
    ("text", "found", "half"),
    [
        ("a.b=1:3", Wear("a.b", 1, 3), 2.0),
        ("a.b=1:100:log", Wear("a.b", 1, 100, log=True), 10.0),
        ("a.b=x1:x0.5", Wear("a.b", 1, 0.5, factor=True), 0.75),
        (" a.b = x1:x4:log ", Wear("a.b", 1, 4, log=True, factor=True), 2.0),
        ("a.b=-1:1e-3", Wear("a.b", -1, 1e-3), -0.4995),
    ],
)
def test_drifts_are_read(text, found, half):
    w = wear(text)
    assert w == found and wear(str(w)) == w
    assert w.at(0.5) == pytest.approx(half) and (w.at(0.0), w.at(1.0)) == (found.start, found.end)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a.b", "expected KEY=START:END"),
        ("a.b=1", "expected KEY=START:END"),
        ("a.b=x1:2", "expected KEY=START:END"),
        ("a.b=1:1", "two different numbers"),
        ("a.b=-1:1:log", "above 0"),
        ("a.b=x0:x1", "factors must be above 0"),
        ("a.b=nan:1", "two different numbers"),
    ],
)
def test_what_is_no_drift_is_refused(text, words):
    with pytest.raises(ValueRefused, match=words):
        wear(text)


def test_drifts_must_fit_the_loop():
    for text, words in (
        ("plant.lag=0.1:0.2", "did you mean plant.lag_s"),
        ("plant.lag_s=0:0.2", "allowed range"),
        ("controller.stages=1:3", "only numbers drift"),
        ("controller.kp=3:5", "is distributed as well"),
    ):
        with pytest.raises((ValueRefused, NameUnknown), match=words):
            wears((text,), job(), SPACE)
    with pytest.raises(ValueRefused, match="given twice"):
        wears(("plant.lag_s=0.1:0.2", "plant.lag_s=0.1:0.3"), job(), SPACE)
    with pytest.raises(ValueRefused, match="differs between the scenarios"):
        wears(("reference.target=x1:x2",), job("small", "large"), SPACE)
    with pytest.raises(ValueRefused, match="allowed range"):
        wears(("sensor.noise_mm=x1:x2", "controller.kp=x1:x2"), job(), Space.of(["controller.kp=normal:0.1:0.05"]))


def test_every_step_is_the_same_samples_and_noise_with_the_drift():
    found = montecarlo(job(), SPACE, 200, seed=3, tolerances=("rms_error<=0.3",), crew=CREW)
    life = envelope(found, ("plant.lag_s=0.03:0.09", "controller.kp=x1:x0.8"), steps=4, crew=CREW)
    for k, at in enumerate((0.0, 1 / 3, 2 / 3, 1.0)):
        columns = {
            "controller.kp": found.samples.columns["controller.kp"] * (1.0 + at * (0.8 - 1.0)),
            "plant.lag_s": np.full(200, 0.03 + at * 0.06),
        }
        values = measure(job(), columns, CREW).metrics["small"]["rms_error"]
        band = life.band("small", "rms_error")[k]
        assert band == pytest.approx([q.value for q in quantiles(values)], rel=1e-6)
        assert abs(life.yields[k].passed - (values <= 0.3).sum()) <= 1
    assert np.all(np.diff(life.band("small", "rms_error")[:, 3]) > 0)


def test_a_factor_on_a_parameter_that_is_not_drawn_is_of_the_loops_own():
    found = montecarlo(job(), SPACE, 50, crew=CREW)
    a, b = (envelope(found, (text,), steps=2, crew=CREW) for text in ("plant.lag_s=x1:x2", "plant.lag_s=0.05:0.1"))
    assert np.array_equal(a.band("small", "rms_error"), b.band("small", "rms_error"))
    bare = montecarlo(job(), Space(()), 50, crew=CREW)
    assert np.array_equal(
        envelope(bare, ("plant.lag_s=x1:x2",), steps=2, crew=CREW).band("small", "rms_error")[0],
        [q.value for q in bare.spreads[0].quantiles],
    )


def test_drifts_are_given_as_a_mapping_too(tmp_path):
    found = montecarlo(job(), SPACE, 50, crew=CREW)
    texts = envelope(found, ["plant.lag_s=0.05:0.1", "controller.kp=x1:x0.8"], steps=2, crew=CREW)
    for more in ({}, {"resume": True}):
        given = {"plant.lag_s": (0.05, 0.1), "controller.kp": "x1:x0.8"}
        plain = envelope(found, given, steps=2, journal=tmp_path / "wear", **more)
        assert plain.wears == texts.wears and plain.yields == texts.yields
        assert np.array_equal(plain.band("small", "rms_error"), texts.band("small", "rms_error"))
    with pytest.raises(ValueRefused, match="different: life"):
        envelope(found, given, steps=3, journal=tmp_path / "wear", resume=True)
    with pytest.raises(ValueRefused, match="expected KEY=START:END"):
        envelope(found, {"plant.lag_s": "soon"}, steps=2)


def test_where_the_yield_falls_below_a_level():
    life = np.linspace(0, 1, 5)
    assert falls_below(life, np.array([1.0, 1.0, 0.8, 0.4, 0.0]), 0.9) == pytest.approx(0.375)
    assert falls_below(life, np.array([0.5, 1.0, 1.0, 1.0, 1.0]), 0.9) == 0.0
    assert np.isnan(falls_below(life, np.ones(5), 0.9))
    found = montecarlo(job(), SPACE, 300, tolerances=("rms_error<=0.3",), crew=CREW)
    drift = envelope(found, ("plant.lag_s=0.03:0.12",), steps=6, crew=CREW)
    end = drift.crossing(0.5)
    assert 0.0 < end.low < end.life < end.high < 1.0
    with pytest.raises(ValueRefused, match="2 on"):
        envelope(found, ("plant.lag_s=0.03:0.12",), steps=1, crew=CREW)
