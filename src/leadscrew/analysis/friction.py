"""Friction models without a mass: the steady curve, and the force along an imposed path.

A friction is the parameters of a model of :mod:`leadscrew.friction`. Forces are those that the friction puts against a
positive motion. Experiments with a mass: :mod:`leadscrew.analysis.friction_runs`.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from leadscrew.friction import dahl, lugre, maxwell_slip
from leadscrew.friction.asymmetric import TwoSidedLuGre, one_way_lugre
from leadscrew.friction.static_map import TwoSided, sliding_friction
from leadscrew.kernel.errors import ValueRefused


def friction_velocity(f: Any, speeds: Any) -> np.ndarray:
    """Friction in steady sliding at each speed; 0 at rest, where a static map has a jump."""
    speeds = np.asarray(speeds, dtype=float)
    return np.array([_steady(f, float(v)) for v in speeds.ravel()]).reshape(speeds.shape)


def _steady(f: Any, v: float) -> float:
    if isinstance(f, TwoSided | TwoSidedLuGre):
        return float(sliding_friction(f, v))
    if isinstance(f, dahl.Dahl):
        return float(np.sign(v) * f.coulomb + f.viscous * v)
    return float(np.sign(v) * lugre.level(f, v) + f.viscous * v)


def friction_along(f: Any, positions: Any, dt: float) -> np.ndarray:
    """Friction at each sample of an imposed path, from rest without force.

    The speed is constant between samples; a sample has the speed with which it was reached.

    Raises:
        ValueRefused: a static map, which has no friction before sliding; elements that make no sense; no path or time.
    """
    positions = np.asarray(positions, dtype=float)
    if positions.ndim != 1 or positions.size == 0 or not np.isfinite(positions).all():
        raise ValueRefused(f"positions of shape {positions.shape}: a path is one row of finite numbers, at least one")
    positive("dt", dt)
    speeds = np.diff(positions) / dt
    if isinstance(f, dahl.Dahl):
        forces = _along_dahl(f, speeds, dt)
    elif isinstance(f, maxwell_slip.MaxwellSlip | maxwell_slip.MaxwellSlipScrew):
        forces = _along_elements(maxwell_slip.checked(f), speeds, dt)
    elif hasattr(f, "stiffness"):
        forces = _along_lugre(f, speeds, dt)
    else:
        raise ValueRefused(
            f"{type(f).__name__} has no friction before sliding; a path needs Dahl, LuGre or MaxwellSlip"
        )
    return np.array([0.0, *forces])


def _along_dahl(f: Any, speeds: np.ndarray, dt: float) -> list[float]:
    force, out = 0.0, []
    for v in speeds.tolist():
        force = dahl.force_after(f, v * dt, force)
        out.append(force + f.viscous * v)
    return out


def _along_lugre(f: Any, speeds: np.ndarray, dt: float) -> list[float]:
    z, out = 0.0, []
    for v in speeds.tolist():
        now = one_way_lugre(f, v) if isinstance(f, TwoSidedLuGre) else f
        z = lugre.bristle_after(now, v, z, dt)
        out.append(lugre.friction(now, v, z, lugre.bristle_rate(now, v, z)))
    return out


def _along_elements(
    f: maxwell_slip.MaxwellSlip | maxwell_slip.MaxwellSlipScrew, speeds: np.ndarray, dt: float
) -> list[float]:
    e, out = maxwell_slip.unloaded(f), []
    share_of_damping = f.damping / maxwell_slip.total_stiffness(f)
    for v in speeds.tolist():
        e = maxwell_slip.move_elements(f, e, v, dt)
        damping = share_of_damping * maxwell_slip.stuck_stiffness(f, e) + f.viscous
        out.append(maxwell_slip.elements_force(e) + damping * v)
    return out


def path_through(points: Sequence[float], step: float) -> np.ndarray:
    """Positions from point to point in equal steps of about ``step``; each point is met exactly."""
    parts = [np.asarray(points[:1], dtype=float)]
    for a, b in pairwise(points):
        n = max(1, round(abs(b - a) / step))
        parts.append(a + (b - a) * np.arange(1, n + 1) / n)
    return np.concatenate(parts)


def positive(name: str, *values: float) -> None:
    """Refuses values that are not positive and finite."""
    for value in values:
        if not 0.0 < value < np.inf:
            raise ValueRefused(f"{name} = {value!r}: a positive finite number is needed")
