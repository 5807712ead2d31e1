"""Scores of ``identify axis``: from the start that was measured, and a cascade that did not make the log is named."""

import numpy as np
import pytest

from leadscrew.identify.axis.cascade import Cascade
from leadscrew.identify.axis.fit import identify_axis
from leadscrew.logs import axis_log
from leadscrew.report.identified_axis import sentences
from tests.identify.axis_oracle import Axis, closed_loop, open_loop
from tests.identify.axis_runs import AXIS, DT, shove

N = 2000
T = DT * np.arange(N)
START = 0.05
"""m/s."""


@pytest.mark.parametrize(("refine", "holdout"), [("open", 0.0), pytest.param("open", 0.4, marks=pytest.mark.slow)])
def test_an_error_is_not_made_small_by_a_start_speed_that_nobody_measured(refine, holdout):
    force = shove(N * DT)
    unknown = np.where((T > 0.06) & (T < 0.3), 20.0, 0.0)  # which a start speed would make up for
    measured = 1e-7 * np.round(open_loop(AXIS, force + unknown, DT, 0.0, START) / 1e-7)
    fit = identify_axis(
        axis_log(T, force, measured), symmetric=True, model="coulomb", refine=refine, holdout=holdout, delay=0.0
    )
    v = fit.values
    axis = Axis(v["mass"], v["friction.forward.viscous"], v["friction.forward.coulomb"], v["offset"])
    left = open_loop(axis, force, DT, 0.0, START) - measured
    for judged in fit.judged:
        if judged.what != "hold-out":
            expected = float(np.sqrt(np.mean(left[: len(judged.time)] ** 2)))
            # The start is measured in 20 ms, with the model's mass; with a start that fits best it is 0.1 to 0.4 of it.
            assert 0.9 * expected < judged.rms < 1.5 * expected, judged.what


@pytest.fixture(scope="module")
def looped():
    """A log under u = 6000 (40 (command - x) - v), the speed as the axis has it."""
    command = 0.05 * np.sin(2.0 * np.pi * 0.8 * T) + 0.01 * np.sin(2.0 * np.pi * 3.1 * T)
    x = closed_loop(AXIS, command, DT, 40.0, 6000.0, 0.0, over=1)
    speed = np.diff(x, prepend=x[0]) / DT
    return axis_log(T, 6000.0 * (40.0 * (command - x) - speed), x, command)


@pytest.mark.parametrize(("kv", "left"), [(6000.0, 0.0), (3000.0, 50.0), (19000.0, 216.7)])
def test_a_cascade_that_did_not_make_the_log_says_so_beside_its_score(looped, kv, left):
    fit = identify_axis(looped, symmetric=True, model="coulomb", refine="none", cascade=Cascade(40.0, kv))
    # The law is proportional to kv: (kv / 6000 - 1) of the drive is left, and its mean is near 0.
    assert fit.cascade_left_percent == pytest.approx(left, rel=0.02, abs=0.5)
    said = [k for k, s in enumerate(sentences(fit)) if s.startswith("the known controller leaves")]
    assert bool(said) == (left > 5.0)
    if said:
        assert sentences(fit)[said[0] - 1].startswith("under the known controller")
        assert f"leaves {left:.3g} % of the logged drive" in sentences(fit)[said[0]] or left > 100.0
    assert fit.as_dict()["cascade_left_percent"] == fit.cascade_left_percent
