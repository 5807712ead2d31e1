"""Why a running controller does what it does: the rules that fire, their sets, the phase plane, the circle.

========  =============================================================================================================
rules     which rules fire, in words, with their shares; the shares of all sum to one, and where the output is a
          weighted mean ``sum of share times value`` is what the rules say
sets      the membership functions as they are now (contracted, or moved by learning), with the degrees at the point
phase     of a sliding-mode controller: error and its rate, the line s = 0 and the boundary layer
circle    of a circle run: :class:`~leadscrew.operate.circle.Circle`
========  =============================================================================================================

They are made of the parameters and the state of the live loop and of the last row of its signals: rows hold the
controller's state *after* the period's step, as ``live`` does. A controller inside others (feed-forward, a disturbance
observer, a guard) is found in them. Plain dicts of numbers (finite, or None) and texts.
"""

from __future__ import annotations

import types
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from leadscrew.controllers._grey_fuzzy import explanation as grey
from leadscrew.controllers._parts import Part, engine_of, follow, parts
from leadscrew.controllers._sliding import explanation as sliding
from leadscrew.controllers._sofnn import explanation as sofnn
from leadscrew.controllers._tangent import explanation as tangent
from leadscrew.controllers._vud import explanation as vud
from leadscrew.controllers._wrapping import copied
from leadscrew.fuzzy.block import Memory
from leadscrew.fuzzy.engine import Engine
from leadscrew.fuzzy.system_view import Rules
from leadscrew.fuzzy.views import Now, View
from leadscrew.kernel.block import Block
from leadscrew.operate.circle import Circle

if TYPE_CHECKING:
    from leadscrew.kernel.live import Live
    from leadscrew.kernel.loop import Loop

EXPLANATIONS: dict[type, Callable[[Part], View | None]] = {
    **vud.EXPLANATIONS, **grey.EXPLANATIONS, **sofnn.EXPLANATIONS, **tangent.EXPLANATIONS, **sliding.EXPLANATIONS,
}  # fmt: skip
"""Of each family of controllers, which stand in its folder; by the type of the parameters."""


class FromSystem:
    """The explanation of a controller made by :func:`leadscrew.fuzzy.controller` or read from a system's file.

    Its inputs are not kept in its state, so they are those of the period that comes: the step is taken once more, in
    plain Python, with what the loop would give it, and what it hands to the system is noted.
    """

    views = ("rules", "sets")

    def __init__(self, block: Block, engine: Engine) -> None:
        self.block, self.rules = block, Rules(engine)
        self.params: Any = None
        self.plan: Any = None
        self.handed: list[float] = []
        infer = engine.infer
        many = len(engine.system.inputs)

        def noted(plan: Any, *values: float) -> Any:
            self.handed = [float(x) for x in values[:many]]
            return infer(plan, *values)

        own = {**block.step.__globals__, "infer": noted}
        self.step: Any = types.FunctionType(block.step.__code__, own)

    def look(self, now: Now) -> dict[str, Any]:
        """The views ``rules`` and ``sets``, of the period that comes."""
        p = now.params
        if p is not self.params:
            self.params, self.plan = p, replace(self.block, params=p).prepare(p, now.dt)  # type: ignore[misc]
            self.rules.prepare(p.tables)
        try:
            coming = now.live.advance_preview()
        except IndexError:  # the loop is lost in the period that comes: it gives no signals
            return {}
        _, output = self.step(self.plan, copied(now.state), coming["command"], coming["feedback"], now.dt)
        ones = [1.0] * len(self.handed)
        outputs = [("output", float(output), self.block.unit)]
        return self.rules.look(self.handed, ones, [v.unit for v, _ in self.rules.variables], outputs)


@dataclass
class Explainer:
    """What can be shown of one controller in one loop."""

    views: tuple[str, ...] = ()
    """Of ``rules``, ``sets``, ``phase``."""
    reason: str = ""
    """Where there is no view: why not, in a sentence."""
    part: Part | None = None
    view: View | None = None
    last: dict[str, Any] = field(default_factory=dict)
    """The views of the last look; a loop that has diverged keeps them."""

    def look(self, live: Live, row: Mapping[str, float], views: Collection[str] | None = None) -> dict[str, Any]:
        """The views now, by name; ``views`` names those wanted, all where it is None.

        ``live`` has the loop that the explainer was made for, with any values of its parameters; ``row`` is its last
        row of signals by column (``command``, ``feedback``, the controller's states).
        """
        if self.view is None or self.part is None:
            return {}
        if live.diverged is None and live.period > 0:
            block = live.loop.blocks["controller"]
            assert block is not None
            state = live.program.plan.state.unpack(*live.state).controller
            own = follow(block.params, self.part.params), follow(state, self.part.state)
            self.last = self.view.look(Now(*own, row, live.loop.period, live)) or self.last
        return {k: v for k, v in self.last.items() if views is None or k in views}


def view_of(part: Part) -> View | None:
    """The explanation of a controller, without looking inside it; None where there is none."""
    explanation = EXPLANATIONS.get(type(part.block.params))
    if explanation is not None:
        return explanation(part)
    engine = None if part.around else engine_of(part.block)
    return FromSystem(part.block, engine) if engine is not None and isinstance(part.block.state, Memory) else None


def explained(block: Block) -> tuple[Part, View] | None:
    """The first explanation of a controller or of one inside it, from the outermost in."""
    for part in parts(block):
        found = view_of(part)
        if found is not None:
            return part, found
    return None


def explainer(loop: Loop, controller_name: str) -> Explainer:
    """The explainer of a loop's controller; one without views says why in ``reason``.

    After ``Live.switch`` the loop has another controller: make another explainer, of ``live.loop``.
    """
    block = loop.blocks["controller"]
    found = None if block is None else explained(block)
    if found is None:
        return Explainer(
            reason=f"{controller_name} is neither a fuzzy nor a sliding-mode controller: it has no rules, no sets and "
            "no surface to show."
        )
    part, view = found
    return Explainer(tuple(view.views), "", part, view)


__all__ = ["Circle", "Explainer", "explained", "explainer"]
