"""Refinement of an axis model by simulation: the parameters with which the plant itself comes nearest to the log.

    minimise  sum_k (x_k(theta) - y_k)^2        x: leadscrew.plants._servo_axis under the logged drive

by trust-region least squares (SciPy) in scaled variables; all simulations of an iteration are one ``Loop.batch``.

- ``windows``: pieces of 0.7 s, each with a free start position and speed (:class:`Windows`): multiple shooting.
  The logged drive acted exactly as it is in the log, so with noise of the sensor alone this is maximum likelihood, in
  closed loop too. A force that the model does not know is forgotten at the next window.
- ``open``: the whole log in one, its start speed free, and its start position too where nothing but the sensor's noise
  is left. Nothing is forgotten: what the model lacks adds up twice.
- ``closed``: the known cascade closes the loop on the model under the logged command. What is left is small, and tells
  of the parameters only as much as the controller lets them show.

Covariances are those of :func:`leadscrew.identify.estimation.clustered`; ``at_bound`` names a parameter on its bound.
H. G. Bock, *Recent advances in parameter identification techniques for ODE*, 1983, for multiple shooting; L. Ljung,
*System Identification* (2nd ed., 1999), section 7.4 for the output-error method.

Windows of a log, each with a start position and speed of its own, which are solved for inside (variable projection).

With ``x_w(theta, p_w, v_w)`` the model's position in window ``w`` and ``y`` the measured one,

    r_w(theta) = min over p_w, v_w of  x_w(theta, p_w, v_w) - y_w

The start position shifts the whole window, so it takes the mean out. In sliding the start speed acts linearly: one step
of Gauss and Newton finds it; where the axis stops within the window a second step is taken from there. A window that
begins at rest begins with speed 0. Windows begin where the axis moves fastest nearby, since there a start speed is what
it seems; the derivative is that of L. Kaufman, *A variable projection method*, BIT 15 (1975) 49.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from leadscrew.identify.axis.cascade import closed_loop
from leadscrew.identify.axis.record import Record, record_of
from leadscrew.identify.axis.replay import played
from leadscrew.identify.axis.simulation import NO_STRIBECK, START_S, plant_values, start_state
from leadscrew.identify.estimation import Spread, clustered, correlations, inverse, quantile
from leadscrew.identify.log_player import LOST, Starts
from leadscrew.kernel import validate
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

if TYPE_CHECKING:
    from leadscrew.identify.axis.cascade import Cascade
    from leadscrew.logs import AxisLog


LOGARITHMS = ("mass", "force_per_drive", "stribeck_speed")
"""Fitted as logarithms; all others as multiples of their own size, so that they may come down to zero."""
FACTOR = 100.0
"""A logarithm stays within this factor of where it starts."""
LONGEST_DELAY = 7.0
"""Periods."""


@dataclass(frozen=True)
class Scales:
    """Fitted keys, and how each becomes a variable."""

    keys: tuple[str, ...]
    base: dict[str, float]
    """All values at the start."""
    symmetric: bool
    size: np.ndarray
    """Value of one unit of each variable, for those that are not logarithms."""
    logs: np.ndarray
    origin: np.ndarray
    low: np.ndarray
    high: np.ndarray
    force_per_drive: float | None
    delay_s: float

    def values(self, x: np.ndarray) -> dict[str, float]:
        """All values at a point, both directions."""
        found = dict(self.base)
        for key, at, size, log in zip(self.keys, x, self.size, self.logs, strict=True):
            found[key] = float(size * math.exp(at) if log else size * at)
        return {k: v for k, v in found.items() if not (self.symmetric and k.startswith("friction.backward."))}

    def point(self, x: np.ndarray) -> dict[str, float]:
        """The plant's values at a point."""
        return plant_values(self.values(x), self.force_per_drive)

    def delay(self, x: np.ndarray) -> float:
        """Seconds from a logged drive to its act."""
        return float(x[self.keys.index("delay_s")] * self.size[self.keys.index("delay_s")]) if (
            "delay_s" in self.keys
        ) else self.delay_s  # fmt: skip

    def per_variable(self, x: np.ndarray) -> np.ndarray:
        """Change of each value for a change of its variable."""
        return np.where(self.logs, self.size * np.exp(np.where(self.logs, x, 0.0)), self.size)


def scales(log: AxisLog, start: Mapping[str, float], fitted: Sequence[str], symmetric: bool, delay_s: float) -> Scales:
    """The variables of a fit.

    Raises:
        NameUnknown: a fitted key that no axis has.
        ValueRefused: nothing to fit; a key twice; a backward key of a symmetric model; a drive's force and all that is
            in its unit together, which no log can tell; a start that is not positive where it must be.
    """
    keys = tuple(fitted)
    if not keys or len(set(keys)) != len(keys):
        raise ValueRefused(f"fitted = {list(keys)}: expected one or more keys, each once")
    if symmetric and any(k.startswith("friction.backward.") for k in keys):
        raise ValueRefused("fitted: a symmetric model has no backward friction of its own; leave out its keys")
    if {"mass", "force_per_drive"} <= set(keys):
        raise ValueRefused("fitted: mass and force_per_drive are not identifiable together; give one of them")
    if not symmetric and {"offset", "friction.forward.coulomb", "friction.backward.coulomb"} <= set(keys):
        raise ValueRefused(
            "fitted: offset and Coulomb friction of both directions together; no log tells them apart, since what is "
            "added to one may be taken from the others: leave out offset"
        )
    base = _tied({k: float(v) for k, v in start.items()}, keys, symmetric)
    full = plant_values(base, log.force_per_drive) | {"delay_s": delay_s}
    for key in keys:
        if key not in full:
            raise NameUnknown(f"fitted: {key!r} is not what a refinement fits; it fits {', '.join(sorted(full))}")
    top = float(np.max(np.abs(np.gradient(log.position, log.period))))
    force = max(full["friction.forward.coulomb"], 0.02 * float(np.std(log.drive)) * abs(full["force_per_drive"]))
    sizes = {"offset": force, "coulomb": force, "static": force, "viscous": force / max(top, 1e-12)}
    sizes |= {"delay_s": log.period, "backlash": 1e-4 * float(np.ptp(log.position))}
    size, logs, origin, low, high = [], [], [], [], []
    for key in keys:
        name = key.rsplit(".", 1)[-1]
        log_like = name in LOGARITHMS
        if log_like and full[key] == 0.0:
            raise ValueRefused(f"start: {key} = 0; its fit needs a start that is not 0")
        unit = full[key] if log_like else max(sizes[name], abs(full[key]) if name != "offset" else 0.0)
        size.append(unit)
        logs.append(log_like)
        origin.append(0.0 if log_like else full[key] / unit)
        low.append(-math.log(FACTOR) if log_like else -np.inf if name == "offset" else 0.0)
        high.append(math.log(FACTOR) if log_like else LONGEST_DELAY if name == "delay_s" else np.inf)
    return Scales(
        keys, base, symmetric, np.array(size), np.array(logs), np.array(origin), np.array(low), np.array(high),
        log.force_per_drive, delay_s,
    )  # fmt: skip


def _tied(base: dict[str, float], keys: Sequence[str], symmetric: bool) -> dict[str, float]:
    """Without what follows another value: static friction that is Coulomb friction, backward that is forward."""
    found = dict(base)
    found.pop("delay_s", None)
    for way in ("forward", "backward"):
        static, coulomb = f"friction.{way}.static", f"friction.{way}.coulomb"
        same = found.get(static) == found.get(coulomb, found.get("friction.forward.coulomb"))
        if static not in keys and same:
            found.pop(static, None)
        speed = f"friction.{way}.stribeck_speed"
        if speed in keys and not found.get(speed, NO_STRIBECK) > 0.0:
            raise ValueRefused(f"start: {speed} = {found[speed]:g}: must be above 0")
    if symmetric:
        found = {k: v for k, v in found.items() if not k.startswith("friction.backward.")}
    return found


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


def differences(
    simulate: Callable[[list[np.ndarray]], np.ndarray], x: np.ndarray, low: np.ndarray, central: bool
) -> list[np.ndarray]:
    """Change of what is simulated by each variable; one-sided, or to both sides where bounds leave room."""
    steps = STEP * np.eye(len(x))
    ups = [x + step for step in steps]
    downs = [np.maximum(x - step, low) for step in steps] if central else [x] * len(x)
    found = simulate([*ups, *(downs if central else [x])])
    below = found[len(x) :] if central else [found[-1]] * len(x)
    return [(found[i] - below[i]) / (ups[i] - downs[i])[i] for i in range(len(x))]


class Windows:
    """Residuals of all windows at once; ``x`` are the variables of :class:`Scales`."""

    def __init__(self, log: AxisLog, scale: Scales, pieces: Cut, held: bool = False) -> None:
        self.held = held
        """Start positions are the measured ones."""
        self.log, self.scale, self.player = log, scale, played(log)
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
            rows = self.player.play(runs, starts, most, np.repeat(delays, w).tolist())
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
        changes = differences(lambda at: self.simulate(at, [speed] * len(at)), x, self.scale.low, central)
        return np.column_stack([self._without(change, by_speed)[self.counted] for change in changes])

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


BLOCK_S = 0.5
"""Blocks of time that count as independent where there are no windows."""


class Closed:
    """The log's whole command played on the closed loop."""

    def __init__(self, log: AxisLog, scale: Scales, cascade: Cascade) -> None:
        self.log, self.scale, self.player, self.runs = log, scale, closed_loop(log, cascade), 0
        self.start = start_state(log)

    def simulate(self, points: list[np.ndarray]) -> np.ndarray:
        """``[point, sample]``, model less measured."""
        self.runs += len(points)
        values, delays = [self.scale.point(x) for x in points], [self.scale.delay(x) for x in points]
        starts = Starts.together(self.start, len(points))
        return self.player.play(values, starts, len(self.log.time), delays) - self.log.position

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """All samples."""
        return self.simulate([x])[0]

    def jacobian(self, x: np.ndarray, central: bool = False) -> np.ndarray:
        """``[sample, variable]``; one-sided differences, or to both sides."""
        return np.column_stack(differences(self.simulate, x, self.scale.low, central))

    @property
    def cluster(self) -> np.ndarray:
        """Block of time of each sample."""
        return np.arange(len(self.log.time)) // max(1, round(BLOCK_S / self.log.period))

    def begin(self, x: np.ndarray) -> tuple[float, float]:
        """As measured."""
        return self.start


SHORT_S = 0.02
"""Over which a force is averaged for a look at what disturbs."""


def by_force(jacobian: np.ndarray, left: np.ndarray, period: float, rate: float, block_s: float) -> Spread:
    """Covariance of an open-loop fit, whose residual is a disturbing force integrated twice.

    ``rate`` is viscous friction over mass. The residual is taken back to the force that makes it, ``left = G w`` with
    ``G`` the mass under viscous friction, so that ``X' left = (G' X)' w``: what adds up are blocks of time in ``w``,
    which are independent where those of ``left`` are not.
    """
    from scipy.signal import lfilter

    middle, condition = inverse(jacobian)
    kept = float(np.exp(-rate * period))
    a = np.array([1.0, -1.0 - kept, kept])
    force, turned = lfilter(a, [1.0], left), lfilter(a, [1.0], jacobian, axis=0)
    # what the fit itself is off by is in the force too, and would be counted as noise: least squares takes it out
    some = np.arange(0, len(left), max(1, round(SHORT_S / period)))
    off, *_ = np.linalg.lstsq(np.add.reduceat(turned, some, axis=0), np.add.reduceat(force, some), rcond=None)
    force = force - turned @ off
    adjoint = lfilter([1.0], a, jacobian[::-1], axis=0)[::-1]
    block = max(1, round(block_s / period))
    score = np.add.reduceat(adjoint * force[:, None], np.arange(0, len(left), block), axis=0)
    spare = max(1.0, len(score) - jacobian.shape[1] - 2.0)
    covariance = middle @ (score.T @ score) @ middle * len(score) / spare
    return Spread(covariance, np.full(jacobian.shape[1], spare), condition)


Mode = Literal["open", "windows", "closed"]

DRIFTS = 0.9
"""Correlation of a residual from sample to sample above which it is a force integrated, not noise of the sensor."""
BEYOND = 20.0
"""An open-loop residual of more than so many times the sensor's noise is no noise; then the start position stays the
measured one, which a free one would leave to make up for what the model lacks."""
FLOOR = 5e-5
"""Standard error, as a share of the value, that is always there: simulations of the same axis in finer steps, and
drives that are logged rounded, give values that differ by so much."""
CLOCK = 2e-3
"""The same for a delay, in periods: a clock that samples is not better."""
ROUNDS = 3
"""How often windows are chosen anew, at most."""
MOST = 30
"""Evaluations of an optimisation, at most."""


@dataclass(frozen=True)
class Refined:
    """What a refinement found."""

    mode: Mode
    keys: tuple[str, ...]
    """Fitted keys, in the order of ``covariance``."""
    values: dict[str, float]
    """All values, both directions, the fitted ones and those that were kept."""
    covariance: np.ndarray
    """Of the fitted values, in their units."""
    standard_error: dict[str, float]
    degrees: dict[str, float]
    """Degrees of freedom of Student's t, by fitted key."""
    interval: dict[str, tuple[float, float]]
    """95 %."""
    condition: float
    """Columns of the Jacobian scaled to the same length."""
    correlation: dict[str, dict[str, float]]
    rms: float
    """Of what is left, m or rad."""
    residual: np.ndarray
    """Model less measured, window after window; free starts are taken out."""
    window: np.ndarray
    """Window of each entry of ``residual``; whiteness is judged within windows."""
    windows: int
    left_out: int
    """Windows that the model misses by far more than the others."""
    start_state: tuple[float, float]
    """Position and speed at the first sample; in ``open`` mode those that fit best."""
    at_bound: tuple[str, ...]
    runs: int
    converged: bool
    message: str


def refine(
    log: AxisLog,
    start: Mapping[str, float],
    fitted: Sequence[str],
    symmetric: bool = False,
    mode: Mode = "windows",
    delay_s: float = 0.0,
    cascade: Cascade | None = None,
    progress: Callable[[str, float], None] | None = None,
    *,
    window_s: float | None = None,
) -> Refined:
    """The values of ``fitted`` with which the simulated axis comes nearest to the log, from ``start`` downhill.

    Args:
        log: evenly sampled; is not changed.
        start: values by key of the plant; those that are not fitted stay. Static friction that equals Coulomb friction
            and is not fitted follows it.
        fitted: keys, ``delay_s`` among them where the delay is to be fitted.
        symmetric: friction alike both ways; ``friction.forward.*`` then speaks for both.
        mode: ``windows``, ``open`` or ``closed``.
        delay_s: from a logged drive to its act, where it is not fitted; where it is, its start.
        cascade: the loop that was active, for ``closed``.
        progress: gets what happens and the fraction done.
        window_s: length of a window, s; 0.7 unless given, less in a short log.

    Raises:
        NameUnknown, ValueRefused: an unknown key, mode or value; ``closed`` without a cascade.
        DataError: the simulation diverges at the start; the log is too short; no command for ``closed``.
    """
    validate.one_of("mode", mode, ["open", "windows", "closed"])
    scale = scales(log, start, fitted, symmetric, delay_s)
    problem = _problem(log, scale, mode, cascade, window_s)
    found = _descend(log, scale, problem, mode, progress)
    if isinstance(problem, Windows) and problem.held:
        left = problem.residuals(found[0])
        if float(np.sqrt(np.mean(left * left))) <= BEYOND * problem.noise:
            problem = Windows(log, scale, problem.pieces)
            found = _descend(log, scale, problem, mode, progress, found[0])
    if isinstance(problem, Windows) and mode == "windows":
        for _ in range(ROUNDS):
            if not problem.choose(found[0]):
                break
            found = _descend(log, scale, problem, mode, progress, found[0])
    return _result(log, scale, problem, mode, *found)


def _descend(
    log: AxisLog, scale: Scales, problem: Windows | Closed, mode: Mode, progress: Callable[[str, float], None] | None,
    begin: np.ndarray | None = None,
) -> tuple[np.ndarray, bool, str]:  # fmt: skip
    from scipy.optimize import least_squares

    say = progress or (lambda what, done: None)
    x = np.clip(scale.origin if begin is None else begin, scale.low, scale.high)
    first = problem.residuals(x)
    if np.max(np.abs(first)) >= 0.5 * LOST:
        raise DataError(f"{log.source}: the simulated axis diverges with the values that the refinement starts from")
    unit = max(float(np.sqrt(np.mean(first * first))), 1e-15)
    steps = 0

    def residuals(at: np.ndarray) -> np.ndarray:
        return problem.residuals(at) / unit

    def jacobian(at: np.ndarray) -> np.ndarray:
        nonlocal steps
        steps += 1
        say(f"refinement ({mode})", 1.0 - 0.8**steps)
        return problem.jacobian(at) / unit

    best = least_squares(
        residuals, x, jacobian, bounds=(scale.low, scale.high), x_scale="jac",
        ftol=1e-6 if mode == "open" else 1e-8, xtol=1e-6, gtol=1e-12,
        max_nfev=MOST,
    )  # fmt: skip
    return best.x, bool(best.status > 0), str(best.message)


def _problem(
    log: AxisLog, scale: Scales, mode: Mode, cascade: Cascade | None, window_s: float | None
) -> Windows | Closed:
    if mode == "closed":
        if cascade is None:
            raise ValueRefused("mode = 'closed': give the cascade that was active while the log was made")
        return Closed(log, scale, cascade)
    if window_s is not None:
        validate.positive("window_s", window_s, "s")
    if mode == "open":
        return Windows(log, scale, whole(log), held=True)
    return Windows(log, scale, cut(log, scale.point(scale.origin), window_s))


def _result(
    log: AxisLog, scale: Scales, problem: Windows | Closed, mode: Mode, x: np.ndarray, converged: bool, message: str
) -> Refined:
    left, jacobian = problem.residuals(x), problem.jacobian(x, central=True)
    spread = _spread(log, scale, problem, x, mode, left, jacobian)
    per = scale.per_variable(x)
    least = FLOOR * np.where(scale.logs, 1.0, np.abs(x))
    least = np.where([k == "delay_s" for k in scale.keys], CLOCK, least)
    spread = spread._replace(covariance=spread.covariance + np.diag(least * least))
    covariance = spread.covariance * np.outer(per, per)
    error = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    at_bound = tuple(k for k, v, low, high in zip(scale.keys, x, scale.low, scale.high, strict=True)
                     if v <= low + 1e-6 or v >= high - 1e-6)  # fmt: skip
    values = scale.values(x)
    full = scale.point(x) | {k: v for k, v in values.items() if k not in scale.point(x)}
    cluster = problem.cluster
    return Refined(
        mode=mode, keys=scale.keys, values=full | {"delay_s": scale.delay(x)}, covariance=covariance,
        standard_error=dict(zip(scale.keys, error.tolist(), strict=True)),
        degrees=dict(zip(scale.keys, spread.degrees.tolist(), strict=True)),
        interval=_intervals(scale, x, spread), condition=spread.condition,
        correlation=correlations(covariance, scale.keys),
        rms=float(np.sqrt(np.mean(left * left))), residual=left, window=cluster, windows=int(np.unique(cluster).size),
        left_out=int(np.sum(~problem.used)) if isinstance(problem, Windows) else 0,
        start_state=problem.begin(x), at_bound=at_bound, runs=problem.runs, converged=converged, message=message,
    )  # fmt: skip


def _spread(
    log: AxisLog, scale: Scales, problem: Windows | Closed, x: np.ndarray, mode: Mode, left: np.ndarray,
    jacobian: np.ndarray,
) -> Spread:  # fmt: skip
    if mode == "open":
        steady = float(left[1:] @ left[:-1]) / max(float(left @ left), 1e-300)
        if steady > DRIFTS:
            point = scale.point(x)
            rate = 0.5 * (point["friction.forward.viscous"] + point["friction.backward.viscous"]) / point["mass"]
            return by_force(jacobian, left, log.period, rate, BLOCK_S)
        return clustered(jacobian, left, np.arange(len(left)) // max(1, round(BLOCK_S / log.period)))
    return clustered(jacobian, left, problem.cluster)


def _intervals(scale: Scales, x: np.ndarray, spread: Spread) -> dict[str, tuple[float, float]]:
    """95 %, in the variable that was fitted: a logarithm's interval does not reach zero."""
    reach = np.array([quantile(d) for d in spread.degrees]) * np.sqrt(np.maximum(np.diag(spread.covariance), 0.0))
    found = {}
    for i, key in enumerate(scale.keys):
        ends = [x[i] - reach[i], x[i] + reach[i]]
        low, high = (
            scale.size[i] * np.exp(np.clip(e, -700, 700)) if scale.logs[i] else scale.size[i] * e for e in ends
        )
        found[key] = (float(min(low, high)), float(max(low, high)))
    return found
