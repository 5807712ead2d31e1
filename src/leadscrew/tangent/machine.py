"""A simulated cutter: runs strokes of a program through the process of the study, and gives the cut line as files.

The blade goes along a stroke at the programmed feed, sampled every 10 ms; the block
:func:`~leadscrew.plants.flexible_cut` makes the deviation ``e`` of the cut's tangent of heading, curvature
and offset. The texture of the material is an Ornstein-Uhlenbeck process in arc length, as in
:obj:`leadscrew.disturbances.cut_load`, of a stream of its own for each stroke. The material is at rest when the knife
plunges, and the axis has its angle.

The cut line is the curve with the tangent ``phi + e``: each step of the programmed line, turned by the mean of ``e``
over it, set one behind the other from where the knife plunged.

Source: process and values are the reconstruction of the study ``sofnn_tangent``; no material here was measured.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.paths.curve import Array
from leadscrew.tangent.settings import Settings
from leadscrew.tangent.stroke import Stroke
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.plants._flexible_cut import Material


PERIOD_S = 0.01
TEXTURE_DEG = 0.25
TEXTURE_MM = 3.0
"""Size and correlation length of the texture: those of the study."""
MOST_SAMPLES = 5_000_000
NEWS = 2000
"""Samples between two words on how far the work is."""


class Cut(NamedTuple):
    """What was cut in a stroke."""

    travel: Array
    """Of the blade, mm."""
    x: Array
    """Of the cut line, mm."""
    y: Array
    heading: Array
    """Tangent of the cut line, deg."""
    error: Array
    """Tangent of the cut less that of the programme, deg."""
    offset: Array
    """Of the axis, as sent, deg."""
    distance: Array
    """Of the cut from where the blade was programmed, mm."""
    seconds: float


def material_of(name: str) -> Material:
    """A material by name.

    Raises:
        ValueRefused: an unknown one.
    """
    from leadscrew.plants._flexible_cut import MATERIALS

    if name not in MATERIALS:
        raise ValueRefused(f"material {name!r}: expected {', '.join(MATERIALS)}")
    return MATERIALS[name]


def cut(
    strokes: Sequence[Stroke],
    settings: Settings,
    material: str = "fabric",
    seed: int | None = 1,
    progress: Callable[[float], None] = lambda done: None,
) -> list[Cut]:
    """The lines that these strokes cut; ``seed=None``: a material without texture."""
    stuff = material_of(material)
    clocks = [_clock(stroke, settings) for stroke in strokes]
    total = sum(times[-1] for _, times in clocks)
    if total / PERIOD_S > MOST_SAMPLES:
        raise ValueRefused(f"the program cuts for {total:.0f} s: at most {MOST_SAMPLES * PERIOD_S:.0f} s are simulated")
    found, gone = [], 0.0
    for k, (stroke, (places, times)) in enumerate(zip(strokes, clocks, strict=True)):
        draw = None if seed is None else np.random.default_rng([seed, k])
        before, share = gone / total, times[-1] / total
        report = partial(_part, progress, before, share)
        found.append(_cut(stroke, places, times, stuff, draw, report))
        gone += times[-1]
    return found


def _part(progress: Callable[[float], None], before: float, share: float, done: float) -> None:
    progress(before + share * done)


def _clock(stroke: Stroke, settings: Settings) -> tuple[Array, Array]:
    """Arc lengths of the ends of the moves, and when the blade is there."""
    if stroke.feeds is not None:
        places, feeds = stroke.feeds
        return places, np.concatenate(([0.0], np.cumsum(60.0 * np.diff(places) / feeds[:-1])))
    from leadscrew.tangent.moves import moves_of

    moves = moves_of(stroke, settings)
    places = np.array([0.0, *(m.last for m in moves)])
    return places, np.concatenate(([0.0], np.cumsum([60.0 * m.length / m.feed for m in moves])))


def _cut(
    stroke: Stroke,
    places: Array,
    times: Array,
    material: Material,
    draw: np.random.Generator | None,
    progress: Callable[[float], None],
) -> Cut:
    from leadscrew.disturbances._cut_load import CutLoad
    from leadscrew.plants._flexible_cut import FlexibleCutState, flexible_cut

    count = max(math.ceil(times[-1] / PERIOD_S - 1e-9), 1)
    travel = np.interp(np.append(np.arange(count) * PERIOD_S, times[-1]), times, places)
    line = stroke.at(travel)
    offset = stroke.offset(travel)
    way = np.append(np.diff(travel), travel[-1] - travel[-2])
    texture = np.zeros(count + 1)
    if draw is not None:
        keep = np.exp(-way / TEXTURE_MM)
        pushes = TEXTURE_DEG * np.sqrt(1.0 - keep**2) * draw.standard_normal(count + 1)
        value = TEXTURE_DEG * float(draw.standard_normal())
        for k in range(count + 1):
            value = keep[k] * value + pushes[k]
            texture[k] = value
    state = FlexibleCutState(offset=float(offset[0]))
    params = flexible_cut.params._replace(material=material)
    step = flexible_cut.step
    error = np.empty(count + 1)
    rows = zip(line.heading.tolist(), line.curvature.tolist(), texture.tolist(), travel.tolist(), strict=True)
    for k, ((heading, curvature, rough, s), u, ds) in enumerate(zip(rows, offset.tolist(), way.tolist(), strict=True)):
        feed = max(ds, 1e-9) / PERIOD_S
        state = step(params._replace(feed=feed), state, u, CutLoad(heading, curvature, rough, 0.0, s), PERIOD_S)
        error[k] = state.deviation
        if k % NEWS == 0:
            progress(k / count)
    dx, dy = np.diff(line.x), np.diff(line.y)
    turn = np.radians(0.5 * (error[1:] + error[:-1]))
    x = line.x[0] + np.concatenate(([0.0], np.cumsum(dx * np.cos(turn) - dy * np.sin(turn))))
    y = line.y[0] + np.concatenate(([0.0], np.cumsum(dx * np.sin(turn) + dy * np.cos(turn))))
    away = np.hypot(x - line.x, y - line.y)
    return Cut(travel, x, y, line.heading + error, error, offset, away, float(times[-1]))


def rms(cuts: Sequence[Cut]) -> float:
    """Root mean square of the deviation, over the length of all strokes, deg."""
    whole = sum(float(c.travel[-1]) for c in cuts)
    power = sum(float(np.trapezoid(c.error**2, c.travel)) for c in cuts)
    return math.sqrt(power / whole)


class Scan(NamedTuple):
    """How a piece is scanned."""

    noise: float = 0.0
    """Standard deviation of a point, mm."""
    dx: float = 0.0
    """How far the piece lies from its place, mm, after the turn."""
    dy: float = 0.0
    turn_deg: float = 0.0
    """How far it is turned about the origin, counter-clockwise."""
    seed: int = 1

    def of(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Where points are, without noise."""
        c, s = math.cos(math.radians(self.turn_deg)), math.sin(math.radians(self.turn_deg))
        return c * x - s * y + self.dx, s * x + c * y + self.dy


def cut_csv(cuts: Sequence[Cut]) -> str:
    """The cut line with its errors, a row every 10 ms."""
    lines = ["stroke,travel_mm,x_mm,y_mm,error_deg,offset_deg"]
    for k, c in enumerate(cuts, start=1):
        rows = zip(c.travel, c.x, c.y, c.error, c.offset, strict=True)
        lines += [f"{k},{s:.4f},{x:.4f},{y:.4f},{e:.4f},{d:.4f}" for s, x, y, e, d in rows]
    return "\n".join(lines) + "\n"


def scan_csv(cuts: Sequence[Cut], scan: Scan) -> str:
    """Points of the cut line as a scanner gives them."""
    lines = ["stroke,x_mm,y_mm"]
    for k, (x, y) in enumerate(scanned(cuts, scan), start=1):
        lines += [f"{k},{a:.4f},{b:.4f}" for a, b in zip(x, y, strict=True)]
    return "\n".join(lines) + "\n"


def scanned(cuts: Sequence[Cut], scan: Scan) -> list[tuple[Array, Array]]:
    """The points of each stroke, mm."""
    found = []
    for k, c in enumerate(cuts):
        draw = np.random.default_rng([scan.seed, k, 77])
        x, y = scan.of(c.x, c.y)
        found.append((x + scan.noise * draw.standard_normal(x.size), y + scan.noise * draw.standard_normal(y.size)))
    return found


def marks_of(
    strokes: Sequence[Stroke], scan: Scan, pricked: Sequence[tuple[float, float]] = ()
) -> list[tuple[float, float, float, float]]:
    """Marks, or else two corners of the frame around all lines: programmed and scanned X, Y."""
    at = [s.at(s.grid(1.0)) for s in strokes]
    x, y = np.concatenate([p.x for p in at]), np.concatenate([p.y for p in at])
    frame = np.array([[x.min(), y.min()], [x.max(), y.max()]]).round(1)
    places = np.array(pricked) if pricked else frame
    u, v = scan.of(places[:, 0], places[:, 1])
    draw = np.random.default_rng([scan.seed, 78])
    noise = scan.noise * draw.standard_normal((2, len(places)))
    rows = zip(places, u + noise[0], v + noise[1], strict=True)
    return [(float(p[0]), float(p[1]), float(a), float(b)) for p, a, b in rows]
