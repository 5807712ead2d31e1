"""Two controllers in series, against the wrapper that does the same and against SciPy."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy import signal

import leadscrew as ls
from leadscrew.controllers._biquad import LowPass, Notch, biquad, coefficients
from leadscrew.controllers._cascade_ppi import cascade_ppi
from leadscrew.controllers._filters import low_pass, notch
from leadscrew.controllers._npid import npid
from leadscrew.references._sine import sine
from leadscrew.studies.npid_xytable.tunings import TUNINGS, table_pid
from leadscrew.util.errors import BlockError
from tests.controllers.xy_loop import PERIOD, xy_loop

TUNED = TUNINGS["ours.pid_ms_159"]


class GainParams(NamedTuple):
    kp: float = 0.5


@ls.controller(GainParams())
def gain(p, command, feedback):
    return p.kp * (command - feedback)


@ls.controller()
def follow(command, feedback):
    return command - feedback


def outputs(block, errors):
    p = block.prepare(block.params, PERIOD) if block.prepare else block.params
    s, seen = block.state, []
    for e in errors:
        s, y = block.step(p, s, float(e), 0.0, PERIOD)
        seen.append(y)
    return np.array(seen)


def test_a_notch_behind_a_pid_gives_the_bits_of_a_pid_with_a_notch():
    wave = sine(amplitude=4.0, frequency=3.0)
    mine = xy_loop(ls.series(TUNED, notch(centre_hz=150.0)), wave).run(0.1)
    theirs = xy_loop(biquad(TUNED, Notch(centre_hz=150.0)), wave).run(0.1)
    assert np.array_equal(mine["output"], theirs["output"]) and np.ptp(mine["output"]) > 0.0


def test_a_filter_before_a_controller_filters_its_error():
    errors = np.random.default_rng(1).normal(size=300)
    c = coefficients(LowPass(), PERIOD)
    expected = 0.5 * signal.lfilter([c.b0, c.b1, c.b2], [1.0, c.a1, c.a2], errors)
    assert outputs(ls.series(low_pass, gain), errors) == pytest.approx(expected, abs=1e-13)


def test_parameters_and_states_have_the_names_of_their_controllers():
    loop = xy_loop(ls.series(TUNED, notch), sine)
    changed = loop.using({"controller.pid.kp": 2.0, "controller.notch.depth": 0.5})
    assert changed.blocks["controller"].params.notch.depth == 0.5
    assert {"controller.pid.integral", "controller.notch.m1"} <= set(loop.run(0.01, record="controller").signals)
    twice = ls.series(gain(kp=3.0), gain)
    assert twice.params._fields == ("gain", "gain_2") and twice.state is None
    three = ls.series(ls.series(table_pid, notch), low_pass)
    assert [k for k in xy_loop(three, sine).sheet if "hz" in k] == [
        "controller.pid_notch.notch.centre_hz", "controller.pid_notch.notch.width_hz", "controller.low_pass.corner_hz",
    ]  # fmt: skip


@pytest.mark.parametrize(
    "block", [ls.series(TUNED, notch), ls.series(gain, notch), ls.series(TUNED, gain), ls.series(gain, gain)]
)
def test_every_engine_gives_the_same_bits(block):
    loop = xy_loop(block, sine(amplitude=2.0, frequency=5.0))
    fast, plain = (loop.run(0.05, record=("output", "actual"), engine=engine) for engine in ("llvm", "python"))
    many = loop.batch(0.05, {"controller.gain.kp": [0.5, 0.5]} if "gain" in block.name else {}, runs=2, record="output")
    assert np.array_equal(fast["output"], plain["output"]) and np.array_equal(many["output"][0], plain["output"])


@pytest.mark.parametrize("block", [ls.series(TUNED, notch), ls.series(notch, TUNED)])
def test_it_takes_over_without_a_bump(block):
    ready = block.prepare(block.params, PERIOD)
    state = block.align(ready, 1.0, 1.0, 0.7)
    for _ in range(20):
        state, output = block.step(ready, state, 1.0, 1.0, PERIOD)
        assert output == pytest.approx(0.7, abs=1e-12)
    assert ls.series(TUNED, npid).align is None


def test_the_linear_view_of_a_series_is_the_product():
    w = np.array([10.0, 100.0, 900.0])
    c = coefficients(Notch(), PERIOD)
    z = np.exp(1j * w * PERIOD)
    through = np.polyval([c.b0, c.b1, c.b2], z) / np.polyval([1.0, c.a1, c.a2], z)
    alone, behind, before = (
        xy_loop(block, sine).linearize().open_loop(z)
        for block in (TUNED, ls.series(TUNED, notch), ls.series(notch, TUNED))
    )
    assert behind == pytest.approx(through * alone, rel=1e-9) and before == pytest.approx(behind, rel=1e-9)


@pytest.mark.parametrize(
    ("first", "second", "text"),
    [
        (table_pid, sine, "sine is not a sampled controller"),
        (follow, notch, "follow is not a sampled controller with parameters"),
        (table_pid, cascade_ppi, "cascade_ppi needs a motion"),
    ],
)
def test_what_cannot_stand_in_series_is_refused(first, second, text):
    with pytest.raises(BlockError, match=text):
        ls.series(first, second)
