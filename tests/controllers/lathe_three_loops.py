"""The whole lathe under its three loops, for tests: falling depth, the spindle running."""

from leadscrew.actuators._dac import lathe_dac
from leadscrew.controllers._lathe_loops import lathe_loops
from leadscrew.kernel.loop import Loop
from leadscrew.plants._turning_lathe import turning_lathe
from leadscrew.references._lathe_program import lathe_program
from leadscrew.sensors._lathe_sensors import lathe_sensors
from leadscrew.studies.grey_turning.tunings import TUNINGS

FALLING = {"depth.step": -0.2, "depth.steps": 3}
IDEAL = {"spindle.bits": 0, "feed.bits": 0, "radial.bits": 0}


def three(feed="corrected.gpfc_b_s9", law="gpfc", volts=8.0, **more):
    """The fuzzy loops; the spindle's voltage that of 1,200 1/min."""
    force = TUNINGS[feed] if isinstance(feed, str) else feed
    return lathe_loops(
        TUNINGS[f"ours.spindle_{law}"].starting(output=volts), force, TUNINGS[f"ours.depth_{law}"], **more
    )


def lathe(controller=None, program=FALLING, bits=IDEAL, noise_n=2.0, **plant):
    return Loop(
        reference=lathe_program(**program),
        controller=controller or three(),
        plant=turning_lathe(**plant),
        sensor=lathe_sensors(**{"cell.noise_n": noise_n}),
        actuator=lathe_dac(**bits),
        period=0.02,
        substeps=20,
        metrics={},
        name="the lathe",
    )


def falling():
    """Depth falling by 0.2 mm every 2 s; for exports, whose bumpless start takes one output."""
    return lathe(three(bumpless=False))
