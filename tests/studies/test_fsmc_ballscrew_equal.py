"""Laws of the equal comparison: what the study calls a PID is one, and its judge counts as the searches do."""

import math

import numpy as np
import pytest

from leadscrew import resolve
from leadscrew.controllers._pd_dob import pd_dob
from leadscrew.controllers._sliding.integral import smc_integral
from leadscrew.plants._ballscrew_stage import INERTIA
from leadscrew.references._motion import Motion
from leadscrew.studies.fsmc_ballscrew import equal
from leadscrew.studies.lab import Lab

DT = 2.5e-4


def torques(block, errors, dt=DT):
    """Torques of a controller that stands at 0 and sees these angles."""
    plan = block.params if block.prepare is None else block.prepare(block.params, dt)
    state, given = block.state, []
    for angle in errors:
        state, torque = block.step(plan, state, Motion(0.0, 0.0, 0.0), float(angle), dt)
        given.append(torque)
    return np.array(given)


def test_the_integral_law_inside_its_layer_is_the_pid_whose_gains_the_study_names():
    angles = 1e-6 * np.sin(np.arange(400) / 17.0)
    lam, r = 800.0, 3000.0
    kp, ki, kd = INERTIA * np.array([3.0 * lam**2 + 2.0 * lam * r, lam**2 * (lam + r), 3.0 * lam + r])
    rate = np.diff(angles, prepend=0.0) / DT
    given = torques(smc_integral(lam=lam, layer_rate=r, friction_from=0), angles)
    assert given[1:] == pytest.approx(-(kp * angles + ki * DT * np.cumsum(angles) + kd * rate)[1:], rel=1e-9, abs=1e-12)


def test_a_pd_with_an_observer_and_fixed_gains_is_a_pid():
    dt, kp, kd, rate = 1e-6, 300.0, 0.9, 500.0
    t = dt * np.arange(20_000)
    angles = 1e-6 * (1.0 - np.cos(300.0 * t))
    block = pd_dob(kp=kp, kd=kd, kp_slow=0.0, kd_slow=0.0, observer_rate=rate, low_pass_hz=0.0, friction=False)
    speed, area = 3e-4 * np.sin(300.0 * t), 1e-6 * (t - np.sin(300.0 * t) / 300.0)
    pid = -((kp + rate * kd) * angles + rate * kp * area + (kd + rate * INERTIA) * speed)
    assert np.abs(torques(block, angles, dt) - pid).max() < 1e-3 * np.abs(pid).max()


@pytest.mark.filterwarnings("ignore:.*diverged")
def test_a_sine_from_rest_is_late_and_leaves_the_track_when_it_is_asked_to():
    """A delay or a mode that the scenario does not pass on leaves the loop as it was."""
    study = resolve.study("fsmc_ballscrew")
    delayed = study.build(study.controllers["ours.pd_dob"], study.scenario("rest_fast", {"delay": True}))
    flexible = study.build(study.controllers["ours.pd_dob"], study.scenario("rest_fast", {"axial_mode": True}))
    plain = study.build(study.controllers["ours.pd_dob"], study.scenario("rest_fast"))
    runs = [loop.run(0.3, record=("true_error",)) for loop in (plain, delayed, flexible)]
    size = [math.inf if run.diverged else 1e3 * np.abs(run["true_error"]).max() for run in runs]
    assert size[0] < 1.0 < 100.0 <= size[2] and size[1] != size[0]


@pytest.mark.slow
def test_the_judge_and_the_search_agree_on_the_order_of_the_best_and_the_worst_law():
    """Other stages and finer steps: a law that is good on the search's stages alone would change places."""
    found = equal.judged(Lab(resolve.study("fsmc_ballscrew")), "rigid")
    for law in ("pd_dob", "smc"):
        assert found[law].worst_um == pytest.approx(equal.searched_um(law), rel=0.5)
    assert found["pd_dob"].worst_um < found["smc"].worst_um
