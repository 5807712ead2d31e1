"""Resonators that find the spindle's speed: what they find, how still they hold it, what they leave of the lines."""

from itertools import product

import numpy as np
import pytest

from leadscrew.controllers._adaptive_resonant import adaptive_resonant
from leadscrew.controllers._inverse_feed_forward import inverse_feed_forward
from leadscrew.controllers._resonant import resonant
from leadscrew.disturbances._wandering_spindle import speed_hz, wandering_spindle
from leadscrew.sensors._counts import noisy_ruler
from leadscrew.studies.npid_xytable.tunings import INVERSE, TUNINGS, XY_TABLE, table_pid
from leadscrew.util.errors import ValueRefused
from tests.controllers.table_axis import PERIOD, rms_um, table_axis, tried

RPM, SHARES = (1000, 2000, 3000), (0.98, 1.0, 1.02)
PLAIN = adaptive_resonant(TUNINGS["ours.pid_ms_159"], model=XY_TABLE)
FOUND = "controller.spindle.spindle_hz"
READ = noisy_ruler(resolution_mm=5e-4, noise_mm=1e-4)


def cut(block, spindle_hz, seconds=20.0, sensor=READ, **more):
    loop = table_axis(block, sensor=sensor, spindle_hz=spindle_hz, spindle_v=1e-3, tooth_v=2e-3, **more)
    names = [n for n in loop.run(PERIOD, record=("controller",)).signals if n.endswith("spindle.spindle_hz")]
    run = loop.run(seconds, record=("true_error", "output", *names))
    return run, run[names[0]] if names else None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rpm", "share"),
    [pytest.param(r, s, marks=() if (r, s) == (1000, 0.98) else pytest.mark.slow) for r, s in product(RPM, SHARES)],
)
def test_the_speed_is_found_and_the_error_is_as_small_as_with_a_known_one(rpm, share):
    block = TUNINGS["ours.resonant_adaptive"](**{"inner.spindle_hz": rpm / 60.0})
    run, found = cut(block, share * rpm / 60.0)
    assert found[0] == pytest.approx(rpm / 60.0) and found[-20000:] == pytest.approx(share * rpm / 60.0, rel=5e-4)
    assert rms_um(run) < 0.1


@pytest.mark.slow
def test_known_resonators_that_are_told_a_wrong_speed_leave_most_of_the_lines():
    block = TUNINGS["ours.resonant_full"](**{"inner.spindle_hz": 50.0})
    right, wrong = (rms_um(cut(block, hz)[0]) for hz in (50.0, 51.0))
    assert right < 0.1 and wrong > 0.5


def test_without_adaptation_and_at_the_right_speed_it_is_the_resonators_of_two_lines():
    t = PERIOD * np.arange(600)
    errors = np.sin(300.0 * t) + 0.3 * np.sin(650.0 * t)
    blocks = (
        resonant(table_pid, [50.0, 100.0], strength=6.0, model=XY_TABLE),
        adaptive_resonant(table_pid, strength=6.0, rate=0.0, model=XY_TABLE),
    )
    same, found = (np.array(tried(block, errors, np.zeros(600))) for block in blocks)
    assert found == pytest.approx(same, abs=1e-9 * np.abs(same).max())


@pytest.mark.slow
def test_the_signal_of_the_adaptation_is_the_offset_of_the_speed():
    """Resonators that do not adapt, 1 % off: once they have settled, ``x`` averages to the offset whatever the line."""
    block = PLAIN(rate=1e-9)
    offset = table_axis(block, sensor=None, amplitude=0.0, spindle_hz=50.5, spindle_v=1e-3, tooth_v=2e-3).run(
        12.0, record=("controller.spindle.offset",)
    )["controller.spindle.offset"]
    seen = (offset[-1] - offset[12000]) / (6.0 * 1e-9)  # rate x, summed up over 6 s
    assert seen == pytest.approx(2.0 * np.pi * 0.5, rel=0.05)


@pytest.mark.slow
def test_a_speed_that_drifts_is_followed():
    """0.1 % a second, from 2 % below to the believed speed."""
    load = wandering_spindle(spindle_hz=49.0, drift=1e-3)
    loop = table_axis(TUNINGS["ours.resonant_adaptive"](**{"inner.spindle_hz": 50.0}), disturbance=load, sensor=READ)
    run = loop.run(20.0, record=("true_error", "controller.spindle.spindle_hz"))
    wanted = speed_hz(load.params, 19.9995)
    assert run["controller.spindle.spindle_hz"][-1] == pytest.approx(wanted, rel=2e-4) and rms_um(run) < 0.1


@pytest.mark.slow
def test_the_lines_of_the_wandering_spindle_turn_at_its_speed():
    p = wandering_spindle(spindle_hz=20.0, drift=0.01, wander=0.05, wander_s=2.0, tooth_v=0.0).params
    t = np.linspace(0.0, 3.0, 300001)
    values = np.array([wandering_spindle.step(p, float(x)) for x in t[::100]])
    turns = np.concatenate([[0.0], np.cumsum([speed_hz(p, float(x)) for x in 0.5 * (t[1:] + t[:-1])]) * 1e-5])
    assert values == pytest.approx(1e-3 * np.sin(2.0 * np.pi * turns[::100]), abs=1e-9)


@pytest.mark.slow
def test_where_no_spindle_turns_nothing_gets_worse():
    without, with_it = (
        rms_um(table_axis(block, sensor=READ).run(20.0))
        for block in (TUNINGS["ours.resonant_full"], TUNINGS["ours.resonant_adaptive"])
    )
    assert with_it < 1.05 * without


@pytest.mark.slow
def test_a_speed_outside_its_range_is_not_followed_beyond_it():
    _, found = cut(PLAIN(within=0.01), 52.0, 10.0, sensor=None)
    assert found.max() <= 50.5 * (1.0 + 1e-12) and found[-1] > 50.4


@pytest.mark.slow
def test_the_first_output_after_an_align_is_the_last_one_before():
    live = table_axis(table_pid).start()
    live.advance(3000)
    expected = live.advance_preview()["output"]
    after = live.switch(PLAIN)
    assert after.bumpless and after.advance(1)["output"][0] == pytest.approx(expected, abs=1e-13)


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    loop = table_axis(
        inverse_feed_forward(PLAIN(lower=-0.02, upper=0.02), **INVERSE), spindle_hz=51.0, spindle_v=1e-3, tooth_v=2e-3
    )
    fast, plain = (loop.run(0.3, record=("output", "controller"), engine=e) for e in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


def test_at_the_limit_of_the_output_the_lines_turn_and_do_not_grow():
    """The same block without a limit, by hand: where the sum is beyond it, the lengths of both lines stay."""
    block = adaptive_resonant(table_pid(kp=0.0, ki=0.0, kd=0.0), lower=-2e-3, upper=2e-3, model=XY_TABLE)
    p, s = block.prepare(block.params, PERIOD), block.state
    lengths, outputs = [], []
    for k in range(4000):
        s, u = block.step(p, s, 0.05 * np.sin(2.0 * np.pi * 50.0 * PERIOD * k), 0.0, PERIOD)
        lines = s.spindle
        lengths.append([np.hypot(z.re, z.im) for z in (lines.first, lines.tooth)])
        outputs.append(u)
    grown, limited = np.diff(lengths, axis=0), np.abs(outputs[1:]) == 2e-3
    assert np.abs(outputs).max() == 2e-3 and 500 < limited.sum() < 3500
    assert np.abs(grown[limited]).max() < 1e-15 and np.abs(grown[~limited]).max() > 1e-6


@pytest.mark.slow
def test_a_limit_outside_holds_the_lines_and_one_inside_does_not():
    """A motion that needs 60 times the voltage: the lines stay within 50 times the limit, or run away."""
    small = TUNINGS["ours.pid_ms_159"](lower=-5e-3, upper=5e-3, anti_windup=1)
    keys = [f"controller.spindle.{line}.{part}" for line in ("first", "tooth") for part in ("re", "im")]
    sizes = []
    for block in (
        adaptive_resonant(small, lower=-5e-3, upper=5e-3, model=XY_TABLE),
        adaptive_resonant(small, model=XY_TABLE),
    ):
        run = table_axis(block, spindle_hz=50.0, spindle_v=1e-3, tooth_v=2e-3).run(8.0, record=("output", *keys))
        sizes.append((np.abs(run["output"]).max(), max(np.abs(run[key]).max() for key in keys)))
    assert sizes[0][0] == 5e-3 and sizes[0][1] < 0.25 and sizes[1][1] > 1e6


def test_a_cutter_of_one_tooth_has_one_line():
    t = PERIOD * np.arange(600)
    errors = np.sin(300.0 * t)
    one = np.array(
        tried(adaptive_resonant(table_pid, teeth=1, strength=6.0, rate=0.0, model=XY_TABLE), errors, np.zeros(600))
    )
    same = np.array(tried(resonant(table_pid, [50.0], strength=6.0, model=XY_TABLE), errors, np.zeros(600)))
    assert one == pytest.approx(same, abs=1e-9 * np.abs(same).max())


def test_a_tooth_line_that_could_pass_half_the_sampling_frequency_is_refused():
    with pytest.raises(ValueRefused, match=r"spindle_hz = 400.0 with teeth = 3 .*1236 Hz.* here 1000 Hz"):
        table_axis(PLAIN(spindle_hz=400.0, teeth=3)).run(0.1)
