"""Friction on the XY table: what the claims rest on, by second methods."""

import numpy as np
import pytest

from leadscrew.analysis.contour import contour_error
from leadscrew.studies.npid_xytable.friction_runs import (
    COUNTS,
    ENCODER_UM,
    HIGH_15,
    LOW_15,
    MEDIUM,
    RADIUS_MM,
    SINES,
    WEAK_Y,
    circles,
    counted,
    errors,
)
from leadscrew.studies.npid_xytable.runs import Loops


@pytest.fixture(scope="module")
def loops():
    return Loops()


@pytest.mark.slow
def test_far_above_e_max_npid_is_pid_with_all_gains_2_35_fold(loops):
    """15 mm: the digest's compression law, 57.5 % less whatever the friction."""
    plain, nonlinear = (
        counted(errors(loops, SINES[k], (HIGH_15, LOW_15))[1]) for k in ("paper.pid", "corrected.npid_um")
    )
    assert nonlinear.rms / plain.rms == pytest.approx([1.0 / np.cosh(1.5)] * 2, rel=3e-3)


@pytest.mark.slow
def test_the_circles_deviation_is_the_contour_error(loops):
    """Against the polyline of the commands, by the analysis that knows no circle."""
    wide = MEDIUM._replace(amplitude_mm=RADIUS_MM)
    found = circles(loops, SINES["paper.pid"])[0]
    t, error = errors(loops, SINES["paper.pid"], (wide, wide._replace(gain=WEAK_Y * wide.gain)), ENCODER_UM)
    w, quarter = 2.0 * np.pi * 0.7, 0.25 / 0.7
    t_seen = t[t <= t[-1] - quarter][-COUNTS // 5 :]
    x = 10.0 * np.cos(w * t_seen) - 1e-3 * np.interp(t_seen + quarter, t, error[0])
    y = 10.0 * np.sin(w * t_seen) - 1e-3 * np.interp(t_seen, t, error[1])
    fine = np.linspace(0.0, 2.0 * np.pi, 4000)
    off = contour_error(10.0 * np.cos(fine), 10.0 * np.sin(fine), x[::7], y[::7])
    # Left of the direction of travel is inwards.
    assert -1e3 * off.signed == pytest.approx(found.radial[-COUNTS // 5 :][::7], abs=0.01)
