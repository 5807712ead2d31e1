"""One force law fitted to a table of cuts, one way: parameters, intervals, residuals, errors left out."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from leadscrew.analysis.cutting_force import ChipAndEdge, PowerLaw, r_squared, specific_force
from leadscrew.identify.cutting_force_table import ForceTable

Method = Literal["log-log", "relative", "absolute"]
METHODS: tuple[Method, ...] = ("log-log", "relative", "absolute")
CONFIDENCE = 0.95
KAPPA_DEG = 90.0
MOST_REFITTED = 200
"""Rows up to which a nonlinear law is fitted again without each of them; beyond, its leverage says what that gives."""


class Interval(NamedTuple):
    """A parameter with its 95 % interval."""

    value: float
    low: float
    high: float

    def holds(self, value: float) -> bool:
        """Whether a value lies inside."""
        return self.low <= value <= self.high


@dataclass(frozen=True)
class LawFit:
    """One law, fitted one way."""

    law: PowerLaw | ChipAndEdge
    method: Method
    parameters: Mapping[str, Interval]
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
        """Root mean square error of a row that the fit has not seen; NaN where one cannot be left out."""
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
    from scipy.stats import t as student

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
    covariance = np.linalg.inv(jacobian.T @ jacobian) * scatter**2
    reach = float(student.ppf(0.5 + 0.5 * CONFIDENCE, freedom)) * np.sqrt(np.diag(covariance))
    sizes = np.linalg.svd(jacobian / np.linalg.norm(jacobian, axis=0), compute_uv=False)
    parameters = {
        name: Interval(*(float(np.exp(v)) if name == "kf" else float(v) for v in (at, at - r, at + r)))
        for name, at, r in zip(model.names, x, reach, strict=True)
    }
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
        rms_n=_rms(force - modelled), condition=float(sizes[0] / sizes[-1]), freedom=freedom, scatter=scatter,
        covariance=covariance,
    )  # fmt: skip


def _middle(
    model: Model, x: np.ndarray, covariance: np.ndarray, freedom: int, f: np.ndarray, a: np.ndarray
) -> Interval:
    from scipy.stats import t as student

    at = np.exp(np.array([[np.log(f).mean()], [np.log(a).mean()]]))
    row = model.columns(at[0], at[1])[0]
    reach = float(student.ppf(0.5 + 0.5 * CONFIDENCE, freedom)) * math.sqrt(float(row @ covariance @ row))
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
