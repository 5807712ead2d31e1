"""The tangential knife of ``sofnn_tangent``: deviation of the cut in degrees and mm, offset, line, material."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from leadscrew.operate.profile import (
    NEVER_S,
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
    noise,
    to_value,
)
from leadscrew.plants._flexible_cut import MATERIALS

SETTLED = "0.25 deg: when our steps count as settled; no tolerance in the paper"

PLOTS = (
    Plot(
        "Deviation of the cut",
        "deg",
        (
            Trace("actual.deviation", "cut less line", "actual"),
            Trace("feedback", "camera", "feedback"),
            Trace("command", "command", "command"),
        ),
        (Band(-0.25, 0.25, "0.25 deg", doc=SETTLED),),
    ),
    Plot(
        "Error",
        "deg",
        (Trace("true_error", "command less deviation", "error"),),
        (Band(-0.25, 0.25, "0.25 deg", doc=SETTLED),),
    ),
    Plot(
        "Offset of the blade",
        "deg",
        (
            Trace("output", "offset asked for", "output"),
            Trace("plant.offset", "offset of the axis", "other"),
        ),
        (Band(-15.0, 15.0, "largest, 15 deg", doc="largest offset of the blade, 15 deg"),),
    ),
    Plot(
        "Lateral deviation of the cut",
        "mm",
        (Trace("actual.lateral", "to the left of the line", "other"),),
    ),
    Plot(
        "Heading",
        "deg",
        (
            Trace("disturbance.heading", "programmed line", "command"),
            Trace("actual.angle", "cut", "actual"),
        ),
    ),
    Plot("Curvature of the line", "1/m", (Trace("disturbance.curvature", "curvature", "other"),)),
    Plot(
        "Material",
        "deg",
        (
            Trace("plant.shear", "shear of the material", "other"),
            Trace("disturbance.texture", "texture and steps", "disturbance"),
            Trace("disturbance.push", "push of the cut", "disturbance"),
        ),
    ),
)

READOUTS = (
    Readout("heading", "disturbance.heading", "deg", decimals=1),
    Readout("cut", "actual.angle", "deg", decimals=1),
    Readout("deviation", "actual.deviation", "deg", decimals=2, shows="peak"),
    Readout("lateral", "actual.lateral", "mm", decimals=3, shows="peak"),
    Readout("offset", "plant.offset", "deg", decimals=2),
    Readout("way", "actual.travel", "mm", decimals=0),
)

SHEAR = ("disturbance.step", "disturbance.push", "disturbance.step_at", "disturbance.step_for")


def _pushed(moved: str, other: str) -> Callable[[Mapping[str, float], float, Values], Changes]:
    """A pulse of one of the two that the load's block times together."""

    def act(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
        seconds = fields["for_s"] or NEVER_S
        return [
            (0.0, {moved: fields["size"], other: 0.0, "disturbance.step_at": now_s, "disturbance.step_for": seconds})
        ]

    return act


def _lost(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
    return [(0.0, {"sensor.lost_from_s": now_s, "sensor.lost_for_s": fields["for_s"] or NEVER_S})]


def _to(material: str) -> Disturbance:
    """The rest of the line in another material, whatever lay ahead."""
    changes = {
        f"plant.{slot}.{name}": value
        for slot in ("material", "changed")
        for name, value in MATERIALS[material]._asdict().items()
    }

    def act(fields: Mapping[str, float], now_s: float, values: Values) -> Changes:
        return for_a_while(dict(changes), values, fields["for_s"])

    doc = f"The blade comes into {material}: shear, its lag, the fibres and the gain of the blade change at once."
    return Disturbance(f"to_{material}", f"Into {material}", doc, (lasting(0.0),), act, tuple(changes))


def _size(most: float, value: float, doc: str) -> Field:
    return Field("size", "size", "deg", -most, most, value, doc)


DISTURBANCES = (
    _to("foam"),
    _to("leather"),
    _to("fabric"),
    Disturbance(
        "load_pulse",
        "Step of the shear",
        "The steady shear of the material changes for a while; the cut follows with the lag of the material.",
        (_size(14.0, -5.0, "change of the steady shear; the scenario step has -5 deg"), lasting(1.0)),
        _pushed("disturbance.step", "disturbance.push"),
        SHEAR,
    ),
    Disturbance(
        "push",
        "Push of the cut",
        "The cut itself is turned, at once, as by a slip of the cloth; it ends a step of the shear.",
        (_size(14.0, 3.0, "turn of the cut"), lasting(0.3)),
        _pushed("disturbance.push", "disturbance.step"),
        SHEAR,
    ),
    to_value(
        "texture",
        "Texture",
        "A coarser or smoother material: how much its steady shear varies along the line.",
        "disturbance.size",
        Field("size", "deviation", "deg", 0.0, 5.0, 1.0, "standard deviation of the texture; 0.25 deg is ours"),
        lasts_s=4.0,
    ),
    to_value(
        "camera_zero",
        "Zero of the camera",
        "The camera is knocked: it reads the deviation with an offset that no controller can see.",
        "sensor.zero_deg",
        Field("zero", "zero", "deg", -10.0, 10.0, 1.0, "error of the camera's zero"),
        lasts_s=0.0,
    ),
    Disturbance(
        "camera_lost",
        "Cut not seen",
        "The camera loses the cut: the last reading is held, and only controllers with an input for it know it.",
        (lasting(0.5),),
        _lost,
        ("sensor.lost_from_s", "sensor.lost_for_s"),
    ),
    noise("sensor.noise_deg", "deg", 5.0, 0.5, "the camera"),
)


PROFILE = Profile(
    study="sofnn_tangent",
    controller="ours.sofnn_tuned",
    scenario="flower_laps",
    window_s=8.0,
    plots=PLOTS,
    readouts=READOUTS,
    disturbances=DISTURBANCES,
    notes=(
        "flower_laps goes round without end, 7.9 s a lap, and the heading grows by 360 deg a lap; straight and step go "
        "straight on without end. The other lines end after 8 to 15 s: then the last heading and curvature are held. "
        "The feed cannot change in the run: the line is sampled at it, and the way is the number of the sample times "
        "the feed, so *.feed would move the blade along the line by a jump; take a new start. sensor.trailing_s shows "
        "readings of another delay at once. Step of the shear and push share one clock: one of them at a time, and "
        "either takes the place of the scenario's own step. Controllers that are given the line and those that only "
        "get the angle have another reference and sensor: a switch between them takes a new start. No tolerance in "
        "the paper; 0.25 deg is what our step responses are judged by."
    ),
)
