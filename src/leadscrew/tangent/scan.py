"""A simulated cut as files: with all that the simulation knows, or as a scanner gives it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from leadscrew.paths.curve import Array
from leadscrew.tangent.machine import Cut
from leadscrew.tangent.stroke import Stroke


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
