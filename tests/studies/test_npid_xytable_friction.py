"""Friction on the XY table: what the claims rest on, by a second method."""

import numpy as np
import pytest

from leadscrew.studies.npid_xytable import friction
from tests.studies.npid_lab import lab


@pytest.mark.slow
def test_far_above_e_max_npid_is_pid_with_all_gains_2_35_fold():
    """15 mm: the compression law, 57.5 % less whatever the friction."""
    found = friction.sines_on_friction(lab())
    at = [friction.TABLE.index(friction.HIGH_15), len(friction.TABLE) + friction.MORE.index(friction.LOW_15)]
    less = found["corrected.npid_um"].rms[at] / found["paper.pid"].rms[at]
    assert less == pytest.approx([1.0 / np.cosh(1.5)] * 2, rel=3e-3)


def test_the_angle_from_the_reversal_is_zero_where_the_sine_turns():
    time = 5e-4 * np.arange(friction.COUNTS)
    speed = np.cos(2.0 * np.pi * 0.7 * time)
    assert friction.turned_deg(1.0 - np.abs(speed)) < 0.2 and friction.turned_deg(speed) > 89.8
