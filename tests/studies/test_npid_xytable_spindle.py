"""Spindle speeds up to 24,000 1/min: folding and what moves between the samples, by second methods."""

import numpy as np
import pytest

from leadscrew.plants._xy_table_cutting import xy_table_cutting
from leadscrew.studies.npid_xytable.calibration import PERIOD_S, gain_um_per_mv
from leadscrew.studies.npid_xytable.spindle import APART, SWEPT, closed_form, line, seen_hz, sweep, table
from leadscrew.studies.npid_xytable.tunings import TUNINGS
from tests.studies.npid_lab import lab

RETUNED = TUNINGS["ours.pid_ms_159"]
FINE = 16
"""Steps of the true motion in a control period."""


def test_the_closed_form_of_a_slow_line_is_the_studys_disturbance_gain():
    """A force that is not held over the period, against one that is: the same below 8 Hz but for (w T)^2 / 24."""
    for hz in (2.1, 7.7):
        assert line(TUNINGS["paper.pid"], hz).sampled == pytest.approx(gain_um_per_mv(hz), rel=1e-3)


def motion_between_samples(resonator_hz, force_hz, periods=6000):
    """The true motion under 1 mV at ``force_hz``, stepped 16 times a period, with the controller called once in it.

    ``resonator_hz``: a resonator that is added to the retuned PID, written by hand; 0 for none.
    """
    dt = PERIOD_S / FINE
    plant = xy_table_cutting(dead_time_s=0.0)
    p, s = plant.prepare(plant.params, dt), plant.state
    w, turn = 2.0 * np.pi * force_hz, np.exp(2j * np.pi * resonator_hz * PERIOD_S)
    law, z, gain = RETUNED.state, 0.0j, 0.0j
    if resonator_hz:
        seen = 2.0 * np.pi * resonator_hz
        driven = table(seen) * np.exp(-1j * seen * (0.775e-3 + 0.5 * PERIOD_S))
        gain = 20.0 * PERIOD_S / driven
    # The force is held over 31 us, so it is given its mean there: sinc of half a step, at the middle of the step.
    mean = np.sinc(force_hz * dt)
    # 0.775 ms are 24.8 steps: in 0.8 of a step the voltage sent 25 steps ago still acts.
    sent, motion = [0.0] * 25, []
    for k in range(periods):
        e = -s.position
        law, u = RETUNED.step(RETUNED.params, law, 0.0, s.position, PERIOD_S)
        new = u + (turn * z + gain * e).real
        z = turn * z + gain * e
        for i in range(FINE):
            sent.append(new)
            held = 0.8 * sent[-26] + 0.2 * sent[-25]
            force = 1e-3 * mean * np.sin(w * (k * FINE + i + 0.5) * dt)
            s = plant.step(p, s, held, force, 0.0, dt)
            motion.append(s.position)
    return np.array(motion)[-FINE * 2000 :]


def amplitude_um(motion, hz, dt=PERIOD_S / FINE):
    t = dt * np.arange(len(motion))
    return 2e3 * abs(np.mean(motion * np.exp(-2j * np.pi * hz * t)))


@pytest.mark.slow
@pytest.mark.parametrize("force_hz", [1480.0, 1600.0])
def test_a_resonator_at_the_folded_line_moves_the_table_at_both_frequencies(force_hz):
    """Fine simulation with a resonator of its own, against the closed form."""
    ghost = line(RETUNED, force_hz, cancelled=True)
    motion = motion_between_samples(seen_hz(force_hz), force_hz)
    assert amplitude_um(motion, force_hz) == pytest.approx(ghost.own, rel=0.02)
    assert amplitude_um(motion, seen_hz(force_hz)) == pytest.approx(ghost.ghost, rel=0.02)
    assert amplitude_um(motion[FINE - 1 :: FINE], seen_hz(force_hz), PERIOD_S) < 0.01 * ghost.ghost


def test_resonators_are_refused_above_half_the_control_rate():
    """The block says so itself: nobody places one at a folded line by accident."""
    from leadscrew.util.errors import ValueRefused

    with pytest.raises(ValueRefused, match=r"1600 Hz .* half the sampling frequency"):
        lab().loop(SWEPT["resonant"](spindle_hz=400.0, teeth=4), "sine_1mm").run(0.1)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper.pid", "ours.pid_ms_159"])
def test_simulated_lines_are_those_of_the_closed_form_above_half_the_control_rate_too(name):
    found, expected = sweep(lab(), name), closed_form(name)
    for what in ("spindle", "tooth"):
        assert getattr(found, what)[APART] == pytest.approx(getattr(expected, what)[APART], rel=1e-6)
