"""A linear loop, cut at the error: what every stability criterion starts from.

    e --> [ controller, delays, plant ] --> y        unity negative feedback: e = command - y

``G`` is the transfer function from the error ``e`` to the position ``y``, both in mm. A loop with a static
nonlinearity ``phi`` in front of its controller is ``e = -G phi(e)``; a gain ``k`` there is ``phi(e) = k e``.

A sampled loop has all its delays among its states: it is exact at the sampling instants. A continuous one is a rational
part and a dead time, which its response takes exactly.

Rightmost poles of a linear system with one dead time: ``x'(t) = A x(t) + M x(t - h)``.

Its infinitesimal generator on ``[-h, 0]`` is replaced by a matrix on Chebyshev points, whose rightmost eigenvalues are
those of the system (D. Breda, S. Maset, R. Vermiglio, SIAM J. Sci. Comput. 27 (2005) 482); each is then refined by
Newton's method on the characteristic equation ``det(s I - A - M e^(-s h)) = 0``.

Frequencies at which a loop is looked at: dense where its response turns, never coarser than its delay asks.

A grid has ``per_decade`` points a decade, a cluster around every pole of the open loop and of the loop at gain 1 (a
lightly damped one is narrower than any fixed grid; around one without damping the points come ever nearer, but not
onto it), steps of at most 1/40 turn of the dead time's phase for the first
500 turns, and for a sampled loop 2000 even steps up to half the sampling rate.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leadscrew.util.errors import ValueRefused

POINTS = 28
"""Chebyshev points on the dead time: more than twice what the loops of the tests need."""

STEPS = 8
"""Newton steps; from the matrix's eigenvalues two or three do."""


def delay_poles(a: np.ndarray, m: np.ndarray, h: float) -> np.ndarray:
    """The rightmost poles, those that the Newton refinement confirmed, from right to left."""
    n = len(a)
    slope = _chebyshev(POINTS, h)
    whole = np.kron(slope, np.eye(n))
    whole[:n] = 0.0
    whole[:n, :n] = a
    whole[:n, -n:] = m
    rough = np.linalg.eigvals(whole)
    rough = rough[np.argsort(-rough.real)][: 4 * n + 12]
    kept: list[complex] = []
    for s in rough:
        refined = _newton(a, m, h, complex(s))
        if refined is not None and all(abs(refined - k) > 1e-9 * (1.0 + abs(k)) for k in kept):
            kept.append(refined)
    return np.array(sorted(kept, key=lambda s: -s.real))


def _newton(a: np.ndarray, m: np.ndarray, h: float, s: complex) -> complex | None:
    eye = np.eye(len(a))
    start = s
    for _ in range(STEPS):
        late = m * np.exp(-s * h)
        matrix = s * eye - a - late
        try:
            # the derivative of log det is the trace of the matrix' inverse times its derivative
            change = 1.0 / np.trace(np.linalg.solve(matrix, eye + h * late))
        except np.linalg.LinAlgError:
            return s
        if not np.isfinite(change):
            return s
        s = s - change
        if abs(change) <= 1e-13 * (1.0 + abs(s)):
            return s if abs(s - start) <= 0.05 * (1.0 + abs(start)) else None
    return None


def _chebyshev(count: int, h: float) -> np.ndarray:
    """The matrix that differentiates on the Chebyshev points from 0 down to -h."""
    k = np.arange(count + 1)
    x = np.cos(np.pi * k / count)
    weight = np.where((k == 0) | (k == count), 2.0, 1.0) * (-1.0) ** k
    apart = x[:, None] - x[None, :]
    slope = np.outer(weight, 1.0 / weight) / (apart + np.eye(count + 1))
    slope -= np.diag(slope.sum(axis=1))
    return np.asarray(slope * 2.0 / h)


CHUNK = 4096
"""Frequencies solved at once; bounds the memory of a response."""

MARGINAL = 1e-9
"""How near to its boundary a pole counts as unstable: |z| above 1 - this, or Re s above -this (|s| + 1)."""

BESIDE = 1e-8
"""How near to an undamped pole of the loop its response is still computed, as a share of the pole's frequency."""
DERIVATIVE_RAD = 1e-11
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
    def frequencies(self) -> np.ndarray:
        """Its own grid of frequencies in rad/s."""
        return own_grid(self).w

    @property
    def phase_crossings(self) -> list[Crossing]:
        """Where its Nyquist curve crosses the negative real axis."""
        return phase_crossings(self)

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
                least = DERIVATIVE_RAD / self.dt
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


def worst_pole(loop: LinearLoop, gain: float) -> str:
    """The closed loop's outermost pole, for a sentence."""
    poles = loop.closed_poles(gain)
    if loop.dt is not None:
        z = poles[np.argmax(np.abs(poles))]
        return f"a pole at |z| = {abs(z):.6g}"
    s = poles[np.argmax(poles.real)]
    return f"a pole at {s.real:.4g} {'+-' if s.imag else ''}{f' {abs(s.imag):.4g}j' if s.imag else ''} 1/s".replace(
        "  ", " "
    )


PER_DECADE = 400
LARGEST_RAD_S = 2e5
"""Upper end for a continuous loop, rad/s."""
SMALLEST_RAD_S = 1e-5
TURN = 2.0 * np.pi / 40
"""Largest step of the dead time's phase between two points, rad."""
LINEAR_POINTS = 20_000
AROUND = np.concatenate([-np.geomspace(20.0, 0.02, 40), [0.0], np.geomspace(0.02, 20.0, 40)])
"""Where a cluster has its points, in half widths of the resonance."""
NEARER = 12
"""Points a decade of the distance to an undamped pole."""
DELAY = 0.02
"""Poles with a smaller ``|z|`` are delays, spread around 0 by rounding; none of them makes a resonance."""


@dataclass(frozen=True)
class Grid:
    """Frequencies in rad/s, and how they were chosen."""

    w: np.ndarray
    chosen: bool
    """Whether the loop's own grid; else it was given by the caller."""
    refined: int = 0
    """Points added where a maximum was bracketed."""

    def as_dict(self) -> dict[str, float | int | bool]:
        """From, to, points: for a certificate."""
        return {
            "from": float(self.w[0]), "to": float(self.w[-1]), "points": len(self.w), "refined": self.refined,
            "chosen": self.chosen,
        }  # fmt: skip


def modes(loop: LinearLoop) -> np.ndarray:
    """Poles of the open loop and of the loop at gain 1, in 1/s: where its response can turn quickly."""
    poles = np.linalg.eigvals(loop.a)
    closed = loop.closed_poles(1.0)
    if loop.dt is not None:
        every = np.concatenate([poles, closed])
        every = every[np.abs(every) > DELAY]
        return np.asarray(np.log(every.astype(complex)) / loop.dt)
    return np.concatenate([poles, closed])


def own_grid(loop: LinearLoop, per_decade: int = PER_DECADE) -> Grid:
    """The loop's own grid."""
    top = min(loop.nyquist, LARGEST_RAD_S)
    low = SMALLEST_RAD_S
    decades = np.log10(top / low)
    parts: list[Any] = [np.geomspace(low, top, int(decades * per_decade) + 1)]
    for s in modes(loop):
        centre, half = abs(s.imag), max(abs(s.real), 1e-9 * abs(s))
        if low < centre < top:
            parts.append(centre + half * AROUND)
    for centre, near in loop.undamped:
        if low < centre < top:
            apart = np.geomspace(near, centre, int(NEARER * np.log10(centre / near)) + 1)
            parts += [centre - apart, centre + apart]
    if loop.dt is not None:
        parts.append(np.linspace(0.0, top, 2001)[1:])
    if loop.dead_time:
        step = TURN / loop.dead_time
        parts.append(step * np.arange(1, min(int(top / step), LINEAR_POINTS) + 1))
    w = np.unique(np.concatenate(parts))
    w = w[(w >= low) & (w <= top)]
    for centre, near in loop.undamped:
        w = w[np.abs(w - centre) >= 0.999 * near]
    if loop.dt is not None and w[-1] < top:
        w = np.append(w, top)
    return Grid(w, True)


def given_grid(loop: LinearLoop, w: object) -> tuple[Grid, list[str]]:
    """A grid of the caller's, and what is wrong with it in sentences.

    Raises:
        ValueRefused: fewer than 3 frequencies, or one that is not positive and finite, or above half the sampling rate.
    """
    found = np.unique(np.asarray(w, dtype=float).ravel())
    if len(found) < 3 or not np.isfinite(found).all() or found[0] <= 0.0:
        raise ValueRefused("grid: needs at least 3 different positive frequencies in rad/s")
    if found[-1] > loop.nyquist * (1.0 + 1e-12):
        raise ValueRefused(
            f"grid: {found[-1]:g} rad/s lies above {loop.nyquist:g} rad/s, half the sampling rate of {loop.name!r}"
        )
    return Grid(found, False), coarse(loop, found)


def coarse(loop: LinearLoop, w: np.ndarray) -> list[str]:
    """What the grid is too coarse or too short for, in sentences; empty where it will do."""
    found: list[str] = []
    if loop.dead_time:
        gap = float(np.diff(w[w < LARGEST_RAD_S]).max()) * loop.dead_time
        live = w[:-1][np.abs(loop.response(w[:-1])) > 1e-3]
        if len(live):
            gap = float(np.diff(w)[: len(live)].max()) * loop.dead_time
        if gap > np.pi / 4:
            found.append(
                f"The grid is too coarse for the dead time of {1e3 * loop.dead_time:g} ms: between two of its points "
                f"the phase turns by up to {np.degrees(gap):.0f} deg, so that a crossing can be missed; at most 45 deg."
            )
    bare = loop.undamped
    for s in modes(loop):
        centre, half = abs(s.imag), abs(s.real)
        if any(abs(centre - f) < near and half < near for f, near in bare):
            continue  # infinitely narrow in G; what it makes of the closed loop is among the modes
        if half < 0.3 * centre and w[0] < centre < w[-1]:
            i = int(np.searchsorted(w, centre))
            step = float(w[min(i, len(w) - 1)] - w[i - 1])
            if step > half:
                found.append(
                    f"The grid is too coarse for the resonance at {centre / (2 * np.pi):.4g} Hz: its points lie "
                    f"{step / (2 * np.pi):.3g} Hz apart there, the resonance is {half / np.pi:.3g} Hz wide."
                )
    slow, fast = _range(loop)
    if w[0] > slow:
        found.append(f"The grid starts at {w[0]:.3g} rad/s, above the loop's slowest dynamics of {slow:.3g} rad/s.")
    if w[-1] < fast:
        found.append(f"The grid ends at {w[-1]:.4g} rad/s, below {fast:.4g} rad/s, up to where the loop has dynamics.")
    return list(dict.fromkeys(found))


def _range(loop: LinearLoop) -> tuple[float, float]:
    sizes = np.abs(modes(loop))
    sizes = sizes[sizes > 1e-6]
    slow = float(sizes.min()) if len(sizes) else 1.0
    fast = loop.nyquist if loop.dt is not None else float(sizes.max() if len(sizes) else 1.0)
    return slow, 0.999 * fast


Response = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Crossing:
    """A frequency in rad/s, and the real part there (phase crossover) or the phase margin in rad (gain crossover)."""

    w: float
    value: float


def phase_crossings(loop: LinearLoop, w: np.ndarray | None = None, positive: bool = False) -> list[Crossing]:
    """Every crossing of the negative real axis: ``Im G = 0``, ``Re G < 0``, by rising frequency.

    ``positive`` adds those of the positive one, where a negative gain makes the loop oscillate.

    A sampled loop is real at half its sampling rate; a crossing there counts, being where a gain makes a pole leave at
    ``z = -1``. At frequency 0, where a curve begins, a negative ``G(0)`` counts likewise.
    """
    w = own_grid(loop).w if w is None else w
    found = [c for c in crossings_of(loop.response, w, positive) if not _on_a_pole(loop, c.w)]
    if loop.dt is not None:
        last = complex(loop.response(np.array([loop.nyquist]))[0])
        if (last.real < 0.0 or positive) and all(abs(c.w - loop.nyquist) > 1e-9 * loop.nyquist for c in found):
            found.append(Crossing(loop.nyquist, last.real))
    at = 1.0 if loop.dt is not None else 0.0
    poles = np.linalg.eigvals(loop.a)
    if np.all(np.abs(poles - at) > 1e-12):
        rest = complex(loop.response(np.array([0.0]))[0]).real
        if rest < 0.0 or (positive and rest > 0.0):
            found.insert(0, Crossing(0.0, rest))
    return found


def crossings_of(response: Response, w: np.ndarray, positive: bool = False) -> list[Crossing]:
    """Crossings of the negative real axis of any response, bracketed on ``w`` and refined."""
    g = response(w)
    found = []
    near = positive | (np.minimum(g.real[:-1], g.real[1:]) < 0.0)
    for i in np.nonzero((np.sign(g.imag[:-1]) != np.sign(g.imag[1:])) & near)[0]:
        at = _root(lambda x: float(response(np.array([x]))[0].imag), float(w[i]), float(w[i + 1]))
        value = complex(response(np.array([at]))[0])
        if (value.real < 0.0 or (positive and value.real > 0.0)) and abs(value.imag) <= 1e-6 * abs(value):
            found.append(Crossing(at, value.real))
    return found


def gain_crossings(loop: LinearLoop, w: np.ndarray | None = None) -> list[Crossing]:
    """Every crossing of the unit circle, with the phase margin there in rad (0 .. 2 pi)."""
    w = own_grid(loop).w if w is None else w
    over = np.log(np.abs(loop.response(w)))
    found = []
    for i in np.nonzero(np.sign(over[:-1]) != np.sign(over[1:]))[0]:
        at = _root(lambda x: float(np.log(np.abs(loop.response(np.array([x]))[0]))), float(w[i]), float(w[i + 1]))
        angle = float(np.angle(loop.response(np.array([at]))[0]))
        found.append(Crossing(at, (angle + np.pi) % (2.0 * np.pi)))
    return found


def _on_a_pole(loop: LinearLoop, w: float) -> bool:
    """Whether the curve only changes sign there because it passes through infinity."""
    return any(abs(w - f) <= 1.001 * near for f, near in loop.undamped)


def _root(f: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import brentq

    if f(low) == 0.0:
        return low
    if f(high) == 0.0:
        return high
    return float(brentq(f, low, high, xtol=1e-12 * high, rtol=1e-14))
