"""Protection of a cut: a guard on the force and the load cell around a force controller, and its feed override."""

from leadscrew.controllers.guard.feed_override import FeedCommand, feed_override
from leadscrew.controllers.guard.force_guard import Clock, force_guard
from leadscrew.controllers.guard.holding import HOLDING, RUNNING, TRIPPED, AirCut, Recovery
from leadscrew.controllers.guard.watching import CAUSES, CellChecks, Levels

__all__ = [
    "CAUSES", "HOLDING", "RUNNING", "TRIPPED", "AirCut", "CellChecks", "Clock", "FeedCommand", "Levels", "Recovery",
    "feed_override", "force_guard",
]  # fmt: skip
