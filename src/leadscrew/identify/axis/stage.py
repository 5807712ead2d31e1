"""One model in the linear stage: what the log cannot tell is taken out of it, with a sentence, never invented."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from leadscrew.identify.axis.intervals import weakest
from leadscrew.identify.axis.inverse_dynamics import LinearFit, inverse_dynamics
from leadscrew.identify.axis.record import Record
from leadscrew.identify.axis.stribeck import stribeck_fit
from leadscrew.identify.axis.terms import Terms
from leadscrew.kernel.errors import DataError

MOST = 100.0
"""Condition number of the columns above which parameters cannot be told apart."""
SHARE = 0.02
"""Of the moving time that must go the other way for a log to count as one of both directions."""
GIVEN_UP = ("excess", "viscous", "offset", "coulomb")
"""What is given up first where terms cannot be told apart."""
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
