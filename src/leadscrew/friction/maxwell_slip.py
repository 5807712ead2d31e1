"""Generalised Maxwell slip (GMS): N springs in parallel, each sticks or slips.

Element ``i`` with the force ``F_i``, ``s(v) = F_C + (F_S - F_C) exp(-(v / v_s)^2)``:

1. sticks:  dF_i/dt = k_i v                                  until sgn(v) F_i reaches alpha_i s(v); then it slips
2. slips:   dF_i/dt = (C + C_x abs(v)) (sgn(v) alpha_i - F_i / s(v))                until v changes its sign
3. total:   F = sum F_i + sigma_1 v sum_stuck k_i / sum k + sigma_2 v

``alpha_i`` sum to 1, so steady sliding gives the Stribeck map. Before sliding the elements give the hysteresis that
metal slides show: it depends on the path and not on its speed, remembers every turning point that is not yet passed
again (non-local memory), and its branches are the first loading curve, doubled (Masing). LuGre has neither memory.

``C`` [N/s] is the published attraction, with which sliding elements lag behind the Stribeck map. ``C_x`` [N/m] and
``sigma_1`` are ours: a lag by travel in place of time, and damping of stuck elements as LuGre's bristles have it.

Source: F. Al-Bender, V. Lampaert, J. Swevers, *The generalized Maxwell-slip model: a novel model for friction
simulation and compensation*, IEEE Trans. Automatic Control 50 (2005) 1883. The six elements are our choice: their first
loading at 9.36 N is close to ``F_S (1 - exp(-1e5 x / F_S))``, what LuGre of the ball-screw stage bends by.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple, TypeVar

import numpy as np

from leadscrew.friction.lugre import FAR, level
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.util.errors import ValueRefused


class MaxwellSlip(NamedTuple):
    """Elements, what ties them to the Stribeck map, and the map."""

    share: Annotated[np.ndarray, Doc("share of each element in the sliding friction, alpha_i; sums to 1")] = np.array(
        [0.0376, 0.0865, 0.1449, 0.1811, 0.2310, 0.3189]
    )
    stiffness: Annotated[np.ndarray, Unit("N/m"), Doc("stiffness of each element while it sticks, k_i")] = np.array(
        [25983.0, 19248.0, 18138.0, 14511.0, 12318.0, 9802.0]
    )
    damping: Annotated[float, Unit("N s/m"), Ge(0), Doc("damping while all elements stick, sigma_1")] = math.sqrt(1e5)
    attraction: Annotated[float, Unit("N/s"), Ge(0), Doc("how fast slipping elements follow the map, C")] = 100.0
    attraction_per_travel: Annotated[float, Unit("N/m"), Ge(0), Doc("the same for each metre of travel, C_x")] = 0.0
    viscous: Annotated[float, Unit("N s/m"), Ge(0), Doc("viscous coefficient, sigma_2")] = 0.4
    coulomb: Annotated[float, Unit("N"), Gt(0), Doc("friction in fast sliding, F_C")] = 1.0
    static: Annotated[float, Unit("N"), Gt(0), Doc("largest friction before sliding, F_S")] = 1.5
    stribeck_speed: Annotated[float, Unit("m/s"), Gt(0), Doc("speed of the fall from F_S to F_C, v_s")] = 0.001


class MaxwellSlipScrew(NamedTuple):
    """The same at a screw, in N m and rad: what the ball-screw stage of Shams and Safdari (2010) has beside LuGre.

    Friction of its Table 2 (``F_C, F_S, v_s, sigma_2``), damping as LuGre's bristles have it, stiffnesses that sum to
    LuGre's ``sigma_0``. Slipping elements follow the map by travel, ``C_x = sigma_0``, and not by time.
    """

    share: Annotated[np.ndarray, Doc("share of each element in the sliding friction, alpha_i; sums to 1")] = np.array(
        [0.0376, 0.0865, 0.1449, 0.1811, 0.2310, 0.3189]
    )
    stiffness: Annotated[np.ndarray, Unit("N m/rad"), Doc("stiffness of each element while it sticks, k_i")] = np.array(
        [25983.0, 19248.0, 18138.0, 14511.0, 12318.0, 9802.0]
    )
    damping: Annotated[float, Unit("N m s/rad"), Ge(0), Doc("damping while all elements stick, sigma_1")] = math.sqrt(
        1e5
    )
    attraction: Annotated[float, Unit("N m/s"), Ge(0), Doc("how fast slipping elements follow the map, C")] = 0.0
    attraction_per_travel: Annotated[float, Unit("N m/rad"), Ge(0), Doc("the same for each radian of travel, C_x")] = (
        1e5
    )
    viscous: Annotated[float, Unit("N m s/rad"), Ge(0), Doc("viscous coefficient, sigma_2")] = 0.4
    coulomb: Annotated[float, Unit("N m"), Gt(0), Doc("friction in fast sliding, F_C")] = 6.24
    static: Annotated[float, Unit("N m"), Gt(0), Doc("largest friction before sliding, F_S")] = 9.36
    stribeck_speed: Annotated[float, Unit("rad/s"), Gt(0), Doc("speed of the fall from F_S to F_C, v_s")] = 0.001


AnyMaxwellSlip = TypeVar("AnyMaxwellSlip", bound=MaxwellSlip | MaxwellSlipScrew)


class Elements(NamedTuple):
    """The force of each element, and the way it slips: 1 forwards, -1 backwards, 0 while it sticks."""

    force: np.ndarray
    slips: np.ndarray


def checked(f: AnyMaxwellSlip) -> AnyMaxwellSlip:
    """The parameters, if their elements make sense.

    Raises:
        ValueRefused: lists of different length or empty, a number that is not positive, shares that do not sum to 1.
    """
    share, stiffness = np.asarray(f.share, dtype=float), np.asarray(f.stiffness, dtype=float)
    if share.ndim != 1 or share.shape != stiffness.shape or share.size == 0:
        raise ValueRefused(
            f"friction.share has the shape {share.shape}, friction.stiffness {stiffness.shape}; "
            "each needs one number for every element"
        )
    for name, values in (("share", share), ("stiffness", stiffness)):
        bad = np.flatnonzero(~((values > 0.0) & np.isfinite(values)))
        if bad.size:
            raise ValueRefused(
                f"friction.{name}[{bad[0]}] = {values[bad[0]]:g}; every element needs a positive finite number"
            )
    if abs(share.sum() - 1.0) > 1e-9:
        raise ValueRefused(f"friction.share sums to {share.sum():.10g}; the shares of all elements must sum to 1")
    return f


def unloaded(f: AnyMaxwellSlip) -> Elements:
    """All elements stuck, without force."""
    return Elements(np.zeros(len(f.share)), np.zeros(len(f.share)))


def stuck_stiffness(f, e):
    """Sum of the stiffnesses of the elements that stick."""
    total = 0.0
    for i in range(f.stiffness.shape[0]):
        total = total + (f.stiffness[i] if e.slips[i] == 0.0 else 0.0)
    return total


def total_stiffness(f):
    """Sum of all stiffnesses: the slope of the first loading at its start."""
    total = 0.0
    for i in range(f.stiffness.shape[0]):
        total = total + f.stiffness[i]
    return total


def elements_force(e):
    """Sum of the elements' forces."""
    total = 0.0
    for i in range(e.force.shape[0]):
        total = total + e.force[i]
    return total


def speed_after(f, e, stiffness, mass, speed, push, dt):
    """Speed of a mass ``dt`` later under ``push``: an implicit step over the springs that stick and the damping.

    ``stiffness`` is :func:`total_stiffness`. For a rotor, inertia and torque.
    """
    stuck = stuck_stiffness(f, e)
    damping = f.damping * stuck / stiffness + f.viscous
    return (mass * speed + dt * (push - elements_force(e))) / (mass + dt * damping + dt * dt * stuck)


def move_elements(f, e, v, dt):
    """Moves all elements in place by ``dt`` at the constant speed ``v``: the exact solution of 1. and 2.

    Returns ``e``. Standing still changes nothing but that every element sticks.
    """
    side = 1.0 if v > 0.0 else -1.0 if v < 0.0 else 0.0
    limit = level(f, v)
    pull = (f.attraction + f.attraction_per_travel * abs(v)) / limit
    for i in range(e.force.shape[0]):
        along = side * e.force[i]
        most = f.share[i] * limit
        slides = (side != 0.0) & (e.slips[i] == side)
        rate = f.stiffness[i] * abs(v)
        missing = max(most - along, 0.0)
        sticks_for = 0.0 if slides else missing / max(rate, 1e-300)
        slides_now = (side != 0.0) & (slides | (sticks_for <= dt))
        start = along if slides else along + missing
        kept = math.exp(-min(pull * max(dt - sticks_for, 0.0), FAR))
        slid = most + (start - most) * kept
        moved = slid if slides_now else along + rate * dt
        e.force[i] = side * moved if side != 0.0 else e.force[i]
        e.slips[i] = side if slides_now else 0.0
    return e
