"""A loop of the controller that learns its friction, to be exported and drawn."""

from leadscrew.controllers._pd_learned import pd_learned
from tests.controllers.stage_loop import stage_loop


def learned():
    """The paper's fastest sine in rad, at 4 kHz with the scale's 10 nm."""
    return stage_loop(pd_learned, "fast", encoder_mm=1e-5)
