"""The state of a controller with another output: one function for each that the wrappers know.

A controller that adds to its output keeps it in the field ``output`` of its state. A wrapper that sets it needs the
state built anew, field by field, as compiled steps do. A controller of one's own says how in an attribute of its step:
``my_controller.step.with_output = my_function``, a function of the state and the new output.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from leadscrew.controllers._force.power_law_inversion import PowerLawInversionState
from leadscrew.controllers._grey_fuzzy.gpfc import GpfcState
from leadscrew.controllers._grey_fuzzy.pi_incremental import PiIncrementalState
from leadscrew.controllers._grey_fuzzy.tfc import TfcState


def of_tfc(s, output):
    """The TFC's."""
    return TfcState(s.error, s.change, output, s.started)


def of_gpfc(s, output):
    """The GPFC's."""
    return GpfcState(s.window, s.prediction, s.error, s.change, output, s.started)


def of_pi(s, output):
    """The incremental PI's."""
    return PiIncrementalState(s.error, output, s.started)


def of_inversion(s, output):
    """The adaptive inversion's."""
    return PowerLawInversionState(s.turns, s.feed, s.k, s.variance, output, s.held)


WITH_OUTPUT: dict[type, Callable[..., Any]] = {
    TfcState: of_tfc,
    GpfcState: of_gpfc,
    PiIncrementalState: of_pi,
    PowerLawInversionState: of_inversion,
}
"""By the type of the state."""
