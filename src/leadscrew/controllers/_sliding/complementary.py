"""Complementary sliding mode: equations (8) to (10), (14) and (15) for n = 2.

    s   = e' + 2 lam e + lam^2 xi,      s_c = (d/dt + lam) (d/dt - lam) xi = e' - lam^2 xi          (8), (14)
    u   = y_r'' - 3 lam e' - 3 lam^2 e - lam^3 xi - K sat((s + s_c) / phi)                          (10), (15)
    T   = F_hat + J u

Source: Shams and Safdari (2010), after C. Y. Liang and J. P. Su (2003). ``s + s_c = 2 (e' + lam e)`` has no integral,
``s - s_c = 2 lam (e + lam xi)``. ``|s + s_c| <= phi`` means ``|e| <= phi / (2 lam)``, half the bound of smc: (16).
The readings of f_hat and the sampled form: :mod:`leadscrew.controllers._sliding.stage`.

Defaults: ``lam = 150, eta = 20`` as printed, ``layer_rate`` 2000 (ours): the switching term acts on twice ``e'``, so
that the loop is as fast as the conventional one at 4000. ``layer_rate = 0`` takes the printed ``phi = 0.1``: that is
the ``paper.csmc`` of the study ``fsmc_ballscrew``.

Bumpless start: ``xi = -2 e / lam``, so that ``s = 0``, and bristles preset so that the first output is the last one;
from rest, and as far as static friction holds.
"""

from __future__ import annotations

from leadscrew.controllers._sliding.integral import equivalent
from leadscrew.controllers._sliding.stage import SlidingParams, SlidingState, ended, holding, sat, standing, view
from leadscrew.kernel.block import controller


def surface(p, now):
    """``s + s_c``."""
    return 2.0 * (now.rate + p.lam * now.e)


def law(p, now):
    """``u``, (9) with (15)."""
    return equivalent(p, now) - now.gain * sat(now.slope * surface(p, now) / now.gain)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``, at rest, with ``s = 0``."""
    now = standing(params, command, feedback, -2.0 / params.lam)
    return holding(params, now, surface(params, now), output - params.inertia * law(params, now))


@controller(SlidingParams(eta=20.0, layer_rate=2000.0), SlidingState(), align=align, unit="N m", drive="torque")
def csmc(p, s, command, feedback, dt):
    """Complementary sliding mode, for a stage with LuGre friction; a torque."""
    now = view(p, s, command, feedback, dt)
    return ended(p, s, now, surface(p, now), law(p, now))
