"""Force control of a lathe under guard, as a feed override for LinuxCNC's motion.adaptive-feed: docs/force_guard.md.

    leadscrew simulate examples/turning_guard.py:loop
    leadscrew export examples/turning_guard.py:fast --target hal --name force_override --out force_override

A cut of 1 mm at 150 N, with a hard spot that doubles the force at 1.5 s; the tool leaves the work at 3 s, and from
3.2 s on the machine is on a rapid. ``fast`` is the same for a thread of 1 ms: the guard looks in every call.
"""

from typing import Annotated, NamedTuple

from leadscrew import Doc, Gt, Loop, Unit, actuator, reference, study
from leadscrew.controllers import Clock, FeedCommand, feed_override, force_guard
from leadscrew.disturbances import hard_spot
from leadscrew.plants import turning
from leadscrew.references import NEVER_S
from leadscrew.sensors import lathe_reading

FEED = 120.0
"""Programmed feed, mm/min: the F word."""
LEAVE_S = 3.0


class Machine(NamedTuple):
    """What the machine control tells."""

    force: Annotated[float, Unit("N"), Gt(0), Doc("main cutting force to hold")] = 150.0
    feed: Annotated[float, Unit("mm/min"), Gt(0), Doc("programmed feed")] = FEED
    rapid_s: Annotated[float, Unit("s"), Gt(0), Doc("when a rapid begins")] = 3.2


@reference(Machine())
def machine(p, t):
    """A cut, then a rapid."""
    return FeedCommand(p.force, 1.0, 1.0, NEVER_S, p.feed, 1.0 if t >= p.rapid_s else 0.0)


class Override(NamedTuple):
    """What the machine makes of an override."""

    feed: Annotated[float, Unit("mm/min"), Gt(0), Doc("programmed feed")] = FEED
    gain: Annotated[float, Unit("mm/(min V)"), Gt(0), Doc("feed of the lathe at 1 V")] = 150.0


@actuator(Override())
def overridden_feed(p, output):
    """The feed voltage of an override."""
    return p.feed * output / p.gain


TFC = study("grey_turning").controllers["corrected.tfc_stfc"]
controller = feed_override(force_guard(TFC), programmed_feed=FEED, machine=True)

loop = Loop(
    reference=machine,
    controller=controller,
    actuator=overridden_feed,
    plant=turning(**{"depth.leave_s": LEAVE_S}),
    sensor=lathe_reading,
    disturbance=hard_spot,
    period=0.02,
    substeps=20,
    metrics={},
    name="turning under guard",
)

guarded = force_guard(TFC, clock=Clock(every=20))
fast = Loop(
    reference=machine,
    controller=feed_override(guarded, programmed_feed=FEED, machine=True),
    actuator=overridden_feed,
    plant=turning(**{"depth.leave_s": LEAVE_S}),
    sensor=lathe_reading,
    disturbance=hard_spot,
    period=0.001,
    metrics={},
    name="turning under guard, 1 ms",
)
