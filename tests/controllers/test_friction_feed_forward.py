"""Friction feed-forward: steady values by hand, bristles by an ODE solver, the error that it takes from the axis."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.controllers._friction_feed_forward import friction_feed_forward
from leadscrew.controllers._inverse_feed_forward import inverse_feed_forward
from leadscrew.kernel.loop import Loop
from leadscrew.plants._xy_table_lugre import LEVELS
from leadscrew.references._eased_sine import eased_sine_motion
from leadscrew.references._motion import Motion
from leadscrew.studies.npid_xytable.tunings import INVERSE, TUNINGS, table_pid
from tests.controllers.table_axis import PERIOD, rms_um, table_axis, tried

SILENT = table_pid(kp=0.0, ki=0.0, kd=0.0)


def steadily(block, v, periods=400):
    return tried(block, [Motion(v * PERIOD * k, v) for k in range(periods)], np.zeros(periods))[-1]


@pytest.mark.parametrize("presliding", [0.0, 5.0])
@pytest.mark.parametrize("v", [0.7, -3.0, 40.0])
def test_in_steady_motion_it_is_the_stribeck_curve(presliding, v):
    block = friction_feed_forward(SILENT, 20.0, presliding, static_ratio=1.4, stribeck_mm_s=2.0, share=0.5)
    expected = 0.5 * 0.020 * math.copysign(1.0 + 0.4 * math.exp(-((v / 2.0) ** 2)), v)
    assert steadily(block, v) == pytest.approx(expected, rel=1e-6)


def test_without_bristles_the_leap_at_a_reversal_is_spread_over_the_smooth_speed():
    block = friction_feed_forward(SILENT, 20.0, 0.0, static_ratio=1.0, smooth_mm_s=0.1, ahead_s=0.0)
    assert tried(block, [Motion(0.0, v) for v in (0.0, 0.05, -0.1)], np.zeros(3)) == pytest.approx(
        [0.0, 0.02 * math.tanh(0.5), -0.02 * math.tanh(1.0)]
    )


def test_the_bristles_bend_as_scipys_do():
    """A reversal of 3 um within the presliding of 5 um: hysteresis, far from the steady curve."""
    block, w, size = friction_feed_forward(SILENT, ahead_s=0.5 * PERIOD, presliding_um=5.0), 2.0 * math.pi, 3e-3

    def rate(t, z):
        v = size * w * math.cos(w * t)
        r = 1.0 + 0.2 * math.exp(-(v**2))
        return [1e3 * v / 5.0 - abs(1e3 * v) / 5.0 * z[0] / r]

    t = PERIOD * np.arange(4000)
    # read in the middle of the period before: the bristles at the end of step k are those of t_k + T/2
    expected = 0.02 * solve_ivp(rate, (-0.5 * PERIOD, 2.0), [0.0], t_eval=t + 0.5 * PERIOD, rtol=1e-9, atol=1e-12).y[0]
    moves = [Motion(size * math.sin(w * x), size * w * math.cos(w * x), -size * w * w * math.sin(w * x)) for x in t]
    assert tried(block, moves, np.zeros(4000)) == pytest.approx(expected, abs=2e-5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("level", "mv", "um"), [("medium", 20.0, 5.0), pytest.param("high", 150.0, 10.0, marks=pytest.mark.slow)]
)
def test_it_takes_most_of_the_error_that_friction_makes(level, mv, um):
    fed = inverse_feed_forward(TUNINGS["ours.pid_ms_159"], **INVERSE)
    found = []
    for block in (fed, friction_feed_forward(fed, friction_mv=mv, presliding_um=um)):
        loop = Loop(
            reference=eased_sine_motion(amplitude=1.0, frequency=0.7), controller=block, plant=LEVELS[level],
            period=PERIOD, substeps=20, computation_delay=0.775e-3, metrics={},
        )  # fmt: skip
        found.append(rms_um(loop.run(6.0), 4.0))
    assert found[1] < 0.2 * found[0]


@pytest.mark.slow
def test_wrong_by_a_fifth_it_still_takes_most_of_it():
    fed = inverse_feed_forward(TUNINGS["ours.pid_ms_159"], **INVERSE)
    blocks = (fed, friction_feed_forward(fed), friction_feed_forward(fed, friction_mv=24.0, presliding_um=4.0))
    found = []
    for block in blocks:
        loop = Loop(
            reference=eased_sine_motion(amplitude=1.0, frequency=0.7), controller=block, plant=LEVELS["medium"],
            period=PERIOD, substeps=20, computation_delay=0.775e-3, metrics={},
        )  # fmt: skip
        found.append(rms_um(loop.run(6.0), 4.0))
    assert found[1] < found[2] < 0.6 * found[0]


@pytest.mark.parametrize("presliding", [0.0, 5.0])
def test_the_first_output_after_an_align_is_the_last_one_before(presliding):
    block, here = friction_feed_forward(TUNINGS["ours.pid_ms_159"], presliding_um=presliding), Motion(0.3, 2.0, 0.0)
    p = block.prepare(block.params, PERIOD)
    _, u = block.step(p, block.align(p, here, 0.29, 0.5), here, 0.29, PERIOD)
    assert u == pytest.approx(0.5, abs=1e-12)


@pytest.mark.sweep
@pytest.mark.parametrize("presliding", [0.0, 5.0])
def test_all_engines_give_the_same_bits(presliding):
    loop = table_axis(friction_feed_forward(inverse_feed_forward(table_pid, **INVERSE), presliding_um=presliding))
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.2, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)
