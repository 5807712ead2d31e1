"""Design of a nonlinear PID: its bounds against worked numbers, its limits, what binds, and the paper's own way."""

import math
from dataclasses import replace

import numpy as np
import pytest

from leadscrew.design.npid import Bench, design_npid, retuned
from leadscrew.design.npid_axis import Case, Gains, TableAxis, Work, block_of, bounds_of, strength_for
from leadscrew.design.npid_paper import paper_design
from leadscrew.report.npid_design import paper_steps, report_of
from leadscrew.studies.npid_xytable.calibration import volts
from leadscrew.studies.npid_xytable.table2 import LINES_HZ, PID_UM
from leadscrew.util.errors import ValueRefused

WORK = Work(tuple(Case(f"{rpm} 1/min", volts(um), rpm / 60.0) for rpm, um in PID_UM.items()), LINES_HZ)
RETUNED = Gains(1.6533, 248.0, 0.00533)
"""An independent design, Ms 1.85."""


def words(design):
    """The steps as a terminal prints them."""
    return "\n".join(line.plain for line in report_of(design, None, []).parts[0](1000))


@pytest.mark.parametrize(
    ("slope", "x", "gain", "most"), [(2.5, 0.941, 1.477, 32), (2.27, 0.873, 1.406, 29), (2.0, 0.783, 1.322, 24)]
)
def test_the_slope_limits_the_saturated_cosh_as_worked_by_hand(slope, x, gain, most):
    found = strength_for("cosh", math.inf, slope)
    assert found == pytest.approx(x, abs=6e-4)
    top, steepest = bounds_of("cosh", found)
    assert top == pytest.approx(gain, abs=6e-4) and steepest == pytest.approx(slope, rel=1e-12)
    assert round(100.0 * (1.0 - 1.0 / top)) == most


def test_the_gain_limits_the_cosh_where_the_slope_does_not():
    assert strength_for("cosh", 2.35, 100.0) == pytest.approx(math.acosh(2.35), rel=1e-12)
    assert strength_for("slope", 2.1, 2.06) == 2.06 and strength_for("slope", 0.5, 9.0) == 1.0


def test_the_candidates_are_the_blocks_that_they_name():
    paper = block_of("cosh", Gains(), 1.5, 3.0)
    assert paper.name == "npid" and (paper.params.alpha, paper.params.e_max) == (0.5, 3.0)
    ours = block_of("slope", Gains(), 2.2, 0.5)
    assert ours.name == "npid_slope" and (ours.params.k, ours.params.es_um) == (2.2, 0.5)
    with pytest.raises(ValueRefused, match=r"slope .* and cosh"):
        block_of("quadratic", Gains())


@pytest.mark.slow
def test_a_trial_reproduces_the_calibrated_column_and_the_following_error():
    bench = Bench(TableAxis(), WORK, "slope")
    found = bench.tried(Gains(), [1.0], [1.0])
    assert found.rows_um[0] == pytest.approx(np.array(list(PID_UM.values())), abs=6e-3)
    assert found.tracking_um[0] == pytest.approx(7.12, rel=2e-3)
    many = bench.tried([Gains(), Gains().times(1.5)], [1.0, 1.0], [1.0, 1.0])
    assert many.rms_um[0] == pytest.approx(found.rms_um[0], rel=2e-3)
    assert many.score(found, 1.0)[1] == pytest.approx(1.0 / 1.5, rel=0.01), "high loop gain: the error goes as 1 / gain"
    assert many.rest_du_mv[1] > 1.2 * many.rest_du_mv[0]


def test_the_papers_way_gives_its_numbers_and_says_where_it_breaks():
    found = paper_design()
    assert found.alpha == pytest.approx(0.4996, abs=5e-5) and found.k_limit == 2.5
    assert 1e3 * found.dead_time_s == pytest.approx(1.2888, abs=5e-5)
    assert 1e3 * found.sampled_dead_time_s == pytest.approx(0.7797, abs=5e-5)
    assert (found.popov_zero, found.popov_one, found.circle_one) == pytest.approx((1.408, 2.5, 2.270), rel=5e-4)
    assert found.slope == pytest.approx(5.5463, abs=5e-5) and found.linear_fit_r2 == pytest.approx(0.916, abs=5e-4)
    said = "\n".join(line.plain for line in paper_steps(found)(1000))
    assert [s for s in said.splitlines() if s[:1].isdigit()] == [
        "1. PID gains (Table I)", "2. intercept of the plot with the negative real axis",
        "3. limit of the gain, equation (3)", "4. retuned by hand against chatter", "5. e_max chosen, alpha from (2)",
    ]  # fmt: skip
    assert "no crossing without dead time" in said and "chatter follows the slope" in said


def test_a_retuned_pid_has_the_sensitivity_that_was_asked_and_beats_the_digests_at_it():
    control = pytest.importorskip("control")
    axis = TableAxis()
    found = retuned(axis, LINES_HZ, 1.85)
    g = found.gains
    loop = axis.linear(g).to_control()
    w = np.concatenate([np.geomspace(1.0, 2e3, 6000), np.linspace(2e3, np.pi / axis.period_s, 500)])
    sensitivity = control.feedback(1.0, loop)
    assert np.abs(sensitivity(np.exp(1j * w * axis.period_s))).max() == pytest.approx(1.85, rel=2e-3)
    assert found.ms <= 1.85 * 1.0001 and g.ki / g.kp <= 150.0 * (1.0 + 1e-9)

    def at_lines(gains):
        law = axis.linear(gains)
        return np.abs(1.0 / (1.0 + law.response(2.0 * np.pi * np.array(LINES_HZ))))

    ratio = (at_lines(g) / at_lines(Gains())).mean()
    assert found.ratio == pytest.approx(ratio, rel=1e-9)
    assert ratio <= (at_lines(RETUNED) / at_lines(Gains())).mean() * 1.01


@pytest.mark.slow
def test_the_slope_limited_design_stands_at_its_proof_and_at_its_noise_budget():
    found = design_npid(work=WORK)
    assert found.limits.driven == pytest.approx(2.265, abs=1e-3)
    assert found.best.slope == pytest.approx(2.265 / 1.1, rel=5e-4) and found.driven.grade == "certificate"
    assert found.binding == ("stability under command and load", "noise budget")
    assert 0.2 < found.best.scale_um < 0.6 and found.best.rest_du_mv <= found.limits.budget_mv
    assert found.best.score < 0.55 < 0.78 < found.linear.score < 1.0
    assert found.free.scale_um < 0.01 and found.free.score < found.best.score, "without noise a constant gain is best"
    assert found.free.rest_du_mv > 1.5 * found.limits.budget_mv
    file = found.controller_file()
    assert (file.controller, file.study) == ("npid_slope", "npid_xytable")
    assert found.controller().params.k == found.parameters["k"] == file.parameters["k"]
    assert "2. PID" in words(found) and "what binds: the slope stands at its limit" in words(found)


@pytest.mark.slow
def test_the_designed_loop_rests_under_every_load_where_the_papers_chatters():
    found = design_npid(work=WORK)
    still = replace(WORK, amplitude_mm=0.0, encoder_um=0.0, noise_um=0.0)
    for controller, chatters in ((found.controller(), False), (block_of("cosh", Gains(), 1.5, 3.0), True)):
        loop = found.axis.loop(controller, still, Case("load"))
        loop = loop.using({"disturbance.first.frequency": 0.0, "disturbance.first.phase": 0.5 * math.pi})
        push = 1.32e-3 * np.array([1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 12.0])
        done = loop.batch(4.0, {"disturbance.first.amplitude": push}, record=("true_error",))
        tail = 1e3 * done["true_error"][:, -1000:]
        assert (np.ptp(tail, axis=1).max() > 5.0) == chatters
        if not chatters:
            assert np.ptp(tail, axis=1).max() < 0.01


@pytest.mark.slow
def test_the_cosh_is_bound_by_its_slope_alone():
    found = design_npid(work=WORK, law="cosh", m2=1.0)
    assert found.best.gain == pytest.approx(1.406, abs=2e-3) and found.binding == ("stability under command and load",)
    assert found.best.score < found.linear.score


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"m2": 0.9}, "m2 = 0.9: a margin is a factor from 1 on"),
        ({"gains": Gains(kd=0.03)}, "makes an unstable loop with this axis"),
        pytest.param({"budget_mv": 1.0}, "the PID alone moves the voltage by", marks=pytest.mark.slow),
        ({"m2": 3.0}, "no gain above 1 is left"),
        ({"retune_ms": 1.0}, "a peak of sensitivity is above 1"),
        ({"axis": TableAxis(dead_time_s=0.01)}, "at most 4 periods"),
    ],
)
def test_what_cannot_be_designed_is_refused(options, said):
    with pytest.raises(ValueRefused, match=said.replace(".", r"\.")):
        design_npid(work=WORK, **options)


def test_a_work_without_anything_to_do_is_refused():
    with pytest.raises(ValueRefused, match="no error to make small"):
        Work(amplitude_mm=0.0)
    with pytest.raises(ValueRefused, match="one case at least"):
        Work(cases=())
