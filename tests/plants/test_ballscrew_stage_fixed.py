"""The stage in steps of a fixed cost: against SciPy's Radau, in slow sliding, in batches, exported."""

import math
import shutil
import subprocess

import numpy as np
import pytest

from leadscrew.bench.stage import (
    SMOOTH,
    TRUTH,
    angles,
    benchmark,
    error_nm,
    every,
    sharp_pd,
)
from leadscrew.controllers._pd_dob import pd_dob
from leadscrew.export.controller import export_controller
from leadscrew.export.folder import write
from leadscrew.plants import _ballscrew_stage_fixed as module
from leadscrew.plants._ballscrew_stage import INERTIA, BallscrewStageParams, ballscrew_stage
from leadscrew.plants._ballscrew_stage_fixed import ballscrew_stage_fixed, solve_stage, stage_step
from tests.controllers.stage_loop import stage_loop
from tests.plants.test_ballscrew_stage import opened, radau
from tests.tools import missing, runnable

G_C, G_S = 6.24e-5, 9.36e-5


def fixed(amplitude, substeps, periods=60, engine="llvm", **more):
    loop = opened(plant=ballscrew_stage_fixed, amplitude=amplitude, options={"substeps": substeps} | more)
    return loop.run(periods * 1e-3, record="plant", engine=engine)


@pytest.mark.slow
def test_sliding_and_reversing_it_follows_radau_with_order_three():
    expected = radau(20.0, 1e-3, 60)
    coarse, fine = (np.abs(fixed(20.0, n)["plant.angle"] - expected[:, 0]).max() for n in (100, 400))
    assert fine < 1e-11
    assert coarse / fine > 4.0**2.5


@pytest.mark.slow
@pytest.mark.parametrize("sine", SMOOTH)
def test_steps_of_50_us_are_good_to_a_tenth_of_a_nanometre_on_the_smooth_sines(sine):
    truth = angles(sine, TRUTH)
    assert error_nm(sine, every("fixed", 50.0), truth) < 0.1
    assert error_nm(sine, every("fixed", 10.0), truth) < 0.03


def test_where_the_stage_breaks_loose_at_once_it_keeps_the_nanometre():
    truth = angles("sine_wide", TRUTH, law=sharp_pd)
    assert 0.5 < error_nm("sine_wide", every("fixed", 50.0), truth, law=sharp_pd) < 10.0
    assert error_nm("sine_wide", every("fixed", 10.0), truth, law=sharp_pd) < 0.3


@pytest.mark.filterwarnings("ignore:.*diverged")
def test_in_slow_sliding_it_stays_where_the_kernels_own_sdirk3_runs_away():
    truth = angles("sine_wide", TRUTH, law=sharp_pd)
    assert not error_nm("sine_wide", every("sdirk3", 25.0), truth, law=sharp_pd) < 1e6
    assert error_nm("sine_wide", every("fixed", 25.0), truth, law=sharp_pd) < 3.0


@pytest.mark.parametrize("dt", [1e-5, 1e-3, 0.1, 1.0])
@pytest.mark.parametrize("torque", [5.0, 7.0, 9.3, 20.0])
def test_at_any_step_it_comes_to_rest_or_to_steady_sliding(dt, torque):
    """Below F_C it stands on its bristles; above F_S it slides at the speed that balances the viscous friction."""
    p = stage_step(BallscrewStageParams(), dt)
    s = ballscrew_stage_fixed.state
    for _ in range(max(50, min(5000, round(1.0 / dt)))):
        s = ballscrew_stage_fixed.step(p, s, torque, 0.0, dt)
    if torque > 9.36:
        assert s.speed == pytest.approx((torque - 6.24) / 0.4, rel=1e-3)
        assert s.bristle == pytest.approx(G_C, rel=1e-6)
    elif torque < 6.24:
        assert abs(s.speed) < 1e-3
        assert s.bristle == pytest.approx(torque / 1e5, rel=1e-3)
    assert abs(s.bristle) <= 1.0001 * G_S


def test_a_stage_solves_its_equation_for_steps_from_a_tenth_of_a_microsecond_to_ten_milliseconds():
    """``V`` put back into the printed equations, for 3,000 random states; four Newton steps are enough."""
    rng = np.random.default_rng(0)
    left = []
    for _ in range(3000):
        dt, v = 10.0 ** rng.uniform(-7, -2), rng.choice([-1, 1]) * 10.0 ** rng.uniform(-7, 1.5)
        z, torque = rng.uniform(-1.2, 1.2) * G_S, rng.uniform(-20, 20)
        a = module.GAMMA * dt
        end = solve_stage(stage_step(BallscrewStageParams(), dt), torque, v, z, v)
        g = (6.24 + 3.12 * math.exp(-min((end.speed / 1e-3) ** 2, 700.0))) / 1e5
        assert end.bristle == pytest.approx((z + a * end.speed) / (1.0 + a * abs(end.speed) / g), rel=1e-9, abs=1e-18)
        friction = 1e5 * end.bristle + math.sqrt(1e5) * (end.bristle - z) / a + 0.4 * end.speed
        error = end.speed - v - a * (torque - friction) / INERTIA
        left.append(abs(error) / (abs(end.speed) + abs(v) + 1e-9))
    assert max(left) < 1e-8


def test_mirrored_torque_gives_mirrored_motion():
    p = stage_step(BallscrewStageParams(), 5e-5)
    right = left = ballscrew_stage_fixed.state
    for k in range(2000):
        u = 12.0 * math.sin(0.01 * k)
        right, left = (
            ballscrew_stage_fixed.step(p, s, side * u, 0.0, 5e-5) for s, side in ((right, 1.0), (left, -1.0))
        )
        assert tuple(right) == tuple(-x for x in left)


@pytest.mark.sweep
@pytest.mark.parametrize("engine", ["llvm", "c"])
def test_all_engines_give_the_same_bits(engine):
    fast, plain = (fixed(60.0, 20, periods=15, engine=e) for e in (runnable(engine), "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


def test_a_simulated_machine_with_it_is_exported_and_compiles_without_a_loop_in_its_step(tmp_path):
    gcc = shutil.which("gcc") or missing("gcc", "gcc is not installed")
    loop = stage_loop(pd_dob(max_torque=40.0), plant=ballscrew_stage_fixed, method="rk4", substeps=5, encoder_mm=1e-5)
    core, record = export_controller(loop, 0.05, name="ours", title="ours")
    write(core, record, "hal", tmp_path / "out", loop=loop)
    text = (tmp_path / "out" / "ours_plant.c").read_text(encoding="utf-8")
    assert text.count(" = solve_stage(") == 3
    assert text.count("for (") == 1  # over the substeps
    assert "while (" not in text
    command = [gcc, "-std=c99", "-O2", "-Wall", "-c", "ours_plant.c", "-o", "plant.o"]
    subprocess.run(command, cwd=tmp_path / "out", check=True)


@pytest.mark.slow
def test_a_batch_gives_each_run_its_own_bits():
    loop = benchmark("sine_fast", every("fixed", 50.0))
    inertia = np.linspace(2.12e-4, 3.7e-4, 19)
    batch = loop.batch(0.02, {"plant.inertia": inertia}, record=("plant.angle",))
    for k in (0, 7, 18):
        alone = loop.using({"plant.inertia": inertia[k]}).run(0.02, record="plant.angle")
        assert np.array_equal(batch["plant.angle"][k], alone["plant.angle"])


def test_it_takes_the_place_of_the_other_stage_as_it_is():
    assert ballscrew_stage_fixed.params == ballscrew_stage.params
    assert ballscrew_stage_fixed.state == ballscrew_stage.state
