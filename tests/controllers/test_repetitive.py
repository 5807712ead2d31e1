"""Repetitive control: its memory by SciPy, its promise of convergence against the loop, and what it leaves."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy import signal

from leadscrew.controllers._inverse_feed_forward import inverse_feed_forward
from leadscrew.controllers._repetitive import TAPS, contraction, low_pass, repetitive
from leadscrew.disturbances._five_sines import five_sines
from leadscrew.disturbances._sine_load import sine_load
from leadscrew.kernel.loop import Loop
from leadscrew.plants._xy_table_lugre import LEVELS
from leadscrew.references._eased_sine import eased_sine_motion
from leadscrew.studies.npid_xytable.tunings import INVERSE, TUNINGS, XY_TABLE, table_pid
from leadscrew.util.errors import BlockError, ValueRefused
from tests.controllers.table_axis import PERIOD, lines_um, rms_um, table_axis, tried

ONE = table_pid(kp=1.0, ki=0.0, kd=0.0)
TUNED = TUNINGS["ours.pid_ms_159"]
W = np.geomspace(1.0, 6200.0, 2000)
HARMONICS = five_sines(**{f"{place}.amplitude": 1e-3 for place in five_sines.params._fields})


@pytest.mark.parametrize("late", [150.0, 149.4, 150.3])
def test_the_memory_is_a_delay_behind_a_low_pass(late):
    """Gain one in place of the PID: u = e + v, v = q z^-N (v + strength e), by SciPy with the taps written out."""
    block = repetitive(ONE, late * PERIOD, cutoff_hz=60.0, lead_s=0.0, strength=0.6, room=300)
    errors = np.random.default_rng(4).normal(size=900)
    width = np.sqrt(np.log(2.0)) / (2.0 * np.pi * 60.0 * PERIOD)
    delays = np.arange(round(late) - TAPS, round(late) + TAPS + 1)
    weights = np.exp(-0.5 * ((delays - late) / width) ** 2)
    path = np.zeros(delays[-1] + 1)
    path[delays] = weights / weights.sum()
    start = np.zeros(len(path))
    start[0] = 1.0
    expected = errors + signal.lfilter(0.6 * path, start - path, errors)
    assert tried(block, errors, np.zeros(900)) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_the_low_pass_has_lost_3_db_at_its_cut_off_and_shifts_nothing():
    w = 2.0 * np.pi * np.array([1e-3, 40.0])
    response = np.exp(-1j * np.outer(w * PERIOD, np.arange(-TAPS, TAPS + 1))) @ low_pass(40.0, PERIOD)
    assert np.abs(response) == pytest.approx([1.0, np.sqrt(0.5)], abs=2e-3) and np.abs(response.imag).max() < 1e-12


@pytest.mark.slow
def test_the_error_of_a_repeated_disturbance_shrinks_as_promised():
    """Five lines of 0.7 Hz: their distance from what stays of them falls each period at least by the contraction."""
    run = table_axis(repetitive(TUNED), amplitude=0.0, disturbance=HARMONICS).run(16.0)
    e = [1e3 * run["true_error"][round(k / 0.7 / PERIOD) :][:2857] for k in range(1, 11)]
    away = [float(np.sqrt(np.mean((x - e[-1]) ** 2))) for x in e[:4]]
    p = repetitive(TUNED).params
    lines = 2.0 * np.pi * np.array([2.1, 3.5, 4.9, 6.3, 7.7])
    most = contraction(TUNED, lines, p.cutoff_hz, p.lead_s, p.strength, model=XY_TABLE).max()
    assert most == pytest.approx(0.3, abs=0.01) and all(b < 1.1 * most * a for a, b in pairwise(away)), away


def test_our_tuning_converges_at_every_frequency_and_a_bad_lead_does_not():
    p = TUNINGS["ours.repetitive"].params.inner
    assert contraction(TUNED, W, p.cutoff_hz, p.lead_s, p.strength, model=XY_TABLE).max() < 0.35
    assert contraction(TUNED, W, 150.0, 0.0, 1.2, model=XY_TABLE).max() > 1.0


@pytest.mark.slow
def test_where_the_contraction_is_above_one_the_loop_is_lost():
    """The same memory with and without the lead that the loop's lag asks for."""
    last = []
    for lead, cutoff in ((2.5e-3, 100.0), (8e-3, 100.0)):
        block = repetitive(TUNED, 0.2, cutoff, lead, 1.0, room=500)
        assert (contraction(TUNED, W, cutoff, lead, 1.0, model=XY_TABLE).max() > 1.0) == (lead > 5e-3)
        run = table_axis(block, amplitude=0.0, disturbance=sine_load(amplitude=1e-3, frequency=5.0)).run(6.0)
        last.append(np.abs(1e3 * run["true_error"][-400:]).max())
    assert last[0] < 0.02 and last[1] > 10.0


@pytest.mark.slow
def test_every_harmonic_goes_without_being_named():
    lines = [0.7, 2.1, 3.5, 4.9, 6.3, 7.7]
    blocks = (TUNED, TUNINGS["ours.repetitive"])
    before, after = (lines_um(table_axis(block, disturbance=HARMONICS).run(20.0), lines) for block in blocks)
    q = np.exp(-0.5 * np.log(2.0) * (np.array(lines) / 30.0) ** 2)
    assert (after < 1.3 * (1.0 - q) / (1.0 - 0.3 * q) * before + 2e-3).all()


@pytest.mark.slow
def test_a_spindle_line_stays():
    cut = {"amplitude": 0.0, "spindle_hz": 50.0 / 3.0, "spindle_v": 1e-3}
    plain, learned = (lines_um(table_axis(b, **cut).run(20.0), [50.0 / 3.0])[0] for b in (TUNED, repetitive(TUNED)))
    assert learned > 0.7 * plain


@pytest.mark.slow
def test_friction_repeats_itself_and_is_learned():
    found = []
    for block in (inverse_feed_forward(TUNED, **INVERSE), TUNINGS["ours.repetitive"]):
        loop = Loop(
            reference=eased_sine_motion(amplitude=1.0, frequency=0.7), controller=block, plant=LEVELS["medium"],
            period=PERIOD, substeps=20, computation_delay=0.775e-3, metrics={},
        )  # fmt: skip
        found.append(rms_um(loop.run(20.0)))
    assert found[1] < 0.5 * found[0]


@pytest.mark.parametrize("inner", [ONE, ONE(lower=-1.0, upper=1.0)], ids=["", "the same limit inside"])
def test_what_did_not_act_is_not_learned(inner):
    """Gain one: errors of 0.5 act, of 2.0 they do not; a period later the first are met by the taps, the others not."""
    errors = np.zeros(400)
    errors[100:130], errors[160:190] = 0.5, 2.0
    late = 150
    block = repetitive(inner, late * PERIOD, cutoff_hz=200.0, lead_s=0.0, strength=0.6, room=300, lower=-1.0, upper=1.0)
    found = np.array(tried(block, errors, np.zeros(400)))
    taps = low_pass(200.0, PERIOD)
    learned = np.convolve(np.where(errors == 0.5, 0.6 * errors, 0.0), taps)[TAPS : TAPS + 400]
    expected = np.clip(errors, -1.0, 1.0)
    # Up to the second return of the first errors, at 400 less the width of the low-pass.
    expected[late:360] += learned[: 360 - late]
    assert found[:360] == pytest.approx(expected[:360], abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("limit", [math.inf, 5e-3])
def test_a_limit_outside_keeps_the_memory_from_winding_up(limit):
    """A motion that needs 60 times the voltage, around a PID with the same limit: what is added to its command."""
    block = repetitive(TUNED(lower=-5e-3, upper=5e-3, anti_windup=1), lower=-limit, upper=limit)
    run = table_axis(block).run(20.0, record=("output", "controller.added"))
    most = np.abs(run["controller.added"]).max()
    assert np.abs(run["output"]).max() == 5e-3 and (most > 1.0 if limit == math.inf else most < 0.05)


def test_periods_and_cut_offs_that_the_memory_cannot_hold_are_refused():
    with pytest.raises(ValueRefused, match=r"period_s = 3.0 .* 45 to 4055; a longer one needs more room"):
        table_axis(repetitive(table_pid, 3.0)).run(0.1)
    with pytest.raises(ValueRefused, match=r"cutoff_hz = 5.0 \(repetitive\): expected 20 or more"):
        table_axis(repetitive(table_pid, cutoff_hz=5.0)).run(0.1)
    with pytest.raises(BlockError, match="room = 10"):
        repetitive(table_pid, room=10)


@pytest.mark.slow
def test_the_first_output_after_an_align_is_the_last_one_before():
    live = table_axis(table_pid).start()
    live.advance(3000)
    expected = live.advance_preview()["output"]
    after = live.switch(repetitive(TUNED))
    assert after.bumpless and after.advance(1)["output"][0] == pytest.approx(expected, abs=1e-13)


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    loop = table_axis(repetitive(TUNED, 0.05 + 1e-4, room=200, lower=-0.05, upper=0.05), frequency=20.0)
    record = ("output", "actual", "controller.at", "controller.added")
    fast, plain = (loop.run(0.2, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)
