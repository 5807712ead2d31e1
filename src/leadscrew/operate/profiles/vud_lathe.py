"""The lathe axis of ``vud_lathe``: where it is, what is left in um, the duty, and how far the universes contract."""

from __future__ import annotations

from typing import TYPE_CHECKING

from leadscrew.kernel.block import Block
from leadscrew.operate.profile import (
    Band,
    Field,
    Plot,
    Profile,
    Readout,
    Trace,
    axis_plots,
    load_pulse,
    moved_on,
    multiplied,
    noise,
    to_value,
    with_blocks,
    with_pulse,
)

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

PLOTS = (
    *axis_plots("slide", Band(-2.0, 2.0, "2 um", doc="2 um after 2 s (the paper, Figure 12)")),
    Plot(
        "Duty",
        "1",
        (
            Trace("output", "duty asked for", "output"),
            Trace("applied", "duty applied", "other"),
            Trace("disturbance", "duty added by a load", "disturbance"),
        ),
    ),
    Plot("Speed of the slide", "mm/s", (Trace("plant.speed", "speed", "other"),)),
    Plot(
        "Contraction of the universes",
        "1",
        (
            Trace("controller.alpha_e", "error", "other"),
            Trace("controller.alpha_ec", "its change", "other"),
            Trace("controller.beta", "output", "other"),
        ),
    ),
)

READOUTS = (
    Readout("target", "command", "mm", decimals=3),
    Readout("slide", "actual.position", "mm", decimals=4),
    Readout("following error", "true_error", "um", decimals=1, shows="peak"),
    Readout("duty", "output", "%", decimals=1),
    Readout("speed", "plant.speed", "mm/s", decimals=2),
)


DISTURBANCES = (
    to_value(
        "go_to",
        "Go to",
        "A step of the command to another target, for this axis and for the one it is compared with.",
        "reference.target",
        Field("target", "target", "mm", -190.0, 190.0, -170.0, "where to go; Table 1 goes 190 mm each way"),
    ),
    moved_on(
        "reference.start",
        "reference.start_time",
        Field("target", "target", "mm", -190.0, 190.0, 0.0, "where to go; Table 1 goes 190 mm each way"),
    ),
    load_pulse("1", 1.0, 0.1, "A cut pulls at the slide: a duty that is added to the controller's for a while."),
    multiplied(
        "speed_loss",
        "Loss of speed",
        "The drive makes less speed from the same duty: low supply, heavy cut, cold grease.",
        ("plant.full_duty_speed_mm_s",),
        Field("loss", "loss", "%", 0.0, 90.0, 20.0, "share of the speed at full duty that is lost"),
        times=lambda loss: 1.0 - loss / 100.0,
    ),
    to_value(
        "stiction",
        "Stiction",
        "Small duties do nothing any more: friction of screw and brushes. No controller here has integral action.",
        "actuator.threshold",
        Field("threshold", "threshold", "1", 0.0, 0.2, 0.01, "smallest duty that still moves the slide"),
        lasts_s=4.0,
    ),
    noise("sensor.noise_mm", "um", 100.0, 2.0, "the ruler, before it is rounded to counts", factor=1e-3),
)


def operated(loop: Loop) -> Loop:
    """A pulse of duty where nothing loads the axis, noise before the counter, stiction where nothing limits it."""
    from leadscrew.actuators._stiction import stiction
    from leadscrew.sensors._counts import encoder_count, grating_count, noisy_encoder, noisy_grating

    blocks: dict[str, Block] = {}
    found = loop.blocks["sensor"]
    for plain, noisy in ((grating_count, noisy_grating), (encoder_count, noisy_encoder)):
        if found is not None and found.step is plain.step:
            blocks["sensor"] = noisy(resolution_mm=found.params.resolution_mm)
    if loop.blocks["actuator"] is None:
        blocks["actuator"] = stiction
    return with_pulse(with_blocks(loop, **blocks))


PROFILE = Profile(
    study="vud_lathe",
    controller="corrected.vud_beta_e",
    scenario="fig11a_step_m50",
    window_s=4.0,
    plots=PLOTS,
    readouts=READOUTS,
    disturbances=DISTURBANCES,
    operated=operated,
    notes=(
        "The command steps at 0 s and then stays: the run goes on without end at the target. Another move: Go to, or "
        "reference.target. The scenario sequence makes six moves in 18 s and stays at the last; trapezoid and S-curve "
        "moves end at their target and go on with Move to. Controllers of the original servo (ours.original_*) read "
        "the encoder, all others the ruler: a switch between the two takes a new start."
    ),
)
