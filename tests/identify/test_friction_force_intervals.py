"""Stated intervals against the truth of many made logs, with a force whose noise is coloured."""

from __future__ import annotations

import numpy as np
import pytest

from leadscrew.identify.estimation import quantile
from leadscrew.identify.friction_force import force_record, identify_friction_force
from leadscrew.identify.friction_force.task import clusters_of, spread_of
from tests.identify.friction_force_logs import TRUTH, log

STROKES = ((0.2e-3, 1.6), (0.05e-3, 0.4), (0.3e-3, 0.8))


@pytest.mark.slow
def test_the_truth_lies_in_the_stated_intervals_as_often_as_they_say():
    inside = []
    for seed in range(24):
        t, x, force = log(noise=0.03, colour=0.9, seed=seed, strokes=STROKES, repeats=6)
        found = identify_friction_force(force_record(t, force, position=x), holdout=0.0).chosen.parameters
        for key, value in (
            ("friction.stiffness", TRUTH.stiffness),
            ("friction.damping", TRUTH.damping),
            ("friction.forward.coulomb", TRUTH.forward.coulomb),
            ("friction.forward.static", TRUTH.forward.static),
            ("friction.backward.coulomb", TRUTH.backward.coulomb),
            ("friction.backward.static", TRUTH.backward.static),
            ("friction.forward.viscous", TRUTH.forward.viscous),
            ("friction.forward.stribeck_speed", TRUTH.forward.stribeck_speed),
        ):
            assert found[key].identifiable
            inside.append(found[key].low <= value <= found[key].high)
    assert 0.88 <= np.mean(inside) <= 0.99


def test_coloured_noise_widens_an_interval_where_the_usual_one_would_be_too_narrow():
    rng = np.random.default_rng(5)
    strokes = np.repeat(np.arange(40), 50)
    column = np.ones((2000, 1))
    errors, robust_sizes, usual_sizes = [], [], []
    for _ in range(200):
        e = np.repeat(rng.standard_normal(20), 100)
        errors.append(e.mean())
        spread = spread_of(column, e - e.mean(), clusters_of(strokes), np.array([True]))
        robust_sizes.append(quantile(spread.degrees[0]) * np.sqrt(spread.covariance[0, 0]))
        usual_sizes.append(1.96 * e.std() / np.sqrt(2000))
    held = np.mean(np.abs(errors) <= robust_sizes)
    assert 0.9 <= held <= 0.99
    assert np.mean(np.abs(errors) <= usual_sizes) < 0.4
