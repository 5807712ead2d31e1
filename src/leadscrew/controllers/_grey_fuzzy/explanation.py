"""Rules and sets of the fuzzy force controllers: TFC, GPFC, and the Smith predictor around the same rules."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from leadscrew.controllers._grey_fuzzy.gpfc import GpfcParams
from leadscrew.controllers._grey_fuzzy.rule_tables import SETS
from leadscrew.controllers._grey_fuzzy.rules_shown import set_name, surface_of
from leadscrew.controllers._grey_fuzzy.smith import SmithParams
from leadscrew.controllers._grey_fuzzy.surface import CENTRES, Surface, firing
from leadscrew.controllers._grey_fuzzy.tfc import TfcParams
from leadscrew.controllers._parts import Part
from leadscrew.fuzzy.inference import inside_universe, interval_index, upper_membership
from leadscrew.fuzzy.views import Acting, Now, Quantity, rules_view, sets_view, triangles, two_degrees

PEAKS = [float(c) for c in CENTRES]
INPUTS = {
    TfcParams: ("error", "change"),
    GpfcParams: ("predicted error", "its change"),
    SmithParams: ("error without the delay", "its change"),
}
"""Of the rules."""


class Scaled:
    """The explanation of a controller whose 49 rules are scaled by S1, S2 and S3."""

    views = ("rules", "sets")

    def __init__(self, part: Part) -> None:
        self.block = part.block
        self.error, self.change = INPUTS[type(part.block.params)]
        self.params: Any = None
        self.surface: Surface
        self.table: list[list[float]]
        self.points: list[Any]

    def _prepare(self, p: Any) -> None:
        if p is self.params:
            return
        self.params, self.surface = p, surface_of(replace(self.block, params=p))
        self.table = self.surface.rules.table.tolist()
        self.points = [triangles(PEAKS, s, 7.5 * -s, 7.5 * s) for s in (p.error_scale, p.change_scale)]

    def look(self, now: Now) -> dict[str, Any]:
        """The views ``rules`` and ``sets``."""
        p, s = now.params, now.state
        self._prepare(p)
        f = firing(self.surface, s.error, s.change)
        row, column = int(f.row), int(f.column)
        inputs = (
            self._input(0, self.error, s.error, p.error_scale, self.surface.rules.first),
            self._input(1, self.change, s.change, p.change_scale, self.surface.rules.second),
        )
        places = ((row, column), (row, column + 1), (row + 1, column), (row + 1, column + 1))
        acting = [
            self._acting(i, j, float(share), inputs) for (i, j), share in zip(places, f[2:], strict=True)
        ]  # fmt: skip
        said = sum(a.share * (a.value or 0.0) for a in acting)
        what = "output" if p.positional else "step of the output"
        outputs = [(f"{what} by the rules", said, "V"), ("output", s.output, "V")]
        if hasattr(s, "prediction"):
            outputs.insert(0, ("predicted force", s.prediction, "N"))
        joined = "product" if p.inference == 0 else "minimum"
        return {
            "rules": rules_view(inputs, outputs, acting, len(SETS) ** 2, f"{joined} inference, {what}"),
            "sets": sets_view(inputs),
        }

    def _acting(self, i: int, j: int, share: float, inputs: tuple[Quantity, Quantity]) -> Acting:
        concludes, p = self.table[i][j], self.params
        mu, nu = inputs[0].degrees[i], inputs[1].degrees[j]
        then = "output is" if p.positional else "the output changes by"
        text = f"if {self.error} is {SETS[i]} and {self.change} is {SETS[j]} then {then} {set_name(concludes / 2.0)}"
        strength = mu * nu if p.inference == 0 else min(mu, nu)
        return Acting(7 * i + j + 1, text, share, strength, p.output_scale * concludes)

    def _input(self, which: int, name: str, value: float, scale: float, axis: Any) -> Quantity:
        x = inside_universe(axis, value / scale)
        k = int(interval_index(axis, x))
        degrees = two_degrees(len(SETS), k, float(upper_membership(axis, k, x)))
        end = PEAKS[-1] * scale
        return Quantity(name, value, "N", -end, end, -end, end, scale, SETS, self.points[which], degrees)


EXPLANATIONS = dict.fromkeys(INPUTS, Scaled)
"""By the type of the parameters."""
