"""Turning under force control in plain Python: the plant, the fuzzy law and grey predictor written a second time.

Nothing of the package is used: servo by SciPy's matrix exponential, root search for the chip by SciPy's ``brentq``,
surface of one revolution ago by interpolation over a list of past angles, fuzzy inference as a sum over all 49 rules.
"""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass, field

import numpy as np

STANDARD = [[max(-3, min(3, i + j)) for j in range(-3, 4)] for i in range(-3, 4)]
"""Consequent by error (row) and its change (column), -3 to 3."""


@dataclass
class Lathe:
    """Plant F."""

    kf: float = 2256.3
    exponent: float = 0.77
    depth: float = 1.0
    rpm: float = 1200.0
    gain: float = 150.0
    most: float = 150.0
    rate: float = 40.0
    damping: float = 0.7
    dead_time_s: float = 0.0
    stiffness: float = 20_000.0
    runout: float = 0.01
    dt: float = 1e-3
    turns: float = 0.0
    acceleration: float = 0.0
    feed: float = 0.0
    x: float = 0.0
    cut: float = 0.0
    angles: list[float] = field(default_factory=lambda: [0.0])
    surfaces: list[float] = field(default_factory=lambda: [0.0])
    waiting: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        from scipy.linalg import expm

        w, zeta = self.rate, self.damping
        self.exact = expm(self.dt * np.array([[0.0, 1.0, 0.0], [-w * w, -2.0 * zeta * w, 0.0], [1.0, 0.0, 0.0]]))

    def force_of(self, chip: float, depth: float) -> float:
        """Cutting force of a chip of this thickness, N."""
        return self.kf * depth * chip**self.exponent if chip > 0.0 else 0.0

    def surface(self) -> float:
        """Carriage position at which the surface of one revolution ago was left, mm."""
        ago = self.turns - 1.0
        if ago < 0.0:
            return 0.0
        i = bisect.bisect_right(self.angles, ago)
        if i >= len(self.angles):
            return self.surfaces[-1]
        a, b = self.angles[i - 1], self.angles[i]
        return self.surfaces[i - 1] + (self.surfaces[i] - self.surfaces[i - 1]) * (ago - a) / (b - a)

    def step(self, u: float) -> float:
        """One integration step under the voltage ``u``; the force at its end, N."""
        from scipy.optimize import brentq

        self.waiting.append(u)
        late = self.waiting.pop(0) if len(self.waiting) > round(self.dead_time_s / self.dt) else 0.0
        self.turns += self.rpm / 60.0 * self.dt
        asked = min(max(self.gain * late, 0.0), self.most)
        y = self.exact @ np.array([self.feed - asked, self.acceleration, 0.0])
        self.feed, self.acceleration = max(asked + y[0], 0.0), float(y[1])
        self.x += max(asked * self.dt + y[2], 0.0) / 60.0
        s = self.surface()
        w = self.x - s
        depth = self.depth + self.runout * math.sin(2.0 * math.pi * self.turns)
        if w <= 0.0 or depth <= 0.0:
            force = 0.0
        elif math.isinf(self.stiffness):
            force = self.force_of(w, depth)
        else:
            chip = brentq(
                lambda h: h + self.force_of(h, depth) / self.stiffness - w, 0.0, w, xtol=1e-18, rtol=1e-14, maxiter=200
            )
            force = self.force_of(chip, depth)
        self.cut = max(self.x - force / self.stiffness, s)
        self.angles.append(self.turns)
        self.surfaces.append(self.cut)
        return force


def grey(y: list[float]) -> float | None:
    """Next value by GM(1,1) with five samples from the normal equations; ``None`` where they are singular."""
    z = [sum(y[: j + 1]) - 0.5 * y[j] for j in range(1, 5)]
    zm, ym = sum(z) / 4.0, sum(y[1:]) / 4.0
    szz = sum((v - zm) ** 2 for v in z)
    if 4.0 * szz <= 1e-12 * 4.0 * sum(v * v for v in z):
        return None
    c = -sum((v - zm) * (w - ym) for v, w in zip(z, y[1:], strict=True)) / szz
    u = ym + c * zm
    growth = math.expm1(c) / c if abs(c) > 1e-8 else 1.0 + 0.5 * c
    return (u - c * y[0]) * growth * math.exp(-5.0 * c)


def memberships(x: float, scale: float) -> list[float]:
    """Of the seven triangles at -6 to 6 times ``scale``, shoulders saturating."""
    v = min(max(x / scale, -6.0), 6.0)
    return [max(0.0, 1.0 - abs(v - 2.0 * i) / 2.0) for i in range(-3, 4)]


@dataclass
class Fuzzy:
    """TFC (``reading`` none) and GPFC (``A`` or ``B``), incremental, output held to 0..1 V."""

    factors: tuple[float, float, float]
    reading: str = ""
    rules: list[list[int]] = field(default_factory=lambda: STANDARD)
    u: float = 0.0
    last: float | None = None
    window: list[float] = field(default_factory=list)

    def ahead(self, r: float, y: float) -> float:
        """The predicted next value."""
        self.window = [*self.window, y][-5:]
        if len(self.window) < 5:
            return y
        found = grey(self.window)
        return y if found is None else min(max(found, 0.0), 2.0 * r)

    def increment(self, e: float, ec: float) -> float:
        """All 49 rules: product inference, height method."""
        s1, s2, s3 = self.factors
        over = under = 0.0
        for i, a in enumerate(memberships(e, s1)):
            for j, b in enumerate(memberships(ec, s2)):
                over += a * b * 2.0 * self.rules[i][j] * s3
                under += a * b
        return over / under

    def __call__(self, r: float, y: float) -> float:
        """One sample."""
        e = r - y
        judged = r - self.ahead(r, y) if self.reading else e
        before = judged if self.last is None else self.last
        if self.reading == "A":
            before = e
        self.last = judged
        self.u = min(max(self.u + self.increment(judged, judged - before), 0.0), 1.0)
        return self.u


def run(
    controller: Fuzzy, seconds: float, lathe: Lathe, noise: np.ndarray | None = None, keep: float = 0.8
) -> dict[str, np.ndarray]:
    """Simulates with a sample every 20 ms: force a step, filtered force a sample."""
    every = round(0.02 / lathe.dt)
    forces, ys = [], []
    y = force = u = 0.0
    for k in range(round(seconds / lathe.dt)):
        if k % every == 0:
            y = keep * y + (1.0 - keep) * (force + (0.0 if noise is None else noise[k // every]))
            u = controller(150.0, y)
            ys.append(y)
        force = lathe.step(u)
        forces.append(force)
    return {"force": np.array(forces), "y": np.array(ys)}
