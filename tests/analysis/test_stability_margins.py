"""Margins of linear loops, against python-control and against formulas by hand."""

import math

import numpy as np
import pytest

from leadscrew.analysis.stability.linear import LinearLoop, own_grid, phase_crossings
from leadscrew.analysis.stability.loop import continuous_loop
from leadscrew.analysis.stability.margins import margins
from leadscrew.studies.npid_xytable.reference_loops import reference_loops


def random_rational(seed: int, dt: float | None) -> LinearLoop:
    """A stable loop of third order with a lightly damped pair, drawn by seed."""
    rng = np.random.default_rng(seed)
    w, zeta, lag = 10 ** rng.uniform(1, 2.5), rng.uniform(0.03, 0.6), 10 ** rng.uniform(1, 2.5)
    den = np.polymul([1.0, 2 * zeta * w, w * w], [1.0, lag])
    loop = continuous_loop([rng.uniform(0.05, 0.6) * w * w * lag], [1.0], [1.0], den)
    if dt is None:
        return loop
    from scipy.signal import cont2discrete

    a, b, c, d, _ = cont2discrete((loop.a, loop.b, loop.c, loop.d), dt)
    return LinearLoop(a, b, c, d, dt)


@pytest.mark.filterwarnings("ignore:stability_margins")
@pytest.mark.parametrize("dt", [None, 2e-3])
def test_python_control_finds_the_same_margins(dt):
    control = pytest.importorskip("control")
    compared = 0
    for seed in range(12):
        loop = random_rational(seed, dt)
        found = margins(loop)
        gm, pm, _, w_pc, w_gc, _ = control.stability_margins(loop.to_control())
        if not loop.stable():
            assert found.grade == "refused"
            continue
        compared += 1
        assert found.gm == pytest.approx(gm, rel=1e-5)
        assert found.w_pc == pytest.approx(w_pc, rel=1e-5)
        if math.isfinite(pm):
            assert found.pm_deg == pytest.approx(pm, abs=1e-4)
            assert found.w_gc == pytest.approx(w_gc, rel=1e-6)
    assert compared >= 6


@pytest.mark.slow
@pytest.mark.parametrize("dt", [None, 2e-3])
def test_the_peak_of_sensitivity_is_that_of_a_very_dense_grid(dt):
    for seed in range(4):
        loop = random_rational(seed, dt)
        if loop.stable():
            w = np.linspace(1.0, 900.0, 200_001)
            assert margins(loop).ms == pytest.approx(np.max(1 / abs(1 + loop.response(w))), rel=1e-6)


def test_an_integrator_with_dead_time_has_the_margins_of_the_formula():
    """G = k e^(-s h) / s: PM = 90 deg - k h, GM = pi / (2 k h), delay margin = PM / k."""
    k, h = 30.0, 0.02
    found = margins(continuous_loop([k], [1.0], [1.0], [1.0, 0.0], dead_time=h))
    assert found.pm_deg == pytest.approx(90.0 - math.degrees(k * h), abs=1e-8)
    assert found.gm == pytest.approx(math.pi / (2 * k * h), rel=1e-9)
    assert found.delay_s == pytest.approx(math.pi / 2 / k - h, rel=1e-9)
    assert found.w_gc == pytest.approx(k, rel=1e-10)


def test_the_delay_margin_is_the_dead_time_that_makes_the_loop_unstable():
    loop = reference_loops()["Lc"]
    more = margins(loop).delay_s
    for share, stable in ((0.999, True), (1.001, False)):
        late = LinearLoop(loop.a, loop.b, loop.c, loop.d, None, loop.dead_time + share * more)
        assert late.stable() is stable


def test_a_narrow_resonance_is_not_missed():
    """A mode of 0.01 % damping far above the crossover, whose peak alone reaches -1."""
    w, zeta = 3000.0, 1e-4
    loop = continuous_loop([30.0], [1.0, 0.0], [w * w], [1.0, 2 * zeta * w, w * w])
    # s (s^2 + 2 zeta w s + w^2) + k w^2: Routh asks for k < 2 zeta w
    assert margins(loop).grade == "refused"
    assert loop.gain_limit() * 30.0 == pytest.approx(2 * zeta * w, rel=1e-9)


def test_an_unstable_loop_has_no_margins_and_says_which_pole():
    found = margins(reference_loops()["Lc"], gain=2.6)
    assert found.grade == "refused" and math.isnan(found.gm)
    assert "unstable (a pole at" in found.statement


def test_a_grid_of_the_callers_that_misses_the_resonance_is_refused():
    w, zeta = 300.0, 0.005
    loop = continuous_loop([1.0], [1.0, 0.0], [w * w], [1.0, 2 * zeta * w, w * w])
    found = margins(loop, grid=np.geomspace(0.1, 1e4, 60))
    assert found.grade == "refused"
    assert "too coarse for the resonance at 47.7" in found.statement
    assert margins(loop, grid=own_grid(loop).w).grade == "grid-checked"


def test_a_grid_too_coarse_for_the_dead_time_is_refused():
    found = margins(reference_loops()["Lc"], grid=np.geomspace(1e-5, 1e4, 200))
    assert found.grade == "refused" and "too coarse for the dead time of 1.2888 ms" in found.statement


def test_the_nyquist_curve_is_drawn_with_labelled_axes():
    axes = margins(reference_loops()["L_star"]).figure().axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("Re G", "Im G")
    assert any("phase crossover -0.3984" in t.get_text() for t in axes.get_legend().get_texts())


THIRD = continuous_loop([1.0], [1.0], [1.0], [1.0, 3.0, 3.0, 1.0])  # 1 / (s + 1)^3
FIRST = LinearLoop(np.array([[0.5]]), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)), 1.0)  # 1 / (z - 1/2)
INVERTED = LinearLoop(FIRST.a, FIRST.b, -FIRST.c, FIRST.d, 1.0)
BLOCKED = continuous_loop([1.0, 0.0], [1.0], [1.0], [1.0, 3.0, 3.0, 1.0])  # s / (s + 1)^3: nothing passes at 0


@pytest.mark.parametrize(
    ("loop", "positive", "expected"),
    [
        (THIRD, False, [(math.sqrt(3.0), -1 / 8)]),
        (THIRD, True, [(0.0, 1.0), (math.sqrt(3.0), -1 / 8)]),
        (FIRST, False, [(math.pi, -2 / 3)]),
        (FIRST, True, [(0.0, 2.0), (math.pi, -2 / 3)]),
        (INVERTED, False, [(0.0, -2.0)]),
        (INVERTED, True, [(0.0, -2.0), (math.pi, 2 / 3)]),
        (BLOCKED, False, []),
        (BLOCKED, True, [(1.0 / math.sqrt(3.0), 3 / 8)]),
    ],
)  # fmt: skip
def test_the_real_axis_is_crossed_where_it_is_by_hand_also_at_rest_and_at_half_the_sampling_rate(
    loop, positive, expected
):
    assert [(c.w, c.value) for c in phase_crossings(loop, positive=positive)] == [pytest.approx(e) for e in expected]
