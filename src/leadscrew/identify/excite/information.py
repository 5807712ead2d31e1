"""How well a move would tell the parameters of an axis: Fisher information of output error over windows.

The model of the fitter, ``M dv/dt = g u(t - delay) - offset - F(v)``, with the drive as exact input and white noise of
standard deviation ``s`` on the measured position. A change of a parameter acts as a force ``phi`` on the moving mass::

    M d(dv)/dt = -phi - F_v dv,    d(dx)/dt = dv,     dv = 0 at rest
    phi: mass: a;  offset: 1;  Coulomb: sgn v (1 - e);  viscous: v;  static: sgn v e;  e = exp(-(v/v_s)^2)
         Stribeck speed: sgn v (F_S - F_C) e 2 v^2 / v_s^3;   delay: dF/dt, F = M a + F(v) + offset

each friction value in its direction alone. Over windows of half a second whose start position and speed are free (and
so are projected out), with ``S`` the responses ``dx``: information ``S'S / s^2``, whose inverse bounds any covariance
from below (L. Ljung, *System Identification*, 2nd edition, section 9.3). What real friction does beyond the model adds
``(sum phi phi' / f^2)^-1``, with ``f`` the force that a model leaves, independent every 25 ms.

Stiffness and damping of the bristles are told by strokes shorter than pre-sliding: there ``dx = z / sigma_0`` and
``dz/dt / sigma_0``. Backlash is told by reversals, each to ``sqrt(2) s``.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from leadscrew.identify.excite.belief import SIDES, Belief, level
from leadscrew.identify.excite.move import Move, Sampled, sampled

WINDOW_S = 0.5
ALIKE_S = 0.025
"""Seconds over which what a model leaves of the force is alike."""


class Information(NamedTuple):
    """Of one part of a move; parts at rest between them add up."""

    sensor: np.ndarray
    """k x k, of the parameters :func:`columns_of`."""
    force: np.ndarray
    """k x k, per unit of the force left squared."""
    bristles: np.ndarray
    """2 x 2, stiffness and damping."""
    reversals: int
    seconds: float

    def plus(self, other: Information, times: int = 1) -> Information:
        """Both."""
        return Information(
            self.sensor + times * other.sensor, self.force + times * other.force,
            self.bristles + times * other.bristles,
            self.reversals + times * other.reversals, self.seconds + times * other.seconds,
        )  # fmt: skip


def columns_of(belief: Belief) -> dict[str, tuple[str, ...]]:
    """What is estimated together: name of a column, and the keys that it stands for (both directions where alike)."""
    stribeck = any(k.endswith(("static", "stribeck_speed")) for k in belief.wanted)
    kinds = ("coulomb", "viscous", *(("static", "stribeck_speed") if stribeck else ()))
    found: dict[str, tuple[str, ...]] = {"mass": ("mass",)}
    if belief.symmetric:
        # By direction a constant force and unequal Coulomb friction are one and the same.
        found["offset"] = ("offset",)
    for kind in kinds:
        keys = tuple(f"friction.{s}.{kind}" for s in SIDES)
        found.update({kind: keys} if belief.symmetric else {k: (k,) for k in keys})
    found["delay_s"] = ("delay_s",)
    return found


def nothing(belief: Belief) -> Information:
    """No information."""
    count = len(columns_of(belief))
    return Information(np.zeros((count, count)), np.zeros((count, count)), np.zeros((2, 2)), 0, 0.0)


def information(move: Move, belief: Belief) -> Information:
    """What the move tells."""
    seen = sampled(move, belief.period)
    moving = (seen.velocity != 0.0) & ~_short(move, seen, belief)
    forces = np.where(moving[:, None], regressors(seen, belief, moving), 0.0)
    held = _windows(forces, moving, belief)
    purposes = [s.purpose for s in move.strokes]
    return Information(
        held / belief.noise**2, forces.T @ forces * min(belief.period / ALIKE_S, 1.0), _bristles(move, seen, belief),
        purposes.count("lost motion"), move.duration,
    )  # fmt: skip


def regressors(seen: Sampled, belief: Belief, moving: np.ndarray) -> np.ndarray:
    """``phi`` of each sample and column, n x k."""
    v, sign = seen.velocity, np.sign(seen.velocity)
    ahead = v > 0.0

    def by_side(name: str) -> np.ndarray:
        return np.where(ahead, belief.side(name, True), belief.side(name, False))

    coulomb, viscous, static, speed = (by_side(n) for n in ("coulomb", "viscous", "static", "stribeck_speed"))
    known = speed > 0.0
    size = np.where(known, speed, 1.0)
    fall = np.where(known, np.exp(-np.minimum((v / size) ** 2, 700.0)), 0.0)
    static = np.where(known, np.maximum(static, coulomb), coulomb)
    force = belief.of("mass") * seen.acceleration + sign * (coulomb + (static - coulomb) * fall) + viscous * v
    edge = np.diff(force, prepend=force[0]) / belief.period
    edge[~(moving & np.r_[False, moving[:-1]])] = 0.0
    by_kind = {
        "coulomb": sign * (1.0 - fall), "viscous": v, "static": sign * fall,
        "stribeck_speed": sign * (static - coulomb) * fall * 2.0 * v**2 / size**3,
    }  # fmt: skip
    found = []
    for name, keys in columns_of(belief).items():
        if name in ("mass", "offset", "delay_s"):
            found.append({"mass": seen.acceleration, "offset": np.ones(len(v)), "delay_s": edge}[name])
            continue
        sides = np.zeros(len(v), dtype=bool)
        for key in keys:
            sides |= ahead if ".forward." in key else v < 0.0
        found.append(np.where(sides, by_kind[name.rsplit(".", 1)[-1]], 0.0))
    return np.column_stack(found)


def _windows(forces: np.ndarray, moving: np.ndarray, belief: Belief) -> np.ndarray:
    """``sum S'S`` over windows, their free start projected out."""
    length = max(round(WINDOW_S / belief.period), 8)
    count = math.ceil(len(forces) / length)
    padded = np.zeros((count * length, forces.shape[1] + 2))
    padded[: len(forces), 2:] = forces
    going = np.zeros(count * length)
    going[: len(moving)] = moving
    push, moves = padded.reshape(count, length, -1), going.reshape(count, length, 1)
    mass, viscous = belief.of("mass"), 0.5 * (belief.side("viscous", True) + belief.side("viscous", False))
    kept = math.exp(-viscous * belief.period / mass)
    place, speed = np.zeros((count, push.shape[2])), np.zeros((count, push.shape[2]))
    place[:, 0], speed[:, 1] = 1.0, 1.0
    seen = np.empty_like(push)
    for k in range(length):
        seen[:, k] = place
        after = moves[:, k] * (kept * speed - push[:, k] * (belief.period / mass))
        place = place + 0.5 * belief.period * (moves[:, k] * speed + after)
        speed = after
    seen[-1, length - (count * length - len(forces)) :] = 0.0  # what was padded is not measured
    free, _ = np.linalg.qr(seen[:, :, :2])
    response = seen[:, :, 2:]
    response = response - free @ (np.swapaxes(free, 1, 2) @ response)
    return np.einsum("wki,wkj->ij", response, response)


def _short(move: Move, seen: Sampled, belief: Belief) -> np.ndarray:
    """Whether a sample belongs to a stroke within pre-sliding, where the mass hangs on bristles."""
    short = np.array([s.purpose == "pre-sliding" for s in move.strokes] + [False])
    return short[seen.stroke] & (belief.of("friction.stiffness") > 0.0)


def _bristles(move: Move, seen: Sampled, belief: Belief) -> np.ndarray:
    stiffness = belief.of("friction.stiffness")
    part = _short(move, seen, belief)
    if not stiffness or not part.any():
        return np.zeros((2, 2))
    most = level(belief) / stiffness
    bend = (seen.position[part] - move.start).clip(-most, most)
    columns = np.column_stack([bend, seen.velocity[part]]) / stiffness
    return columns.T @ columns / belief.noise**2
