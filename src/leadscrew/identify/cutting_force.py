"""Force laws from a table of cuts: parameters with 95 % intervals, errors, and what the table cannot tell.

Three laws are fitted (:mod:`leadscrew.analysis.cutting_force`): the power law ``F = Kf a f^P``, which is Kienzle's in
another notation; the same with a free depth exponent; and the law of chip and edge, ``F = Ktc a f + Kte b``.

- ``log-log``: linear least squares of ``ln F``. It takes the scatter of the force to be a share of the force.
- ``relative``: least squares of ``(F - model) / F`` (SciPy), the same scatter without the logarithm.
- ``absolute``: least squares of ``F - model``, for a scatter in N that is the same in every row.

Intervals are ``estimate -+ t s`` with Student's ``t`` at 0.975 and the rows minus the parameters as its degrees of
freedom; those of ``Kf`` are of its logarithm, so they are not symmetric. The error left out is the root mean square of
what each row deviates from the law that the other rows give. The coefficient of determination depends on what is
looked at: ``ln F`` nearly always has one near 1, because the force follows the chip's area under any law; that of
``ln kc`` says how much of the change in the specific force the law explains.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from leadscrew.analysis.cutting_force import ChipAndEdge, PowerLaw, r_squared, specific_force
from leadscrew.identify.cutting_force_table import ForceTable
from leadscrew.identify.estimation import CONFIDENCE, Interval, Parameter, fitted, quantile, white
from leadscrew.util.errors import DataError, ValueRefused

Method = Literal["log-log", "relative", "absolute"]
METHODS: tuple[Method, ...] = ("log-log", "relative", "absolute")
KAPPA_DEG = 90.0
MOST_REFITTED = 200
"""Rows up to which a nonlinear law is fitted again without each of them; beyond, its leverage says what that gives."""


@dataclass(frozen=True)
class LawFit:
    """One law, fitted one way."""

    law: PowerLaw | ChipAndEdge
    method: Method
    parameters: Mapping[str, Parameter]
    """By name, those that were fitted."""
    middle: Interval
    """Specific cutting force at the middle of the table (geometric means of feed and depth), N/mm^2."""
    residual_percent: np.ndarray
    """``100 (F / model - 1)`` of each row."""
    left_out_percent: np.ndarray
    """The same with the law of the other rows; NaN where these do not tell the parameters."""
    r2: Mapping[str, float]
    """Of ``force``, ``log force`` and ``log specific force``."""
    rms_n: float
    condition: float
    """Of the columns of the problem at unit length: 1 at best; parameters trade with one another where it is large."""
    freedom: int
    """Rows minus parameters."""
    scatter: float
    """Standard deviation of a row about the law: a share of the force, N for ``absolute``."""
    covariance: np.ndarray
    """Of ``(ln Kf, [q,] P)`` or ``(Ktc, Kte)``; of ``ln Kf`` alone where the exponent was given."""

    @property
    def rms_percent(self) -> float:
        """Root mean square of the residuals."""
        return _rms(self.residual_percent)

    @property
    def worst_percent(self) -> float:
        """Largest residual."""
        return float(np.abs(self.residual_percent).max())

    @property
    def left_out_rms_percent(self) -> float:
        """Root mean square error of a row by the law of the others; NaN where one cannot be left out."""
        return _rms(self.left_out_percent)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.asarray(values) ** 2)))


class Model(NamedTuple):
    """A law as a function of the vector that is fitted."""

    names: tuple[str, ...]
    law: Callable[[np.ndarray], PowerLaw | ChipAndEdge]
    columns: Callable[[np.ndarray, np.ndarray], np.ndarray]
    """Design of ``ln F`` for a power law, of ``F`` for chip and edge."""
    given: Callable[[np.ndarray], np.ndarray]
    """Part of ``ln F`` that is given."""
    logarithmic: bool


def power_model(exponent: float | None = None, depth_free: bool = False) -> Model:
    """``F = Kf a f^P``: ``P`` fitted or given, the depth's exponent 1 or fitted."""

    def law(x: np.ndarray) -> PowerLaw:
        p = float(x[-1]) if exponent is None else exponent
        return PowerLaw(float(np.exp(x[0])), p, float(x[1]) if depth_free else 1.0)

    def columns(f: np.ndarray, a: np.ndarray) -> np.ndarray:
        parts = [np.ones_like(f), *([np.log(a)] if depth_free else []), *([np.log(f)] if exponent is None else [])]
        return np.column_stack(parts)

    def given(fa: np.ndarray) -> np.ndarray:
        f, a = fa
        return (0.0 if depth_free else 1.0) * np.log(a) + (0.0 if exponent is None else exponent) * np.log(f)

    names = ("kf", *(["depth_exponent"] if depth_free else []), *(["exponent"] if exponent is None else []))
    return Model(names, law, columns, given, True)


def chip_and_edge_model(kappa_deg: float = KAPPA_DEG) -> Model:
    """``F = Ktc a f + Kte a / sin(kappa)``."""
    sine = math.sin(math.radians(kappa_deg))
    return Model(
        ("ktc", "kte"), lambda x: ChipAndEdge(float(x[0]), float(x[1]), kappa_deg),
        lambda f, a: np.column_stack([a * f, a / sine]), lambda fa: np.zeros_like(fa[0]), False,
    )  # fmt: skip


def _solve(model: Model, method: Method, f: np.ndarray, a: np.ndarray, force: np.ndarray) -> np.ndarray:
    from scipy.optimize import least_squares

    design, given = model.columns(f, a), model.given(np.array([f, a]))
    if model.logarithmic:
        start = np.linalg.lstsq(design, np.log(force) - given, rcond=None)[0]
        if method == "log-log":
            return np.asarray(start)
    weight = 1.0 / force if method == "relative" else np.full_like(force, 1.0 / force.mean())
    if not model.logarithmic:
        return np.asarray(np.linalg.lstsq(design * weight[:, None], force * weight, rcond=None)[0])

    def left(x: np.ndarray) -> np.ndarray:
        return np.asarray((np.exp(np.clip(design @ x + given, -50.0, 50.0)) - force) * weight)

    def jacobian(x: np.ndarray) -> np.ndarray:
        return design * (np.exp(np.clip(design @ x + given, -50.0, 50.0)) * weight)[:, None]

    return np.asarray(least_squares(left, start, jacobian, method="lm", xtol=1e-14, ftol=1e-14, gtol=1e-14).x)


def fit_law(model: Model, method: Method, table: ForceTable) -> LawFit:
    f, a, force = table.feed, table.depth, table.force
    x = _solve(model, method, f, a, force)
    law = model.law(x)
    modelled, design = law.force(f, a), model.columns(f, a)
    if method == "log-log":
        left, jacobian = np.log(force) - np.log(modelled), design
    else:
        weight = 1.0 / force if method == "relative" else np.ones_like(force)
        left = (force - modelled) * weight
        jacobian = design * (modelled * weight if model.logarithmic else weight)[:, None]
    freedom = len(force) - len(x)
    scatter = math.sqrt(float(left @ left) / freedom)
    spread = white(jacobian, left)
    covariance = spread.covariance
    reach = quantile(freedom) * np.sqrt(np.diag(covariance))
    parameters = {name: _parameter(name, at, at - r, at + r) for name, at, r in zip(model.names, x, reach, strict=True)}
    return LawFit(
        law=law, method=method, parameters=parameters, middle=_middle(model, x, covariance, freedom, f, a),
        residual_percent=100.0 * (force / modelled - 1.0), left_out_percent=_left_out(model, method, f, a, force),
        r2={
            "force": r_squared(force, modelled),
            "log force": r_squared(np.log(force), np.log(modelled)),
            "log specific force": r_squared(
                np.log(specific_force(force, f, a)), np.log(specific_force(modelled, f, a))
            ),
        },
        rms_n=_rms(force - modelled), condition=spread.condition, freedom=freedom, scatter=scatter,
        covariance=covariance,
    )  # fmt: skip


UNITS = {"kf": "N/mm^(1+P)", "ktc": "N/mm^2", "kte": "N/mm", "exponent": "1", "depth_exponent": "1"}


def _parameter(name: str, at: float, low: float, high: float) -> Parameter:
    """Of the vector that is fitted: ``Kf`` stands in it as its logarithm."""
    value, *ends = (float(np.exp(v)) if name == "kf" else float(v) for v in (at, low, high))
    return fitted(value, (ends[0], ends[1]), UNITS[name])


def _middle(
    model: Model, x: np.ndarray, covariance: np.ndarray, freedom: int, f: np.ndarray, a: np.ndarray
) -> Interval:
    at = np.exp(np.array([[np.log(f).mean()], [np.log(a).mean()]]))
    row = model.columns(at[0], at[1])[0]
    reach = quantile(freedom) * math.sqrt(float(row @ covariance @ row))
    kc = float(model.law(x).force(at[0], at[1])[0] / (at[0, 0] * at[1, 0]))
    if model.logarithmic:
        return Interval(kc, kc * math.exp(-reach), kc * math.exp(reach))
    share = reach / float(at[0, 0] * at[1, 0])
    return Interval(kc, kc - share, kc + share)


def _left_out(model: Model, method: Method, f: np.ndarray, a: np.ndarray, force: np.ndarray) -> np.ndarray:
    design = model.columns(f, a)
    if method == "log-log" or not model.logarithmic:
        return _left_out_linear(model, method, f, a, force)
    if len(force) > MOST_REFITTED:
        x = _solve(model, method, f, a, force)
        modelled, weight = model.law(x).force(f, a), 1.0 / force if method == "relative" else np.ones_like(force)
        jacobian = design * (modelled * weight)[:, None]
        leverage = np.einsum("ij,ji->i", jacobian, np.linalg.pinv(jacobian))
        return np.asarray(100.0 * (force / (force + (modelled - force) / (1.0 - leverage)) - 1.0))
    found = np.full(len(force), math.nan)
    for i in range(len(force)):
        rest = np.arange(len(force)) != i
        if np.linalg.matrix_rank(design[rest] / np.linalg.norm(design[rest], axis=0), tol=1e-6) == design.shape[1]:
            law = model.law(_solve(model, method, f[rest], a[rest], force[rest]))
            found[i] = 100.0 * float(force[i] / law.force(f[i], a[i]) - 1.0)
    return found


def _left_out_linear(model: Model, method: Method, f: np.ndarray, a: np.ndarray, force: np.ndarray) -> np.ndarray:
    """By leverage: the residual without its own row is ``e / (1 - h)``, exactly, where the problem is linear."""
    weight = np.ones_like(force) if method != "relative" else 1.0 / force
    design = model.columns(f, a) * weight[:, None]
    wanted = np.log(force) - model.given(np.array([f, a])) if model.logarithmic else force * weight
    solver = np.linalg.pinv(design)
    free = 1.0 - np.einsum("ij,ji->i", design, solver)
    alone = free < 1e-9
    left = np.where(alone, math.nan, (wanted - design @ (solver @ wanted)) / np.where(alone, 1.0, free))
    if model.logarithmic:
        return np.asarray(100.0 * np.expm1(left))
    return np.asarray(100.0 * (force / (force - left / weight) - 1.0))


SAME = 1.02
"""Feeds or depths within this ratio are taken to be one."""
NARROW = 1.5
"""Range of feeds below which the exponent is told by hardly anything."""
ROUNDING = 1e-9
"""An exponent nearer to 1 than this is 1."""


class DepthTest(NamedTuple):
    """Whether the force is in proportion to the depth."""

    exponent: Parameter
    p_value: float
    """Probability of an exponent at least as far from 1 if it were 1 (two-sided ``t`` test)."""


@dataclass(frozen=True)
class ForceFit:
    """What a table of cuts tells."""

    table: ForceTable
    chosen: LawFit
    """The power law by the method asked for."""
    others: Mapping[str, LawFit]
    """By name: the power law by the other methods, with a free depth exponent, chip and edge."""
    depth: DepthTest | None
    """``None`` where the table has one depth, or too few rows."""
    kappa_deg: float
    exponent_given: bool
    notes: tuple[str, ...]
    """What the table cannot tell, and what to be careful with."""

    @property
    def law(self) -> PowerLaw:
        """The power law."""
        assert isinstance(self.chosen.law, PowerLaw)
        return self.chosen.law

    def force(self, feed: float, depth: float) -> tuple[Interval, bool]:
        """Force of one more cut with its 95 % interval (law and scatter), and whether the table has cuts around it.

        Raises:
            ValueRefused: a feed or a depth that is not positive.
        """
        if not (0.0 < feed < math.inf and 0.0 < depth < math.inf):
            raise ValueRefused(f"feed = {feed!r} mm/rev, depth = {depth!r} mm: both must be above 0")
        fit, value = self.chosen, float(self.law.force(feed, depth))
        row = np.array([1.0, math.log(feed)][: len(fit.covariance)])
        share = fit.scatter / value if fit.method == "absolute" else fit.scatter
        reach = quantile(fit.freedom) * math.sqrt(float(row @ fit.covariance @ row) + share**2)
        table = self.table
        inside = table.feed.min() <= feed <= table.feed.max() and table.depth.min() <= depth <= table.depth.max()
        return Interval(value, value * math.exp(-reach), value * math.exp(reach)), bool(inside)


def fit_forces(
    table: ForceTable, *, method: Method = "log-log", kappa_deg: float = KAPPA_DEG, exponent: float | None = None
) -> ForceFit:
    """The laws of a table.

    Args:
        table: at least three cuts.
        method: what the power law's parameters come from.
        kappa_deg: cutting edge angle, for Kienzle's notation and the length of the edge.
        exponent: ``P``, where the table has one feed only and cannot tell it.

    Raises:
        DataError: fewer than three cuts, or one feed and no exponent.
        ValueRefused: a method, an angle or an exponent that is none.
    """
    if method not in METHODS:
        raise ValueRefused(f"method = {method!r}: allowed are {', '.join(METHODS)}")
    if not 0.0 < kappa_deg <= 90.0:
        raise ValueRefused(f"kappa = {kappa_deg!r}: allowed range is (0, 90] degrees")
    if exponent is not None and not 0.0 < exponent <= 1.0:
        raise ValueRefused(f"exponent = {exponent!r}: allowed range is (0, 1]")
    several_feeds, several_depths = (float(x.max() / x.min()) > SAME for x in (table.feed, table.depth))
    n, fitted = len(table.force), 2 if exponent is None else 1
    if n < 3:
        raise DataError(
            f"{n} cut{'s' if n != 1 else ''}{' after leaving out repeats' if table.repeated else ''}: a law of two "
            "parameters passes through two points whatever they are; expected at least 3"
        )
    if not several_feeds and exponent is None:
        raise DataError(
            f"every cut has the feed {table.feed.mean():.4g} mm/rev: one feed says nothing about the exponent; give "
            "cuts at other feeds, or the exponent with --exponent"
        )
    chosen = fit_law(power_model(exponent), method, table)
    others: dict[str, LawFit] = {}
    for way in METHODS[:2]:
        if way != method:
            others[f"power law, {way}"] = fit_law(power_model(exponent), way, table)
    depth, confounded = None, False
    if several_depths and n > fitted + 1:
        free = power_model(exponent, depth_free=True)
        design = free.columns(table.feed, table.depth)
        centred = design[:, 1:] - design[:, 1:].mean(axis=0)
        sizes = np.linalg.svd(centred, compute_uv=False)
        confounded = bool(sizes[-1] < 1e-3 * sizes[0])
        if not confounded:
            fit = fit_law(free, "log-log", table)
            others["power law with depth exponent, log-log"] = fit
            depth = _depth_test(fit)
    if several_feeds:
        others["chip and edge, relative"] = fit_law(chip_and_edge_model(kappa_deg), "relative", table)
    notes = _notes(table, chosen, depth, several_depths, confounded, exponent)
    return ForceFit(table, chosen, others, depth, kappa_deg, exponent is not None, tuple(notes))


def _depth_test(fit: LawFit) -> DepthTest:
    from scipy.stats import t as student

    found = fit.parameters["depth_exponent"]
    error = math.sqrt(float(fit.covariance[1, 1]))
    away = abs(found.value - 1.0)
    # where the law fits to rounding there is nothing to test against
    p = 1.0 if away < ROUNDING else 2.0 * float(student.sf(away / max(error, ROUNDING), fit.freedom))
    return DepthTest(found, p)


def _notes(
    table: ForceTable, chosen: LawFit, depth: DepthTest | None, several_depths: bool, confounded: bool,
    exponent: float | None,
) -> Sequence[str]:  # fmt: skip
    notes = [f"row {row} repeats row {of} in every number: one cut, counted once" for row, of in table.repeated]
    ratio = float(table.feed.max() / table.feed.min())
    if exponent is not None:
        notes.append(f"the exponent {exponent:g} was given, not fitted")
    elif ratio < NARROW:
        notes.append(f"the feeds differ by a factor of {ratio:.3g} only: the exponent rests on little")
    if not several_depths:
        notes.append(f"one depth, {table.depth.mean():.4g} mm: in proportion to the depth is assumed, not tested")
    elif confounded:
        notes.append("feed and depth change together in every row: their effects cannot be separated")
    elif depth is None:
        notes.append("too few cuts to test whether the force is in proportion to the depth")
    elif depth.p_value < 1.0 - CONFIDENCE:
        q = depth.exponent
        notes.append(
            f"the force is not in proportion to the depth: exponent {q.value:.3f} ({q.low:.3f} to {q.high:.3f}), "
            f"p = {depth.p_value:.2g}; a law in proportion is off by up to {chosen.worst_percent:.3g} % here"
        )
    own = chosen.parameters.get("exponent")
    if own is not None and not (own.low > 0.0 and own.high < 1.0):
        notes.append(
            f"the exponent's interval {own.low:.3f} to {own.high:.3f} reaches outside 0 to 1, where cutting laws "
            "have it: more feeds, or less scatter"
        )
    speed = table.others.get("speed")
    if speed is not None and float(speed.max() / speed.min()) > 1.1:
        notes.append(
            f"the cutting speed changes from {speed.min():.4g} to {speed.max():.4g} m/min, which no law here knows of"
        )
    return notes


def bootstrap(fit: ForceFit, draws: int = 2000, seed: int = 1) -> dict[str, Parameter]:
    """Intervals of the log-log power law from drawing residuals again, as a check of the ``t`` intervals.

    Residuals are first widened by ``1 / sqrt(1 - leverage)``. With fewer than some ten rows such intervals are too
    narrow: there are few residuals to draw from.

    Raises:
        ValueRefused: fewer than 100 draws, or more than a million.
    """
    if not 100 <= draws <= 1_000_000:
        raise ValueRefused(f"bootstrap = {draws!r}: allowed range is 100 to 1000000 draws")
    table, exponent = fit.table, fit.law.exponent if fit.exponent_given else None
    model = power_model(exponent)
    design, given = model.columns(table.feed, table.depth), model.given(np.array([table.feed, table.depth]))
    solver = np.linalg.pinv(design)
    x = solver @ (np.log(table.force) - given)
    leverage = np.einsum("ij,ji->i", design, solver)
    left = (np.log(table.force) - given - design @ x) / np.sqrt(np.maximum(1.0 - leverage, 1e-12))
    picked = np.random.default_rng(seed).choice(left - left.mean(), size=(draws, len(left)))
    found = x + picked @ solver.T
    ends = np.quantile(found, [0.5 - 0.5 * CONFIDENCE, 0.5 + 0.5 * CONFIDENCE], axis=0)
    return {name: _parameter(name, x[i], ends[0, i], ends[1, i]) for i, name in enumerate(model.names)}
