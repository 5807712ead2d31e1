"""Predictors beside GM(1,1), on the same window of five: straight lines, DGM(1,1), Verhulst, residual correction."""

from __future__ import annotations

import math

from leadscrew.grey.gm11 import SINGULAR, decay, phi

STEEPEST = 0.1
"""A Verhulst curve that grows more than tenfold within the horizon, or passes infinity, is not believed."""


def two_point(window, horizon):
    """The line through the last two samples."""
    return window.y4 + horizon * (window.y4 - window.y3)


def line(window, horizon):
    """The least squares line through the last four samples, ``horizon`` samples after the newest.

    One sample ahead it is ``y4 + y3/2 - y1/2``: what GM(1,1) becomes where the offset is large and the variation small.
    """
    slope = (1.5 * (window.y4 - window.y1) + 0.5 * (window.y3 - window.y2)) * 0.2
    return 0.25 * ((window.y1 + window.y2) + (window.y3 + window.y4)) + slope * (1.5 + horizon)


def fir(window):
    """The fixed filter that GM(1,1) is near a set-point, one sample ahead: ``y4 + (y3 - y1) / 2``."""
    return window.y4 + 0.5 * (window.y3 - window.y1)


def dgm(window, horizon):
    """DGM(1,1): least squares of y1(j) = b y1(j-1) + d over the running sums, j = 1..4 (Xie, Liu 2009).

    y(4 + h) = ((b - 1) y(0) + d) b^(3 + h). Singular sums, or a ratio b that is not positive: the last sample.
    """
    x0 = window.y0
    x1, x2 = x0 + window.y1, x0 + window.y1 + window.y2
    x3 = x2 + window.y3
    # The new sample against the old sum: slope b - 1, intercept d.
    x_mean = 0.25 * ((x0 + x1) + (x2 + x3))
    y_mean = 0.25 * ((window.y1 + window.y2) + (window.y3 + window.y4))
    d0, d1, d2, d3 = x0 - x_mean, x1 - x_mean, x2 - x_mean, x3 - x_mean
    spread = (d0 * d0 + d1 * d1) + (d2 * d2 + d3 * d3)
    singular = spread <= SINGULAR * ((x0 * x0 + x1 * x1) + (x2 * x2 + x3 * x3))
    along = (d0 * (window.y1 - y_mean) + d1 * (window.y2 - y_mean)) + (
        d2 * (window.y3 - y_mean) + d3 * (window.y4 - y_mean)
    )
    slope = 0.0 if singular else along / (1.0 if singular else spread)
    fits = not singular and slope > -1.0
    held = slope if fits else 0.0
    value = (y_mean + held * (x0 - x_mean)) * decay(-(3.0 + horizon) * math.log1p(held))
    return value if fits else window.y4


def verhulst(window, horizon):
    """The grey Verhulst model: growth towards a limit, dy/dt + a y = b y^2.

    The samples themselves are its sums (they rise towards a limit as sums of an S-shaped series do), so that their
    differences d and means m of neighbours give d + a m = b m^2 by least squares over the four intervals. From the
    newest sample on the curve is

        y(4 + h) = y4 / (exp(a h) - b y4 h phi(a h))

    Equal samples, no growth to fit: the last sample; also where the curve grows more than tenfold within the horizon or
    passes infinity.
    """
    m1, m2 = 0.5 * (window.y0 + window.y1), 0.5 * (window.y1 + window.y2)
    m3, m4 = 0.5 * (window.y2 + window.y3), 0.5 * (window.y3 + window.y4)
    w1, w2, w3, w4 = m1 * m1, m2 * m2, m3 * m3, m4 * m4
    weight = (w1 + w2) + (w3 + w4)
    nothing = weight <= 0.0
    over = 1.0 / (1.0 if nothing else weight)
    m_mean = ((w1 * m1 + w2 * m2) + (w3 * m3 + w4 * m4)) * over
    p1, p2 = m1 * (window.y1 - window.y0), m2 * (window.y2 - window.y1)
    p3, p4 = m3 * (window.y3 - window.y2), m4 * (window.y4 - window.y3)
    rate_mean = ((p1 + p2) + (p3 + p4)) * over
    e1, e2, e3, e4 = m1 - m_mean, m2 - m_mean, m3 - m_mean, m4 - m_mean
    spread = (w1 * e1 * e1 + w2 * e2 * e2) + (w3 * e3 * e3 + w4 * e4 * e4)
    singular = nothing or spread <= SINGULAR * ((w1 * w1 + w2 * w2) + (w3 * w3 + w4 * w4))
    along = (e1 * p1 + e2 * p2) + (e3 * p3 + e4 * p4)
    b = 0.0 if singular else along / (1.0 if singular else spread)
    a = b * m_mean - rate_mean
    ratio = decay(-a * horizon) - b * window.y4 * horizon * phi(a * horizon)
    steady = not singular and ratio >= STEEPEST
    return window.y4 / (ratio if steady else 1.0)


def residual(window, c, u, horizon):
    """What is to be added to GM(1,1) with c and u: a second GM(1,1) of its residuals.

    The second one is fitted to the sizes of the four residuals e(1..4) of the window, has the sign of the newest and is
    held to the largest: residuals are mostly noise, and a grey model of noise can run away.
    """
    start = (u - c * window.y0) * phi(c)
    e1, e2 = window.y1 - start * decay(c), window.y2 - start * decay(2.0 * c)
    e3, e4 = window.y3 - start * decay(3.0 * c), window.y4 - start * decay(4.0 * c)
    r1, r2, r3, r4 = abs(e1), abs(e2), abs(e3), abs(e4)
    z1, z2, z3 = r1 + 0.5 * r2, r1 + r2 + 0.5 * r3, r1 + r2 + r3 + 0.5 * r4
    z_mean, r_mean = (z1 + z2 + z3) / 3.0, (r2 + r3 + r4) / 3.0
    d1, d2, d3 = z1 - z_mean, z2 - z_mean, z3 - z_mean
    spread = d1 * d1 + d2 * d2 + d3 * d3
    singular = spread <= SINGULAR * (z1 * z1 + z2 * z2 + z3 * z3)
    along = d1 * (r2 - r_mean) + d2 * (r3 - r_mean) + d3 * (r4 - r_mean)
    k = 0.0 if singular else -along / (1.0 if singular else spread)
    v = r_mean + k * z_mean
    size = (v - k * r1) * phi(k) * decay(k * (3.0 + horizon))
    held = min(max(size, 0.0), max(max(r1, r2), max(r3, r4)))
    return (r4 if singular else held) * (1.0 if e4 >= 0.0 else -1.0)
