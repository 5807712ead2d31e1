"""The knife in flexible material: its steady states, its lags, its texture, what the camera sees, and the program."""

import math

import numpy as np
import pytest
from scipy import signal

from leadscrew.disturbances._cut_load import CutLoad, cut_load
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.noise import Noise
from leadscrew.plants._flexible_cut import MATERIALS, FlexibleCutParams, FlexibleCutState, flexible_cut, steady_shear
from leadscrew.references._cut_line import ROOM, along, cut_line, tables
from leadscrew.references._step import step
from leadscrew.sensors._cut_camera import cut_camera, cut_reading
from leadscrew.studies.npid_xytable.tunings import table_pid
from leadscrew.util.errors import ValueRefused
from tests.kernel.loops import turns_blade

T = 0.01
STILL = table_pid(kp=0.0, ki=0.0, kd=0.0)


def knife(**parts):
    given = {
        "reference": step(target=0.0), "controller": STILL, "plant": flexible_cut, "disturbance": cut_load(size=0.0),
        "sensor": cut_camera(noise_deg=0.0), "period": T, "metrics": {},
    }  # fmt: skip
    return Loop(**(given | parts))


def test_a_curve_turns_the_cut_by_shear_times_curvature():
    radius = 30.0
    heading, curvature = np.degrees(np.arange(800) * 0.5 / radius), np.full(800, 1.0 / radius)
    isotropic = flexible_cut(**{"material.fibre": 0.0, "material.bias": 0.0})
    run = knife(plant=isotropic, disturbance=along(cut_load, heading, curvature, size=0.0)).run(2.0)
    assert run["actual.deviation"][-1] == pytest.approx(-14.0 * math.tanh(45.0 / radius / 14.0), rel=1e-9)


def test_an_offset_of_the_axis_turns_the_cut_by_the_gain_of_the_material_after_both_lags():
    plain = flexible_cut(**{"material.bias": 0.0, "material.fibre": 0.0})
    run = knife(plant=plain, reference=step(target=1.0, time=0.0), controller=table_pid(kp=1.0, ki=0.0, kd=0.0)).run(
        0.2
    )
    assert run["output"][0] == 1.0
    # before the camera sees anything (4 samples): the lag of the axis alone, exactly
    seen = run["actual.deviation"][:4]
    assert seen == pytest.approx(0.95 * (1.0 - np.exp(-np.arange(4) * T / 0.02)), rel=1e-12)


def test_the_shear_follows_its_steady_value_as_scipy_says():
    pushed = along(cut_load, np.zeros(1), np.zeros(1), size=0.0, step=-5.0, step_at=0.1)
    plain = flexible_cut(**{"material.bias": 0.0, "material.lag_s": 0.1})
    run = knife(plant=plain, disturbance=pushed).run(1.0)
    u = np.where(np.arange(100) * T > 0.1 - 1e-9, -14.0 * math.tanh(5.0 / 14.0), 0.0)
    a, b, c, d, _ = signal.cont2discrete((np.array([[-10.0]]), np.array([[10.0]]), np.eye(1), np.zeros((1, 1))), T)
    found = signal.dlsim((a, b, c, d, T), u)[1].ravel()
    assert run["actual.deviation"] == pytest.approx(found, abs=1e-12)


def test_the_cut_leaves_its_line_by_the_integral_of_the_sine_of_its_deviation():
    run = knife().run(3.0)
    e = np.radians(run["actual.deviation"])
    assert run["actual.lateral"] == pytest.approx(np.cumsum(np.sin(e)) * 0.5, abs=1e-12)
    assert run["actual.lateral"][-1] < -0.5  # the bevel alone pulls it half a millimetre away in 150 mm


@pytest.mark.parametrize("name", MATERIALS)
def test_the_steady_shear_is_the_digests_sum(name):
    m = MATERIALS[name]
    p = FlexibleCutParams(material=m, feed=80.0)
    load = CutLoad(heading=40.0, curvature=0.05, texture=0.7, travel=10.0)
    expected = -(m.shear * 0.05 * 1.6**m.exponent + m.fibre * math.sin(math.radians(80.0)) + m.bias) + 0.7
    assert steady_shear(p, m, load) == pytest.approx(expected, rel=1e-12)


def test_the_material_changes_where_it_is_said():
    plant = flexible_cut(change_at=100.0, **{"changed.bias": 3.0})
    e = knife(plant=plant).run(4.0)["actual.deviation"]
    assert e[200] == pytest.approx(-0.3, abs=1e-3) and e[-1] == pytest.approx(-14.0 * math.tanh(3.0 / 14.0), abs=1e-3)


def test_play_in_the_shear_keeps_the_side_it_came_from():
    state = FlexibleCutState()
    p = FlexibleCutParams(hysteresis=0.3, material=MATERIALS["fabric"]._replace(bias=0.0))
    found = []
    for texture in (2.0, 0.0, -2.0, 0.0):
        for _ in range(100):
            state = flexible_cut(p, state, 0.0, CutLoad(texture=texture), T)
        found.append(14.0 * math.atanh(state.deviation / 14.0))
    assert found == pytest.approx([1.7, 0.3, -1.7, -0.3], abs=1e-6)


@pytest.mark.slow
def test_texture_has_its_size_and_length_at_every_feed():
    for feed in (20.0, 50.0):
        loop = knife(disturbance=cut_load(feed=feed, size=0.25), plant=flexible_cut(feed=feed))
        n = np.concatenate(
            [loop.run(60.0, replicate=k, record="disturbance.texture")["disturbance.texture"] for k in range(3)]
        )
        near = int(3.0 / (feed * T))
        assert np.std(n) == pytest.approx(0.25, rel=0.08)
        assert np.corrcoef(n[:-near], n[near:])[0, 1] == pytest.approx(math.exp(-near * feed * T / 3.0), abs=0.06)
        first = [loop.run(T, replicate=k, record="disturbance.texture")["disturbance.texture"][0] for k in range(200)]
        assert np.std(first) == pytest.approx(0.25, rel=0.2)


@pytest.mark.slow
def test_the_camera_sees_the_cut_late_with_noise_and_loses_it():
    camera = cut_reading(noise_deg=0.15, zero_deg=0.1, lost_from_s=1.0, lost_for_s=0.5)
    line = along(cut_line, np.zeros(1), np.zeros(1))
    run = knife(reference=line, controller=turns_blade, sensor=camera).run(6.0, record=("feedback", "actual"))
    error = run["feedback.deviation"][4:] - run["actual.deviation"][:-4] - 0.1
    seen = run["feedback.seen"] > 0.5
    assert np.flatnonzero(~seen).tolist() == list(range(100, 150))
    assert set(run["feedback.deviation"][~seen]) == {run["feedback.deviation"][99]}
    assert np.std(error[seen[4:]]) == pytest.approx(0.15, rel=0.1) and abs(np.mean(error[seen[4:]])) < 0.02


def test_the_program_shows_the_line_ahead_and_goes_round_again():
    heading = np.linspace(0.0, 350.0, 36)
    block = along(cut_line, heading, np.arange(36) / 100.0, again=True, turn=360.0, preview=3)
    run = knife(reference=block, controller=turns_blade, sensor=cut_reading).run(1.0, record="command")
    assert run["command.heading"] == pytest.approx(10.0 * np.arange(100))
    assert run["command.heading_ahead"] == pytest.approx(10.0 * (np.arange(100) + 3))
    assert run["command.curvature_ahead"] == pytest.approx((np.arange(100) + 3) % 36 / 100.0)
    assert run["command.travel"] == pytest.approx(0.5 * np.arange(100))
    held = knife(reference=block(again=False), controller=turns_blade, sensor=cut_reading).run(1.0, record="command")
    assert set(held["command.heading"][36:]) == {350.0}


def test_what_has_no_place_is_refused():
    with pytest.raises(ValueRefused, match="1 to 2048 samples"):
        tables(np.zeros(ROOM + 1), np.zeros(ROOM + 1))
    with pytest.raises(ValueRefused, match="not finite"):
        tables(np.array([0.0, np.nan]), np.zeros(2))
    with pytest.raises(ValueRefused, match="63 or fewer"):
        knife(sensor=cut_camera(trailing_s=1.0)).run(0.1)
    with pytest.raises(ValueRefused, match="inf samples late; expected 63 or fewer"):
        knife(sensor=cut_camera(trailing_s=1e308)).run(0.1)


def test_a_change_of_the_material_comes_with_its_sample_and_goes_with_the_one_of_its_end():
    block = cut_load(size=0.0, step=-5.0, push=2.0, step_at=0.02, step_for=0.03)
    state, found = block.state, []
    for k in range(7):
        state, load = block.step(block.params, state, k * T, T, Noise(0, 0, 0, 0))
        found.append((load.texture, load.push, load.travel))
    on = [0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0]
    assert found == [pytest.approx((-5.0 * x, 2.0 * x, 0.5 * k)) for k, x in enumerate(on)]
