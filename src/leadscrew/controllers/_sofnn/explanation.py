"""The 49 rules of a tangential knife, and what they have learned: which fire, what they say now and what at first."""

from __future__ import annotations

from typing import Any

from leadscrew.controllers._parts import Part
from leadscrew.controllers._sofnn.levels import MOST_LEVEL, Scales, scales
from leadscrew.controllers._sofnn.network import AllWeightsParams, FnnParams, SofcParams, SofnnParams
from leadscrew.fuzzy.views import (
    Acting,
    Now,
    Quantity,
    closest,
    rules_view,
    sets_view,
    triangles,
    two_degrees,
)
from leadscrew.neural.groups import said_by
from leadscrew.neural.inference_net import AXIS, CENTRES, LABELS, RULES, Fired, fired, strengths

PEAKS = [float(c) for c in CENTRES]
SHOWN = 7.5
"""Levels up to which the shoulders of the outer sets are drawn."""


def four(at: Fired) -> list[tuple[int, float]]:
    """The rules that fire, as place ``7 j + i`` and firing strength."""
    k = 7 * int(at.j) + int(at.i)
    return list(zip((k, k + 1, k + 7, k + 8), map(float, strengths(at)), strict=True))


def levels_of(name: str, unit: str, value: float, level: float, centres: list[float], k: int, mu: float) -> Quantity:
    """An input with seven sets, in units of the value; ``level`` levels stand for one of them."""
    per = 1.0 / level if level > 0.0 else 1.0
    shown, unit = (value, unit) if level > 0.0 else (0.0, "levels")
    end = MOST_LEVEL * per
    return Quantity(
        name, shown, unit, -end, end, centres[0] * per, centres[-1] * per, per, LABELS,
        triangles(centres, per, -SHOWN * per, SHOWN * per), two_degrees(7, k, mu),
    )  # fmt: skip


class Texts:
    """The words of 49 rules, with what each says now and what it said before anything was learned."""

    def __init__(self, first: str, second: str, learns: bool) -> None:
        self.learns = learns
        self.ifs = [f"if {first} is {e} and {second} is {ec} then offset is " for ec in LABELS for e in LABELS]

    def acting(self, k: int, share: float, strength: float, says: float, prior: float) -> Acting:
        """Rule ``k``, which says ``says`` levels and said ``prior``."""
        text = f"{self.ifs[k]}{closest(LABELS, PEAKS, says)}"
        if not self.learns:
            return Acting(k + 1, text, share, strength, says)
        return Acting(k + 1, f"{text} ({says:+.2f}, at first {prior:+.2f})", share, strength, says, prior)


class Network:
    """The explanation of a fixed or learning network of the deviation and its change."""

    views = ("rules", "sets")

    def __init__(self, part: Part) -> None:
        self.fixed = isinstance(part.block.params, FnnParams)
        self.texts = Texts("deviation", "change", not self.fixed)
        self.params: Any = None
        self.scales: Scales
        self.prior: list[float]

    def _prepare(self, p: Any, dt: float) -> None:
        if p is not self.params:
            self.params, self.scales = p, scales(p, dt)
            self.prior = (p.rules if self.fixed else p.prior).tolist()

    def look(self, now: Now) -> dict[str, Any]:
        """The views ``rules`` and ``sets``."""
        self._prepare(now.params, now.dt)
        s, g = now.state, self.scales
        e, ec = g.k_e * s.watch.error, g.k_ec * s.watch.rate
        weights = self.prior if self.fixed else s.weights
        certain = hasattr(s, "certainties")
        centres = (s.centres_e.tolist(), s.centres_ec.tolist()) if certain else (PEAKS, PEAKS)
        if certain:
            found = said_by(weights, s.certainties, s.centres_e, s.centres_ec, e, ec)
            at, total = found.fired, float(found.total)
        else:
            at, total = fired(AXIS, AXIS, e, ec), 1.0
        acting = []
        for k, strength in four(at):
            share = strength * float(s.certainties[k]) / total if certain else strength
            acting.append(self.texts.acting(k, share, strength, float(weights[k]), self.prior[k]))
        # Unit of the change: per sample, unless the scale is per second.
        per, unit = (now.dt, "deg/s") if now.params.per_second else (1.0, "deg a sample")
        inputs = (
            levels_of("deviation", "deg", s.watch.error, g.k_e, centres[0], int(at.i), float(at.mu)),
            levels_of("change", unit, s.watch.rate / per, g.k_ec * per, centres[1], int(at.j), float(at.nu)),
        )
        said = sum(a.share * (a.value or 0.0) for a in acting)
        learned = sum(a.share * ((a.value or 0.0) - (a.prior or 0.0)) for a in acting) if not self.fixed else None
        outputs = [("level", said, "levels")]
        outputs += [] if learned is None else [("learned of it", learned, "levels")]
        outputs += [("offset of that level", min(max(g.k_d * said, -g.max_offset), g.max_offset), "deg")]
        outputs += [("offset sent", s.offset, "deg")]
        note = "the cut is not seen: the offset fades, the rules wait" if s.watch.blind else ""
        return {"rules": rules_view(inputs, outputs, acting, RULES, note), "sets": sets_view(inputs)}


EXPLANATIONS = dict.fromkeys((FnnParams, SofnnParams, SofcParams, AllWeightsParams), Network)
"""By the type of the parameters."""
