"""The phase plane of a sliding-mode controller: error and its rate, the line s = 0, the boundary layer, all as now.

The line is read off the controller's own ``surface(p, now)``, which is linear in the error, its rate and its integral:
``s = a e + b e' + c xi``. With an integral the line moves as the integral does. What stands for the boundary layer:

- smc, csmc, smc_integral: ``|s| <= phi``, phi the gain over the slope where a slope is given;
- super_twisting: ``|s| <= layer``, below which the sign is a slope;
- fuzzy sliding mode: ``|s| <= scale_s``, beyond which the fuzzy system says its most.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from leadscrew.controllers._parts import Part, engine_of, named_by
from leadscrew.controllers._sliding import complementary, conventional, integral
from leadscrew.controllers._sliding.fields import stage_params
from leadscrew.controllers._sliding.fuzzy import FsmcParams, complement
from leadscrew.controllers._sliding.stage import SlidingParams, View, layer_slope, switching_gain
from leadscrew.controllers._sliding.super_twisting import SuperTwistingParams
from leadscrew.fuzzy.engine import Engine
from leadscrew.fuzzy.system_view import Rules
from leadscrew.fuzzy.views import Now, number, rounded_up
from leadscrew.kernel.block import Block

WORDS = {
    conventional: "s = e' + lambda e",
    complementary: "s + s_c = 2 (e' + lambda e)",
    integral: "s = e' + 2 lambda e + lambda^2 xi",
}
"""By the module of the law."""
FADES = 0.98
"""What is left of the plane's width from one look to the next, where the point stays further in."""
NOTHING = View(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)


class Line(NamedTuple):
    """``s = e error + rate speed + xi integral``."""

    e: float
    rate: float
    xi: float


def line_of(surface: Callable[..., float], p: SlidingParams) -> Line:
    """The factors of a surface that is linear."""
    unit = [surface(p, NOTHING._replace(**{of: 1.0})) for of in Line._fields]
    return Line(*(float(x) for x in unit))


def law_of(block: Block) -> Any:
    """The module whose ``surface`` a sliding-mode controller uses; None where that is not known."""
    if isinstance(block.params, FsmcParams):
        return integral
    if isinstance(block.params, SuperTwistingParams):
        return conventional
    names = {block.step.__module__} | {getattr(v, "__module__", "") for _, v in named_by(block.step)}
    return next((m for m in WORDS if m.__name__ in names), None)


class Plane:
    """The explanation of one sliding-mode controller."""

    def __init__(self, part: Part, law: Any, engine: Engine | None) -> None:
        self.column, self.law = part.column, law
        self.ideal = part.block.continuous
        self.rules = Rules(engine) if engine is not None else None
        self.views = ("rules", "sets", "phase") if self.rules is not None else ("phase",)
        self.params: Any = None
        self.stage: SlidingParams
        self.line: Line
        self.widest = 0.0

    def _prepare(self, p: Any) -> None:
        if p is self.params:
            return
        self.params, self.stage = p, stage_params(p)
        self.line = line_of(self.law.surface, self.stage)
        if self.rules is not None:
            self.rules.prepare(p.tables)

    def seen(self, now: Now) -> View:
        """What the law saw in the period of the row."""
        p, row = self.stage, now.row
        per = 1.0 / p.travel_per_rad
        at = {k: per * row[f"command.{k}"] for k in ("position", "velocity", "acceleration")}
        if self.ideal:
            angle, speed = per * row["feedback.position"], per * row["feedback.velocity"]
            xi = row.get(f"{self.column}xi", now.state.xi)
        else:
            angle, speed, xi = now.state.angle, now.state.speed, now.state.xi
        gain = switching_gain(p, speed)
        return View(
            angle, speed, angle - at["position"], speed - at["velocity"], xi, at["acceleration"], 0.0, 0.0, gain,
            layer_slope(p, gain),
        )  # fmt: skip

    def layer(self, p: Any, now: View) -> float:
        """Half the width of the boundary layer, in units of s."""
        if isinstance(p, FsmcParams):
            return float(p.scale_s)
        if isinstance(p, SuperTwistingParams):
            return float(p.layer)
        return float(now.gain / now.slope)

    def look(self, now: Now) -> dict[str, Any]:
        """The view ``phase``; of fuzzy sliding mode ``rules`` and ``sets`` besides."""
        self._prepare(now.params)
        seen = self.seen(now)
        found = {"phase": self._phase(now.params, seen)}
        return found | self._rules(now.params, seen, now) if self.rules is not None else found

    def _rules(self, p: FsmcParams, seen: View, now: Now) -> dict[str, Any]:
        assert self.rules is not None
        if self.ideal:
            s, s_c = self.law.surface(self.stage, seen) / p.scale_s, complement(self.stage, seen) / p.scale_sc
        else:
            s, s_c = now.state.s, now.state.s_c
        pushes = [("torque", p.fuzzy_torque * self.rules.engine.infer(self.rules.engine.plan, s, s_c), "N m")]
        return self.rules.look((s, s_c), (p.scale_s, p.scale_sc), ("rad/s", "rad/s"), pushes)

    def _phase(self, p: Any, seen: View) -> dict[str, Any]:
        a, b, c = self.line
        moved = c * seen.xi
        s = a * seen.e + b * seen.rate + moved
        phi = self.layer(p, seen)
        self.widest = max(abs(seen.e), abs(seen.rate) * b / a, FADES * self.widest)
        reach = rounded_up(1.2 * self.widest)

        def along(level: float) -> list[list[float | None]]:
            return [[number(x), number((level - moved - a * x) / b)] for x in (-reach, reach)]

        inside = abs(s) <= phi
        layer = "|s| <= S, the fuzzy system's universe" if isinstance(p, FsmcParams) else "the boundary layer"
        text = (
            f"{WORDS[self.law]} = {s:.3g} rad/s, {'inside' if inside else 'outside'} {layer} of {phi:.3g} rad/s; "
            f"lambda = {p.lam:g} 1/s"
        )
        return {
            "x": self._axis("error", "rad", seen.e, "angle", "position", reach),
            "y": self._axis("error rate", "rad/s", seen.rate, "speed", "velocity", reach * a / b),
            "surface": along(0.0), "layer": [along(phi), along(-phi)], "s": number(s), "phi": number(phi),
            "inside": inside, "text": text,
        }  # fmt: skip

    def _axis(self, label: str, unit: str, value: float, own: str, field: str, reach: float) -> dict[str, Any]:
        """An axis from ``low`` to ``high``; ``terms``: columns and factors whose sum draws the trail."""
        per = 1.0 / self.stage.travel_per_rad
        measured = (f"feedback.{field}", per) if self.ideal else (f"{self.column}{own}", 1.0)
        terms = [[name, factor] for name, factor in (measured, (f"command.{field}", -per))]
        return {
            "label": label, "unit": unit, "value": number(value), "low": number(-reach), "high": number(reach),
            "terms": terms,
        }  # fmt: skip


LOOK_AHEAD = "leadscrew.controllers._look_ahead"
"""A wrapper that gives the controller inside it another command than the signals have."""


def explained(part: Part) -> Plane | None:
    """The explanation of a sliding-mode controller; None where its surface or its command is not known."""
    law = law_of(part.block)
    if law is None or LOOK_AHEAD in part.around:
        return None
    return Plane(part, law, engine_of(part.block) if isinstance(part.block.params, FsmcParams) else None)


EXPLANATIONS = dict.fromkeys((SlidingParams, SuperTwistingParams, FsmcParams), explained)
"""By the type of the parameters."""
