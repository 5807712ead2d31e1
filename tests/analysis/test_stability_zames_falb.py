"""The Zames-Falb criterion: what many taps prove beyond one, and what they do not claim."""

import math
from dataclasses import replace

import numpy as np
import pytest

from leadscrew.analysis.stability.criteria import ask
from leadscrew.analysis.stability.lure import lure
from leadscrew.controllers._npid import npid
from leadscrew.studies.npid_xytable.reference_loops import reference_loops
from leadscrew.util.errors import ValueRefused
from tests.analysis.test_stability_criteria import run
from tests.analysis.test_stability_margins import random_rational
from tests.budget import in_every_run

LOOP = reference_loops()["L_star"]


def test_one_tap_proves_what_tsypkin_proves_and_more_taps_more():
    one = ask("zames-falb", LOOP, 1.0, taps=1).limit
    assert one == pytest.approx(ask("tsypkin", LOOP, 1.0).limit, rel=1e-5)
    assert ask("zames-falb", LOOP, 1.0).limit > 1.03 * one


def test_the_multiplier_found_keeps_the_condition_on_a_grid_of_its_own():
    """The condition written out again, tap by tap, at frequencies that the solver never saw."""
    found = ask("zames-falb", LOOP, 1.0, slope=5.5)
    w = np.linspace(0.5, LOOP.nyquist - 0.5, 20_011)
    g = LOOP.response(w)
    g = g / (1 + g)
    z = np.exp(1j * w * LOOP.dt)
    taps, weights = found.data["taps"], found.data["weights"]
    m = np.zeros(len(w), dtype=complex)
    for k, i in enumerate([*range(-taps, 0), *range(1, taps + 1)]):
        m += weights[k] * (1 - z**-i) + weights[2 * taps + k] * (1 + z**-i)
    left = ((1 + m) * g).real + m.real / (5.5 - 1) + 1 / (found.limit - 1)
    assert min(weights) >= 0.0 and -1e-6 < left.min() < 1e-2


def test_the_paper_s_npid_is_proved_at_rest_where_one_tap_is_not_enough_and_dies_out_when_simulated():
    law = lure(npid)
    assert ask("tsypkin", LOOP, nonlinearity=law).grade == "refused"
    assert ask("zames-falb", LOOP, nonlinearity=law).grade == "grid-checked"
    rng = np.random.default_rng(1)
    for size in (1e-3, 3e-3, 1e-2, 1.0):
        x, errors = size * rng.normal(size=(len(LOOP.a), 1)), []
        for _ in range(8000):
            e = -float((LOOP.c @ x)[0, 0])
            x = LOOP.a @ x + LOOP.b * math.cosh(0.5 * min(1e3 * abs(e), 3.0)) * e
            errors.append(e)
        # what the integral leaves takes 1600 s; what could swing has died out
        assert np.ptp(errors[-200:]) < 1e-6 * np.ptp(errors[:200])


@pytest.mark.parametrize("seed", in_every_run(range(3), [0]))
def test_no_odd_nonlinearity_of_the_certified_sector_makes_the_loop_unstable(seed):
    loop = random_rational(seed, 4e-3)
    slope = 30.0
    k2 = min(0.9 * ask("zames-falb", loop, 0.2, slope=slope).limit, 20.0)
    rng = np.random.default_rng(seed)
    for knee in 10.0 ** rng.uniform(-2, 1, 4):
        # flat, then steep up to the sector's bound, then flat: slopes 0.2 and 30
        first = knee * (slope - k2) / (slope - 0.2)
        phi = lambda e, _, a=first, b=knee: 0.2 * e + np.sign(e) * (slope - 0.2) * np.clip(abs(e) - a, 0.0, b - a)  # noqa: E731
        assert phi(knee, 0) == pytest.approx(k2 * knee)
        assert run(loop, phi, rng.normal(size=len(loop.a)), 4000) < 1.0


def test_a_curve_that_is_not_odd_is_refused():
    law = lure(npid)
    skewed = replace(law, map=replace(law.map, gain=lambda e: 1.5 if e > 0 else 1.2))
    assert "is not odd" in ask("zames-falb", LOOP, nonlinearity=skewed).statement


def test_an_integrator_asks_for_a_sector_above_zero():
    assert "has to start above 0" in ask("zames-falb", LOOP, 0.0).statement
    with pytest.raises(ValueRefused, match="is continuous; ask popov"):
        ask("zames-falb", reference_loops()["Lc"], 1.0)
