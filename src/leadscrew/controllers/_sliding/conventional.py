"""Conventional sliding mode with a boundary layer.

    s = e' + lam e
    u = y_r'' - lam e' - K sat(s / phi)
    T = F_hat + J u

Changes against Shams and Safdari (2010), and nothing else: the surface (8) and the terms of (10) have no integral,
because the paper's claims (a steady error under SMC, half of it under CSMC) hold for this law and not for the printed
one (:mod:`leadscrew.controllers._sliding.integral`). ``s' = e'' + lam e'`` gives the terms of ``u``. All else, the
readings of f_hat and the sampled form: :mod:`leadscrew.controllers._sliding.stage`.

``|s| <= phi`` means ``|e| <= phi / lam``. Defaults: lam and eta as printed, ``layer_rate`` 4000 (ours) so that the law
is stable when sampled at 4 kHz. ``layer_rate = 0`` takes the printed ``phi = 0.1``: that is the ``corrected.smc`` of
the study ``fsmc_ballscrew``.

Bumpless start: bristles preset so that the first output is the last one; from rest, and as far as static friction
holds.
"""

from __future__ import annotations

from leadscrew.controllers._sliding.stage import SlidingParams, SlidingState, ended, holding, sat, standing, view
from leadscrew.kernel.block import controller


def surface(p, now):
    """``s``."""
    return now.rate + p.lam * now.e


def law(p, now):
    """``u``."""
    switching = now.gain * sat(now.slope * surface(p, now) / now.gain)
    return now.acceleration - p.lam * now.rate - switching


def align(params, command, feedback, output):
    """The state from which the next output is ``output``, at rest."""
    now = standing(params, command, feedback, 0.0)
    return holding(params, now, surface(params, now), output - params.inertia * law(params, now))


@controller(SlidingParams(layer_rate=4000.0), SlidingState(), align=align, unit="N m", drive="torque")
def smc(p, s, command, feedback, dt):
    """Conventional sliding mode with a boundary layer, for a stage with LuGre friction; a torque."""
    now = view(p, s, command, feedback, dt)
    return ended(p, s, now, surface(p, now), law(p, now))
