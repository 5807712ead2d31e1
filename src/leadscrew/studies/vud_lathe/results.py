"""What the study runs once, for claims and pictures alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from leadscrew.analysis.positioning import Positioning
from leadscrew.studies.vud_lathe.accuracy import Errors
from leadscrew.studies.vud_lathe.claims_accuracy import accuracy_errors
from leadscrew.studies.vud_lathe.original import OriginalResults, original_results
from leadscrew.studies.vud_lathe.positioning_test import positioning_tests
from leadscrew.studies.vud_lathe.runs import Loops, simulate, sweep_gain
from leadscrew.studies.vud_lathe.tables import Move, moves


class Results(NamedTuple):
    """Loops that keep their runs, and what was made of them."""

    loops: Loops
    moves: Mapping[str, Move]
    runs: Mapping[str, Any]
    """By ``scenario/controller``."""
    sweep: Any
    """The batch of A+ over the speeds at full duty."""
    original: OriginalResults
    errors: Errors
    """Of sensor and controller, two by two."""
    positioning: Mapping[str, Positioning]


def results(progress: Callable[[str, float], None]) -> Results:
    """Everything, in the order in which it is cheapest."""
    loops, found = Loops(), moves()
    runs = simulate(lambda what, done: progress(what, 0.4 * done), loops)
    sweep = sweep_gain("corrected.vud_beta_e", "fig11b_step_m170", loops)
    progress("fits of the old servo", 0.5)
    original = original_results(loops, found)
    progress("sensor and controller, two by two", 0.6)
    errors = accuracy_errors(loops)
    progress("positioning test", 0.9)
    return Results(loops, found, runs, sweep, original, errors, positioning_tests(loops))
