"""Cuts under the force controllers that know the programme, for their tests and the table of exports."""

from leadscrew.controllers._force import depth_feed_forward, gain_normalised
from leadscrew.kernel.loop import Loop
from leadscrew.plants._turning import turning
from leadscrew.references._cutting_program import cutting_force, cutting_program
from leadscrew.sensors._load_cell import lathe_reading, load_cell
from leadscrew.studies.grey_turning.tunings import FORCE as TUNINGS
from leadscrew.studies.grey_turning.tunings import TUNINGS as GREY_FUZZY

RADIAL = 8.57
"""A radial axis that takes 0.25 s from 10 to 90 % of a step, 1/s."""
STAIRS = {"depth.step": -0.2, "depth.every_s": 1.5, "depth.steps": 2}


def cut(controller, radial=RADIAL, noise_n=2.0, stairs=STAIRS, **plant):
    """Falling depth at 150 N; a controller that takes numbers gets the force alone."""
    whole = getattr(controller.step, "takes_cut", False)
    sensor = lathe_reading if whole else load_cell
    return Loop(
        reference=cutting_program(**stairs) if whole else cutting_force,
        controller=controller,
        plant=turning(**({"radial.gain": radial} | stairs | plant)),
        sensor=sensor(noise_n=noise_n),
        period=0.02,
        substeps=20,
        metrics={},
    )


def fed_forward():
    """The TFC with depth feed-forward."""
    return cut(TUNINGS["ours.tfc_ff"](**{"radial.gain": RADIAL}))


def grey_normalised_fed_forward():
    """The GPFC with normalised gain, and depth feed-forward around both."""
    return cut(depth_feed_forward(gain_normalised(GREY_FUZZY["corrected.gpfc_b_stfc"])))


def normalised():
    """The TFC with normalised gain."""
    return cut(TUNINGS["ours.gain_normalised"])


def inverted():
    """Adaptive power-law inversion."""
    return cut(TUNINGS["ours.inversion"])


def all_in_one():
    """Everything in one controller."""
    return cut(TUNINGS["ours.constant_force"](**{"radial.gain": RADIAL}))
