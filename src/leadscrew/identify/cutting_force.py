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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from leadscrew.analysis.cutting_force import PowerLaw
from leadscrew.identify.cutting_force_fit import (
    CONFIDENCE,
    KAPPA_DEG,
    METHODS,
    Interval,
    LawFit,
    Method,
    chip_and_edge_model,
    fit_law,
    power_model,
)
from leadscrew.identify.cutting_force_table import ForceTable
from leadscrew.kernel.errors import DataError, ValueRefused

SAME = 1.02
"""Feeds or depths within this ratio are taken to be one."""
NARROW = 1.5
"""Range of feeds below which the exponent is told by hardly anything."""
ROUNDING = 1e-9
"""An exponent nearer to 1 than this is 1."""


class DepthTest(NamedTuple):
    """Whether the force is in proportion to the depth."""

    exponent: Interval
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
        from scipy.stats import t as student

        if not (0.0 < feed < math.inf and 0.0 < depth < math.inf):
            raise ValueRefused(f"feed = {feed!r} mm/rev, depth = {depth!r} mm: both must be above 0")
        fit, value = self.chosen, float(self.law.force(feed, depth))
        row = np.array([1.0, math.log(feed)][: len(fit.covariance)])
        quantile = float(student.ppf(0.5 + 0.5 * CONFIDENCE, fit.freedom))
        share = fit.scatter / value if fit.method == "absolute" else fit.scatter
        reach = quantile * math.sqrt(float(row @ fit.covariance @ row) + share**2)
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
        notes.append("feed and depth change together in every row: their effects cannot be told apart")
    elif depth is None:
        notes.append("too few cuts to test whether the force is in proportion to the depth")
    elif depth.p_value < 1.0 - CONFIDENCE:
        q = depth.exponent
        notes.append(
            f"the force is not in proportion to the depth: exponent {q.value:.3f} ({q.low:.3f} to {q.high:.3f}), "
            f"p = {depth.p_value:.2g}; a law in proportion is off by up to {chosen.worst_percent:.3g} % here"
        )
    told = chosen.parameters.get("exponent")
    if told is not None and not (told.low > 0.0 and told.high < 1.0):
        notes.append(
            f"the exponent's interval {told.low:.3f} to {told.high:.3f} reaches outside 0 to 1, where cutting laws "
            "have it: more feeds, or less scatter"
        )
    speed = table.others.get("speed")
    if speed is not None and float(speed.max() / speed.min()) > 1.1:
        notes.append(
            f"the cutting speed changes from {speed.min():.4g} to {speed.max():.4g} m/min, which no law here knows of"
        )
    return notes
