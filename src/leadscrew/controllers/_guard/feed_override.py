"""Force control as a feed override: what a machine control takes, instead of a voltage.

    ceiling  = programmed feed / feed_per_unit          the output at which the programmed feed is reached
    u        = inner(command, feedback), at most ceiling; the inner controller is told
    override = max(u, 0) / ceiling                      0 .. 1, a number; 1 on rapids; 0 is feed hold

The programmed feed is never exceeded, and the inner controller does not wind up against it: where it is cut down it is
aligned to the ceiling. ``inner`` is a force controller, or one under
:func:`~leadscrew.controllers.force_guard`, whose holds then are feed holds, on rapids as well. Levels
and the air-cutting limit of the guard stay in the unit of its own output.

With ``machine=True`` the command is a :class:`FeedCommand`, which brings the programmed feed and the flag for rapids
from the machine; a feed of 0, below 0 or not finite, or a flag that is not finite, is no programme: override 0, and the
inner controller starts from 0 once there is one. (On a rapid a feed of 0 is none of its business: override 1.)
Otherwise the feed is the parameter ``programmed_feed`` and there are no rapids. During a rapid the inner controller
waits at its last output. Without guard a number that is not finite, in command or reading, gives override 0 in that
period, and the inner controller waits.

For LinuxCNC's ``motion.adaptive-feed`` with ``M52 P1``: it multiplies the feed of G1, G2 and G3 **and of rapids**, so
these get 1. Not for threading and other moves that follow the spindle's angle (G33, G33.1, G76): LinuxCNC does not
scale these, neither does a hold stop them. The guard cannot protect them. See ``docs/force_guard.md``.

Source: ours; the pin is described in LinuxCNC's manual page motion(9).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any, NamedTuple, cast

from leadscrew.controllers._guard.answering import Answer
from leadscrew.controllers._guard.watching import Seen
from leadscrew.controllers._guard.wrapped import finite_command, finite_reading, taken_apart
from leadscrew.controllers._wrapping import around
from leadscrew.kernel.block import Block, make
from leadscrew.kernel.by_position import prepared
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.references._cutting_program import NEVER_S
from leadscrew.util.errors import entry_point

ProgrammedFeed = Annotated[
    float,
    Unit("mm/min"),
    Gt(0),
    Doc("the programme's feed, where the command does not bring it (machine=False): override 1"),
]
FeedPerUnit = Annotated[float, Unit("mm/min"), Gt(0), Doc("feed at which the inner controller's output is 1")]


class FeedCommand(NamedTuple):
    """A :class:`~leadscrew.references.CutCommand` with what the machine is at."""

    force: Annotated[float, Unit("N"), Doc("main cutting force to hold")] = 0.0
    depth: Annotated[float, Unit("mm"), Doc("depth of cut commanded now")] = 0.0
    next_depth: Annotated[float, Unit("mm"), Doc("depth after the next programmed change")] = 0.0
    change_in_s: Annotated[float, Unit("s"), Doc("time until that change")] = NEVER_S
    feed: Annotated[float, Unit("mm/min"), Doc("programmed feed; 0: none, the feed is held")] = 0.0
    rapid: Annotated[float, Doc("1 on a rapid move, else 0")] = 0.0


def feed_of(p, command):
    """The programmed feed that the machine tells; 0 where it tells no sound one."""
    sound = math.isfinite(command.feed) and math.isfinite(command.rapid) and command.feed >= 0.0
    free = command.rapid > 0.5 and command.feed == 0.0
    return p.programmed_feed if sound and free else command.feed if sound else 0.0


def programmed(p, command):
    """The parameter: the machine does not tell."""
    return p.programmed_feed


def rapid_of(command):
    """Whether the machine is on a rapid."""
    return command.rapid


def nothing(command):
    """0: the machine does not tell."""
    return 0.0


def _bare(inner: Block) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """A controller without guard: one period below a ceiling, and its bumpless start."""
    part = taken_apart(inner, "feed_override")
    law, align_law, told, shown = part.law, part.align, part.told, part.shown

    def below(p, s, command, feedback, ceiling, rapid, last, dt):
        """One period below a ceiling; on a rapid the controller waits."""
        if not (finite_command(command) and finite_reading(feedback)):
            return s, 0.0, last
        seen = Seen(feedback.force, feedback.raw, feedback.travel, feedback.turns, 0, 0, 0, 1, Answer())
        stepped, asked = law(p, s, told(command), shown(feedback, seen), dt)
        limited = last if rapid > 0.5 else min(asked, ceiling)
        if rapid > 0.5 or limited < asked:
            stepped = align_law(p, told(command), shown(feedback, seen), limited)
        return stepped, ceiling if rapid > 0.5 else limited, limited

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        seen = Seen(feedback.force, feedback.raw, feedback.travel, feedback.turns, 0, 0, 0, 1, Answer())
        return align_law(params, told(command), shown(feedback, seen), output)

    return below, align


@entry_point
def feed_override(
    inner: Block, programmed_feed: float = 120.0, feed_per_unit: float = 150.0, machine: bool = False, name: str = ""
) -> Block:
    """The force controller ``inner``, guarded or not, with a feed override for output; its parameters below ``inner.``.

    ``machine``: whether the command is a :class:`FeedCommand`.

    Raises:
        BlockError: ``inner`` is no sampled controller with a bumpless start that takes command, feedback and dt.
    """
    taken_apart(inner, "feed_override")
    guarded = getattr(inner.step, "below", None)
    below, align_law = (guarded, inner.align) if guarded is not None else _bare(inner)
    align_of: Any = align_law
    told_feed, told_rapid = (feed_of, rapid_of) if machine else (programmed, nothing)
    own: list[Any] = [("programmed_feed", ProgrammedFeed), ("feed_per_unit", FeedPerUnit)]
    params_type = around("FeedOverrideParams", inner.params, *own)
    state_type = around("FeedOverrideState", inner.state, ("last", float))

    def prepare(params: Any, dt: float) -> Any:
        ready = prepared(inner, dt, params.inner)
        return around("FeedOverridePlan", ready, *own)(ready, params.programmed_feed, params.feed_per_unit)

    def ceiling_of(p, command):
        """The inner controller's output at the programmed feed."""
        return told_feed(p, command) / p.feed_per_unit

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        u = min(max(output, 0.0), 1.0) * ceiling_of(params, command)
        return state_type(align_of(params.inner, command, feedback, u), u)

    def overridden(p, s, command, feedback, dt):
        """Force control as a feed override."""
        ceiling, rapid = ceiling_of(p, command), told_rapid(command)
        after, u, kept = below(p.inner, s.inner, command, feedback, ceiling, rapid, s.last, dt)
        return state_type(after, kept), min(max(u / ceiling, 0.0), 1.0) if ceiling > 0.0 else 0.0

    cast(Any, overridden).takes_cut = True
    return make(
        "controller", overridden, params_type(inner.params, programmed_feed, feed_per_unit),
        state_type(inner.state, 0.0), prepare=prepare, align=align, unit="1", full_scale=1.0, sense=inner.sense,
        doc=f"{inner.doc} Its output is a feed override.", name=name or f"{inner.name}_override",
    )  # fmt: skip
