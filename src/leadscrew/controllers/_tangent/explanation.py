"""The rules of a tangential knife about the line ahead: which fire, what they conclude now and what at first."""

from __future__ import annotations

import math
from typing import Any

from leadscrew.controllers._parts import Part
from leadscrew.controllers._sofnn.explanation import PEAKS, Texts, four, levels_of
from leadscrew.controllers._tangent.believed import RING
from leadscrew.controllers._tangent.curvature_network import TWICE, CurvatureNetworkParams
from leadscrew.fuzzy.views import Now, rules_view, sets_view
from leadscrew.neural.inference_net import AXIS, RULES, fired

AHEAD = "the rules are asked about the line ahead, not about the error"


class Curvature:
    """The explanation of a controller whose rules are about the line ahead."""

    views = ("rules", "sets")

    def __init__(self, part: Part) -> None:
        self.texts = Texts("curvature", "its change", True)

    def look(self, now: Now) -> dict[str, Any]:
        """The views ``rules`` and ``sets``."""
        p, s = now.params, now.state
        last = (s.at + RING - 1) % RING
        e, ec, heading = float(s.curvatures[last]), float(s.changes[last]), float(s.headings[last])
        at = fired(AXIS, AXIS, e, ec)
        acting = [self.texts.acting(k, h, h, float(s.weights[k]), float(p.prior[k])) for k, h in four(at)]
        said = sum(a.share * (a.value or 0.0) for a in acting)
        turned = s.weights[RULES] * math.sin(TWICE * heading) + s.weights[RULES + 1] * math.cos(TWICE * heading)
        inputs = (
            levels_of("curvature", "1/mm", e / p.k_c if p.k_c > 0.0 else 0.0, p.k_c, PEAKS, int(at.i), float(at.mu)),
            levels_of("its change", "1/mm", ec / p.k_h if p.k_h > 0.0 else 0.0, p.k_h, PEAKS, int(at.j), float(at.nu)),
        )
        outputs = [
            ("level", said, "levels"), ("by the direction", turned, "levels"),
            ("by the observer", p.gain * s.found, "levels"), ("offset sent", s.sent, "deg"),
        ]  # fmt: skip
        return {"rules": rules_view(inputs, outputs, acting, RULES, AHEAD), "sets": sets_view(inputs)}


EXPLANATIONS: dict[type, type[Curvature]] = {CurvatureNetworkParams: Curvature}
"""By the type of the parameters."""
