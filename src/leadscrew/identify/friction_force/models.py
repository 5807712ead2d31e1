"""The friction force of each model along a measured motion, computed for all samples.

LuGre, of :mod:`leadscrew.friction.lugre`, with values for each direction. The speed, and with it the steady deflection
``z_s = sgn(d) g(v) / sigma_0``, changes evenly over the travel ``d`` from one sample to the next, and with
``a = abs(d) sigma_0 / g`` (``g`` the mean of both ends) the bristles go exactly

    z_1 = z_s1 + (z_0 - z_s0) exp(-a) - (z_s1 - z_s0) (1 - exp(-a)) / a
    F   = sigma_0 z + sigma_1 (v - abs(v) z sigma_0 / g(v)) + sigma_2 v

Dahl, of :mod:`leadscrew.friction.dahl`: its exact solution over the whole travel since a reversal. Maxwell slip, of
:mod:`leadscrew.friction.maxwell_slip`, without a Stribeck map (``F_S = F_C``): each element is a spring that yields
after its own travel ``d_i`` and slips with its share of the force,

    u_i' = min(max(u_i + d, -d_i), d_i)          F = sum w_i u_i / d_i

which is linear in ``w_i``. All three depend on the travel and not on the time, so gaps and uneven steps do no harm.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from leadscrew.friction.asymmetric import TwoSidedLuGre
from leadscrew.friction.dahl import Dahl
from leadscrew.friction.lugre import FAR
from leadscrew.friction.static_map import Sliding, TwoSided
from leadscrew.identify.friction_force.record import ForceRecord


class Motion(Protocol):
    """What LuGre needs of a record, or of a part of one."""

    @property
    def travel(self) -> np.ndarray:
        """From the sample before."""
        ...

    @property
    def speed(self) -> np.ndarray:
        """At the sample."""
        ...

    @property
    def way(self) -> np.ndarray:
        """Sign of the motion, or of the last one."""
        ...


def levels(f: TwoSided | TwoSidedLuGre, speed: np.ndarray, way: np.ndarray) -> np.ndarray:
    """``g(v)`` of the direction ``way``, in N."""
    out = np.empty(len(speed))
    for side, rows in ((f.forward, way >= 0.0), (f.backward, way < 0.0)):
        ratio = np.minimum((speed[rows] / side.stribeck_speed) ** 2, FAR)
        out[rows] = side.coulomb + (side.static - side.coulomb) * np.exp(-ratio)
    return out


def viscous_of(f: TwoSided | TwoSidedLuGre, way: np.ndarray) -> np.ndarray:
    """Viscous coefficient of the direction."""
    return np.where(way >= 0.0, f.forward.viscous, f.backward.viscous)


def map_force(f: TwoSided, record: ForceRecord) -> np.ndarray:
    """A static map along the motion; at rest the friction of the last motion is held, before the first none."""
    way = record.way
    moved = np.where(record.travel != 0.0, np.arange(len(way)), -1)
    speed = record.speed[np.maximum(np.maximum.accumulate(moved), 0)]
    return way * levels(f, speed, way) + viscous_of(f, way) * record.speed


def lugre_force(f: TwoSidedLuGre, record: Motion, start: float = 0.0) -> np.ndarray:
    """Force at every sample; ``start`` is the force that the bristles hold at the first one."""
    d, v, way = record.travel, record.speed, record.way
    before, level = levels(f, np.concatenate([v[:1], v[:-1]]), way), levels(f, v, way)
    a = np.minimum(2.0 * np.abs(d) * f.stiffness / (before + level), FAR)
    stay = np.exp(-a)
    lag = np.where(a > 0.0, -np.expm1(-a) / np.maximum(a, 1e-300), 1.0)
    # z_1 = stay z_0 + towards
    towards = np.sign(d) / f.stiffness * (level - before * stay - (level - before) * lag)
    most = min(f.forward.static, f.backward.static)
    z, deflections = min(max(start, -most), most) / f.stiffness, []
    for keep, gain in zip(stay.tolist(), towards.tolist(), strict=True):
        z = keep * z + gain
        deflections.append(z)
    bent = np.array(deflections)
    rate = v - np.abs(v) * bent * f.stiffness / level
    return f.stiffness * bent + f.damping * rate + viscous_of(f, way) * v


def dahl_force(f: Dahl, record: ForceRecord, start: float = 0.0) -> np.ndarray:
    """Force, ``start`` at the first sample; no offset."""
    strokes, travelled, way = record.strokes, record.since_reversal, record.way
    out, force = np.empty(len(strokes)), min(max(start, -f.coulomb), f.coulomb)
    edges = np.searchsorted(strokes, np.arange(strokes[-1] + 2))
    for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        side = float(way[b - 1])
        out[a:b] = _dahl_after(f, side, travelled[a:b], force)
        force = float(out[b - 1])
    return out + f.viscous * record.speed


def _dahl_after(f: Dahl, side: float, way: np.ndarray, force: float) -> np.ndarray:
    """:func:`leadscrew.friction.dahl.force_after` for many travels from one force."""
    base, a = 1.0 - side * force / f.coulomb, f.stiffness * way / f.coulomb
    if f.exponent == 1.0:
        left = abs(base) * np.exp(-np.minimum(a, FAR))
    else:
        bent = 1.0 - f.exponent
        rest = np.maximum(max(abs(base), 1e-15) ** bent - bent * a, 1e-300)
        left = np.where((bent > 0.0) & (rest <= 1e-300), 0.0, rest ** (1.0 / bent))
    return side * f.coulomb * (1.0 - np.copysign(left, base)) if side else np.full(len(way), force)


def stops(record: ForceRecord, yields: np.ndarray) -> np.ndarray:
    """Deflection of each element as a share of the travel at which it yields; one column each, unloaded at first."""
    out = np.empty((len(record.travel), len(yields)))
    u = np.zeros(len(yields))
    out[0] = u
    moved = np.flatnonzero(record.travel)
    last = 0
    for k in moved.tolist():
        out[last:k] = u
        u = np.minimum(np.maximum(u + record.travel[k], -yields), yields)
        last = k
    out[last:] = u
    return out / yields


def one_sided(coulomb: float, drop: float, speed: float, viscous: float) -> Sliding:
    """Values of one direction; ``drop`` is ``F_S - F_C``."""
    return Sliding(coulomb, coulomb + drop, speed, viscous)
