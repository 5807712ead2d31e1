"""A made tribometer log with a known friction: what ``leadscrew identify friction-force FILE --example`` writes."""

from __future__ import annotations

import numpy as np

from leadscrew.friction.asymmetric import TwoSidedLuGre
from leadscrew.friction.static_map import Sliding

TRUTH = TwoSidedLuGre(
    stiffness=2.0e5, damping=300.0, forward=Sliding(3.0, 4.5, 4e-4, 120.0), backward=Sliding(2.6, 4.0, 4e-4, 120.0)
)
"""The friction of the example."""
PERIOD, COUNT, NOISE = 0.004, 2e-8, 0.02
"""s; m; N."""
FINE = 10
"""Steps of the simulation in a period of the log."""
STROKES = ((0.4e-3, 1.6), (0.4e-3, 0.8), (0.05e-3, 0.4), (0.2e-3, 3.0), (1.0e-3, 0.4), (0.03e-3, 0.1))
"""Amplitude (m) and period (s) of the cosine strokes, in turn; twice."""


def example_path(step: float) -> np.ndarray:
    """True position, m, every ``step`` seconds: strokes fast and slow, wide and inside the travel before sliding."""
    pieces = [np.zeros(round(0.4 / step))]
    for wide, long in STROKES * 2:
        t = np.arange(round(3.0 * long / step)) * step
        pieces += [0.5 * wide * (1.0 - np.cos(2.0 * np.pi * t / long)), np.zeros(round(0.2 / step))]
    return np.concatenate(pieces)


def example_arrays(seed: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time (s), position (m) in counts of 20 nm, friction force (N) with noise."""
    from leadscrew.analysis.friction import friction_along

    dense = example_path(PERIOD / FINE)
    force, x = friction_along(TRUTH, dense, PERIOD / FINE)[::FINE], dense[::FINE]
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(x))
    return PERIOD * np.arange(len(x)), np.round(x / COUNT) * COUNT, force + noise


def example_text() -> str:
    """The file."""
    t, x, force = example_arrays()
    f = TRUTH.forward
    lines = [
        "# Made, not measured: LuGre friction of a stage moved by hand-set strokes; position in counts of 20 nm.",
        f"# stiffness {TRUTH.stiffness:g} N/m, damping {TRUTH.damping:g} N s/m, viscous {f.viscous:g} N s/m, Stribeck "
        f"speed {f.stribeck_speed:g} m/s,",
        f"# Coulomb {f.coulomb:g} N forward and {TRUTH.backward.coulomb:g} N backward, static {f.static:g} N and "
        f"{TRUTH.backward.static:g} N; noise {NOISE:g} N",
        "Time [s],Position [um],Friction [N]",
    ]
    rows = zip(t.tolist(), (1e6 * x).tolist(), force.tolist(), strict=True)
    return "\n".join([*lines, *(f"{a:.3f},{b:.2f},{c:.4f}" for a, b, c in rows)]) + "\n"
