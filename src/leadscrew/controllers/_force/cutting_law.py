"""What is believed of a cut: a power law in logarithms, two numbers with their covariance, corrected by each reading.

    ln F = ln b + L + P ln(h / h0)                          L: ln of N per mm of depth at the chip h0;  P: exponent
    nu = ln(F / F_hat),      R = (noise_n / F_hat)^2 + floor^2 + (P slack (F - F(theta - 1)) / (stiffness h))^2
    (L, P) += C H nu / (H' C H + R),      C -= C H H' C / (H' C H + R),      H = (1, ln(h / h0))

a Kalman filter: in logarithms the law is a straight line, so a material far from the belief is found in one step. ``R``
holds the load cell's noise, what repeats itself each revolution (runout), and what is not known of the compliance,
which opens the chip only while the force changes. In every period ``C[L, L]`` gains ``drift``; where
``nu^2 > 9 (H' C H + R)`` it gains ``jump``: a hard spot, or a depth that is not the programmed one. ``L`` stays within
:data:`MOST` of its prior and ``P`` within :data:`LEAST_P` to 1, so that a broken load cell cannot ask for any feed.

Source: ours, for the study ``grey_turning``; the Kalman filter of one state is
:mod:`leadscrew.controllers.power_law_inversion`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

MOST = 1.4
"""Farthest that L goes from its prior: a factor of four in the force."""
LEAST_P = 0.5
OPENS = 9.0
"""Square of the innovation over its variance from which the estimate is opened: three standard deviations."""
LOWEST, HIGHEST = -1.8, 2.0
"""Ends of the innovation that counts."""


class Belief(NamedTuple):
    """The prior of material and force, and how it is given up."""

    force_per_mm: Annotated[float, Unit("N/mm"), Gt(0), Doc("force per depth of cut at the chip chip_mm")] = 150.0
    exponent: Annotated[float, Gt(0), Le(1), Doc("P")] = 0.8
    chip_mm: Annotated[float, Unit("mm"), Gt(0), Doc("chip thickness h0 of force_per_mm")] = 0.0296
    spread: Annotated[float, Ge(0), Doc("standard deviation of ln of force_per_mm")] = 0.4
    exponent_spread: Annotated[float, Ge(0), Doc("standard deviation of the exponent")] = 0.09
    stiffness: Annotated[float, Unit("N/mm"), Gt(0), Doc("of tool and work along the feed, per main force")] = 20000.0
    slack: Annotated[float, Ge(0), Doc("relative uncertainty of it")] = 0.5
    noise_n: Annotated[float, Unit("N"), Gt(0), Doc("scatter of one reading of the force")] = 3.0
    floor: Annotated[float, Ge(0), Doc("relative scatter of the force within a revolution")] = 0.02
    drift: Annotated[float, Ge(0), Doc("variance that ln of the force gains in a period")] = 2e-4
    jump: Annotated[float, Ge(0), Doc("the same where the force surprises")] = 0.02
    min_chip_mm: Annotated[float, Unit("mm"), Gt(0), Doc("chip below which nothing is learned")] = 0.001
    min_force: Annotated[float, Unit("N"), Ge(0), Doc("filtered force below which nothing is learned")] = 5.0


class Law(NamedTuple):
    """What is known, and how well."""

    level: Annotated[float, Doc("L")] = 0.0
    exponent: Annotated[float, Doc("P")] = 0.8
    level_level: Annotated[float, Doc("variance of L")] = 0.0
    level_exponent: Annotated[float, Doc("covariance of both")] = 0.0
    exponent_exponent: Annotated[float, Doc("variance of P")] = 0.0


def prior(b):
    """The law before the first reading."""
    return Law(math.log(b.force_per_mm), b.exponent, b.spread * b.spread, 0.0, b.exponent_spread * b.exponent_spread)


def learned(b, s, depth, feed, force, force_before, filtered):
    """The law after one reading: feed per revolution in mm, force now and one revolution ago, and filtered."""
    change = force - force_before
    chip = feed - change / b.stiffness
    thick = max(chip, b.min_chip_mm)
    x = math.log(thick / b.chip_mm)
    expected = depth * math.exp(s.level + s.exponent * x)
    surprise = min(max(math.log(max(force, 1e-9) / expected), LOWEST), HIGHEST)
    noise = b.noise_n / expected
    yields = s.exponent * b.slack * change / (b.stiffness * thick)
    scatter = noise * noise + b.floor * b.floor + yields * yields
    a = s.level_level + b.drift
    spread = a + 2.0 * x * s.level_exponent + x * x * s.exponent_exponent + scatter
    opened = a + (b.jump if surprise * surprise > OPENS * spread else 0.0)
    g = opened + x * s.level_exponent
    h = s.level_exponent + x * s.exponent_exponent
    total = g + x * h + scatter
    start = math.log(b.force_per_mm)
    level = min(max(s.level + g / total * surprise, start - MOST), start + MOST)
    exponent = min(max(s.exponent + h / total * surprise, LEAST_P), 1.0)
    cut = chip > b.min_chip_mm and filtered > b.min_force
    return Law(
        level if cut else s.level,
        exponent if cut else s.exponent,
        opened - g * g / total if cut else s.level_level,
        s.level_exponent - g * h / total if cut else s.level_exponent,
        s.exponent_exponent - h * h / total if cut else s.exponent_exponent,
    )


def feed_for(b, s, force, depth, caution, known, chip=0.0, exponent_caution=0.0):
    """Feed per revolution in mm that gives a force: ``h0 (F / (b e^L))^(1/P)``, less where little is known.

    From ``chip``, up to which the law is trusted, only the part ``1 / (1 + exponent_caution sigma_P / P)`` of the way
    is gone, in logarithms: an exponent that is too small asks for far too much feed in soft material. It is also
    divided by ``e^(caution max(sigma - known, 0) / P)``; ``sigma``: standard deviation of ln of the force.
    """
    right = (math.log(max(force, 1e-9) / depth) - s.level) / s.exponent
    seen = math.log(max(chip, b.min_chip_mm) / b.chip_mm)
    less = 1.0 + exponent_caution * math.sqrt(max(s.exponent_exponent, 0.0)) / s.exponent
    x = seen + (right - seen) / less if right > seen else right
    variance = s.level_level + 2.0 * x * s.level_exponent + x * x * s.exponent_exponent
    doubt = max(math.sqrt(max(variance, 0.0)) - known, 0.0)
    return b.chip_mm * math.exp(min(x - caution * doubt / s.exponent, 10.0))
