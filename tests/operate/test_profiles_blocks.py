"""The quiet blocks: nothing at all until they are told to be something."""

import math
from struct import pack

import pytest
from hypothesis import given
from hypothesis import strategies as st

from leadscrew.actuators._stiction import StictionParams, stiction
from leadscrew.disturbances._five_sines import FiveSinesParams, Line, five_sines
from leadscrew.disturbances._five_sines_pulse import FiveSinesPulseParams, five_sines_pulse
from leadscrew.disturbances._pulse_load import PulseLoadParams
from leadscrew.kernel.noise import Noise, normal
from leadscrew.plants._lathe_servo import LathePosition
from leadscrew.sensors import _counts
from leadscrew.sensors._counts import (
    EncoderCountParams,
    GratingCountParams,
    NoisyParams,
    encoder_count,
    grating_count,
    noisy,
)

DT = 1e-3
NOISE = Noise(7, 0, 2, 11)
places = st.floats(-200.0, 200.0)


def same(a, b):
    """The same number, the sign of a zero too."""
    return pack("d", a) == pack("d", b)


@given(places, places)
def test_a_counter_without_noise_is_the_counter_of_the_study(position, reading):
    at = LathePosition(position, reading)
    plain = _counts.NoisyGratingParams(), _counts.NoisyEncoderParams()
    assert _counts.noisy_grating(plain[0], at, NOISE) == grating_count(GratingCountParams(), at)
    assert _counts.noisy_encoder(plain[1], at, NOISE) == encoder_count(EncoderCountParams(), at)


def test_noise_is_added_before_the_rounding():
    w = 0.05 * normal(NOISE, 0)
    seen = _counts.noisy_grating(_counts.NoisyGratingParams(0.001, 0.05), LathePosition(0.0, 1.0), NOISE)
    assert seen == pytest.approx(0.001 * math.floor((1.0 + w) / 0.001 + 0.5))
    assert noisy(NoisyParams(0.05), 1.0, NOISE) == 1.0 + w


@pytest.mark.slow
@given(st.floats(allow_nan=False))
def test_no_noise_and_no_stiction_let_every_number_pass(x):
    assert same(noisy(NoisyParams(), x, NOISE), x)
    assert same(stiction(StictionParams(), x), x)


def test_stiction_lets_pass_what_reaches_the_threshold():
    assert [stiction(StictionParams(0.1), x) for x in (-0.2, -0.1, -0.09, 0.09, 0.1)] == [-0.2, -0.1, 0.0, 0.0, 0.1]


@given(st.floats(0.0, 100.0), st.floats(-1.0, 1.0))
def test_five_sines_without_a_pulse_are_five_sines(t, amplitude):
    lines = FiveSinesParams(Line(2.1, amplitude, 0.3), fifth=Line(7.7, -amplitude, 1.0))
    assert same(five_sines_pulse(FiveSinesPulseParams(*lines), t, DT), five_sines(lines, t))


def test_the_pulse_is_on_from_its_start_for_its_duration_and_the_force_scales_the_lines_alone():
    p = FiveSinesPulseParams(first=Line(0.0, 1.0, math.pi / 2), force=3.0, pulse=PulseLoadParams(0.5, 0.01, 0.003))
    seen = [five_sines_pulse(p, k * DT, DT) for k in range(16)]
    assert seen == pytest.approx([3.0] * 10 + [3.5] * 3 + [3.0] * 3)
