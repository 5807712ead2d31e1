"""A servo axis stepped exactly, in plain Python: stops to the instant, a drive that acts late by any time, a play.

The oracle of the tests of simulation, refinement and lost motion; nothing of the project is used. Between stops

    w = (u - offset - s C) / B,  v(t) = w + (v0 - w) exp(-B t / M),
    x(t) = x0 + w t + (v0 - w) (1 - exp(-B t / M)) M / B

and the axis stands from the zero of v on while abs(u - offset) <= C.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

PERIOD = 1e-3
VALUES = {
    "mass": 95.0, "offset": -3.0, "friction.forward.coulomb": 20.0, "friction.forward.viscous": 200.0,
}  # fmt: skip
KP, KV = 160.0, 8557.0


@dataclass
class Exact:
    """An axis in motion."""

    mass: float = 95.0
    viscous: float = 200.0
    coulomb: float = 20.0
    offset: float = -3.0
    x: float = 0.0
    v: float = 0.0

    def go(self, force: float, left: float) -> None:
        """On for ``left`` seconds under a held force."""
        push, tau = force - self.offset, self.mass / self.viscous
        for _ in range(4):
            if self.v == 0.0 and abs(push) <= self.coulomb:
                return
            side = math.copysign(1.0, self.v if self.v != 0.0 else push)
            w = (push - side * self.coulomb) / self.viscous
            stop = tau * math.log((self.v - w) / -w) if side * self.v > 0.0 and side * w < 0.0 else math.inf
            t = min(stop, left)
            decay = math.exp(-t / tau)
            self.x += w * t + (self.v - w) * tau * (1.0 - decay)
            self.v = 0.0 if stop < left else w + (self.v - w) * decay
            left -= t
            if left <= 0.0:
                return


def replay(axis: Exact, drive: np.ndarray, delay: float = 0.0) -> np.ndarray:
    """Position at each sample under a drive that acts ``delay`` periods late."""
    whole, part = int(delay), delay - int(delay)
    rows = np.empty(len(drive))
    for k in range(len(drive)):
        rows[k] = axis.x
        axis.go(drive[max(k - whole - 1, 0)], part * PERIOD)
        axis.go(drive[max(k - whole, 0)], (1.0 - part) * PERIOD)
    return rows


def recorded(
    axis: Exact,
    command: np.ndarray,
    play: float = 0.0,
    closed_on: str = "motor",
    count: float = 0.0,
    noise: float = 0.0,
    seed: int = 0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Motor, table and drive of the axis in a cascade whose speed is the difference over two periods."""
    r, n = np.random.default_rng(seed), len(command)
    motor, table, drive = np.empty(n), np.empty(n), np.empty(n)
    at, past = axis.x, [axis.x, axis.x]

    def read(x: float) -> float:
        x += noise * r.standard_normal()
        return round(x / count) * count if count else x

    for k in range(n):
        at = min(max(at, axis.x - play / 2), axis.x + play / 2)
        motor[k], table[k] = read(axis.x), read(at)
        seen = motor[k] if closed_on == "motor" else table[k]
        drive[k] = KV * (KP * (command[k] - seen) - (seen - past[1]) / (2 * PERIOD))
        past = [seen, past[0]]
        axis.go(drive[k], PERIOD)
    return motor, table, drive


def strokes(seconds: float, travel: float = 0.1, rate: float = 0.5) -> np.ndarray:
    """A commanded position to and fro, from rest."""
    t = np.arange(round(seconds / PERIOD)) * PERIOD
    return 0.5 * travel * (1.0 - np.cos(2.0 * np.pi * rate * t)) + 0.05 * travel * (1.0 - np.cos(7.0 * t))
