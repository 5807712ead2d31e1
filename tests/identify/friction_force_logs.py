"""Made logs of a friction force, by the scalar functions of leadscrew.friction at a tenth of the log's period."""

from __future__ import annotations

import numpy as np

from leadscrew.analysis.friction import friction_along
from leadscrew.friction.asymmetric import TwoSidedLuGre
from leadscrew.friction.static_map import Sliding

TRUTH = TwoSidedLuGre(2e5, 300.0, Sliding(3.0, 4.5, 4e-4, 120.0), Sliding(2.6, 4.0, 4e-4, 120.0))
PERIOD, FINE = 0.004, 10
STROKES = ((0.2e-3, 0.8), (0.05e-3, 0.2), (0.1e-3, 1.6), (0.6e-3, 0.4), (0.03e-3, 0.1))


def cosines(strokes=STROKES, repeats=2, step=PERIOD / FINE):
    """Position, m: cosine strokes of these amplitudes and periods, in turn, with rests between."""
    pieces = [np.zeros(round(0.1 / step))]
    for wide, long in strokes * repeats:
        t = np.arange(round(2.0 * long / step)) * step
        pieces += [0.5 * wide * (1.0 - np.cos(2.0 * np.pi * t / long)), np.zeros(round(0.04 / step))]
    return np.concatenate(pieces)


def log(truth=TRUTH, *, noise=0.02, colour=0.0, seed=1, count=0.0, strokes=STROKES, repeats=2):
    """Time, position and force; the noise has this correlation from sample to sample."""
    dense = cosines(strokes, repeats, PERIOD / FINE)
    force, x = friction_along(truth, dense, PERIOD / FINE)[::FINE], dense[::FINE]
    draw = np.random.default_rng(seed).standard_normal(len(x))
    wander = [0.0]
    for e in draw[1:]:
        wander.append(colour * wander[-1] + np.sqrt(1.0 - colour**2) * e)
    t = PERIOD * np.arange(len(x))
    return t, x if count == 0.0 else np.round(x / count) * count, force + noise * np.array(wander)
