"""Frequencies at which a loop is looked at: dense where its response turns, never coarser than its delay asks.

A grid has ``per_decade`` points a decade, a cluster around every pole of the open loop and of the loop at gain 1 (a
lightly damped one is narrower than any fixed grid; around one without damping the points come ever nearer, but not
onto it), steps of at most 1/40 turn of the dead time's phase for the first
500 turns, and for a sampled loop 2000 even steps up to half the sampling rate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.kernel.errors import ValueRefused

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
