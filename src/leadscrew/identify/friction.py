"""LuGre friction of an axis from one log of torque and position.

1. Sliding, by linear least squares: ``F_C``, ``sigma_2``, the inertia and an offset
   (:mod:`leadscrew.identify.friction_record`).
2. Around every stand-still, by simulation: ``sigma_0, sigma_1, F_S, v_s`` minimise what the log's position differs
   from a model that is driven by the log's torque (:mod:`leadscrew.identify.friction_replay`),

        minimise  sum_k rho((y_k - y_k(theta)) / noise),      rho(r) = 18 (sqrt(1 + r^2 / 9) - 1)

   in the logarithms of the parameters, by trust-region least squares from the best point of a coarse grid. ``rho`` is
   quadratic up to three times the noise and linear beyond, so a single slip that the model makes a sample late does not
   decide. All simulations of an iteration are one ``Loop.batch``. Where a piece begins at rest, its mean difference is
   left out: where the encoder's count begins is not known.

Standard errors are those of a linearised fit with independent noise, not below the noise that was met; a parameter
with more than :data:`KNOWN` is said not to be told by the log. Static friction and Stribeck speed act only in slow
motion: sines of millimetres do not tell them, the record of :mod:`leadscrew.references.friction_test` does. Where the
log does not tell them they stay near usual values (F_S = 1.5 F_C; v_s a 3,300th of the top speed), each weighed as one
sample that is off by the noise at a factor of e.

The method is ours; for the model see :mod:`leadscrew.friction.lugre`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.friction.lugre import LuGre
from leadscrew.identify.friction_record import Piece, Record, Sliding, checked, pieces, sliding
from leadscrew.identify.friction_replay import replay_loop
from leadscrew.kernel import door
from leadscrew.kernel.errors import DataError

KNOWN = 0.1
"""Standard error, as a share of the value (of static friction: of what it is above Coulomb friction), up to which a
parameter counts as told by the log."""
WORSE = 20.0
"""Rise of the cost, in squared noise, that half and double of ``F_S - F_C`` must bring for it to count as told: what
six standard deviations bring."""
FITTED = ("stiffness", "damping", "static", "stribeck_speed")
STRIBECK = (3e-5, 3e-4, 3e-3)
"""Stribeck speeds that the descent starts from, as shares of the top speed; the middle one is the usual value."""
ROBUST = 3.0
"""Differences beyond this many times the noise count linearly."""
FINE = 0.02
"""Noise, in counts, of the position in the instant in which a scale counts; more where it counts often."""
LOST = 1e6
LOWEST, HIGHEST = 1e-3, 1e3
"""Each fitted parameter stays between these multiples of where the grid put it."""
MOST_SIMULATED = 60_000
"""Samples in pieces that one simulation takes at most: pieces beyond are left out."""


@dataclass(frozen=True)
class FrictionFit:
    """Parameters in rad and N m (or in m and N, as the log is), and how well the log tells them."""

    friction: LuGre
    inertia: float
    inertia_given: bool
    """Given by the caller, not from the log."""
    offset: float
    """Torque that does not turn with the direction."""
    standard_error: dict[str, float]
    """Of each parameter, in its unit; infinite where the log does not tell it."""
    told: dict[str, bool]
    """Whether the standard error is small enough, :data:`KNOWN`."""
    correlation: dict[str, dict[str, float]]
    """Between the four of the second step."""
    condition: float
    """Of the second step, in relative changes: how much better the best known direction is known than the worst."""
    rms: float
    """Of position, log minus model, in the unit of the log."""
    noise: float
    """Of the log's position."""
    sliding: Sliding
    pieces: int
    simulations: int

    @property
    def consistent(self) -> bool:
        """Whether the model leaves no more than twice the noise: if not, the axis is no LuGre axis."""
        return self.rms <= 2.0 * self.noise

    def as_dict(self) -> dict[str, Any]:
        """The fit for JSON."""
        values = self.friction._asdict()
        return {
            "parameters": {
                name: {"value": values[name], "standard_error": self.standard_error[name], "told": self.told[name]}
                for name in values
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
        progress: is told what happens and the fraction done.

    Raises:
        DataError: the log is malformed, or does not tell: no reversal, no sliding, no stand-still, torque and position
            swapped, inertia unknown, stiffness or damping not told.
    """
    say = progress or (lambda what, done: None)
    if inertia is not None:
        inertia = door.positive("inertia", inertia, "kg m^2")
    say("sliding", 0.0)
    record = checked(time_s, torque, angle, delay)
    slide = sliding(record)
    known_inertia = inertia if inertia is not None else _inertia(slide)
    found = _limited(pieces(record, slide))
    if not found:
        raise DataError(
            "the log has no stand-still in which the torque changes by half of Coulomb friction: let the axis reverse, "
            "or come to rest and move off again"
        )
    problem = _Problem(record, slide, known_inertia, found)
    start = problem.grid(lambda done: say("coarse grid", 0.3 * done))
    best = problem.descend(start, lambda done: say("descent", 0.3 + 0.7 * done))
    return _result(record, slide, known_inertia, inertia is not None, problem, best)


def _inertia(slide: Sliding) -> float:
    error = slide.standard_error["inertia"]
    if not slide.inertia > 0.0 or error > KNOWN * slide.inertia:
        raise DataError(
            f"the log does not tell the inertia ({slide.inertia:.3g} with a standard error of {error:.2g}): give it, "
            "or let the axis accelerate more while it slides"
        )
    return slide.inertia


def _limited(found: list[Piece]) -> list[Piece]:
    kept, total = [], 0
    for piece in found:
        total += piece.length
        if total <= MOST_SIMULATED:
            kept.append(piece)
    return kept


def _result(
    record: Record, slide: Sliding, inertia: float, given: bool, problem: _Problem, x: np.ndarray
) -> FrictionFit:
    jacobian, left = problem.jacobian(x), problem.residuals(x[None])[0]
    inside = np.abs(left) < ROBUST * 3.0
    scale = max(1.0, float(np.sqrt(np.mean(left[inside] ** 2)))) if inside.any() else LOST
    _, sizes, directions = np.linalg.svd(jacobian[inside], full_matrices=False)
    usable = np.where(sizes > 1e-9 * sizes[0], sizes, np.nan) if sizes[0] > 0.0 else np.full(4, np.nan)
    covariance = (directions.T / usable**2) @ directions * scale**2
    to_log = np.array([[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    covariance = to_log @ covariance @ to_log.T
    spread = np.sqrt(np.diag(covariance))
    friction = problem.friction(x)
    values = friction._asdict()
    # the third is the logarithm of static above Coulomb friction
    share = spread * np.array([1.0, 1.0, (friction.static - friction.coulomb) / friction.static, 1.0])
    errors = {n: float(s * values[n]) if np.isfinite(s) else math.inf for n, s in zip(FITTED, share, strict=True)}
    errors |= {n: slide.standard_error[n] for n in ("coulomb", "viscous", "offset")}
    errors["inertia"] = 0.0 if given else slide.standard_error["inertia"]
    # both act through F_S - F_C and trade with one another: not along a straight line, so far away is looked at too
    if problem.worse_elsewhere(x) < WORSE * scale**2:
        errors |= {"static": math.inf, "stribeck_speed": math.inf}
    above = values | {"static": friction.static - friction.coulomb}
    told = {n: bool(errors[n] <= KNOWN * above[n]) for n in values}
    poor = [n for n in ("stiffness", "damping") if not told[n]]
    if poor:
        raise DataError(
            f"the log does not tell the {' and the '.join(poor)} of the bristles (standard error above "
            f"{100.0 * KNOWN:.0f} %): it needs slower reversals, more of them, or a finer encoder"
        )
    return FrictionFit(
        friction=friction, inertia=inertia, inertia_given=given, offset=slide.offset, standard_error=errors, told=told,
        correlation={
            a: {b: float(covariance[i, j] / (spread[i] * spread[j])) for j, b in enumerate(FITTED)}
            for i, a in enumerate(FITTED)
        },
        condition=float(sizes[0] / sizes[-1]) if sizes[-1] > 0.0 else math.inf,
        rms=scale * record.noise if scale < LOST else math.inf, noise=record.noise, sliding=slide,
        pieces=len(problem.pieces), simulations=problem.simulations,
    )  # fmt: skip


def _steps(record: Record, piece: Piece) -> np.ndarray:
    """Samples before a single count of the scale; none where it does not count."""
    moves = np.abs(np.diff(record.angle[piece.first : piece.first + piece.length]))
    if np.mean(moves < 0.5 * record.count) < 0.2:
        return np.empty(0, dtype=np.int64)
    return np.flatnonzero((moves > 0.5 * record.count) & (moves < 1.5 * record.count))


def _weights(steps: np.ndarray) -> np.ndarray:
    """One over the noise, in counts: :data:`FINE`, and that a count came somewhere between two samples."""
    if len(steps) < 2:
        return np.full(len(steps), 1.0 / FINE)
    speed = 1.0 / np.maximum(np.gradient(steps.astype(np.float64)), 1.0)
    return np.asarray(1.0 / np.sqrt(FINE**2 + speed**2 / 12.0))


class _Problem:
    """Points are ``[point, (ln sigma_0, ln (sigma_1 / sigma_0), ln (F_S - F_C), ln v_s)]``.

    A fast reversal tells the ratio far better than the size.
    """

    def __init__(self, record: Record, slide: Sliding, inertia: float, found: list[Piece]) -> None:
        self.record, self.slide, self.pieces, self.simulations = record, slide, found, 0
        self.loop = replay_loop(record.torque - slide.offset, record.angle, record.period, inertia)
        # A scale that counts says exactly where the axis is in the instant in which it counts, and little in between.
        self.steps = {p.first: _steps(record, p) for p in found}
        self.fine = {first: _weights(steps) / record.count for first, steps in self.steps.items()}
        longest = sorted({p.length for p in found})
        # Two batches: short pieces do not wait for long ones.
        edge = longest[-1] // 3
        self.groups = [g for g in ([p for p in found if p.length > edge], [p for p in found if p.length <= edge]) if g]

    def friction(self, x: np.ndarray) -> LuGre:
        """The model at a point."""
        s0, ratio, more, vs = np.exp(x).tolist()
        coulomb = self.slide.coulomb
        return LuGre(s0, ratio * s0, max(self.slide.viscous, 0.0), coulomb, coulomb + more, vs)

    def residuals(self, points: np.ndarray, groups: list[list[Piece]] | None = None) -> np.ndarray:
        """Log minus model in units of the noise, ``[point, sample]``; the last two say how unusual F_S and v_s are."""
        usual = np.log([0.5 * self.slide.coulomb, STRIBECK[1] * self.slide.top_speed])
        parts = [self._group(points, g) for g in groups or self.groups]
        return np.concatenate([*parts, np.asarray(points)[:, 2:] - usual], axis=1)

    def _group(self, points: np.ndarray, group: list[Piece]) -> np.ndarray:
        n, m = len(points), len(group)
        self.simulations += n * m
        tables = [self.friction(x) for x in points]
        varied = {f"plant.friction.{k}": np.repeat([getattr(f, k) for f in tables], m) for k in LuGre._fields}
        starts = {
            "reference.first": [p.first for p in group],
            "reference.length": [p.length for p in group],
            "plant.start_torque": [p.start_torque - self.slide.offset for p in group],
            "plant.start_speed": [p.start_speed for p in group],
            "plant.start_angle": [p.start_angle for p in group],
        }
        varied |= {k: np.tile(np.array(v, dtype=np.float64), n) for k, v in starts.items()}
        lasts = max(p.length for p in group) * self.record.period
        batch = self.loop.batch(lasts, varied, runs=n * m, record=("controller.e",))
        table = batch["controller.e"].reshape(n, m, -1)
        parts = []
        for i, piece in enumerate(group):
            e = table[:, i, : piece.length]
            if piece.start_speed == 0.0:
                steps = self.steps[piece.first]
                at = 0.5 * (e[:, steps] + e[:, steps + 1]) if len(steps) else e
                weight = self.fine[piece.first] if len(steps) else np.full(e.shape[1], 1.0 / self.record.noise)
                parts.append((at - at @ weight[:, None] / weight.sum()) * weight)
            else:
                parts.append(e / self.record.noise)
        return np.clip(np.nan_to_num(np.concatenate(parts, axis=1), nan=LOST), -LOST, LOST)

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

    def grid(self, say: Callable[[float], None]) -> np.ndarray:
        """Where the descent starts: stiffness and damping by a grid over short pieces, then Stribeck's part."""
        some = sorted(self.pieces, key=lambda p: p.length)
        short = [p for p in some if p.length <= 3 * some[len(some) // 2].length][:8]
        coulomb, top = self.slide.coulomb, self.slide.top_speed
        stiffness = coulomb / self._give()
        first = [
            (stiffness * a, b, 0.5 * coulomb, STRIBECK[1] * top)
            for a in 0.1 * 1.3 ** np.arange(17) for b in 3e-4 * 1.8 ** np.arange(7)
        ]  # fmt: skip
        best = self._best(np.log(first), [short])
        say(0.3)
        tried = []
        for i, share in enumerate(STRIBECK):
            x = np.array([best[0], best[1], best[2], math.log(share * top)])
            tried.append(self._down(x, [short], 30.0 * ROBUST, 12, 1e-4))
            say(0.3 + 0.2 * (i + 1))
        best = self._best(np.array(tried), [short])
        if len(short) == len(some):
            return best
        second = [
            (best[0], best[1], math.log(a * coulomb), math.log(b * top)) for a in (0.15, 0.5, 1.5) for b in STRIBECK
        ]
        say(1.0)
        return self._best(np.array([best, *second]), [short, [some[-1]]])

    def _best(self, points: np.ndarray, groups: list[list[Piece]]) -> np.ndarray:
        cost = np.log1p((self.residuals(points, groups) / (3.0 * ROBUST)) ** 2).sum(axis=1)
        return np.asarray(points[int(np.argmin(cost))])

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

    def descend(self, start: np.ndarray, say: Callable[[float], None]) -> np.ndarray:
        """Downhill, first with a wide eye for outliers, then with a narrow one."""
        x = self._down(start, self.groups, 30.0 * ROBUST, 12, 1e-4, say)
        return self._down(x, self.groups, ROBUST, 40, 3e-6, say)

    def _down(
        self, start: np.ndarray, groups: list[list[Piece]], scale: float, most: int, tolerance: float,
        say: Callable[[float], None] | None = None,
    ) -> np.ndarray:  # fmt: skip
        from scipy.optimize import least_squares

        steps, reach = 0, np.log(HIGHEST)

        def jacobian(at: np.ndarray) -> np.ndarray:
            nonlocal steps
            steps += 1
            if say is not None:
                say(1.0 - 0.85**steps)
            return self.jacobian(at, groups)

        return np.asarray(
            least_squares(
                lambda at: self.residuals(at[None], groups)[0], start, jacobian, loss="soft_l1", f_scale=scale,
                xtol=tolerance, ftol=3e-5, gtol=1e-12, max_nfev=most, x_scale="jac",
                bounds=(start - reach, start + reach),
            ).x
        )  # fmt: skip
