"""The cascade: the PID that it is, what feed-forward does, and which PIDs are none."""

import numpy as np
import pytest

from leadscrew.analysis.stability.loop import sampled_loop
from leadscrew.controllers._cascade_ppi import as_pid, cascade_ppi, of_pid
from leadscrew.references._motion import Motion
from leadscrew.references._ramp import ramp_motion
from leadscrew.studies.npid_xytable.tunings import TUNINGS, table_cascade, table_pid
from leadscrew.util.errors import ValueRefused
from tests.controllers.table_axis import PERIOD, table_axis, tried

RNG = np.random.default_rng(3)
COMMANDS, FEEDBACKS = RNG.normal(size=300).tolist(), RNG.normal(size=300).tolist()
TAME = cascade_ppi(kpos=150.0, kvp=0.004, kvi=0.6)


@pytest.mark.parametrize("block", [cascade_ppi, table_cascade, TAME])
def test_with_unit_velocity_feed_forward_it_is_a_pid(block):
    p = block.params
    same = table_pid(kp=p.kvp * p.kpos + p.kvi, ki=p.kvi * p.kpos, kd=p.kvp)
    found = tried(block, [Motion(r) for r in COMMANDS], FEEDBACKS)
    assert found == pytest.approx(tried(same, COMMANDS, FEEDBACKS), rel=1e-11, abs=1e-11)
    assert as_pid(block).params == pytest.approx(same.params)


def test_table_i_is_the_cascade_of_the_digest():
    p = of_pid(table_pid).params
    assert (p.kvp, p.kpos, p.kvi) == pytest.approx((0.006805, 193.975, 4.25e-6), rel=1e-3)
    assert p == pytest.approx(table_cascade.params, rel=1e-6)


def test_a_pid_with_complex_zeros_is_no_cascade():
    for name in ("ours.pid_ms_159", "ours.pid_ms_185"):
        with pytest.raises(ValueRefused, match=r"kp\^2 >= 4 kd ki"):
            of_pid(TUNINGS[name])
    with pytest.raises(ValueRefused, match=r"c = 0.0"):
        of_pid(table_pid(c=0.0))
    with pytest.raises(ValueRefused, match=r"velocity_share = 0.5"):
        as_pid(cascade_ppi(velocity_share=0.5))


def test_without_velocity_feed_forward_a_ramp_lags_by_speed_over_kpos():
    """With it the lag goes; the integral of the speed loop alone does not take it away."""
    for share, lag in ((0.0, 40.0 / 150.0), (0.5, 20.0 / 150.0), (1.0, 0.0)):
        loop = table_axis(TAME(velocity_share=share))
        loop.blocks["reference"] = ramp_motion(rate=40.0, duration=10.0)
        assert loop.run(3.0)["true_error"][-1] == pytest.approx(lag, abs=2e-3)


def test_feed_forward_leaves_the_stability_alone():
    plain, fed = (
        sampled_loop(table_axis(TAME(**given))) for given in ({"velocity_share": 0.0}, {"acceleration_v": 1e-5})
    )
    assert fed.closed_poles() == pytest.approx(plain.closed_poles())


def test_acceleration_feed_forward_adds_its_voltage():
    here = [Motion(0.1, 0.0, 300.0)]
    (plain,), (fed,) = (tried(TAME(acceleration_v=a), here, [0.1]) for a in (0.0, 2e-5))
    assert fed - plain == pytest.approx(6e-3, rel=1e-9)


def test_our_tuning_is_at_the_edge_of_what_a_cascade_can_be():
    p = TUNINGS["ours.cascade"].params.inner
    assert p.kvi == pytest.approx(p.kvp * p.kpos, rel=1e-3)  # both zeros at -kpos
    same = as_pid(cascade_ppi(kpos=p.kpos, kvp=p.kvp, kvi=p.kvi))
    loop = sampled_loop(table_axis(same))
    w = np.geomspace(10.0, 6000.0, 4000)
    assert (1.0 / np.abs(1.0 + loop.response(w))).max() == pytest.approx(1.59, abs=0.005)


def test_at_the_limit_the_integral_waits():
    block = TAME(lower=-0.5, upper=0.5)
    s = block.state
    for _ in range(400):
        s, u = block.step(block.params, s, Motion(0.1), 0.0, PERIOD)
    held = s.integral
    s, u = block.step(block.params, s, Motion(0.1), 0.0, PERIOD)
    assert u == 0.5 and s.integral == held
    assert 0.3 < 0.6 * held < 0.5
    for _ in range(3):
        s, _ = block.step(block.params, s, Motion(-0.1), 0.0, PERIOD)
    assert s.integral < held


def test_the_first_output_after_an_align_is_the_last_one_before():
    here = Motion(0.3, 20.0, 40.0)
    block = TAME(acceleration_v=1e-5)
    _, u = block.step(block.params, block.align(block.params, here, 0.29, 1.5), here, 0.29, PERIOD)
    assert u == pytest.approx(1.5, abs=1e-12)


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    loop = table_axis(TUNINGS["ours.cascade"])
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.2, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)
