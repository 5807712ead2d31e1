"""The turning lathe of ``grey_turning``: force, feed, depth of cut, voltage, as the paper's own interface shows them.

Figure 10a of the paper monitors force, spindle speed and depth of cut while the controller's parameters are set.
"""

from __future__ import annotations

from collections.abc import Mapping

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
    for_a_while,
    lasting,
    load_pulse,
    noise,
    to_value,
)

STEADY = ("steady, 1 %", "steady within 1.0 % of 150 N (the paper, section 5.1)")
OVERSHOOT = ("overshoot, 1.5 %", "overshoot of 1.5 % of 150 N (the paper, section 5.1)")


def _bands(about: str) -> tuple[Band, ...]:
    return Band(-1.5, 1.5, STEADY[0], about, STEADY[1]), Band(1.5, 2.25, OVERSHOOT[0], about, OVERSHOOT[1])


PLOTS = (
    Plot(
        "Cutting force",
        "N",
        (
            Trace("command", "command", "command"),
            Trace("actual.force", "force", "actual"),
            Trace("feedback", "filtered", "feedback"),
        ),
        _bands("command"),
    ),
    Plot(
        "Force error",
        "N",
        (
            Trace("true_error", "error of the force", "error"),
            Trace("error", "error as measured", "other"),
        ),
        (Band(-1.5, 1.5, STEADY[0], doc=STEADY[1]),),
    ),
    Plot("Feed rate", "mm/min", (Trace("actual.feed", "feed rate", "other"),)),
    Plot("Feed voltage", "V", (Trace("output", "voltage", "output"),)),
    Plot(
        "Depth of cut",
        "mm",
        (
            Trace("actual.depth", "depth without runout", "actual"),
            Trace("command.depth", "programmed depth", "command"),
        ),
    ),
    Plot("Chip thickness", "um", (Trace("actual.chip", "chip", "other"),)),
    Plot("Hard spot", "%", (Trace("disturbance", "specific force", "disturbance", 100.0),)),
)

READOUTS = (
    Readout("force", "actual.force", "N", decimals=1),
    Readout("set force", "command", "N", decimals=1),
    Readout("spindle", "plant.spindle_rpm", "1/min", decimals=0),
    Readout("depth of cut", "actual.depth", "mm", decimals=3),
    Readout("feed rate", "actual.feed", "mm/min", decimals=1),
    Readout("feed per rev", "actual.feed", "mm", decimals=4, per="plant.spindle_rpm"),
)


def _depth(told: bool) -> Disturbance:
    """A step of the depth of cut; ``told``: in the programme, so that a controller that reads it knows."""

    def act(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
        keys = ("plant.depth.start", "reference.depth.start") if told else ("plant.depth.start",)
        changes = {key: max(values[key] + fields["step"], 0.0) for key in keys if key in values}
        return for_a_while(changes, values, fields["for_s"])

    doc = (
        "The depth of cut steps, as in section 5.2. A controller that reads the programme gets it, but not ahead."
        if told
        else "The raw part is thicker or thinner than programmed: the depth of cut steps and no controller knows it."
    )
    step = Field("step", "step", "mm", -1.0, 1.0, -0.2 if told else 0.2, "added to the depth, down to 0")
    name, label = ("depth_step", "Depth step") if told else ("stock_step", "Thicker stock")
    return Disturbance(name, label, doc, (step, lasting(0.0 if told else 1.0)), act, ("plant.depth.start",))


def _material(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
    changes = {"plant.law.kf": fields["kf"], "plant.law.exponent": fields["exponent"]}
    return for_a_while(changes, values, fields["for_s"])


DISTURBANCES = (
    _depth(told=True),
    _depth(told=False),
    load_pulse(
        "%", 300.0, 50.0, "A hard spot in the work: the specific force is higher, or lower, for a while.",
        factor=0.01, label="Hard spot", least=-90.0,
    ),
    Disturbance(
        "material",
        "Other material",
        "The tool meets another material. S45C: 2256.3 and 0.77; iron: 1450 and 0.96 (section 2 of the paper).",
        (
            Field("kf", "specific force", "N/mm^(1+P)", 200.0, 6000.0, 1450.0, "main force at 1 mm of depth and chip"),
            Field("exponent", "exponent P", "1", 0.3, 1.0, 0.96, "how the force grows with the chip thickness"),
            lasting(0.0),
        ),
        _material,
        ("plant.law.kf", "plant.law.exponent"),
    ),
    to_value(
        "runout",
        "Runout",
        "The work runs out of true: the depth of cut changes once a revolution. It shows in the force; "
        "the depth that is drawn is that without it.",
        "plant.runout",
        Field("runout", "amplitude", "mm", 0.0, 0.5, 0.05, "amplitude of the change of the depth of cut"),
        lasts_s=2.0,
    ),
    to_value(
        "spindle_speed",
        "Spindle speed",
        "Another spindle speed: at the same feed rate the chip is thicker where the spindle is slower.",
        "plant.spindle_rpm",
        Field("rpm", "speed", "1/min", 200.0, 3000.0, 1000.0, "spindle speed; 1,200 1/min in the paper"),
        lasts_s=0.0,
    ),
    noise("sensor.noise_n", "N", 100.0, 8.0, "the load cell, before its filter"),
)  # fmt: skip


PROFILE = Profile(
    study="grey_turning",
    controller="corrected.gpfc_b_s6",
    scenario="fig6_fixed_depth",
    window_s=4.0,
    plots=PLOTS,
    readouts=READOUTS,
    disturbances=DISTURBANCES,
    notes=(
        "The cut goes on without end at its last depth; fig9_falling_depth stays at 0.4 mm after 6 s, where 150 N "
        "need 117 of the 150 mm/min that the feed can make. The spindle speed is a parameter (plant.spindle_rpm, "
        "1,200 1/min), no signal: this plant's spindle has no dynamics. The depth changes at once (plant.radial.gain "
        "= 0) but in the scenarios with a changing depth, where the slide follows in 0.25 s. Bands are in N at the "
        "paper's 150 N. A hard spot takes the place of the one that the scenario hard_spot brings. Controllers that "
        "read the programme and all sensors (ours.inversion, ours.constant_force, ...) need another reference and "
        "sensor: a switch to or from them takes a new start. sensor.keep changes how the force is filtered at once."
    ),
)
