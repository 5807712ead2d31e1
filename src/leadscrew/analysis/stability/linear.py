"""A linear loop, cut at the error: what every stability criterion starts from.

    e --> [ controller, delays, plant ] --> y        unity negative feedback: e = command - y

``G`` is the transfer function from the error ``e`` to the position ``y``, both in mm. A loop with a static
nonlinearity ``phi`` in front of its controller is ``e = -G phi(e)``; a gain ``k`` there is ``phi(e) = k e``.

A sampled loop has all its delays among its states: it is exact at the sampling instants. A continuous one is a rational
part and a dead time, which its response takes exactly.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leadscrew.analysis.stability.delay_poles import delay_poles
from leadscrew.kernel.errors import ValueRefused

CHUNK = 4096
"""Frequencies solved at once; bounds the memory of a response."""

MARGINAL = 1e-9
"""How near to its boundary a pole counts as unstable: |z| above 1 - this, or Re s above -this (|s| + 1)."""

BESIDE = 1e-8
"""How near to an undamped pole of the loop its response is still computed, as a share of the pole's frequency."""
TURN = 1e-11
"""The same for a sampled loop at the least, as an angle in rad; nearer, rounding decides."""


@dataclass(frozen=True, eq=False)
class LinearLoop:
    """``x+ = a x + b e`` (sampled) or ``x' = a x + b e`` (continuous); ``y = c x + d e``, late by ``dead_time``.

    ``a`` is n by n, ``b`` n by 1, ``c`` 1 by n, ``d`` 1 by 1.
    """

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    d: np.ndarray
    dt: float | None = None
    """Period in s; ``None`` for a continuous loop."""
    dead_time: float = 0.0
    """Dead time of a continuous loop, s; a sampled loop has its delays among its states."""
    name: str = ""
    notes: tuple[str, ...] = ()
    """What was left out of the loop, or holds only in a range: sentences for the certificates."""
    from_blocks: bool = False
    """Whether the loop was taken from the steps that run and are exported; else it is a model."""
    known: dict[tuple[str, float], Any] = field(default_factory=dict, init=False, repr=False)
    """Poles and limits already computed."""

    def __post_init__(self) -> None:
        order = len(self.a)
        shapes = tuple(np.shape(m) for m in (self.a, self.b, self.c, self.d))
        if shapes != ((order, order), (order, 1), (1, order), (1, 1)):
            raise ValueRefused(
                f"loop {self.name!r}: the shapes {shapes} do not fit; a loop of order n has n x n, n x 1, 1 x n, 1 x 1"
            )
        if not all(np.isfinite(m).all() for m in (self.a, self.b, self.c, self.d)):
            raise ValueRefused(f"loop {self.name!r}: its matrices hold a value that is not finite")
        if self.dt is not None and self.dead_time:
            raise ValueRefused(f"loop {self.name!r}: a sampled loop has its delays among its states, not as dead_time")
        if self.dead_time < 0.0:
            raise ValueRefused(f"loop {self.name!r}: dead_time = {self.dead_time!r} s; allowed from 0")
        if self.dead_time and float(self.d[0, 0]) != 0.0:
            raise ValueRefused(
                f"loop {self.name!r}: direct feed-through of {float(self.d[0, 0])!r} with a dead time makes the gain "
                "stay at every frequency; give the controller or the plant the lag that it has"
            )

    @property
    def sampled(self) -> bool:
        """Whether the loop has a period."""
        return self.dt is not None

    @property
    def nyquist(self) -> float:
        """Highest frequency that means something, rad/s; infinite for a continuous loop."""
        return np.pi / self.dt if self.dt is not None else np.inf

    def response(self, w: Any) -> np.ndarray:
        """``G(e^(jwT))`` or ``G(jw)`` with its dead time, at the frequencies ``w`` in rad/s.

        At an undamped pole (an integrator at 0, a resonator) it is infinite; what is given is the value just beside.
        """
        w = np.asarray(w, dtype=float)
        flat = w.ravel()
        for centre, near in self.undamped:
            off = flat - centre
            if np.any(np.abs(off) < near):
                flat = np.where(np.abs(off) < near, centre + np.where(off < 0.0, -near, near), flat)
        points = np.exp(1j * flat * self.dt) if self.dt is not None else 1j * flat
        eye = np.eye(len(self.a))
        found = np.empty(len(flat), dtype=complex)
        for i in range(0, len(flat), CHUNK):
            here = points[i : i + CHUNK]
            states = np.linalg.solve(
                here[:, None, None] * eye - self.a, np.broadcast_to(self.b, (len(here), *self.b.shape))
            )
            found[i : i + CHUNK] = (self.c @ states)[:, 0, 0] + self.d[0, 0]
        return (found * np.exp(-1j * flat * self.dead_time)).reshape(w.shape)

    @property
    def undamped(self) -> tuple[tuple[float, float], ...]:
        """Frequencies of the poles on the boundary, rad/s, and how near to each the response is computed, rad/s."""
        key = ("undamped", 0.0)
        if key not in self.known:
            poles = np.linalg.eigvals(self.a).astype(complex)
            least = 1e-9
            if self.dt is not None:
                poles = np.log(poles[np.abs(poles) > 0.5]) / self.dt
                least = TURN / self.dt
            size = np.abs(poles.imag)
            held = poles[np.abs(poles.real) <= BESIDE * size + 0.01 * least]
            found = sorted({float(abs(s.imag)) for s in held})
            self.known[key] = tuple((f, max(BESIDE * f, least)) for f in found)
        return tuple(self.known[key])

    def closed_poles(self, gain: float = 1.0) -> np.ndarray:
        """Poles of the loop closed with ``gain``: all of them, or with a dead time the rightmost ones (in s)."""
        if self.dead_time:
            key = ("poles", float(gain))
            if key not in self.known:
                self.known[key] = delay_poles(self.a, -gain * self.b @ self.c, self.dead_time)
            return np.array(self.known[key])
        through = 1.0 + gain * float(self.d[0, 0])
        if through == 0.0:
            raise ValueRefused(f"loop {self.name!r}: closed with a gain of {gain!r} its algebraic loop has no solution")
        return np.asarray(np.linalg.eigvals(self.a - gain / through * self.b @ self.c))

    def stable(self, gain: float = 1.0) -> bool:
        """Whether the loop closed with ``gain`` is stable: every pole inside its boundary."""
        poles = self.closed_poles(gain)
        if self.dt is not None:
            return bool(np.all(np.abs(poles) < 1.0 - MARGINAL))
        return bool(np.all(poles.real < -MARGINAL * np.abs(poles) - MARGINAL))

    def gain_limit(self, above: float | None = None) -> float:
        """The Nyquist limit: the largest gain up to which the closed loop is stable for all gains from ``above`` on.

        ``above`` itself where it is unstable at once, infinity where no gain makes it unstable. From 0 where ``above``
        is not given; but from 1 for a loop that is stable at gain 1 and not at every smaller one, as strong integral
        action makes it.
        """
        if above is None:
            found = self.gain_limit(0.0)
            return found if found >= 1.0 or not self.stable(1.0) else self.gain_limit(1.0)
        key = ("limit", float(above))
        if key not in self.known:
            self.known[key] = self._gain_limit(above)
        return float(self.known[key])

    def _gain_limit(self, above: float) -> float:
        from leadscrew.analysis.stability.crossings import phase_crossings

        every = [-1.0 / c.value for c in phase_crossings(self, positive=above < 0.0)]
        gains = sorted(k for k in every if k > above + 1e-9 * abs(above))
        first = gains[0] if gains else np.inf
        inside = 0.5 * (above + first) if gains else 2.0 * above + 1.0
        return float(first) if self.stable(inside) else float(above)

    def shifted(self, k1: float) -> LinearLoop:
        """The loop with the gain ``k1`` closed inside: ``G / (1 + k1 G)``, for sectors that start at ``k1``.

        Raises:
            ValueRefused: the loop has a dead time (its response can be transformed, its matrices cannot).
        """
        if self.dead_time:
            raise ValueRefused(f"loop {self.name!r}: with a dead time no finite state can hold a closed gain of {k1!r}")
        through = 1.0 + k1 * float(self.d[0, 0])
        return LinearLoop(
            self.a - k1 / through * self.b @ self.c, self.b / through, self.c / through, self.d / through, self.dt,
            name=f"{self.name} closed with {k1:g}", notes=self.notes, from_blocks=self.from_blocks,
        )  # fmt: skip

    def to_control(self) -> Any:
        """The loop as a ``StateSpace`` of python-control; without the dead time, which it does not know."""
        from control import ss

        return ss(self.a, self.b, self.c, self.d, self.dt or 0)
