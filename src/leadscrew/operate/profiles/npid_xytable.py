"""The milling table of ``npid_xytable``: position, error in um, voltage, and the forces of the cut."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from leadscrew.kernel.block import Block
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
    for_a_while,
    lasting,
    load_pulse,
    multiplied,
    noise,
    to_value,
    with_blocks,
)  # fmt: skip

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

TWO_PI = 2.0 * math.pi

PLOTS = (
    *axis_plots(
        "table",
        Band(
            -3.0,
            3.0,
            "e_max, 3 um",
            doc="3 um: e_max of corrected.npid_um, where the gain of (2) stops to grow; no tolerance in the paper, "
            "and the line stays where it is under other controllers and another e_max",
        ),
    ),
    Plot("Drive voltage", "V", (Trace("output", "voltage", "output"),)),
    Plot(
        "Cutting force, as a voltage at the input",
        "mV",
        (Trace("disturbance", "lines of Table II and pulses", "disturbance", 1000.0),),
    ),
    Plot("Speed of the table", "mm/s", (Trace("plant.velocity", "speed", "other"),)),
)

READOUTS = (
    Readout("command", "command", "mm", decimals=3),
    Readout("table", "actual", "mm", decimals=4),
    Readout("following error", "true_error", "um", decimals=2, shows="peak"),
    Readout("voltage", "output", "V", decimals=3),
    Readout("spindle", "plant.spindle_hz", "1/min", decimals=0),
    Readout("speed", "plant.velocity", "mm/s", decimals=2),
)

LINES = ("plant.spindle_v", "plant.tooth_v")


def _cutting(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
    """All forces of the cut at once: the five lines, and where the plant has a spindle its two."""
    by = fields["factor"]
    changes = {"disturbance.force": by * values["disturbance.force"]}
    changes |= {key: by * values[key] for key in LINES if key in values}
    return for_a_while(changes, values, fields["for_s"])


def _spindle(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
    """Another speed from now on; the phases are such that spindle and teeth go on from the angle where they are."""
    hz = fields["rpm"] / 60.0
    turned = TWO_PI * (values["plant.spindle_hz"] - hz) * now_s
    phase = math.remainder(values["plant.spindle_phase"] + turned, TWO_PI)
    tooth = math.remainder(values["plant.tooth_phase"] + values["plant.teeth"] * turned, TWO_PI)
    return [(0.0, {"plant.spindle_hz": hz, "plant.spindle_phase": phase, "plant.tooth_phase": tooth})]


DISTURBANCES = (
    Disturbance(
        "cutting_force",
        "Cutting force",
        "A deeper or a lighter cut: the lines of Table II, of the spindle and of its teeth all change together.",
        (Field("factor", "times", "1", 0.0, 10.0, 3.0, "forces over what they were; 0: out of the cut"), lasting(4.0)),
        _cutting,
        ("disturbance.force",),
    ),
    load_pulse(
        "mV", 500.0, 5.0, "A push at the table for a while, as a voltage at the drive's input.",
        at="disturbance.pulse", factor=1e-3,
    ),
    Disturbance(
        "spindle_speed",
        "Spindle speed",
        "Another speed of the spindle: its line and that of the teeth move; the five lines of Table II stay.",
        (Field("rpm", "speed", "1/min", 0.0, 30000.0, 2000.0, "spindle speed; Table II: 1,000, 2,000, 3,000 1/min"),),
        _spindle,
        ("plant.spindle_hz", "plant.spindle_phase", "plant.tooth_phase", "plant.teeth"),
    ),
    multiplied(
        "drive_gain",
        "Gain of the drive",
        "The drive answers more strongly than equation (1) says: what is left of the margin of the loop.",
        ("plant.gain",),
        Field("factor", "times", "1", 0.3, 2.0, 1.2, "gain of the drive over what it was; forces stay"),
        lasts_s=1.0,
    ),
    to_value(
        "friction",
        "Change of friction",
        "Other friction in the guides, on the machines that have any.",
        "plant.friction_mv",
        Field("friction", "friction", "mV", 0.0, 500.0, 150.0, "friction in fast sliding; 2.6, 20, 150 mV are ours"),
        lasts_s=4.0,
    ),
    to_value(
        "go_to",
        "Go to",
        "A step of the command, for this axis and for the one it is compared with.",
        "reference.target",
        Field("target", "target", "um", -1e4, 1e4, 0.0, "where to go"),
        factor=1e-3,
    ),
    noise("sensor.noise_mm", "um", 20.0, 0.5, "the encoder, before it is rounded where it is", factor=1e-3),
)  # fmt: skip


def operated(loop: Loop) -> Loop:
    """A pulse and a common factor in the load's place, and noise where the position is read without a sensor."""
    from leadscrew.disturbances._five_sines import five_sines
    from leadscrew.disturbances._five_sines_pulse import five_sines_pulse
    from leadscrew.sensors._counts import noisy_position

    blocks: dict[str, Block] = {}
    found = loop.blocks["disturbance"]
    if found is not None and found.step is five_sines.step:
        lines = found.params._asdict()
        blocks["disturbance"] = five_sines_pulse(
            **{f"{place}.{part}": x for place, line in lines.items() for part, x in line._asdict().items()}
        )
    if loop.blocks["sensor"] is None:
        blocks["sensor"] = noisy_position
    return with_blocks(loop, **blocks)


PROFILE = Profile(
    study="npid_xytable",
    controller="corrected.npid_um",
    scenario="spindle_1000",
    window_s=3.0,
    plots=PLOTS,
    readouts=READOUTS,
    disturbances=DISTURBANCES,
    operated=operated,
    notes=(
        "The sine of 0.7 Hz under cutting has no end; it grows to its full size within the first second. The steps and "
        "the constant load stay as they end. The cutting force drawn is the five lines and the pulse; the lines of "
        "spindle and teeth act inside the plant, exactly, and have no signal. reference.frequency changes where the "
        "sine is at once: a jump. plant.dead_time_s can change up to four periods; scenario.column and "
        "scenario.encoder_um take a new start. Controllers that take a motion (feed-forward) need another reference: "
        "a switch to or from them takes a new start. The paper gives no tolerance."
    ),
)
