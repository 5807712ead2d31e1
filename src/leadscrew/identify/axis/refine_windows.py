"""Windows of a log, each with a start position and speed of its own, which are solved for inside (variable projection).

With ``x_w(theta, p_w, v_w)`` the model's position in window ``w`` and ``y`` the measured one,

    r_w(theta) = min over p_w, v_w of  x_w(theta, p_w, v_w) - y_w

The start position shifts the whole window, so it takes the mean out. In sliding the start speed acts linearly: one step
of Gauss and Newton finds it; where the axis stops within the window a second step is taken from there. A window that
begins at rest begins with speed 0. Windows begin where the axis moves fastest nearby, since there a start speed is what
it seems; the derivative is that of L. Kaufman, *A variable projection method*, BIT 15 (1975) 49.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.identify.axis.record import Record, record_of
from leadscrew.identify.axis.refine_replay import Starts, play, played
from leadscrew.identify.axis.refine_scales import Scales
from leadscrew.identify.axis.simulation import START_S, start_state

if TYPE_CHECKING:
    from leadscrew.logs import AxisLog

STEP = 1e-3
"""Difference of a scaled variable for a derivative; also of a start speed, as a share of the top speed."""
SPEED_STEPS = 2
"""Steps of Gauss and Newton by which start speeds are solved for."""
NEARBY = 0.3
"""Share of a window by which its start may move to where the axis is faster."""
LEAST, SHORT = 40, 24
"""Samples of a window, at least; and of one that an unstable motion cuts short."""
CALM, WILD = 3.0, 6.0
"""Growth of an error within a window, as a logarithm: where a window ends, and beyond which it is left out."""
FAR = 8.0
"""Windows whose residual is more than so many times the median are left out: the model sticks there, or slides, where
the axis does not."""
TOGETHER_S = 0.3
"""Windows that begin within so long of each other count as one piece of evidence."""
WINDOW_S, LEAST_WINDOWS = 0.7, 12
"""Length of a window; shorter where the log has fewer than so many."""


class Cut(NamedTuple):
    """Windows of a log: first samples and lengths."""

    first: np.ndarray
    length: np.ndarray


def whole(log: AxisLog) -> Cut:
    """One window."""
    return Cut(np.array([0]), np.array([len(log.position)]))


def cut(log: AxisLog, point: Mapping[str, float], window_s: float | None = None) -> Cut:
    """Windows of the log, for a model near the values ``point`` of the plant.

    Where friction falls with speed an error of the speed grows, at the rate ``-(dF/dv) / M``: a window ends before it
    has grown by ``e^3``, and one in which it grows by ``e^6`` within the shortest window says nothing and is left out.
    """
    n, dt = len(log.position), log.period
    aim = max(LEAST, round((window_s if window_s is not None else min(WINDOW_S, n * dt / LEAST_WINDOWS)) / dt))
    speed = _speed(log)
    grown = np.concatenate([[0.0], np.cumsum(_growth(point, speed) * dt)])
    reach, least = int(NEARBY * aim), min(LEAST, SHORT)
    found, at = [], 0
    while at + least <= n:
        end = min(n, at + aim)
        if grown[end] - grown[at] > CALM:
            end = min(n, max(at + least, int(np.searchsorted(grown, grown[at] + CALM))))
        elif end + LEAST > n:
            end = n
        elif reach > 0:
            low, high = end - reach, min(n - LEAST, end + reach)
            end = low + int(np.argmax(np.abs(speed[low : high + 1]))) if high > low else end
        if grown[end] - grown[at] < WILD:
            found.append((at, end - at))
        at = end
    if not found:
        return whole(log)
    return Cut(*np.array(found).T)


def _speed(log: AxisLog) -> np.ndarray:
    n, side = len(log.position), max(2, round(START_S / log.period))
    speed = np.zeros(n)
    if n > 2 * side:
        speed[side:-side] = (log.position[2 * side :] - log.position[: -2 * side]) / (2 * side * log.period)
    return speed


def _growth(point: Mapping[str, float], speed: np.ndarray) -> np.ndarray:
    """Rate at which an error of the speed grows, 1/s, at least 0."""
    rate = np.zeros(len(speed))
    for way, here in (("forward", speed > 0.0), ("backward", speed < 0.0)):
        c, s, vs, b = (point[f"friction.{way}.{n}"] for n in ("coulomb", "static", "stribeck_speed", "viscous"))
        v = np.abs(speed) / vs
        fall = (s - c) * 2.0 * v / vs * np.exp(-np.minimum(v * v, 500.0)) - b
        rate = np.where(here, np.maximum(fall, 0.0) / point["mass"], rate)
    return rate


class Windows:
    """Residuals of all windows at once; ``x`` are the variables of :class:`Scales`."""

    def __init__(self, log: AxisLog, scale: Scales, pieces: Cut, held: bool = False) -> None:
        self.held = held
        """Start positions are the measured ones."""
        self.log, self.scale, self.loop = log, scale, played(log)
        self.pieces, self.first, self.length = pieces, pieces.first, pieces.length
        self.longest = int(self.length.max())
        rows = np.minimum(self.first[:, None] + np.arange(self.longest), len(log.position) - 1)
        short = self.length <= self.longest // 4
        self.groups = [g for g in (np.flatnonzero(short), np.flatnonzero(~short)) if len(g)]
        self.inside = np.arange(self.longest) < self.length[:, None]
        self.used, self.counted = np.ones(len(self.first), dtype=bool), self.inside
        self.measured = log.position[rows]
        record = record_of(log)
        begins = [start_state(log, int(k), record.noise) for k in self.first]
        self.position = np.array([b[0] for b in begins])
        self.speed = np.array([b[1] for b in begins])
        self.top = float(np.max(np.abs(self.speed))) or 1.0
        self.noise = record.noise
        self.moves = np.array([not _rests(record, int(k)) for k in self.first])
        self.speed[~self.moves] = 0.0
        self.seen = self.speed.copy()
        self.runs = 0
        self._known: tuple[bytes, np.ndarray, np.ndarray, np.ndarray] | None = None

    def simulate(self, points: list[np.ndarray], speeds: list[np.ndarray]) -> np.ndarray:
        """``[point, window, sample]``, model less measured; short windows do not wait for long ones."""
        table = np.zeros((len(points), len(self.first), self.longest))
        values, delays = [self.scale.point(x) for x in points], [self.scale.delay(x) for x in points]
        for group in self.groups:
            w, most = len(group), int(self.length[group].max())
            starts = Starts(
                np.tile(self.first[group], len(points)), np.tile(self.position[group], len(points)),
                np.concatenate([v[group] for v in speeds]),
            )  # fmt: skip
            runs = [p for p in values for _ in range(w)]
            self.runs += len(runs)
            rows = play(self.loop, runs, starts, most, np.repeat(delays, w).tolist())
            table[:, group, :most] = rows.reshape(len(points), w, most)
        return np.where(self.inside, table - self.measured, 0.0)

    def _centred(self, rows: np.ndarray) -> np.ndarray:
        if self.held:
            return rows
        mean = rows.sum(axis=-1, keepdims=True) / self.length[:, None]
        return np.where(self.inside, rows - mean, 0.0)

    def _without(self, rows: np.ndarray, by_speed: np.ndarray) -> np.ndarray:
        """Less what a start position and speed can make."""
        rows = self._centred(rows)
        size = np.sum(by_speed * by_speed, axis=-1)
        share = np.sum(rows * by_speed, axis=-1) / np.where(size > 0.0, size, 1.0)
        return np.asarray(rows - share[..., None] * by_speed)

    def solve(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Residuals ``[window, sample]``, their derivative by the start speeds, and those speeds.

        A step that does not bring a window nearer to the log is not taken: where the axis sticks, it may lead astray.
        """
        if self._known is not None and self._known[0] == x.tobytes():
            return self._known[1:]
        others = [self.seen] if self._known is None else []
        for _ in range(SPEED_STEPS if others else 1):
            speed, left, by_speed = self._nearest(x, [self.speed, *others])
            self.speed, others = speed, [speed - self._share(left, by_speed)]
        speed, left, by_speed = self._nearest(x, [self.speed, *others])
        self.speed = speed
        self._known = (x.tobytes(), left, by_speed, speed)
        return left, by_speed, speed

    def _nearest(self, x: np.ndarray, tries: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The best of some start speeds, window by window: speed, residual and its derivative by the speed."""
        step, n = STEP * self.top, len(tries)
        found = self._centred(self.simulate([x] * (2 * n), [*tries, *(v + step for v in tries)]))
        best, every = np.argmin(np.sum(found[:n] ** 2, axis=2), axis=0), np.arange(len(self.first))
        left, more = found[best, every], found[n + best, every]
        by_speed = np.where(self.moves[:, None], (more - left) / step, 0.0)
        return np.array(tries)[best, every], left, by_speed

    def _share(self, left: np.ndarray, by_speed: np.ndarray) -> np.ndarray:
        size = np.sum(by_speed * by_speed, axis=1)
        change = np.sum(left * by_speed, axis=1) / np.where(size > 0.0, size, 1.0)
        return np.clip(change, -0.2 * self.top, 0.2 * self.top)

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """All windows in one row."""
        return np.asarray(self.solve(x)[0][self.counted])

    def choose(self, x: np.ndarray) -> bool:
        """Leaves out windows that the model misses by far more than the others; whether that changes anything."""
        size = np.sqrt(np.sum(self.solve(x)[0] ** 2, axis=1) / self.length)
        used = size <= FAR * float(np.median(size))
        changed = bool((used != self.used).any())
        self.used, self.counted = used, self.inside & used[:, None]
        return changed

    def jacobian(self, x: np.ndarray, central: bool = False) -> np.ndarray:
        """``[sample, variable]``; one-sided differences, or to both sides."""
        _, by_speed, speed = self.solve(x)
        ups = [x + STEP * row for row in np.eye(len(x))]
        downs = [np.maximum(x - STEP * row, self.scale.low) for row in np.eye(len(x))] if central else [x]
        found = self.simulate([*ups, *downs], [speed] * (len(ups) + len(downs)))
        columns = []
        for i, up in enumerate(ups):
            down = downs[i if central else 0]
            change = (found[i] - found[len(ups) + (i if central else 0)]) / (up[i] - down[i])
            columns.append(self._without(change, by_speed)[self.counted])
        return np.column_stack(columns)

    @property
    def cluster(self) -> np.ndarray:
        """Window of each entry of :meth:`residuals`; short windows side by side count as one."""
        block = max(1, round(TOGETHER_S / self.log.period))
        _, index = np.unique(self.first // block, return_inverse=True)
        return np.asarray(np.repeat(index[self.used], self.length[self.used]))

    def begin(self, x: np.ndarray) -> tuple[float, float]:
        """Position and speed with which the first window fits best."""
        speed = self.solve(x)[2]
        raw = self.simulate([x], [speed])[0][0]
        shift = 0.0 if self.held else float(raw[: self.length[0]].mean())
        return float(self.position[0]) - shift, float(speed[0])


def _rests(record: Record, first: int) -> bool:
    """Whether nothing moves around a sample beyond what the scale's noise makes."""
    side = max(2, round(START_S / record.period))
    near = record.position[max(0, first - side) : first + side + 1]
    half = len(near) // 2
    way = abs(float(near[-half:].mean() - near[:half].mean()))
    return way <= max(1.5 * record.count, 4.0 * record.noise)
