"""Describing functions and limit cycles against closed forms, python-control, textbook loops and simulation."""

import math

import numpy as np
import pytest

from leadscrew.analysis.stability.harmonic_balance import Balance, Task, biggest, describing_function, limit_cycles
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.loop import continuous_loop
from leadscrew.controllers._npid import npid, scaled_error
from leadscrew.studies.npid_xytable.reference_loops import reference_loops
from leadscrew.util.errors import ValueRefused

STATIC = 1.32 * 69380.0 / 166.3
"""Gain of the XY table's loop for slow changes, its slow integral apart."""


def cosh_curve(e, e_max=3.0):
    """K(e) e with the error in um inside K; mm to mm."""
    return e * np.cosh(0.5 * np.minimum(1e3 * np.abs(e), e_max))


def saturation(e):
    return np.clip(e, -1.0, 1.0)


def dead_zone(e):
    return e - np.clip(e, -1.0, 1.0)


def saturation_gain(size):
    r = 1.0 / size
    return 2.0 / math.pi * (math.asin(r) + r * math.sqrt(1.0 - r * r))


CLOSED = {
    "saturation": (saturation, saturation_gain),
    "relay": (np.sign, lambda size: 4.0 / (math.pi * size)),
    "dead zone": (dead_zone, lambda size: 1.0 - saturation_gain(size)),
    "cubic": (lambda e: e + 2.0 * e**3, lambda size: 1.0 + 1.5 * size**2),
}


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("size", [1.2, 3.0, 40.0])
def test_textbook_describing_functions(name, size):
    curve, gain = CLOSED[name]
    found = describing_function(curve, size)
    assert float(found.gain) == pytest.approx(gain(size), rel=1e-6, abs=1e-9)
    assert float(found.mean) == pytest.approx(0.0, abs=1e-12 * size**3)


def test_a_biased_cubic_by_hand():
    # (b + A cos)^3: mean b^3 + 3/2 b A^2, fundamental 3 b^2 A + 3/4 A^3
    found = describing_function(lambda e: e**3, 2.0, bias=0.5)
    assert float(found.mean) == pytest.approx(0.125 + 1.5 * 0.5 * 4.0, rel=1e-12)
    assert float(found.gain) == pytest.approx(3.0 * 0.25 + 0.75 * 4.0, rel=1e-12)


def test_a_biased_relay_by_hand():
    # sign(b + A cos): positive for an angle of 2 acos(-b/A)
    found = describing_function(np.sign, 2.0, bias=1.0, points=100_000)
    assert float(found.mean) == pytest.approx(1.0 / 3.0, abs=1e-4)
    assert float(found.gain) == pytest.approx(4.0 / math.pi / 2.0 * math.sqrt(0.75), rel=1e-4)


def test_a_curve_of_single_numbers_will_do():
    one = describing_function(lambda e: e if abs(e) < 1.0 else math.copysign(1.0, e), 3.0)
    assert float(one.gain) == pytest.approx(saturation_gain(3.0), rel=1e-6)


def test_python_control_finds_the_same_describing_function():
    import control

    sizes = np.array([0.5e-3, 5e-3, 20e-3])
    theirs = control.describing_function(lambda e: float(cosh_curve(e)), sizes, num_points=1000)
    assert describing_function(cosh_curve, sizes).gain == pytest.approx(np.real(theirs), rel=2e-3)


def test_python_control_finds_the_same_limit_cycle_of_a_saturated_loop():
    import control

    loop = continuous_loop([12.0], [1.0], [1.0], [1.0, 3.0, 3.0, 1.0])
    mine = limit_cycles(loop, saturation, amplitudes=(0.1, 100.0))
    theirs = control.describing_function_response(
        control.tf([12.0], [1.0, 3.0, 3.0, 1.0]), control.saturation_nonlinearity(1.0), np.geomspace(1.2, 4.0, 150)
    ).intersections
    (cycle,) = mine.cycles
    assert len(theirs) == 1
    # two parallels on a grid of theirs cross less exactly
    assert cycle.amplitude == pytest.approx(theirs[0][0], rel=1e-2)
    assert 2.0 * math.pi * cycle.frequency_hz == pytest.approx(theirs[0][1], rel=1e-2)
    assert 2.0 * math.pi * cycle.frequency_hz == pytest.approx(math.sqrt(3.0), rel=1e-9)
    assert saturation_gain(cycle.amplitude) == pytest.approx(8.0 / 12.0, rel=1e-5)
    assert cycle.stable


def test_a_relay_chatters_as_the_textbook_says():
    # K/(s+1)^3 crosses at sqrt(3) rad/s with K/8: N = 8/K = 4/(pi A)
    prediction = limit_cycles(
        continuous_loop([5.0], [1.0], [1.0], [1.0, 3.0, 3.0, 1.0]), np.sign, amplitudes=(1e-2, 10)
    )
    (cycle,) = prediction.cycles
    assert cycle.stable and cycle.amplitude == pytest.approx(4.0 / math.pi * 5.0 / 8.0, rel=1e-5)


def test_a_loop_cut_at_the_voltage_is_reported_in_volt():
    loop = continuous_loop([12.0], [1.0], [1.0], [1.0, 3.0, 3.0, 1.0])
    found = limit_cycles(loop, saturation, amplitudes=(0.1, 100.0), unit="V")
    assert " V peak to peak" in found.report() and " um" not in found.report()


def test_a_gain_that_grows_without_end_gives_an_unstable_cycle():
    prediction = limit_cycles(
        continuous_loop([2.0], [1.0], [1.0], [1.0, 3.0, 3.0, 1.0]), lambda e: e + 2.0 * e**3, amplitudes=(1e-3, 10.0)
    )
    (cycle,) = prediction.cycles
    assert not cycle.stable and cycle.amplitude == pytest.approx(math.sqrt(3.0 / 1.5), rel=1e-6)
    assert prediction.rest_stable and not prediction.stable_cycles
    assert any("grows further" in w for w in prediction.warnings)


def test_a_dead_time_moves_the_frequency_to_its_crossover():
    loop = continuous_loop([3.0], [1.0], [1.0], [1.0, 0.0], dead_time=0.8)
    (cycle,) = [c for c in limit_cycles(loop, saturation, amplitudes=(0.1, 100.0)).cycles if c.stable]
    # 3 e^(-0.8 s)/s: phase -180 deg at pi/2/0.8
    assert 2.0 * math.pi * cycle.frequency_hz == pytest.approx(math.pi / 1.6, rel=1e-9)
    assert saturation_gain(cycle.amplitude) == pytest.approx(math.pi / 1.6 / 3.0, rel=1e-5)


def alternating():
    """``y+ = -0.5 y + 2 e``: real and negative at half the sampling frequency, so it flips from sample to sample."""
    one = np.ones((1, 1))
    return LinearLoop(-0.5 * one, 2.0 * one, one, 0.0 * one, 0.01, name="flips")


def test_an_oscillation_of_two_samples_is_exact():
    # G(-1) = 2/(-1 + 0.5) = -4; e alternates +-A with A = 4 sat(A): 4
    (cycle,) = limit_cycles(alternating(), saturation, amplitudes=(0.1, 100.0)).cycles
    assert cycle.frequency_hz == pytest.approx(50.0, rel=1e-12) and cycle.amplitude == pytest.approx(4.0, rel=1e-9)
    y, seen = 0.1, []
    for _ in range(200):
        seen.append(-y)
        y = -0.5 * y + 2.0 * float(saturation(-y))
    assert np.abs(seen[-2:]) == pytest.approx([4.0, 4.0], rel=1e-9) and seen[-1] * seen[-2] < 0.0


def simulate(loop, curve, load, periods, start):
    """The sampled loop itself, its slow gain as in the prediction; the error of the last 2000 samples."""
    x, seen = start * np.ones(len(loop.a)), []
    offset = load * STATIC
    for k in range(periods):
        e = offset - float(loop.c[0] @ x)
        x = loop.a @ x + loop.b[:, 0] * float(curve(e))
        seen.append(e)
        assert k < 100 or abs(e) < 10.0 * abs(offset)
    return np.array(seen[-2000:])


@pytest.fixture(scope="module")
def l_star():
    """L* without its integral, which would take over the load in half an hour."""
    from leadscrew.analysis.stability.loop import sampled_loop
    from leadscrew.kernel.loop import Loop
    from leadscrew.plants._xy_table_cutting import xy_table_cutting
    from leadscrew.references._step import step
    from leadscrew.studies.npid_xytable.tunings import table_pid

    return sampled_loop(
        Loop(reference=step, controller=table_pid(ki=0.0), plant=xy_table_cutting, period=5e-4, metrics={}), "L*"
    )


@pytest.mark.parametrize("load_um", [3.0, 5.0, 7.0])
def test_harmonic_balance_is_the_simulated_chatter_to_half_a_percent(l_star, load_um):
    load = 1e-3 * load_um
    cycle = biggest(limit_cycles(l_star, cosh_curve, load, static_gain=STATIC, harmonics=30))
    tail = simulate(l_star, cosh_curve, load, 6000, 1e-9)
    assert cycle.peak_to_peak == pytest.approx(np.ptp(tail), rel=3e-3)
    lines = np.abs(np.fft.rfft((tail - tail.mean()) * np.hanning(len(tail)), 1 << 17))
    assert cycle.frequency_hz == pytest.approx(np.argmax(lines) / (1 << 17) / 5e-4, rel=1e-4)
    assert cycle.bias == pytest.approx(tail.mean(), rel=2e-3)


def test_the_describing_function_is_within_a_tenth_where_harmonics_are_small(l_star):
    for load in (4e-3, 7e-3, 12e-3):
        one = biggest(limit_cycles(l_star, cosh_curve, load, static_gain=STATIC))
        many = biggest(limit_cycles(l_star, cosh_curve, load, static_gain=STATIC, harmonics=30))
        assert one.peak_to_peak == pytest.approx(many.peak_to_peak, rel=0.1)
        assert one.frequency_hz == pytest.approx(many.frequency_hz, rel=0.02)


def test_newton_on_one_harmonic_finds_the_cycles_of_the_describing_function(l_star):
    one = limit_cycles(l_star, cosh_curve, 10e-3, static_gain=STATIC)
    task = Task(l_star, cosh_curve, 10e-3, STATIC, (1e-5, 1.0))
    assert len(one.cycles) == 2
    for a in one.cycles:
        w = 2.0 * math.pi * a.frequency_hz
        balance = Balance(task, 1)
        b = balance.cycle(balance.solve(np.array([a.bias, 1.01 * a.amplitude, w])), w, a.gain)
        assert (b.amplitude, b.frequency_hz, b.bias) == pytest.approx((a.amplitude, a.frequency_hz, a.bias), rel=1e-4)
        assert a.stable == b.stable and b.growth == pytest.approx(a.growth, rel=0.03)


def test_a_cycle_that_only_a_kick_starts_is_told_with_its_edge(l_star):
    found = limit_cycles(l_star, cosh_curve, 12e-3, static_gain=STATIC, harmonics=30)
    edge, chatter = found.cycles
    assert found.rest_stable and not edge.stable and chatter.stable
    assert "once disturbed" in found.statement and "2.352" in found.report()
    # a sine in the error smaller than the unstable cycle dies away, a larger one grows
    for share, grows in ((0.9, False), (1.1, True)):
        tail = simulate_from(l_star, 12e-3, edge, share)
        assert (np.ptp(tail[-400:]) > 0.8 * chatter.peak_to_peak) == grows


def simulate_from(loop, load, cycle, share, periods=8000):
    """The loop started on ``share`` of a cycle, with the states that belong to it."""
    n, turn = len(loop.a), 2.0 * np.pi * np.arange(4096) / 4096
    seen = cosh_curve(cycle.bias + share * (cycle.wave(turn) - cycle.bias))
    still = np.linalg.solve(np.eye(n) - loop.a, loop.b[:, 0])
    x = still * (load * STATIC - cycle.bias) / float(loop.c[0] @ still)
    for order in range(1, len(cycle.harmonics)):
        z = np.exp(2j * math.pi * order * cycle.frequency_hz * loop.dt)
        f = 2.0 * np.mean(seen * np.exp(-1j * order * turn))
        x = x + np.linalg.solve(z * np.eye(n) - loop.a, loop.b[:, 0] * f).real
    errors = []
    for _ in range(periods):
        e = load * STATIC - float(loop.c[0] @ x)
        x = loop.a @ x + loop.b[:, 0] * float(cosh_curve(e))
        errors.append(e)
    return np.array(errors)


def test_started_on_the_cycle_the_loop_stays_on_it(l_star):
    cycle = biggest(limit_cycles(l_star, cosh_curve, 5e-3, static_gain=STATIC, harmonics=30))
    errors = simulate_from(l_star, 5e-3, cycle, 1.0, 40)
    angle = 2.0 * math.pi * cycle.frequency_hz * l_star.dt * np.arange(40)
    assert errors == pytest.approx(cycle.wave(angle), abs=0.01 * cycle.amplitude)


def exponents(loop, cycle, periods=3000):
    """The two largest Lyapunov exponents of the loop linearised along the cycle, 1/s: one is 0, along the cycle."""
    h, total, turned = 1e-9, np.zeros(len(loop.a)), np.eye(len(loop.a))
    e = cycle.wave(2.0 * math.pi * cycle.frequency_hz * loop.dt * np.arange(periods))
    for k, slope in enumerate((cosh_curve(e + h) - cosh_curve(e - h)) / (2.0 * h)):
        turned, part = np.linalg.qr((loop.a - slope * loop.b @ loop.c) @ turned)
        total += np.log(np.abs(np.diag(part))) if k >= 200 else 0.0
    return total[:2] / (periods - 200) / loop.dt


@pytest.mark.parametrize("load_um", [3.0, 8.0])
def test_stability_of_a_cycle_is_that_of_the_loop_linearised_along_it(l_star, load_um):
    for cycle in limit_cycles(l_star, cosh_curve, 1e-3 * load_um, static_gain=STATIC, harmonics=30).cycles:
        found = exponents(l_star, cycle)
        along, across = sorted(found, key=abs)
        assert abs(along) < 3.0
        assert cycle.growth == pytest.approx(across, rel=0.2) and cycle.stable == (across < 0.0)


def test_what_lure_takes_from_the_controller_gives_the_same_cycle(l_star):
    from leadscrew.analysis.stability.lure import lure

    mine = biggest(limit_cycles(l_star, cosh_curve, 5e-3, static_gain=STATIC, amplitudes=(1e-4, 0.05)))
    taken = biggest(limit_cycles(l_star, lure(npid), 5e-3, static_gain=STATIC, amplitudes=(1e-4, 0.05)))
    assert taken.amplitude == pytest.approx(mine.amplitude, rel=1e-5)
    assert scaled_error(npid.params, 2e-3) == pytest.approx(float(cosh_curve(2e-3)), rel=1e-14)


def test_the_continuous_loop_of_the_paper_chatters_at_189_hz():
    found = limit_cycles(reference_loops()["Lc"], cosh_curve, 5e-3, static_gain=STATIC, harmonics=30)
    assert not found.rest_stable and 185.0 < biggest(found).frequency_hz < 190.0


def test_a_straight_line_has_no_cycle_and_says_whether_it_rests(l_star):
    assert "comes to rest" in limit_cycles(l_star, lambda e: 2.0 * e).statement
    grows = limit_cycles(l_star, lambda e: 3.0 * e)
    assert not grows.rest_stable and not grows.cycles and any("grows further" in w for w in grows.warnings)


def test_harmonics_that_matter_are_warned_about():
    # a lightly damped mode at three times the crossover lets the third harmonic through
    loop = continuous_loop([5.0], [1.0], [27.0], np.polymul([1.0, 3.0, 3.0, 1.0], [1.0, 0.05, 27.0]))
    found = limit_cycles(loop, np.sign, amplitudes=(1e-3, 50.0))
    assert any("balance more harmonics" in w for w in found.warnings)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"curve": np.tanh, "load": 2.0}, "cannot carry"),
        ({"amplitudes": (1.0, 0.1)}, "amplitudes"),
        ({"static_gain": 0.0}, "static_gain"),
        ({"curve": 3.0}, "curve"),
    ],
)
def test_what_makes_no_sense_is_refused(l_star, change, words):
    with pytest.raises(ValueRefused, match=words):
        limit_cycles(l_star, change.pop("curve", cosh_curve), **change)


def test_other_refusals(l_star):
    from leadscrew.analysis.stability.lure import lure
    from leadscrew.controllers._npid_after import npid_after

    with pytest.raises(ValueRefused, match="amplitude"):
        describing_function(np.sign, 0.0)
    with pytest.raises(ValueRefused, match="not finite"):
        describing_function(lambda e: np.full_like(e, np.nan), 1.0)
    with pytest.raises(ValueRefused, match="harmonics"):
        limit_cycles(l_star, cosh_curve, harmonics=0)
    with pytest.raises(ValueRefused, match="behind the linear part"):
        limit_cycles(l_star, lure(npid_after))


def test_a_prediction_can_be_kept_and_drawn(l_star):
    found = limit_cycles(l_star, cosh_curve, 10e-3, static_gain=STATIC, harmonics=30)
    kept = found.as_dict()
    assert kept["grade"] == "prediction" and len(kept["cycles"]) == 2 and len(kept["cycles"][0]["harmonics"]) == 31
    plane, curve = found.figure().axes
    assert plane.get_xlabel() == "Re G" and curve.get_ylabel() == "gain N (1)"
