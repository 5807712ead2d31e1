"""Sliding mode with an integral surface, as printed: equations (8) to (11) for n = 2.

    s = (d/dt + lam)^2 xi = e' + 2 lam e + lam^2 xi,      xi = integral of e                    (8)
    u = y_r'' - 3 lam e' - 3 lam^2 e - lam^3 xi - K sat(s / phi)                                (9), (10), (11)
    T = F_hat + J u

Source: Shams and Safdari (2010), with x_d of (10) read as y_r. Unlike the paper's figures it leaves no steady error;
the law that does is :mod:`leadscrew.controllers._sliding.conventional`. The readings of f_hat and the sampled form:
:mod:`leadscrew.controllers._sliding.stage`.

Defaults: ``lam = 150, eta = 120`` as printed, ``layer_rate`` 4000 (ours) so that the law is stable when sampled at
4 kHz. ``layer_rate = 0`` takes the printed ``phi = 0.1``: that is the ``paper.smc_integral`` of the study
``fsmc_ballscrew``.

Bumpless start: ``xi = -2 e / lam``, so that ``s = 0``, and bristles preset so that the first output is the last one;
from rest, and as far as static friction holds.
"""

from __future__ import annotations

from leadscrew.controllers._sliding.stage import SlidingParams, SlidingState, ended, holding, sat, standing, view
from leadscrew.kernel.block import controller


def surface(p, now):
    """``s``, (8)."""
    return now.rate + 2.0 * p.lam * now.e + p.lam * p.lam * now.xi


def equivalent(p, now):
    """``y_r'' - 3 lam e' - 3 lam^2 e - lam^3 xi``: (10) without f_hat."""
    return now.acceleration - p.lam * (3.0 * now.rate + p.lam * (3.0 * now.e + p.lam * now.xi))


def law(p, now):
    """``u``, (9)."""
    return equivalent(p, now) - now.gain * sat(now.slope * surface(p, now) / now.gain)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``, at rest, with ``s = 0``."""
    now = standing(params, command, feedback, -2.0 / params.lam)
    return holding(params, now, surface(params, now), output - params.inertia * law(params, now))


@controller(SlidingParams(layer_rate=4000.0), SlidingState(), align=align, unit="N m", drive="torque")
def smc_integral(p, s, command, feedback, dt):
    """Sliding mode with an integral surface, the printed law, for a stage with LuGre friction; a torque."""
    now = view(p, s, command, feedback, dt)
    return ended(p, s, now, surface(p, now), law(p, now))
