"""Biquads on a controller's output against SciPy, python-control, and LinuxCNC's formulas."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import signal

from leadscrew.controllers._biquad import Coefficients, LeadLag, LowPass, Notch, biquad, coefficients
from leadscrew.controllers._inverse_feed_forward import inverse_feed_forward
from leadscrew.export import hal_run
from leadscrew.kernel.loop import DivergenceWarning
from leadscrew.plants._xy_table import xy_table
from leadscrew.references._sine import sine, sine_motion
from leadscrew.studies.npid_xytable.tunings import INVERSE, TUNINGS, table_pid
from leadscrew.util.errors import BlockError, ValueRefused
from tests.controllers.xy_loop import PERIOD, xy_loop
from tests.export.hal_bench import Bench
from tests.export.hal_bench import needed as hal_needed

RNG = np.random.default_rng(3)
GAIN = table_pid(kp=1.0, ki=0.0, kd=0.0)
TUNED = TUNINGS["ours.pid_ms_159"]
HIGH = Notch(centre_hz=800.0, width_hz=100.0, depth=0.3)


def through(block, inputs):
    """What the sections make of an error, called by hand."""
    p, s, seen = block.prepare(block.params, PERIOD), block.state, []
    for x in inputs:
        s, y = block.step(p, s, float(x), 0.0, PERIOD)
        seen.append(y)
    return np.array(seen)


@pytest.mark.parametrize("section", [Notch(), HIGH, LowPass(), LowPass(corner_hz=900.0, damping=0.1)])
def test_the_numbers_are_those_of_python_controls_prewarped_bilinear_rule(section):
    import control

    if isinstance(section, Notch):
        w, wide = 2.0 * math.pi * section.centre_hz, 2.0 * math.pi * section.width_hz
        analogue = control.tf([1.0, section.depth * wide, w * w], [1.0, wide, w * w])
    else:
        w = 2.0 * math.pi * section.corner_hz
        analogue = control.tf([w * w], [1.0, 2.0 * section.damping * w, w * w])
    expected = control.sample_system(analogue, PERIOD, "bilinear", prewarp_frequency=w)
    num, den = expected.num[0][0], expected.den[0][0]
    assert coefficients(section, PERIOD) == pytest.approx([*(num / den[0]), *(den[1:] / den[0])], rel=1e-9, abs=1e-12)


def test_several_sections_are_scipys_cascade():
    sections = (Notch(depth=0.0), LowPass(), Coefficients(0.5, 0.2, 0.1, -0.3, 0.1))
    inputs = RNG.normal(size=500)
    sos = [[c.b0, c.b1, c.b2, 1.0, c.a1, c.a2] for c in (coefficients(s, PERIOD) for s in sections)]
    assert through(biquad(GAIN, *sections), inputs) == pytest.approx(signal.sosfilt(sos, inputs), abs=1e-13)


@pytest.mark.parametrize("section", [Notch(), HIGH])
def test_a_notch_leaves_its_depth_at_the_centre_and_everything_far_away(section):
    t = PERIOD * np.arange(4000)
    wave = np.sin(2.0 * math.pi * section.centre_hz * t)
    out = through(biquad(GAIN, section), wave)[-1000:]
    assert np.std(out) / np.std(wave[-1000:]) == pytest.approx(section.depth, rel=1e-6)
    slow = through(biquad(GAIN, section), np.sin(2.0 * math.pi * 0.5 * t))
    assert np.abs(slow[-1000:]).max() == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(("zero", "pole"), [(30.0, 3.0), (8.0, 80.0)])
def test_a_lag_and_a_lead_are_those_of_the_bilinear_rule(zero, pole):
    wz, wp = 2.0 * math.pi * zero, 2.0 * math.pi * pole
    b, a = signal.bilinear([1.0 / wz, 1.0], [1.0 / wp, 1.0], fs=1.0 / PERIOD)
    c = coefficients(LeadLag(zero, pole), PERIOD)
    np.testing.assert_allclose([c.b0, c.b1, c.b2, c.a1, c.a2], [*b, 0.0, a[1], 0.0], rtol=1e-12, atol=1e-15)
    with pytest.raises(ValueRefused, match="pole_hz"):
        coefficients(LeadLag(zero, 0.5 / PERIOD), PERIOD)


@pytest.mark.parametrize("q", [0.5, 0.7071, 2.0])
def test_low_pass_and_notch_of_linuxcnc_are_these_with_their_own_names(q):
    """Type 1 and 2 of its component, f0 = 250 Hz: R. Bristow-Johnson's cookbook."""
    turn = 2.0 * math.pi * 250.0 * PERIOD
    alpha, c = math.sin(turn) / (2.0 * q), math.cos(turn)
    tail = np.array([-2.0 * c, 1.0 - alpha]) / (1.0 + alpha)
    low = [*(np.array([0.5, 1.0, 0.5]) * (1.0 - c) / (1.0 + alpha)), *tail]
    notch = [*(np.array([1.0, -2.0 * c, 1.0]) / (1.0 + alpha)), *tail]
    assert coefficients(LowPass(250.0, 1.0 / (2.0 * q)), PERIOD) == pytest.approx(low, abs=1e-13)
    assert coefficients(Notch(250.0, 250.0 / q, 0.0), PERIOD) == pytest.approx(notch, abs=1e-13)


@pytest.mark.slow
def test_a_notch_on_a_resonance_gives_the_loop_its_gain_back():
    """A section that peaks tenfold at 200 Hz, inverse of a notch: alone it is fatal, with the notch it does nothing."""
    peak = coefficients(Notch(200.0, 100.0, 0.1), PERIOD)
    resonance = Coefficients(1.0 / peak.b0, peak.a1 / peak.b0, peak.a2 / peak.b0, peak.b1 / peak.b0, peak.b2 / peak.b0)
    bare = xy_loop(biquad(TUNED, resonance), sine(amplitude=0.1), bound=10.0)
    with pytest.warns(DivergenceWarning, match="diverged"):
        assert bare.run(2.0).diverged is not None
    cured = xy_loop(biquad(TUNED, resonance, Notch(200.0, 100.0, 0.1)), sine(amplitude=0.1)).run(2.0)
    plain = xy_loop(TUNED, sine(amplitude=0.1)).run(2.0)
    assert cured["actual"] == pytest.approx(plain["actual"], abs=1e-9)


@pytest.mark.parametrize("sections", [(), (HIGH, LowPass(500.0)), (Coefficients(0.5, 0.2, 0.1, -0.2, 0.1),)])
def test_it_takes_over_without_a_bump_and_stays_there(sections):
    block = biquad(TUNED, *sections)
    p = block.prepare(block.params, PERIOD)
    s = block.align(p, 1.0, 1.0, 0.7)
    for _ in range(50):
        s, u = block.step(p, s, 1.0, 1.0, PERIOD)
        assert u == pytest.approx(0.7, abs=1e-12)


def test_a_live_switch_shows_no_jump():
    live = xy_loop(TUNED, sine(amplitude=5.0, frequency=0.7)).start()
    live.advance(1000)
    expected = live.advance_preview()["output"]
    after = live.switch(biquad(TUNED, Notch(), LowPass()))
    assert after.bumpless and after.advance(1)["output"][0] == pytest.approx(expected, abs=1e-14)


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    loop = xy_loop(biquad(TUNED, Notch(), LowPass()), sine(amplitude=4.0, frequency=3.0))
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.2, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


def test_frequencies_can_be_swept_in_a_batch():
    loop = xy_loop(biquad(TUNED, Notch()), sine(amplitude=1.0, frequency=5.0))
    centres = np.array([60.0, 150.0, 400.0])
    many = loop.batch(0.5, {"controller.section_1.centre_hz": centres}, record="actual")
    alone = loop.using({"controller.section_1.centre_hz": 150.0}).run(0.5, record="actual")
    assert np.array_equal(many["actual"][1], alone["actual"]) and len({r[-1] for r in many["actual"]}) == 3


def test_the_memory_decays_to_zero_and_not_to_denormal_numbers():
    block = biquad(GAIN, Notch())
    p, s = block.prepare(block.params, PERIOD), block.state
    for k in range(6000):
        s, _ = block.step(p, s, 1.0 if k == 0 else 0.0, 0.0, PERIOD)
    assert not s.memory.any()


def test_it_goes_around_controllers_of_a_motion_command():
    block = biquad(inverse_feed_forward(TUNED, **INVERSE), LowPass(800.0))
    run = xy_loop(block, sine_motion(amplitude=1.0, frequency=0.7)).run(1.0)
    assert np.abs(run["true_error"][1000:]).max() < 0.1


@pytest.mark.parametrize(
    ("section", "words"),
    [
        (Notch(centre_hz=1000.0), r"centre_hz = 1000.0 Hz .*below half the sampling rate, 1000 Hz"),
        (LowPass(corner_hz=1500.0), r"corner_hz = 1500.0 Hz"),
        (Coefficients(a1=-2.1, a2=1.05), "unstable"),
        (Coefficients(b0=1.0, b1=-1.0), "DC gain is 0"),
    ],
)
def test_what_cannot_be_a_section_is_refused(section, words):
    with pytest.raises(ValueRefused, match=words):
        xy_loop(biquad(table_pid, section), sine()).run(0.01)


def test_a_plant_cannot_be_filtered():
    with pytest.raises(BlockError, match=r"biquad\(xy_table\)"):
        biquad(xy_table)


@pytest.mark.parametrize(
    ("settings", "section"),
    [
        ({"type": 1, "f0": 120.0, "Q": 0.7071}, LowPass(120.0, 1.0 / (2.0 * 0.7071))),
        ({"type": 2, "f0": 60.0, "Q": 1.5}, Notch(60.0, 40.0, 0.0)),
    ],
)
def test_the_real_linuxcnc_component_gives_the_same_output(settings, section):
    """Its own ``biquad``, fed by a square wave in a thread of 1 ms, against these sections on the same samples."""
    hal_needed()
    lines = [
        "loadrt siggen",
        "loadrt biquad",
        "addf siggen.0.update servo",
        "addf biquad.0 servo",
        "setp siggen.0.frequency 7",
        *(f"setp biquad.0.{name} {value}" for name, value in settings.items()),
        "setp biquad.0.enable 1",
        "net sampled0 siggen.0.square => biquad.0.in",
    ]
    with hal_run.workplace() as place:
        here = SimpleNamespace(place=place)
        table, _ = Bench.sampled(here, lines, ["siggen.0.square", "biquad.0.out"], 800)
    assert len(np.unique(table[:, 0])) == 2
    block = biquad(GAIN, section)
    p, s, seen = block.prepare(block.params, 1e-3), block.state, []
    for x in table[:, 0]:
        s, y = block.step(p, s, float(x), 0.0, 1e-3)
        seen.append(y)
    assert seen == pytest.approx(table[:, 1], abs=1e-9)
