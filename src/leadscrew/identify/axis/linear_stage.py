"""Which model: the simplest that no richer one beats by cross-validation inside the training part.

The training part is cut into stretches that fall to :data:`FOLDS` parts in turn; the force of each part is predicted by
the line of the others, and what that leaves, of all parts together, judges a model; a row to which the other parts do
not reach counts with what the line of all leaves. The simplest is taken that leaves no more than :data:`NEARLY` of what
the best leaves: what is needless changes the error by its share of chance, far below that; what is missing shows
clearly. The hold-out chooses nothing. M. Stone, *Cross-validatory choice and assessment of statistical predictions*,
J. Royal Statistical Society B 36 (1974) 111.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from leadscrew.identify.axis.inverse_dynamics import KEY as SPEED
from leadscrew.identify.axis.inverse_dynamics import LinearFit, Rows, Terms, inverse_dynamics, rows_of, stribeck_fit
from leadscrew.identify.axis.parameters import interval_half, weakest
from leadscrew.identify.axis.record import Record
from leadscrew.util.errors import DataError

MOST = 100.0
"""Condition number of the columns above which parameters cannot be complete apart."""
SHARE = 0.02
"""Of the moving time that must go the other way for a log to count as one of both directions."""
GIVEN_UP = ("excess", "viscous", "offset", "coulomb")
"""What is given up first where terms cannot be complete apart."""
ACTS = 1e-3
"""Share of the force that acceleration must make, for a mass to be looked for."""
PENDING = (1.0, 1.0)
"""Stands for a Stribeck speed that is to be found."""


@dataclass(frozen=True)
class Line:
    """A model's line, and why some of its terms are fixed."""

    fit: LinearFit
    why: dict[str, str] = field(default_factory=dict)
    """Sentence by key of a term that was taken out."""


def directions(record: Record) -> tuple[float, float]:
    """Shares of the moving time that go forwards and backwards."""
    s = record.samples
    sign = np.sign(s.smooth[~s.slow])
    moving = max(1, len(sign))
    return float(np.sum(sign > 0.0) / moving), float(np.sum(sign < 0.0) / moving)


def two_ways(record: Record) -> bool:
    """Whether the log moves both ways."""
    return min(directions(record)) >= SHARE


def line(record: Record, terms: Terms, corner_hz: float, delay: float) -> Line:
    """The least-squares line of the terms that the log tells.

    Raises:
        DataError: too few rows; a mass that is not positive: drive and motion do not belong together.
    """
    why: dict[str, str] = {}
    for k in range(8):
        stribeck = terms.stribeck_speed is not None
        fit = (stribeck_fit if stribeck else inverse_dynamics)(record, terms, corner_hz, delay=delay)
        if k == 0:
            _refuse_opposite(fit)
        drop = _negative(fit) or _alike(fit)
        if drop is None:
            break
        key, sentence = drop
        why[key] = sentence
        terms = replace(terms, without=terms.without | {key})
        if stribeck and not any(k.endswith(".excess") for k in terms.keys):
            terms = replace(terms, stribeck_speed=None)
    _refuse_no_mass(fit)
    return Line(fit, why)


def _refuse_opposite(fit: LinearFit) -> None:
    """Refuses a drive that pushes against the motion: inertia and friction both come out negative.

    Raises:
        DataError: mass below 0, and of the friction more below 0 by three standard errors than above it.
    """
    if fit.values.get("mass", 1.0) >= 0.0:
        return
    spread = fit.standard_error
    friction = [k for k in fit.values if k.split(".")[-1] in ("coulomb", "viscous")]
    sure = [np.sign(fit.values[k]) for k in friction if abs(fit.values[k]) > 3.0 * spread[k]]
    if sum(sure) < 0 or (not sure and fit.values["mass"] < -3.0 * spread["mass"]):
        shown = ", ".join(f"{k} {fit.values[k]:.3g}" for k in ("mass", *friction))
        raise DataError(
            f"drive and position have opposite signs: inertia and friction come out negative ({shown}); where a "
            "positive drive moves the axis backwards give a negative force of the drive, --force-per-drive -1 where it "
            "is not known; else see whether the columns are swapped"
        )


def _negative(fit: LinearFit) -> tuple[str, str] | None:
    """The friction that comes out most clearly negative, which no friction is."""
    spread = fit.standard_error
    found = {
        key: value / max(spread[key], 1e-300)
        for key, value in fit.values.items()
        if value < 0.0 and key.split(".")[-1] in ("coulomb", "viscous", "excess")
    }
    if not found:
        return None
    key = min(found, key=lambda k: found[k])
    name = {"excess": "static friction less Coulomb friction"}.get(key.split(".")[-1], key.split(".")[-1] + " friction")
    return key, f"{name} comes out at {fit.values[key]:.3g} with a standard error of {spread[key]:.2g}: taken as 0"


def _alike(fit: LinearFit) -> tuple[str, str] | None:
    """A term that the log cannot tell from the others."""
    if fit.condition <= MOST:
        return None
    keys = fit.terms.sought
    shares = weakest(fit.rows.matrix[fit.rows.used][:, : len(keys)], keys)
    for name in GIVEN_UP:
        for key in keys:
            if key.split(".")[-1] == name and abs(shares[key]) > 0.2:
                others = [k for k in keys if k != key and abs(shares[k]) > 0.2]
                return key, (
                    f"the log cannot tell it from {' and '.join(others) or 'the others'} "
                    f"(condition number {fit.condition:.3g}): fixed at 0"
                )
    return None


def _refuse_no_mass(fit: LinearFit) -> None:
    if "mass" not in fit.values:
        return
    value, spread = fit.values["mass"], fit.standard_error["mass"]
    if value < -3.0 * spread:
        raise DataError(
            f"the mass comes out negative, {value:.3g} with a standard error of {spread:.2g}: drive and position do "
            "not belong together; are the columns swapped, or has one the other sign?"
        )
    share = value * fit.effect["mass"] / fit.rms_force if fit.rms_force > 0.0 else 0.0
    if value <= 2.0 * spread or share < ACTS:
        raise DataError(
            f"the log does not tell the mass ({value:.3g} with a standard error of {spread:.2g}; acceleration makes "
            f"{100.0 * share:.2g} % of the force): let the axis accelerate harder, or give the mass"
        )


NEARLY = 1.02
WEIGHT = 0.8
"""Share of Coulomb friction above which an offset counts as a weight."""
FOLDS, LEAST = 4, 12
"""Parts that are predicted in turn, and rows in them at least."""
FAR = 0.25
"""Leverage of a row beyond which the line of other parts says nothing of it."""
TURNS, LONG = 8, 10
"""Stretches of a part at most, and their least length in windows."""


class Model(NamedTuple):
    """A form of friction."""

    stribeck: bool
    symmetric: bool

    @property
    def name(self) -> str:
        """As the report says it."""
        friction = "Coulomb, viscous and Stribeck" if self.stribeck else "Coulomb and viscous"
        return f"{friction}, {'alike both ways' if self.symmetric else 'by direction'}"


class Setting(NamedTuple):
    """What all candidates share."""

    corner_hz: float
    delay: float
    """Periods."""
    known: dict[str, float]
    without: frozenset[str]
    gauge: float = 0.0
    """Offset that friction by direction is counted beside, where none is known."""


@dataclass
class Candidate:
    """A model, its line on the training part, and its errors where each stretch is predicted by the others."""

    model: Model
    line: Line | None
    share: float = float("nan")
    """Root mean square of the force left, in percent of the force's."""
    rms: float = float("nan")
    verdict: str = ""

    def as_dict(self) -> dict[str, Any]:
        """A row of the comparison."""
        return {"model": self.model.name, "validation_rms_force": self.rms, "validation_force_percent": self.share,
                "verdict": self.verdict}  # fmt: skip


def models(model: str, symmetric: bool | None) -> list[Model]:
    """The candidates, simplest first."""
    forms = {"auto": (False, True), "coulomb": (False,), "stribeck": (True,), "lugre": (True,)}[model]
    ways = (True, False) if symmetric is None else (symmetric,)
    return [Model(stribeck, way) for stribeck in forms for way in ways]


def fitted(record: Record, model: Model, setting: Setting) -> Line:
    """The line of a model."""
    known = dict(setting.known)
    if not model.symmetric and setting.gauge:
        known.setdefault("offset", setting.gauge)
    terms = Terms(model.symmetric, PENDING if model.stribeck else None, known, setting.without)
    return line(record, terms, setting.corner_hz, setting.delay)


def gauge_of(training: Record, setting: Setting) -> float:
    """An offset that is larger than friction, as a weight makes it: beside it no friction by direction is negative."""
    try:
        values = fitted(training, Model(False, True), setting).fit.values
    except DataError:
        return 0.0
    offset = values.get("offset", 0.0)
    return offset if abs(offset) > WEIGHT * values.get("friction.forward.coulomb", 0.0) else 0.0


def choose(training: Record, candidates: list[Model], setting: Setting) -> list[Candidate]:
    """All candidates, the chosen one first.

    Raises:
        DataError: none can be fitted.
    """
    found, problem = [], None
    for model in candidates:
        try:
            found.append(_tried(training, model, setting, len(candidates) > 1))
        except DataError as error:
            problem = error
            found.append(Candidate(model, None, verdict=re.split(r" \(|[:;]", str(error))[0]))
    usable = [c for c in found if c.line is not None]
    if not usable:
        assert problem is not None
        raise problem
    complete = [c for c in usable if not _reduced(c)] or usable[:1]
    least = min((c for c in complete if np.isfinite(c.rms)), key=lambda c: c.rms, default=complete[0])
    best = next((c for c in complete if c.rms <= NEARLY * least.rms), least)
    for other in usable:
        if other not in complete or (np.isfinite(best.rms) and not np.isfinite(other.rms)):
            other.verdict = "this log does not distinguish it from a simpler one"
        elif other.rms > NEARLY * least.rms:
            other.verdict = f"its prediction error is {other.rms / best.rms:.3g} times larger"
        else:
            other.verdict = f"no more than {100.0 * (NEARLY - 1.0):.0f} % better than a simpler one"
    best.verdict = "chosen"
    return [best, *(c for c in found if c is not best)]


def _reduced(candidate: Candidate) -> bool:
    """Whether what sets a model apart was taken out of it, or its rise is not complete in each direction."""
    assert candidate.line is not None
    if not candidate.model.stribeck:
        return False
    fit = candidate.line.fit
    if fit.terms.stribeck_speed is None:
        return True
    falls = [key for key in fit.keys if key.endswith(".excess")]
    return not candidate.model.symmetric and any(_vague(fit, key) for key in falls)


def folds(samples: int, length: int) -> np.ndarray:
    """Fold of each sample: stretches of equal length, the folds in turn, so that each has something of all parts."""
    count = FOLDS * int(np.clip(samples // (FOLDS * LONG * length), 1, TURNS))
    return np.asarray((np.arange(samples) * count // samples) % FOLDS)


def _held(line: Line, setting: Setting) -> Setting:
    """With the Stribeck speed of the whole training part: few stretches are slow enough to tell it."""
    speed = line.fit.values.get(SPEED)
    return setting if speed is None else setting._replace(known={**setting.known, SPEED: speed})


def _vague(fit: LinearFit, key: str) -> bool:
    return interval_half(fit, key) > abs(fit.values[key])


def _tried(training: Record, model: Model, setting: Setting, judge: bool) -> Candidate:
    line = fitted(training, model, setting)
    candidate, all_of_it = Candidate(model, line), line.fit
    fold, held = folds(len(training.position), all_of_it.length), _held(line, setting)
    left, whole, rows = 0.0, 0.0, 0
    for k in range(FOLDS if judge and not _reduced(candidate) else 0):
        inside = fold == k
        try:
            fit = fitted(training.without(inside), model, held).fit
        except DataError:
            return candidate
        if fit.condition > MOST:
            return candidate
        part = training.without(~inside)
        r, by_others = _left(part, fit)
        _, by_all = _left(part, all_of_it)
        a = fit.rows.matrix[fit.rows.used][:, : r.matrix.shape[1]]
        predicted = _leverage(a, r.matrix[r.used]) <= FAR
        left += float(np.sum(np.where(predicted, by_others, by_all) ** 2))
        whole += float(np.sum((r.force + r.known)[r.used] ** 2))
        rows += int(r.used.sum())
    if rows >= LEAST and left < whole:
        candidate.rms, candidate.share = float(np.sqrt(left / rows)), 100.0 * float(np.sqrt(left / whole))
    return candidate


def _left(record: Record, fit: LinearFit) -> tuple[Rows, np.ndarray]:
    """Rows of a record, and what a line leaves of the force of those that are used."""
    r = rows_of(record, fit.terms, fit.length, fit.delay)
    return r, (r.force - r.matrix @ np.array([fit.values[key] for key in fit.terms.sought]))[r.used]


def _leverage(fitted_rows: np.ndarray, others: np.ndarray) -> np.ndarray:
    """``x' (X'X)^-1 x`` of rows that a line was not fitted to."""
    size = np.sqrt(np.mean(fitted_rows**2, axis=0))
    size = np.where(size > 0.0, size, 1.0)
    _, s, v = np.linalg.svd(fitted_rows / size, full_matrices=False)
    return np.asarray(np.sum(((others / size) @ v.T / np.maximum(s, 1e-9 * s.max(initial=0.0))) ** 2, axis=1))
