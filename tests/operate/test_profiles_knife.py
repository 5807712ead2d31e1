"""What the disturbances of the tangential knife do, and that they end; and those of a machine of one's own."""

import math

import numpy as np
import pytest

from leadscrew.experiment import Experiment
from leadscrew.machine import write
from leadscrew.operate.profile import fitted
from leadscrew.operate.profiles import profile_of
from leadscrew.operate.profiles.sofnn_tangent import MATERIALS
from tests.machine.test_machine_file import EMPS
from tests.operate.playing import loop_of, play

LAP_S = 7.9


@pytest.fixture(scope="module")
def calm():
    return play("sofnn_tangent", None, LAP_S, 3 * LAP_S)


def knife(name, then_s=3 * LAP_S, **fields):
    return play("sofnn_tangent", name, LAP_S, then_s, **fields)


@pytest.mark.slow
@pytest.mark.parametrize("material", MATERIALS)
def test_another_material_shears_by_its_own_numbers(material):
    """The equation of the shear, integrated exactly over a sample, from the first sample on."""
    loop = loop_of("sofnn_tangent", "paper.uncompensated")
    run = play("sofnn_tangent", f"to_{material}", LAP_S, LAP_S, loop=loop, for_s=0.0)
    shear, lag, fibre, bias, _, _ = MATERIALS[material]
    fit = shear * run["disturbance.curvature"] + fibre * np.sin(2.0 * np.radians(run["disturbance.heading"])) + bias
    steady = 14.0 * np.tanh((run["disturbance.texture"] - fit) / 14.0)
    seen = run["plant.shear"]
    then = steady[:-1] + (seen[:-1] - steady[:-1]) * math.exp(-run.period_s / lag)
    assert seen[run.at + 1 :] == pytest.approx(then[run.at :], abs=1e-9)


@pytest.mark.slow
def test_a_material_for_a_while_is_followed_by_the_old_one(calm):
    run = knife("to_foam", for_s=2.0)
    assert np.abs(run.span("plant.shear", 0.5, 2.0) - calm.span("plant.shear", 0.5, 2.0)).max() > 1.0
    assert np.abs(run.span("plant.shear", 4.0, 5.0) - calm.span("plant.shear", 4.0, 5.0)).max() < 1e-6
    assert run.after == run.before


@pytest.mark.slow
def test_a_step_of_the_shear_comes_now_and_lasts_as_long_as_asked():
    loop = loop_of("sofnn_tangent", "paper.uncompensated", "step", scenario__step_deg=0.0)
    run = play("sofnn_tangent", "load_pulse", 1.0, 4.0, loop=loop, size=-5.0, for_s=2.0)
    assert run.span("plant.shear", 1.0, 2.0) == pytest.approx(14.0 * math.tanh(-5.0 / 14.0))
    assert run.span("plant.shear", 3.0, 4.0) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
def test_a_push_turns_the_cut_at_once_and_ends(calm):
    run = knife("push", size=3.0, for_s=0.3)
    assert np.count_nonzero(run["disturbance.push"]) == 30
    jump = run["actual.deviation"] - calm["actual.deviation"]
    assert not jump[: run.at + 1].any()
    assert jump[run.at + 1] == pytest.approx(3.0)


@pytest.mark.slow
def test_texture_has_the_size_asked_for_and_ends():
    run = knife("texture", 8 * LAP_S, size=2.0, for_s=5 * LAP_S)
    assert np.std(run.span("disturbance.texture", 0.5, 5 * LAP_S)) == pytest.approx(2.0, rel=0.15)
    assert np.std(run.span("disturbance.texture", 6 * LAP_S, 8 * LAP_S)) == pytest.approx(0.25, rel=0.25)


def late(run, first_s, last_s):
    """What the camera says over what was under the blade four samples before."""
    first, last = (run.at + round(x / run.period_s) for x in (first_s, last_s))
    return run["feedback.deviation"][first:last] - run["actual.deviation"][first - 4 : last - 4]


@pytest.mark.slow
def test_a_camera_that_was_knocked_reads_beside():
    run = knife("camera_zero", zero=1.0, for_s=0.0)
    assert np.mean(late(run, 0.0, 2 * LAP_S)) == pytest.approx(1.0, abs=0.02)
    assert np.mean(late(run, -LAP_S + 0.1, 0.0)) == pytest.approx(0.0, abs=0.03)


@pytest.mark.slow
def test_a_cut_that_is_lost_is_seen_again():
    run = knife("camera_lost", for_s=0.5)
    assert np.count_nonzero(run["feedback.seen"] == 0.0) == 50
    assert set(run.span("feedback.seen", 0.0, 0.5)) == {0.0}
    assert len(set(run.span("feedback.deviation", 0.0, 0.5))) == 1


@pytest.mark.slow
def test_noise_of_the_camera_has_the_size_asked_for_and_ends():
    run = knife("noise", 3 * LAP_S, deviation=1.0, for_s=LAP_S)
    assert np.std(late(run, 0.0, LAP_S)) == pytest.approx(1.0, rel=0.08)
    assert np.std(late(run, LAP_S, 3 * LAP_S)) == pytest.approx(0.15, rel=0.08)


# ---- a machine of one's own


@pytest.fixture
def own(tmp_path):
    write(tmp_path / "emps.toml", EMPS)
    return str(tmp_path / "emps.toml")


def test_a_machine_file_has_its_signals_with_units_a_push_and_noise(own):
    profile = profile_of(own)
    loop = profile.operated(Experiment(own, profile.controller, profile.scenario).loop())
    seen = {p.title: (p.unit, [t.signal for t in p.traces]) for p in fitted(profile, loop).plots}
    assert seen["Command and machine"] == ("mm", ["command.position", "actual.position", "feedback"])
    assert seen["Error"] == ("um", ["true_error", "error"])
    assert seen["Output"] == ("V", ["output", "applied"])
    assert [d.name for d in fitted(profile, loop).disturbances] == ["move_to", "load_pulse", "noise"]


@pytest.mark.slow
def test_a_push_at_a_machine_file_s_axis_is_seen_in_its_load(own):
    profile = profile_of(own)
    loop = profile.operated(Experiment(own, profile.controller, profile.scenario).loop())
    run = play(own, "load_pulse", 1.0, 1.0, loop=loop, size=20.0, for_s=0.2)
    assert np.count_nonzero(run["disturbance"]) == 200
    assert set(run.span("disturbance", 0.0, 0.2)) == {20.0}
    noisy = play(own, "noise", 1.0, 1.0, loop=loop, deviation=50.0, for_s=0.5)
    assert np.std(noisy.span("error", 0.0, 0.5)) > 10.0 * np.std(noisy.span("error", 0.6, 1.0))


def test_a_study_that_does_not_exist_is_refused_with_the_nearest():
    from leadscrew.util.errors import NameUnknown

    with pytest.raises(NameUnknown, match="vud_lathe"):
        profile_of("vud_late")
