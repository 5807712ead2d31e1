"""Friction of a believed LuGre model, as the feed-forward of a sampled controller.

The torque is held over a period in which the bristles may bend and slip many times, so what a period needs is the
*mean* friction over it. With the speed known at the sample and its slope, ``v(tau) = v + a tau``:

1. the period is cut into ``pieces`` of ``h = dt / pieces``; in each the speed is constant, the one at its middle, and
   the deflection moves by the exact solution of (1): stable at any speed and period;
2. ``mean F = s0 mean z + s1 (z_end - z_start) / dt + s2 mean v``, with ``z`` by the trapezoid rule.

With ``pieces = 0`` it is the friction at the sample itself.
"""

from __future__ import annotations

from typing import NamedTuple

from leadscrew.friction.lugre import bristle_after, bristle_rate


class Held(NamedTuple):
    """Friction torque to hold over a period, and the bristles at its end."""

    torque: float
    bristle: float


def held_friction(f, z, v, a, damped, pieces, dt):
    """What the bristles at ``z`` resist with over the coming period; ``damped`` 0 leaves ``s1 dz/dt`` out."""
    damping = damped * f.damping
    if pieces > 0:
        h = dt / pieces
        end = z
        total = 0.0
        for i in range(pieces):
            now = v + a * h * (i + 0.5)
            start = end
            end = bristle_after(f, now, start, h)
            total = total + f.stiffness * 0.5 * (start + end) + f.viscous * now
        return Held(total / pieces + damping * (end - z) / dt, end)
    at_once = f.stiffness * z + damping * bristle_rate(f, v, z) + f.viscous * v
    return Held(at_once, bristle_after(f, v + 0.5 * a * dt, z, dt))
