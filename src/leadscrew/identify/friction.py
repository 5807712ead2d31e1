"""LuGre friction of an axis from one log of torque and position.

1. Sliding, by linear least squares: ``F_C``, ``sigma_2``, the inertia and an offset
   (:mod:`leadscrew.identify.friction_record`).
2. Around every standstill, by simulation: ``sigma_0, sigma_1, F_S, v_s`` minimise what the log's position differs
   from a model that is driven by the log's torque (:mod:`leadscrew.identify.friction_record`),

        minimise  sum_k rho((y_k - y_k(theta)) / noise),      rho(r) = 18 (sqrt(1 + r^2 / 9) - 1)

   in the logarithms of the parameters, over the instants in which the reading changes. ``rho`` is quadratic up to three
   times the noise and linear beyond, so a single slip that the model makes a sample late does not decide. All
   simulations of an iteration are one ``Loop.batch``. Start angle and start speed of a piece are free (linearised).

The cost has several minima along ``v_s``. Trust-region least squares starts from the best points of a scan over
``F_S - F_C`` and ``v_s``, one after another, until the residuals are white and no larger than the noise
(:class:`Residuals`); where none are, the least cost is taken and ``consistent`` is false.

Standard errors are those of a linearised fit, not below the noise, with the errors of inertia, Coulomb and viscous
friction carried over from step 1. A stroke that repeats another count by count counts once. Static friction and
Stribeck speed act in slow motion only: sines of millimetres do not determine them, the record of
:obj:`leadscrew.references.friction_test` does. Where they are not identifiable they stay near usual values (F_S = 1.5
F_C; v_s a 3,300th of the top speed), each weighed as one sample that is off by the noise at a factor of e.

The method is ours; for the model see :mod:`leadscrew.friction.lugre`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from leadscrew.friction.lugre import LuGre
from leadscrew.identify.estimation import SHARE, Parameter, correlations, fitted, identifiable, quantile
from leadscrew.identify.friction_record import Piece, Record, Sliding, checked, pieces, replay_loop, sliding
from leadscrew.kernel import validate
from leadscrew.util.errors import DataError

WORSE = 20.0
"""Rise of the cost, in squared noise, that half and double of ``F_S - F_C`` must bring for it to be identifiable: what
six standard deviations bring."""
FITTED = ("stiffness", "damping", "static", "stribeck_speed")
UNITS = {
    "stiffness": "N m/rad", "damping": "N m s/rad", "viscous": "N m s/rad", "coulomb": "N m", "static": "N m",
    "stribeck_speed": "rad/s",
}  # fmt: skip
USUAL_SPEED = 3e-4
"""Usual Stribeck speed, as a share of the top speed."""
ROBUST, BEYOND = 3.0, 9.0
"""Differences beyond the first many times the noise count linearly, beyond the second not in errors."""
LAGS, FEW = 5, 8
"""Lags of the autocorrelation, and samples that a piece has at least, in the test of the residuals."""
REPEATS = 0.6
"""Share of equal readings above which a stroke is a repetition of another."""
FINE = 0.02
"""Noise, in counts, of the position in the instant in which a scale counts; more where it counts often."""
STARTS = 4
"""Stribeck speeds that a descent starts from: the best of a scan."""
SAME = 0.05
"""Logarithm by which all four parameters of two descents differ at most where they ended in the same valley."""
LOST = 1e6
HIGHEST = 1e3
"""A descent changes each parameter by this factor at most."""
MOST_SIMULATED = 60_000
"""Samples in pieces that one simulation takes at most: pieces beyond are left out."""


class Residuals(NamedTuple):
    """Log minus model around the stand-stills, in units of the noise; each sample counts as :data:`BEYOND` at most.

    White residuals of the noise's size have ``rms`` 1 and ``slow`` 1. The limits lie above by a quarter (of ``slow``: a
    half) and four standard deviations of the scatter of as many samples.
    """

    rms: float
    """Of all pieces."""
    slow: float
    """Spectral density at low frequency, ``mean r^2 (1 + 2 sum_k (1 - k / 6) rho_k)`` up to lag 5, of all pieces."""
    why_not: str = ""
    """How they differ from white noise of the log's size; empty where they do not."""

    @property
    def consistent(self) -> bool:
        """Whether the model leaves white noise of the log's size and no more."""
        return not self.why_not

    @classmethod
    def of(cls, pieces: Mapping[float, np.ndarray]) -> Residuals:
        """Of the residuals of each piece, by the time in s at which it begins."""
        kept = {at: np.clip(r, -BEYOND, BEYOND) for at, r in pieces.items() if len(r) >= FEW}
        rms, slow = _size(list(kept.values()))
        why = _excess(rms, slow, sum(len(r) for r in kept.values()))
        if not why:
            for at, r in kept.items():
                excess = _excess(*_size([r]), len(r))
                if excess:
                    why = f"{excess} around the standstill at {at:.4g} s"
                    break
        return cls(rms, slow, why)


def _size(pieces: list[np.ndarray]) -> tuple[float, float]:
    """Root mean square, and density at low frequency (Bartlett's weights)."""
    n = max(1, sum(len(r) for r in pieces))
    square = sum(float(r @ r) for r in pieces) / n
    shared = [sum(float(r[k:] @ r[:-k]) for r in pieces if len(r) > k) / n for k in range(1, LAGS + 1)]
    slow = square + 2.0 * sum((1.0 - k / (LAGS + 1.0)) * c for k, c in enumerate(shared, 1))
    return math.sqrt(square), slow


def _excess(rms: float, slow: float, n: int) -> str:
    n = max(n, 1)
    if rms > 1.25 + 4.0 / math.sqrt(2.0 * n):
        return f"the residuals are {rms:.2g} times the noise"
    if slow > 1.5 + 4.0 * math.sqrt(6.0 / n):
        return f"the residuals are not white (their power at low frequency is {slow:.2g} times that of the noise)"
    return ""


@dataclass(frozen=True)
class FrictionFit:
    """Parameters in rad and N m (or in m and N, as the log is), and how well the log determines them."""

    friction: LuGre
    inertia: float
    inertia_given: bool
    """Given by the caller, not from the log."""
    offset: float
    """Torque that does not turn with the direction."""
    standard_error: dict[str, float]
    """Of each parameter, in its unit; infinite where the log does not determine it."""
    parameters: dict[str, Parameter]
    """The six of the friction, with their intervals."""
    correlation: dict[str, dict[str, float]]
    """Between the four of the second step."""
    condition: float
    """Of the second step, in relative changes: how much better the best known direction is known than the worst."""
    residuals: Residuals
    noise: float
    """Of the log's position."""
    sliding: Sliding
    pieces: int
    simulations: int

    @property
    def rms(self) -> float:
        """Residual of the position, in the unit of the log."""
        return self.residuals.rms * self.noise

    @property
    def consistent(self) -> bool:
        """Whether the model leaves white noise of the log's size: if not, the standard errors do not hold."""
        return self.residuals.consistent

    @property
    def identifiable(self) -> dict[str, bool]:
        """Of each of the six."""
        return {name: p.identifiable for name, p in self.parameters.items()}

    def known(self) -> dict[str, float]:
        """The identifiable parameters."""
        return {name: p.value for name, p in self.parameters.items() if p.identifiable}

    def as_dict(self) -> dict[str, Any]:
        """The fit for JSON."""
        return {
            "parameters": {
                name: {**p._asdict(), "standard_error": self.standard_error[name]}
                for name, p in self.parameters.items()
            },
            "inertia": {
                "value": self.inertia, "standard_error": self.standard_error["inertia"], "given": self.inertia_given,
            },
            "offset": {"value": self.offset, "standard_error": self.standard_error["offset"]},
            "condition": self.condition,
            "correlation": self.correlation,
            "rms": self.rms,
            "noise": self.noise,
            "consistent": self.consistent,
            "residuals": self.residuals._asdict(),
            "sliding_windows": self.sliding.windows,
            "pieces": self.pieces,
            "simulations": self.simulations,
        }  # fmt: skip


def fit_friction(
    time_s: np.ndarray,
    torque: np.ndarray,
    angle: np.ndarray,
    *,
    inertia: float | None = None,
    delay: int = 0,
    progress: Callable[[str, float], None] | None = None,
) -> FrictionFit:
    """LuGre friction from one log.

    Args:
        time_s: evenly spaced, every 2 ms or faster.
        torque: commanded, N m; held from each sample to the next.
        angle: measured, rad.
        inertia: kg m^2; from the log unless given.
        delay: periods from a logged torque to its act.
        progress: gets what happens and the fraction done.

    Raises:
        DataError: the log is malformed, or does not determine friction: no reversal, no sliding, no stand-still,
            torque and position swapped, inertia, stiffness or damping not identifiable.
    """
    say = progress or (lambda what, done: None)
    if inertia is not None:
        inertia = validate.positive("inertia", inertia, "kg m^2")
    say("sliding", 0.0)
    record = checked(time_s, torque, angle, delay)
    slide = sliding(record)
    known_inertia = inertia if inertia is not None else _inertia(slide)
    found = _limited(_distinct(record, pieces(record, slide)))
    if not found:
        raise DataError(
            "the log has no standstill in which the torque changes by half of Coulomb friction: let the axis reverse, "
            "or come to rest and move off again"
        )
    problem = _Problem(record, slide, known_inertia, found)
    starts = problem.multistart(lambda done: say("coarse grid", 0.3 * done))
    best = problem.descend(starts, lambda done: say("descent", 0.3 + 0.7 * done))
    return _result(record, slide, known_inertia, inertia is not None, problem, best)


def _inertia(slide: Sliding) -> float:
    error = slide.standard_error["inertia"]
    if not slide.inertia > 0.0 or not identifiable(slide.inertia, quantile() * error):
        raise DataError(
            f"the log does not determine the inertia ({slide.inertia:.3g} with a standard error of {error:.2g}): give "
            "it, or let the axis accelerate more while it slides"
        )
    return slide.inertia


def _limited(found: list[Piece]) -> list[Piece]:
    kept, total = [], 0
    for piece in found:
        total += piece.length
        if total <= MOST_SIMULATED:
            kept.append(piece)
    return kept


def _distinct(record: Record, found: list[Piece]) -> list[Piece]:
    """Without strokes that repeat an earlier one count by count, mirrored or not: their rounding is the same error."""
    kept: list[Piece] = []
    for piece in found:
        if piece.start_speed == 0.0 or all(_alike(record, piece, other) <= REPEATS for other in kept):
            kept.append(piece)
    return kept


def _alike(record: Record, one: Piece, other: Piece) -> float:
    """Share of the samples that read the same since the start of their piece."""
    if other.start_speed == 0.0:
        return 0.0
    n = min(one.length, other.length)
    a, b = (
        math.copysign(1.0, p.start_speed) * (record.angle[p.first : p.first + n] - record.angle[p.first])
        for p in (one, other)
    )
    return float(np.mean(np.abs(a - b) < 0.5 * record.count))


def _result(
    record: Record, slide: Sliding, inertia: float, given: bool, problem: _Problem, x: np.ndarray
) -> FrictionFit:
    jacobian, left = problem.jacobian(x), problem.residuals(x[None])[0]
    by_piece = problem.by_piece(x)
    inside = np.abs(left) < BEYOND
    rms, slow = _size([r[np.abs(r) < BEYOND] for r in by_piece.values()])
    scale = math.sqrt(max(1.0, rms**2, slow)) if inside.any() else LOST
    _, sizes, directions = np.linalg.svd(jacobian[inside], full_matrices=False)
    usable = np.where(sizes > 1e-9 * sizes[0], sizes, np.nan) if sizes[0] > 0.0 else np.full(4, np.nan)
    inverse = (directions.T / usable**2) @ directions
    # what one standard error of inertia, Coulomb and viscous friction moves
    moved = -inverse @ jacobian[inside].T @ problem.by_sliding(x, given)[inside]
    to_log = np.array([[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    friction = problem.friction(x)
    values = friction._asdict()
    # the third is the logarithm of static above Coulomb friction
    sizes_of = np.array(
        [friction.stiffness, friction.damping, friction.static - friction.coulomb, friction.stribeck_speed]
    )
    to_value = sizes_of[:, None] * to_log
    moved = to_value @ moved
    moved[2, 1] += slide.standard_error["coulomb"]
    covariance = to_value @ inverse @ to_value.T * scale**2 + moved @ moved.T
    spread = np.sqrt(np.diag(covariance))
    errors = {n: float(e) if np.isfinite(e) else math.inf for n, e in zip(FITTED, spread, strict=True)}
    errors |= {n: slide.standard_error[n] for n in ("coulomb", "viscous", "offset")}
    errors["inertia"] = 0.0 if given else slide.standard_error["inertia"]
    # both act through F_S - F_C and trade with one another: not along a straight line, so far away is looked at too
    if problem.worse_elsewhere(x) < WORSE * scale**2:
        errors |= {"static": math.inf, "stribeck_speed": math.inf}
    parameters = {
        n: fitted(
            v, (v - quantile() * errors[n], v + quantile() * errors[n]), UNITS[n],
            counted=friction.static - friction.coulomb if n == "static" else None,
        )
        for n, v in values.items()
    }  # fmt: skip
    poor = [n for n in ("stiffness", "damping") if not parameters[n].identifiable]
    if poor:
        raise DataError(
            f"the log does not determine the {' and the '.join(poor)} of the bristles (half of the 95 % interval above "
            f"{100.0 * SHARE:.0f} % of the value): it needs slower reversals, more of them, or a finer encoder"
        )
    return FrictionFit(
        friction=friction, inertia=inertia, inertia_given=given, offset=slide.offset, standard_error=errors,
        parameters=parameters, correlation=correlations(covariance, FITTED),
        condition=float(sizes[0] / sizes[-1]) if sizes[-1] > 0.0 else math.inf,
        residuals=Residuals.of(by_piece), noise=record.noise, sliding=slide,
        pieces=len(problem.pieces), simulations=problem.simulations,
    )  # fmt: skip


def _smooth(record: Record) -> np.ndarray:
    """The position on straight lines between the instants in which the reading changes, there the mean of both."""
    y = record.angle
    steps = np.flatnonzero(np.abs(np.diff(y)) > 0.5 * record.count)
    return np.interp(np.arange(len(y)), steps + 0.5, 0.5 * (y[steps] + y[steps + 1]))


def _instants(record: Record, piece: Piece) -> tuple[np.ndarray, np.ndarray]:
    """Samples before a change of the reading, no two next to one another, and one over the noise of the mean of both.

    Between two counts a slow axis is known to half a count, in the instant of a count to what it moves in a sample.
    """
    moves = np.abs(np.diff(record.angle[piece.first : piece.first + piece.length])) / record.count
    steps = np.flatnonzero(moves > 0.5)
    if len(steps) < 2:
        every = np.arange(piece.length - 1)
        return every, np.full(len(every), 1.0 / (record.noise * math.sqrt(len(every))))
    gaps = np.diff(steps)
    speed = 1.0 / np.minimum(np.append(gaps, gaps[-1]), np.append(gaps[0], gaps))
    rounding = FINE**2 + np.where(moves[steps] > 1.5, 1.0 / 24.0, speed**2 / 12.0)
    beyond = max(0.0, record.noise**2 - record.count**2 / 12.0)
    new = np.concatenate([[True], np.diff(steps) > 1])
    place = np.arange(len(steps))
    apart = (place - np.maximum.accumulate(np.where(new, place, 0))) % 2 == 0
    return steps[apart], 1.0 / np.sqrt(rounding[apart] * record.count**2 + beyond / 2.0)


def _unit(columns: np.ndarray) -> np.ndarray:
    """Orthonormal columns of the same span."""
    directions, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(directions[:, sizes > 1e-9 * sizes[0]])


class _Problem:
    """Points are ``[point, (ln sigma_0, ln (sigma_1 / sigma_0), ln (F_S - F_C), ln v_s)]``.

    A fast reversal tells the ratio far better than the size.
    """

    def __init__(self, record: Record, slide: Sliding, inertia: float, found: list[Piece]) -> None:
        self.record, self.slide, self.pieces, self.simulations = record, slide, found, 0
        self.inertia = inertia
        smooth = _smooth(record)
        self.rounding = record.angle - smooth
        self.loop = replay_loop(record.torque - slide.offset, smooth, record.period, inertia)
        self.instants = {p.first: _instants(record, p) for p in found}
        self.starts = {p.first: _unit(self.instants[p.first][1][:, None]) for p in found if p.start_speed == 0.0}
        longest = sorted({p.length for p in found})
        # Two batches: short pieces do not wait for long ones.
        edge = longest[-1] // 3
        self.groups = [g for g in ([p for p in found if p.length > edge], [p for p in found if p.length <= edge]) if g]

    def friction(self, x: np.ndarray) -> LuGre:
        """The model at a point."""
        s0, ratio, more, vs = np.exp(x[:4]).tolist()
        coulomb, viscous = self.slide.coulomb, self.slide.viscous
        if len(x) > 4:
            error = self.slide.standard_error
            coulomb, viscous = coulomb + x[5] * error["coulomb"], viscous + x[6] * error["viscous"]
        return LuGre(s0, ratio * s0, max(viscous, 0.0), coulomb, coulomb + more, vs)

    def residuals(self, points: np.ndarray, groups: list[list[Piece]] | None = None) -> np.ndarray:
        """Log minus model in units of the noise, ``[point, sample]``; the last two say how unusual F_S and v_s are."""
        usual = np.log([0.5 * self.slide.coulomb, USUAL_SPEED * self.slide.top_speed])
        parts = [self._group(points, g) for g in groups or self.groups]
        return np.concatenate([*parts, np.asarray(points)[:, 2:4] - usual], axis=1)

    def _group(self, points: np.ndarray, group: list[Piece]) -> np.ndarray:
        parts = []
        for piece, left in zip(group, self._left(points, group), strict=True):
            basis = self.starts.get(piece.first)
            parts.append(left if basis is None else left - (left @ basis) @ basis.T)
        return np.concatenate(parts, axis=1)

    def _left(
        self, points: np.ndarray, group: list[Piece], angle: float = 0.0, speed: float = 0.0
    ) -> list[np.ndarray]:  # fmt: skip
        """Log minus model in units of the noise, ``[point, sample]`` of each piece, from changed starts."""
        n, m = len(points), len(group)
        self.simulations += n * m
        tables = [self.friction(x) for x in points]
        varied = {f"plant.friction.{k}": np.repeat([getattr(f, k) for f in tables], m) for k in LuGre._fields}
        if len(points[0]) > 4:
            error = self.slide.standard_error["inertia"]
            varied["plant.inertia"] = np.repeat([self.inertia + x[4] * error for x in points], m)
        starts = {
            "reference.first": [p.first for p in group],
            "reference.length": [p.length for p in group],
            "plant.start_torque": [p.start_torque - self.slide.offset for p in group],
            "plant.start_speed": [p.start_speed * (1.0 + speed) for p in group],
            "plant.start_angle": [p.start_angle + angle for p in group],
        }
        varied |= {k: np.tile(np.array(v, dtype=np.float64), n) for k, v in starts.items()}
        lasts = max(p.length for p in group) * self.record.period
        batch = self.loop.batch(lasts, varied, runs=n * m, record=("controller.e",))
        table = batch["controller.e"].reshape(n, m, -1)
        parts = []
        for i, piece in enumerate(group):
            steps, weight = self.instants[piece.first]
            rounding = self.rounding[piece.first : piece.first + piece.length]
            e = table[:, i, : piece.length] + rounding
            left = 0.5 * (e[:, steps] + e[:, steps + 1]) * weight
            parts.append(np.clip(np.nan_to_num(left, nan=LOST), -LOST, LOST))
        return parts

    def by_piece(self, x: np.ndarray) -> dict[float, np.ndarray]:
        """Residuals of each piece, by the time at which it begins."""
        return {p.first * self.record.period: self._group(x[None], [p])[0] for g in self.groups for p in g}

    def by_sliding(self, x: np.ndarray, given: bool) -> np.ndarray:
        """Change of the residuals for one standard error of inertia (none where given), Coulomb, viscous friction."""
        points = np.column_stack([np.tile(x, (4, 1)), np.vstack([np.zeros(3), np.eye(3)])])
        if given:
            points[:, 4] = 0.0
        found = self.residuals(points)
        return (found[1:] - found[0]).T

    def free_starts(self, x: np.ndarray) -> None:
        """Leave out what other starts of the moving pieces would change, linearised at ``x``, from now on."""
        for group in ([p for p in g if p.start_speed != 0.0] for g in self.groups):
            if group:
                at, angle, speed = (
                    self._left(x[None], group, a, s) for a, s in ((0.0, 0.0), (self.record.count, 0.0), (0.0, 0.01))
                )
                for i, piece in enumerate(group):
                    self.starts[piece.first] = _unit(np.column_stack([(angle[i] - at[i])[0], (speed[i] - at[i])[0]]))

    def worse_elsewhere(self, x: np.ndarray) -> float:
        """By how much the cost rises, at least, where ``F_S - F_C`` is half or double and ``v_s`` makes up for it."""
        shifts = [(a * math.log(2.0), -a * b) for a in (1.0, -1.0) for b in (0.0, 0.15, 0.3, 0.45)]
        points = np.array([x, *(x + np.array([0.0, 0.0, more, slower]) for more, slower in shifts)])
        left = self.residuals(points)[:, :-2] / ROBUST
        cost = ROBUST**2 * (np.sqrt(1.0 + left**2) - 1.0).sum(axis=1)
        return float(np.min(cost[1:]) - cost[0])

    def jacobian(self, x: np.ndarray, groups: list[list[Piece]] | None = None, step: float = 1e-3) -> np.ndarray:
        """Forward differences, ``[sample, parameter]``."""
        found = self.residuals(np.concatenate([x[None], x + step * np.eye(len(x))]), groups)
        return ((found[1:] - found[0]) / step).T

    def multistart(self, say: Callable[[float], None]) -> list[np.ndarray]:
        """Where descents start, the best first: a grid of stiffness and damping over short pieces, then a scan.

        The cost has a valley along the edge between slipping too early and too late: the scan takes the best
        static friction at each Stribeck speed of a geometric grid.
        """
        some = sorted(self.pieces, key=lambda p: p.length)
        short = [p for p in some if p.length <= 3 * some[len(some) // 2].length][:8]
        coulomb, top = self.slide.coulomb, self.slide.top_speed
        stiffness = coulomb / self._give()
        first = [
            (stiffness * a, b, 0.5 * coulomb, USUAL_SPEED * top)
            for a in 0.1 * 1.3 ** np.arange(17) for b in 3e-4 * 1.8 ** np.arange(7)
        ]  # fmt: skip
        self.free_starts(np.log([stiffness, 3e-3, 0.5 * coulomb, USUAL_SPEED * top]))
        best = self._best(np.log(first), [short])
        say(0.3)
        self.free_starts(best)
        x = self._down(best, [short], 30.0 * ROBUST, 12, 1e-4)
        say(0.5)
        telling = [p for p in some if p.start_speed == 0.0 and p not in short][-1:]
        self.few = [short, telling] if telling else [short]
        shares = USUAL_SPEED * 4.0 ** np.arange(-2, 3)
        more = 0.1 * 1.6 ** np.arange(7)
        table = np.log([(m * coulomb, v * top) for v in shares for m in more])
        points = np.column_stack([np.tile(x[:2], (len(table), 1)), table])
        cost = self._cost(points, self.few[-1:]).reshape(len(shares), len(more))
        say(1.0)
        each = points.reshape(len(shares), len(more), 4)[np.arange(len(shares)), np.argmin(cost, axis=1)]
        return list(each[np.argsort(np.min(cost, axis=1))][:STARTS])

    def _best(self, points: np.ndarray, groups: list[list[Piece]]) -> np.ndarray:
        return np.asarray(points[int(np.argmin(self._cost(points, groups)))])

    def _cost(self, points: np.ndarray, groups: list[list[Piece]]) -> np.ndarray:
        return np.asarray(np.log1p((self.residuals(points, groups) / (3.0 * ROBUST)) ** 2).sum(axis=1))

    def _give(self) -> float:
        """How far the axis gives way while the torque changes by Coulomb friction, from -1/2 to +1/2 of it."""
        gives = []
        half = 0.5 * self.slide.coulomb
        for p in self.pieces:
            u = self.record.torque[p.first : p.first + p.length] - self.slide.offset
            y = self.record.angle[p.first : p.first + p.length]
            way = 1.0 if u[-1] > u[0] else -1.0
            low, high = np.flatnonzero(way * u > -half), np.flatnonzero(way * u > half)
            if len(low) and len(high):
                gives.append(abs(float(y[high[0]] - y[low[0]])))
        return max(float(np.median(gives)) if gives else 0.0, 2.0 * self.record.count)

    def descend(self, starts: list[np.ndarray], say: Callable[[float], None]) -> np.ndarray:
        """Downhill from each start, until one leaves white residuals no larger than the noise; else the best."""
        ends: list[np.ndarray] = []
        for i, start in enumerate(starts):
            x = self._down(start, self.few, 30.0 * ROBUST, 12, 1e-4)
            if all(np.max(np.abs(x - end)) > SAME for end in ends):
                self.free_starts(x)
                ends.append(self._down(x, self.groups, ROBUST, 40, 3e-6))
                if Residuals.of(self.by_piece(ends[-1])).consistent:
                    return ends[-1]
            say((i + 1) / len(starts))
        return self._best(np.array(ends), self.groups)

    def _down(
        self, start: np.ndarray, groups: list[list[Piece]], scale: float, most: int, tolerance: float
    ) -> np.ndarray:
        from scipy.optimize import least_squares

        reach = np.log(HIGHEST)
        return np.asarray(
            least_squares(
                lambda at: self.residuals(at[None], groups)[0], start, lambda at: self.jacobian(at, groups),
                loss="soft_l1", f_scale=scale, xtol=tolerance, ftol=3e-5, gtol=1e-12, max_nfev=most, x_scale="jac",
                bounds=(start - reach, start + reach),
            ).x
        )  # fmt: skip
