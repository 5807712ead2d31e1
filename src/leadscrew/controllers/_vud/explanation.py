"""Rules and contracting sets of the controllers with a variable universe: :obj:`leadscrew.controllers.vud`."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from leadscrew.controllers._parts import Part
from leadscrew.controllers._vud.family import VudFamilyParams
from leadscrew.controllers._vud.fast import VudFastParams
from leadscrew.controllers._vud.printed import VudBetaEParams, VudIncrementalParams, VudIntegralFactorParams, VudParams
from leadscrew.controllers._vud.scaled import VudScaledParams
from leadscrew.controllers._vud.universe import held
from leadscrew.fuzzy.inference import RuleBase, rule_base
from leadscrew.fuzzy.views import (
    Acting,
    Now,
    Quantity,
    closest,
    rules_view,
    set_names,
    sets_view,
    triangles,
    two_degrees,
)
from leadscrew.neural.inference_net import fired


class Scales(NamedTuple):
    """How a member of the family makes its inputs, and what it makes of the rules' output."""

    error_unit: float
    """Millimetres of e = 1, before the gain."""
    rate_unit: float
    """Millimetres a second of ec = 1, before the gain."""
    error_gain: float
    rate_gain: float
    most: float
    """Largest size of an input before it is contracted."""
    error_name: str
    rate_name: str
    rule: str
    """What the duty is made of, in words."""


def per_interval(p: Any) -> float:
    """Millimetres a second of ec = 1."""
    return float(p.rate_full_scale_mm / p.rate_interval_s)


def plain(p: Any, rule: str) -> Scales:
    """The inputs of (5) and (6)."""
    return Scales(p.error_full_scale_mm, per_interval(p), 1.0, 1.0, math.inf, "error", "change", rule)


def gained(p: Any, most: float, rule: str) -> Scales:
    """The same with gains."""
    return Scales(
        p.error_full_scale_mm, per_interval(p), p.error_gain, p.rate_gain, most, "error", "change", rule
    )  # fmt: skip


PRODUCT = "duty = beta times what the rules say"
SCALES: dict[type, Callable[[Any], Scales]] = {
    VudParams: lambda p: plain(p, PRODUCT),
    VudBetaEParams: lambda p: plain(p, PRODUCT),
    VudIntegralFactorParams: lambda p: plain(p, PRODUCT),
    VudIncrementalParams: lambda p: plain(p, f"duty = last duty + {p.gain:g} times what the rules say"),
    VudFamilyParams: lambda p: gained(p, 1.0 if p.hold_inputs else math.inf, PRODUCT),
    VudScaledParams: lambda p: gained(
        p, 1.0, f"duty = {p.output_gain:g} times what the rules say, plus integral and dead zone"
    ),
    VudFastParams: lambda p: Scales(
        p.error_full_scale_mm, p.speed_full_scale_mm_s, 1.0, 1.0, 1.0, "error of the stop", "speed",
        f"duty = {p.output_gain:g} times what the rules say, within its limits",
    ),
}  # fmt: skip


class Contracting:
    """The explanation of one controller of the family."""

    views = ("rules", "sets")

    def __init__(self, part: Part) -> None:
        self.params: Any = None
        self.scales: Scales
        self.rules: RuleBase
        self.centres: tuple[list[float], list[float]]
        self.names: tuple[tuple[str, ...], tuple[str, ...]]
        self.outputs: list[list[float]]
        self.texts: list[list[str]]

    def _prepare(self, p: Any) -> None:
        if p is self.params:
            return
        self.params, self.scales = p, SCALES[type(p)](p)
        self.rules = rule_base(p.e_centres, p.ec_centres, p.rules)
        self.centres = self.rules.first.centres.tolist(), self.rules.second.centres.tolist()
        self.names = set_names(len(self.centres[0])), set_names(len(self.centres[1]))
        self.outputs = self.rules.table.tolist()
        s, (rows, columns) = self.scales, self.names
        self.texts = [
            [
                f"if {s.error_name} is {a} and {s.rate_name} is {b} then duty is "
                f"{closest(rows, self.centres[0], self.outputs[i][j])}"
                for j, b in enumerate(columns)
            ]
            for i, a in enumerate(rows)
        ]

    def look(self, now: Now) -> dict[str, Any]:
        """The views ``rules`` and ``sets``."""
        self._prepare(now.params)
        seen = getattr(now.state, "seen", now.state)
        g = self.scales
        x = held(g.error_gain * seen.e, g.most) / seen.alpha_e
        y = held(g.rate_gain * seen.ec, g.most) / seen.alpha_ec
        at = fired(self.rules.first, self.rules.second, x, y)
        i, j, mu, nu = int(at.i), int(at.j), float(at.mu), float(at.nu)
        acting = [
            self._acting(i, j, (1.0 - mu) * (1.0 - nu)), self._acting(i, j + 1, (1.0 - mu) * nu),
            self._acting(i + 1, j, mu * (1.0 - nu)), self._acting(i + 1, j + 1, mu * nu),
        ]  # fmt: skip
        inputs = (
            self._input(0, g.error_name, "mm", seen.e * g.error_unit, g.error_unit, g.error_gain, seen.alpha_e, i, mu),
            self._input(1, g.rate_name, "mm/s", seen.ec * g.rate_unit, g.rate_unit, g.rate_gain, seen.alpha_ec, j, nu),
        )
        said = sum(a.share * (a.value or 0.0) for a in acting)
        outputs = [("rules", said, "")]
        outputs += [("beta", seen.beta, "")] if hasattr(seen, "beta") else []
        outputs += [("integral", seen.integral, "")] if hasattr(seen, "integral") else []
        total = len(self.names[0]) * len(self.names[1])
        return {
            "rules": rules_view(inputs, [*outputs, ("duty", seen.rho, "")], acting, total, g.rule),
            "sets": sets_view(inputs),
        }

    def _acting(self, i: int, j: int, share: float) -> Acting:
        number = i * len(self.names[1]) + j + 1
        return Acting(number, self.texts[i][j], share, share, self.outputs[i][j])

    def _input(
        self, which: int, name: str, unit: str, value: float, size: float, gain: float, alpha: float, k: int, mu: float
    ) -> Quantity:
        """An input in its own unit; one with a gain of 0, which the rules do not see, in the rules' own."""
        c, names = self.centres[which], self.names[which]
        unseen = gain == 0.0
        full = 1.0 if unseen else size / gain
        ends = sorted((full * c[0], full * c[-1]))
        now = sorted((alpha * full * c[0], alpha * full * c[-1]))
        return Quantity(
            name, 0.0 if unseen else value, "" if unseen else unit, ends[0], ends[1], now[0], now[1], full * alpha,
            names, triangles(c, full * alpha, min(ends[0], now[0]), max(ends[1], now[1])),
            two_degrees(len(names), k, mu), None if unseen else held(value, self.scales.most * abs(full)),
        )  # fmt: skip


EXPLANATIONS = dict.fromkeys(SCALES, Contracting)
"""By the type of the parameters."""
