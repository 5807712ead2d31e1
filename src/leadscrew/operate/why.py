"""Why a running controller does what it does: the rules that fire, their sets, the phase plane, the circle.

========  =============================================================================================================
rules     which rules fire, in words, with their shares; the shares of all sum to one, and where the output is a
          weighted mean ``sum of share times value`` is what the rules say
sets      the membership functions as they are now (contracted, or moved by learning), with the degrees at the point
phase     of a sliding-mode controller: error and its rate, the line s = 0 and the boundary layer
circle    of a circle run: :class:`~leadscrew.operate.explain.circle.Circle`
========  =============================================================================================================

They are made of the parameters and the state of the live loop and of the last row of its signals: rows hold the
controller's state *after* the period's step, as ``live`` does. A controller inside others (feed-forward, a disturbance
observer, a guard) is found in them. Plain dicts of numbers (finite, or None) and texts.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from leadscrew.kernel.block import Block
from leadscrew.operate.explain.circle import Circle
from leadscrew.operate.explain.parts import Part, engine_of, follow, parts
from leadscrew.operate.explain.shown import Now, View

if TYPE_CHECKING:
    from leadscrew.kernel.live import Live
    from leadscrew.kernel.loop import Loop

MOVED = "leadscrew.controllers._look_ahead"
"""A wrapper that shows the controller inside it another command than the signals have."""


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
    from leadscrew.operate.explain import grey, network, sliding, system, vud

    made = engine_of(part.block)
    found: list[Any] = [of.explained(part.block) for of in (vud, grey, network)]
    if MOVED not in part.around:
        found.append(sliding.explained(part, made))
    if not part.around:
        found.append(system.explained(part.block, made))
    return next((v for v in found if v is not None), None)


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
