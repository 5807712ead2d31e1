"""How often true parameters lie within the intervals that a fit states, over random axes of `axis_truth`.

A constant force cannot be told from friction that differs by direction: sliding shows `offset + C+` and `C- - offset`,
sticking likewise. So the truth is compared in the fit's own terms: with the offset that the fit has (fixed, given or
found), or, where the fit has one Coulomb friction for both directions, with the mean of the two.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np

from tests.identify.axis_truth import SIDES, Truth, truths

GROUPS = ("mass", "coulomb", "viscous", "static", "stribeck_speed", "offset", "delay_s")


class Row(NamedTuple):
    """One statement of a fit about one axis."""

    seed: int
    kind: str
    key: str
    group: str
    truth: float
    value: float
    low: float
    high: float
    told: bool
    how: str
    wanted: bool
    """The log excites it: a fit that says nothing about it dodges."""

    @property
    def inside(self) -> bool:
        return self.low <= self.truth <= self.high

    @property
    def width(self) -> float:
        """Half of the interval as a share of the truth."""
        return 0.5 * (self.high - self.low) / abs(self.truth) if self.truth else math.inf

    @property
    def error(self) -> float:
        return (self.value - self.truth) / abs(self.truth) if self.truth else math.inf

    @property
    def z(self) -> float:
        """Error in halves of the interval."""
        return (self.value - self.truth) / max(0.5 * (self.high - self.low), 1e-300)


def expected(t: Truth, fit: Any) -> dict[str, float]:
    """True values in the terms of the fit."""
    true = dict(t.values)
    ahead, back = (f"friction.{side}" for side in SIDES)
    shift = true["offset"] - fit.parameters["offset"].value
    if fit.symmetric:
        shift = 0.5 * (true[f"{back}.coulomb"] - true[f"{ahead}.coulomb"])
    for name in ("coulomb", "static"):
        true[f"{ahead}.{name}"] += shift
        true[f"{back}.{name}"] -= shift
    true["offset"] -= shift
    return true


def statements(t: Truth, fit: Any) -> list[Row]:
    """What a fit says, beside the truth; values that two keys share are taken once."""
    rows, true = [], expected(t, fit)
    for key, p in fit.parameters.items():
        group = key.split(".")[-1]
        if group not in GROUPS or (group == "stribeck_speed" and t.kind.startswith("coulomb")):
            continue
        ahead = fit.parameters.get(key.replace("backward", "forward"))
        if "backward" in key and ahead is not None and ahead[:4] == p[:4] and _same(true, key):
            continue
        rows.append(
            Row(t.seed, t.kind, key, group, true[key], p.value, p.low, p.high, p.identifiable, p.how, key in t.excites)
        )
    return rows


def _same(true: dict[str, float], key: str) -> bool:
    return math.isclose(true[key], true[key.replace("backward", "forward")], rel_tol=1e-12)


def coverage(fit_function: Callable[[Truth], Any], seeds: Iterable[int]) -> list[Row]:
    """All statements about the axes of these seeds."""
    return [row for t in truths(tuple(seeds)) for row in statements(t, fit_function(t))]


class Share(NamedTuple):
    """Of one group of parameters."""

    group: str
    statements: int
    told: int
    inside: int
    """Of those told."""
    width: float
    """Median half of the interval, of the truth."""
    error: float
    """Median size of the error, of the truth."""
    bias: float
    """Median error in halves of the interval: 0 without bias."""


def shares(rows: Iterable[Row]) -> list[Share]:
    """By group, and all together last."""
    found, every = [], list(rows)
    for group in (*GROUPS, "all"):
        mine = [r for r in every if group in ("all", r.group)]
        said = [r for r in mine if r.told and r.how == "fitted"]
        if said:
            found.append(
                Share(
                    group, len(mine), len(said), sum(r.inside for r in said), float(np.median([r.width for r in said])),
                    float(np.median([abs(r.error) for r in said])), float(np.median([r.z for r in said])),
                )
            )  # fmt: skip
    return found


def table(rows: Iterable[Row]) -> str:
    """For people."""
    lines = [f"{'group':15} {'count':>5} {'told':>5} {'inside':>6} {'share':>6} {'width':>8} {'error':>8} {'bias':>6}"]
    for s in shares(rows):
        lines.append(
            f"{s.group:15} {s.statements:5d} {s.told:5d} {s.inside:6d} {100.0 * s.inside / s.told:5.1f}% "
            f"{100.0 * s.width:7.2f}% {100.0 * s.error:7.2f}% {s.bias:+6.2f}"
        )
    return "\n".join(lines)
