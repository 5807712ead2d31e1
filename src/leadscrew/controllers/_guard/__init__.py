"""Protection of a cut: a guard on the force and the load cell around a force controller, and its feed override."""

from leadscrew.controllers._guard.feed_override import FeedCommand, feed_override
from leadscrew.controllers._guard.force_guard import Clock, force_guard
from leadscrew.controllers._guard.holding import HOLDING, RUNNING, TRIPPED, AirCut, Recovery
from leadscrew.controllers._guard.watching import CAUSES, CellChecks, Levels

__all__ = [
    "CAUSES", "HOLDING", "RUNNING", "TRIPPED", "AirCut", "CellChecks", "Clock", "FeedCommand", "Levels", "Recovery",
    "feed_override", "force_guard",
]  # fmt: skip
