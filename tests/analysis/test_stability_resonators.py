"""Loops with undamped poles: resonators and repetitive control, whose response has poles on the frequency axis."""

import math

import numpy as np
import pytest

from leadscrew.analysis.stability.criteria import ask
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.loop import continuous_loop, sampled_loop
from leadscrew.analysis.stability.margins import margins
from leadscrew.controllers._repetitive import repetitive
from leadscrew.controllers._resonant import ODD_HZ
from leadscrew.disturbances._sine_load import sine_load
from leadscrew.kernel.loop import Loop
from leadscrew.plants._xy_table import xy_table
from leadscrew.references._sine import sine
from leadscrew.studies.npid_xytable.tunings import TUNINGS
from leadscrew.util.errors import ValueRefused

BOX = TUNINGS["ours.resonant_box"]
LINES = 2 * np.pi * np.array(ODD_HZ)


def table(controller=BOX, gain: float = 1.0, amplitude: float = 1.0) -> Loop:
    """The XY table at 2 kHz with 0.775 ms of delay, its gain off by a factor."""
    return Loop(
        reference=sine(amplitude=amplitude), controller=controller, plant=xy_table(gain=69380.0 * gain), period=0.5e-3,
        substeps=20, computation_delay=0.775e-3, disturbance=sine_load(), metrics={},
    )  # fmt: skip


@pytest.fixture(scope="module")
def box() -> LinearLoop:
    return sampled_loop(table(), "box")


def test_every_line_is_found_as_an_undamped_pole_and_the_response_beside_it_is_finite(box):
    centres = [centre for centre, _ in box.undamped]
    assert centres == pytest.approx([0.0, *LINES], rel=1e-9, abs=1e-9)
    g = box.response(np.array(centres))
    assert np.isfinite(g).all() and np.abs(g).min() > 1e4


def test_the_response_around_a_line_is_that_of_the_poles_of_the_open_and_the_closed_loop(box):
    """By another formula: 1 + G = det(zI - A + B C) / det(zI - A), from the poles of both loops."""
    w = LINES[2] + np.array([-1.0, -1e-2, 1e-2, 1.0])
    z = np.exp(1j * w * box.dt)[:, None]
    ratio = np.prod((z - np.linalg.eigvals(box.a - box.b @ box.c)) / (z - np.linalg.eigvals(box.a)), axis=1)
    assert box.response(w) == pytest.approx(ratio - 1.0, rel=1e-6)


@pytest.mark.slow
def test_peaks_of_sensitivity_are_those_of_a_very_dense_grid(box):
    w = np.concatenate([np.linspace(1e-3, 60.0, 60_001), np.linspace(60.0, box.nyquist, 60_001)])
    g = box.response(w)
    found = margins(box)
    assert found.ms == pytest.approx(np.abs(1 / (1 + g)).max(), rel=1e-6)
    assert found.mt == pytest.approx(np.abs(g / (1 + g)).max(), rel=1e-6)


def test_python_control_finds_the_same_margins(box):
    control = pytest.importorskip("control")
    w = np.linspace(60.0, box.nyquist, 4001)
    gm, pm, _, w_pc, w_gc, _ = control.stability_margins(
        control.FrequencyResponseData(box.response(w), w, smooth=True), returnall=True
    )
    found = margins(box)
    assert found.gm == pytest.approx(min(k for k in gm if k > 1.0), rel=1e-5)
    assert found.pm_deg == pytest.approx(min(pm, key=abs), abs=1e-3)
    assert found.w_pc == pytest.approx(w_pc[np.argmin(np.where(gm > 1.0, gm, np.inf))], rel=1e-4)
    assert found.w_gc == pytest.approx(w_gc[np.argmin(np.abs(pm))], rel=1e-4)


@pytest.mark.slow
def test_the_gain_may_go_from_the_lower_to_the_upper_margin_and_no_further(box):
    """By the closed poles at many gains, which know nothing of frequencies."""
    found = margins(box)
    radius = [np.abs(box.closed_poles(k)).max() for k in np.geomspace(1.0001 * found.gm_down, 0.9999 * found.gm, 200)]
    assert max(radius) < 1.0
    assert np.abs(box.closed_poles(1.0001 * found.gm)).max() > 1.0
    assert np.abs(box.closed_poles(0.9999 * found.gm_down)).max() > 1.0
    assert box.gain_limit() == found.gm


@pytest.mark.parametrize("share, grows", [(0.98, False), (1.02, True)])
def test_a_table_with_more_gain_rings_up_only_beyond_the_limit(box, share, grows):
    """The built loop in time, the plant's gain off by the limit: the resonators stay as they were designed."""
    loop = table(gain=share * box.gain_limit(), amplitude=1e-3)
    error = np.abs(loop.run(4.0)["error"])
    early, late = error[len(error) // 8 : len(error) // 4].max(), error[-len(error) // 8 :].max()
    assert bool(late > 10.0 * early) is grows


def test_criteria_reach_from_the_circle_to_the_nyquist_limit(box):
    limits = [ask(name, box, 0.9).limit for name in ("circle", "tsypkin", "zames-falb")]
    assert limits == sorted(limits) and limits[-1] < box.gain_limit()
    for name, k2 in (("circle", 2.9), ("tsypkin", 3.2), ("jury-lee", 3.5)):
        assert ask(name, box, 0.9, k2).grade == "grid-checked"
    said = ask("circle", box, 0.0, 2.0)
    assert said.grade == "refused" and "resonators" in said.statement


def test_a_resonator_does_not_change_the_circle_limit_when_it_is_weak(box):
    inner = sampled_loop(table(TUNINGS["ours.pid_ms_159"]))
    assert ask("circle", box, 0.9).limit == pytest.approx(ask("circle", inner, 0.9).limit, rel=2e-3)


@pytest.mark.slow
def test_a_given_grid_may_hold_the_pole_itself(box):
    w = np.union1d(np.geomspace(1e-4, box.nyquist, 6000), np.concatenate([LINES + d for d in np.linspace(-2, 2, 81)]))
    found = margins(box, grid=w)
    assert found.grade == "grid-checked"
    assert found.ms == pytest.approx(margins(box).ms, rel=1e-6)


def test_a_continuous_oscillator_under_proportional_control_has_the_limits_of_routh():
    """G = 4 (s + 1) / ((s^2 + 9) (s + 5)): s^3 + 5 s^2 + (9 + 4k) s + 45 + 4k is stable if 5 (9 + 4k) > 45 + 4k."""
    loop = continuous_loop([4.0, 4.0], [1.0], [1.0], list(np.polymul([1.0, 0.0, 9.0], [1.0, 5.0])))
    assert loop.undamped[0][0] == pytest.approx(3.0)
    found = margins(loop)
    assert found.grade == "grid-checked" and math.isinf(found.gm) and math.isinf(loop.gain_limit())
    # the zero beyond the lag: 5 (9 + 4k) > 45 + 28k holds for no gain
    late = continuous_loop([4.0, 28.0], [1.0], [1.0], list(np.polymul([1.0, 0.0, 9.0], [1.0, 5.0])))
    assert margins(late).grade == "refused" and late.gain_limit() == 0.0


def test_repetitive_control_is_refused_and_points_to_its_own_condition():
    with pytest.raises(ValueRefused, match=r"state holds 41\d\d numbers.*contraction\(\)"):
        sampled_loop(table(repetitive(BOX)))
