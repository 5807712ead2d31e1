"""The ball-screw stage of ``fsmc_ballscrew``: position, error, torque, and what friction does meanwhile."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from leadscrew.operate.profile import (
    Band,
    Changes,
    Disturbance,
    Field,
    Plot,
    Profile,
    Readout,
    Trace,
    Values,
    axis_plots,
    load_pulse,
    moved_on,
    multiplied,
    noise,
    with_blocks,
    with_pulse,
)

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

PLOTS = (
    *axis_plots("table", Band(-1.0, 1.0, "1 um", doc="1 um: what our steps are judged by; no tolerance in the paper")),
    Plot(
        "Torque",
        "N m",
        (
            Trace("output", "motor torque", "output"),
            Trace("disturbance", "load torque", "disturbance"),
        ),
    ),
    Plot("Speed of the screw", "rad/s", (Trace("plant.speed", "speed", "other"),)),
    Plot(
        "Friction: bristle deflection",
        "urad",
        (Trace("plant.bristle", "bristles", "other"),),
    ),
)

READOUTS = (
    Readout("command", "command", "mm", decimals=3),
    Readout("table", "actual", "mm", decimals=4),
    Readout("following error", "true_error", "um", decimals=2, shows="peak"),
    Readout("torque", "output", "N m", decimals=3),
    Readout("screw speed", "plant.speed", "1/min", decimals=0),
)


def _go_to(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
    """A new move from where the old one is commanded to be now."""
    from leadscrew.references._quintic import QuinticParams, quintic

    here = {name: values[f"reference.{name}"] for name in QuinticParams._fields}
    initial = float(quintic(QuinticParams(**here), now_s).position)
    move = {"initial": initial, "distance": fields["target"] - initial, "start": now_s, "duration": fields["time"]}
    return [(0.0, {f"reference.{name}": value for name, value in move.items()})]


FRICTION = ("plant.friction.coulomb", "plant.friction.static")

DISTURBANCES = (
    Disturbance(
        "go_to",
        "Go to",
        "A new move, for this axis and for the one it is compared with; it begins at rest, so let the last one end.",
        (
            Field("target", "target", "mm", -50.0, 50.0, 0.0, "where to go"),
            Field("time", "in", "s", 0.0, 60.0, 0.05, "time of the move; 0 for a bare step"),
        ),
        _go_to,
        ("reference.distance", "reference.duration", "reference.start", "reference.initial"),
    ),
    moved_on(
        "reference.initial",
        "reference.start",
        Field("target", "target", "mm", -50.0, 50.0, 0.0, "where to go"),
        ("reference.rate",),
    ),
    load_pulse("N m", 20.0, 1.0, "A torque at the screw for a while, as a cutting force at the table makes it."),
    multiplied(
        "friction",
        "Change of friction",
        "Dry or freshly greased guides: Coulomb and static friction change together; the controller believes the old.",
        FRICTION,
        Field("factor", "times", "1", 0.2, 3.0, 1.5, "friction over what it was"),
    ),
    multiplied(
        "viscous",
        "Change of viscous friction",
        "Warm or cold grease: the part of friction that grows with speed.",
        ("plant.friction.viscous",),
        Field("factor", "times", "1", 0.0, 5.0, 3.0, "viscous friction over what it was"),
    ),
    multiplied(
        "inertia",
        "Change of inertia",
        "Another load on the table: 0.57 is the screw without any (Table 1).",
        ("plant.inertia",),
        Field("factor", "times", "1", 0.57, 4.0, 2.0, "inertia at the screw over what it was"),
    ),
    noise("sensor.noise_mm", "nm", 10000.0, 20.0, "the scale, before it is rounded to its resolution", factor=1e-6),
)


def operated(loop: Loop) -> Loop:
    """A torque pulse where nothing loads the screw, and noise in the scale; a loop in continuous time stays as it is.

    The adaptive integrator of such a loop chooses its steps by what the blocks give, and noise it cannot have.
    """
    from leadscrew.sensors._counts import noisy_ruler, ruler

    if loop.continuous:
        return loop
    found = loop.blocks["sensor"]
    if found is not None and found.step is ruler.step:
        loop = with_blocks(loop, sensor=noisy_ruler(resolution_mm=found.params.resolution_mm, noise_mm=0.0))
    return with_pulse(loop)


PROFILE = Profile(
    study="fsmc_ballscrew",
    controller="ours.fsmc_4khz",
    scenario="sine_fast",
    window_s=3.0,
    plots=PLOTS,
    readouts=READOUTS,
    disturbances=DISTURBANCES,
    operated=operated,
    circle=True,
    notes=(
        "The sines have no end. A step, and the creep at its 500 mm, stay where they end; bare and quintic steps go on "
        "with Go to, filtered ones with Move to. reference.frequency and reference.amplitude of a sine change where "
        "the command is at once: a jump, unless changed where the sine crosses 0. The paper.* and corrected.* "
        "controllers run in continuous time: no load pulse, no noise, and no switch to a sampled controller, because "
        "their loop has another plant. The start in motion is part of the scenario. No tolerance in the paper."
    ),
)
