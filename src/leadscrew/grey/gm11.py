"""GM(1,1) of five samples: the grey model of first order in one variable, as step functions.

With j = 0 for the oldest sample, y1(j) the running sum of the samples and z(j) = (y1(j) + y1(j-1)) / 2, least
squares over j = 1..4 fits

    y(j) + c z(j) = u                                                     (5), (7)

in the centred form c = -sum((z - z_mean)(y - y_mean)) / sum((z - z_mean)^2), u = y_mean + c z_mean, which loses far
fewer digits than the closed form (8). The value h samples after the newest is

    y(4 + h) = (u - c y(0)) phi(c) exp(-c (4 + h)),  phi(c) = (exp(c) - 1) / c, phi(0) = 1

This is (9) and (12) without their division by c: at c = 0 it is u, the mean of the last four samples.

Source: the paper of the study grey_turning, equations (2) to (12); the sign of its (11) is wrong, see
:func:`as_printed`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.parameters import Doc, Unit

SINGULAR = 1e-12
"""Spread of z, of the sum of z^2, below which no line has a slope (zeros and alternating samples)."""
MOST = 300.0
"""Exponents are held within this, so that a window out of all reason gives a huge number and not infinity."""
NEAR = 1e-8
"""Below this phi(c) is 1 + c / 2 to the last digit."""


class Grey(NamedTuple):
    """A fitted model."""

    c: Annotated[float, Unit("1/sample"), Doc("development coefficient: negative while the signal grows")] = 0.0
    u: Annotated[float, Doc("grey input, in the unit of the signal")] = 0.0
    singular: Annotated[bool, Doc("nothing could be fitted: c is 0 and u the last sample")] = True


def phi(c):
    """``(exp(c) - 1) / c`` without a singularity."""
    held = min(max(c, -MOST), MOST)
    small = abs(held) < NEAR
    return 1.0 + 0.5 * held if small else math.expm1(held) / (1.0 if small else held)


def decay(exponent):
    """``exp(-exponent)``, the exponent held within :data:`MOST`."""
    return math.exp(-min(max(exponent, -MOST), MOST))


def fit(window):
    """The model of a full window; of a singular one the model that gives its last sample."""
    z1 = window.y0 + 0.5 * window.y1
    z2 = window.y0 + window.y1 + 0.5 * window.y2
    z3 = window.y0 + window.y1 + window.y2 + 0.5 * window.y3
    z4 = window.y0 + window.y1 + window.y2 + window.y3 + 0.5 * window.y4
    # Added by pairs: four equal samples then have exactly their value as mean.
    z_mean = 0.25 * ((z1 + z2) + (z3 + z4))
    y_mean = 0.25 * ((window.y1 + window.y2) + (window.y3 + window.y4))
    d1, d2, d3, d4 = z1 - z_mean, z2 - z_mean, z3 - z_mean, z4 - z_mean
    spread = (d1 * d1 + d2 * d2) + (d3 * d3 + d4 * d4)
    singular = spread <= SINGULAR * ((z1 * z1 + z2 * z2) + (z3 * z3 + z4 * z4))
    along = (d1 * (window.y1 - y_mean) + d2 * (window.y2 - y_mean)) + (
        d3 * (window.y3 - y_mean) + d4 * (window.y4 - y_mean)
    )
    c = 0.0 if singular else -along / (1.0 if singular else spread)
    return Grey(c, window.y4 if singular else y_mean + c * z_mean, singular)


def ahead(window, grey, horizon):
    """What the model says ``horizon`` samples after the newest: 1 is the next one, 0 the fit of the newest itself."""
    return (grey.u - grey.c * window.y0) * phi(grey.c) * decay(grey.c * (4.0 + horizon))


def as_printed(window, grey, horizon):
    """Equation (11) to the letter: ``(1 - exp(-c)) (y(0) - u/c) exp(-c k)``, k = 3 + h.

    A documented error: it is minus the value of (9) and (12). Of a singular window: the last sample.
    """
    value = (grey.c * window.y0 - grey.u) * phi(-grey.c) * decay(grey.c * (3.0 + horizon))
    return window.y4 if grey.singular else value


def derivative(window, grey, horizon):
    """The reading of (11) as what its text calls it, the derivative of (9): ``(u - c y(0)) exp(-c t)``, t = 4 + h.

    ``horizon`` 0.5 takes it in the middle of the next interval, where it comes nearest to the difference.
    """
    return (grey.u - grey.c * window.y0) * decay(grey.c * (4.0 + horizon))


def exponential(window, grey, horizon):
    """The model with its bias removed: a = ln((2 + c) / (2 - c)) in the exponentials, u/c kept.

    Samples of an exact exponential have c = 2 tanh(a/2), so that this is exact on them. No exponential has a c
    outside (-2, 2): the last sample.
    """
    fits = abs(grey.c) < 2.0
    c = grey.c if fits else 0.0
    rate = math.log1p(2.0 * c / (2.0 - c))
    value = (grey.u - c * window.y0) * (2.0 / (2.0 - c)) * decay(rate * (4.0 + horizon))
    return value if fits else window.y4
