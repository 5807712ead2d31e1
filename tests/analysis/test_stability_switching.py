"""Gains that switch: the worst pattern of two intervals."""

import numpy as np
import pytest

from leadscrew.analysis.stability.criteria import ask
from leadscrew.analysis.stability.switching import pattern_radius, worst_switching
from leadscrew.studies.npid_xytable.reference_loops import reference_loops
from leadscrew.util.errors import ValueRefused


@pytest.mark.slow
def test_the_pattern_found_makes_a_simulated_loop_grow_and_a_smaller_gain_does_not():
    loop = reference_loops()["L_star"]
    found = worst_switching(loop)
    assert (found.periods_low, found.periods_high) == (2, 9)
    assert found.high == pytest.approx(2.4767, abs=1e-3)

    def size_after(high):
        x = np.ones(len(loop.a))
        for k in range(11 * 3000):
            gain = 1.0 if k % 11 < 2 else high
            x = loop.a @ x - loop.b[:, 0] * gain * float((loop.c @ x)[0])
        return np.linalg.norm(x)

    assert size_after(1.005 * found.high) > 1e3
    assert size_after(0.995 * found.high) < 10.0


def test_what_the_circle_criterion_proves_no_pattern_breaks():
    loop = reference_loops()["L_star"]
    assert pattern_radius(loop, 1.0, ask("circle", loop, 1.0).limit)[0] < 1.0


def test_a_continuous_loop_is_refused():
    with pytest.raises(ValueRefused, match="needs a sampled one"):
        worst_switching(reference_loops()["Lc"])
