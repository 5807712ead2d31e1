"""A turn around the circle, and the circular test that one or two turns make. Lengths in mm, results in um.

The least-squares circle through points: the sum of squared distances to the circle is least.

    minimise  sum w_i (d_i - r)^2,   d_i = sqrt((x_i - x_c)^2 + (y_i - y_c)^2)

Start: the algebraic circle of Kasa, linear in ``x_c``, ``y_c`` and ``r^2 - x_c^2 - y_c^2``; then Gauss-Newton with the
exact Jacobian ``(-(x - x_c)/d, -(y - y_c)/d, -1)``. Near the solution it converges in 2 to 4 steps, because the
residuals of a circular test are parts per million of the radius.

``w_i`` is the part of the turn that a point stands for, half the angle between its neighbours: where a recording has
many points, on a ramp or at rest, they count no more than elsewhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.util.errors import DataError, ValueRefused

Floats = NDArray[np.float64]
TURN = 2.0 * math.pi
FEWEST = 36
"""Points a turn: one every 10 degrees still shows squareness and scale, and hardly a reversal."""
USUAL = 1800
"""Points a turn of this workbench: one every 0.2 degree."""
FARTHEST = 0.1
"""Part of the radius by which the measured circle may differ from the nominal one in size and place."""

OPEN_UM = 0.01
"""A path that ends farther from its start than this has not settled."""

SHORTEST = math.radians(355.0)
"""What counts as a full turn, with a note where it is less than 360 degrees."""

ALIKE = 1e-3
"""Difference of the parts of a turn below which points count alike."""

CCW, CW = "ccw", "cw"
SOURCES = {
    "path": "the true path",
    "encoder": "encoder signals: what the control sees, not the path of the tool",
    "bar": "what a double ball bar would read of the true path",
    "measured": "a measured file",
}
"""What a circle was made of, in the words of a report."""


@dataclass(frozen=True)
class Turn:
    """One turn in the order in which it was run, in mm from the set-up centre (the nominal centre).

    Raises:
        DataError: too few points, a value that is not finite, less than a full turn, or a turn the other way round
            than ``direction`` says.
    """

    direction: str
    """``ccw`` or ``cw``, as seen with x to the right and y up."""
    x_mm: Floats
    y_mm: Floats
    even: bool = True
    """Taken at even angles of the command, as in a simulation: all points count alike."""

    def __post_init__(self) -> None:
        name = self.direction
        if name not in (CCW, CW):
            raise ValueRefused(f"direction = {name!r}: expected ccw or cw")
        for axis in ("x_mm", "y_mm"):
            object.__setattr__(self, axis, np.asarray(getattr(self, axis), dtype=np.float64))
        if self.x_mm.ndim != 1 or self.x_mm.shape != self.y_mm.shape:
            raise DataError(f"direction {name}: x and y have the shapes {self.x_mm.shape} and {self.y_mm.shape}")
        if self.x_mm.size < FEWEST:
            raise DataError(
                f"direction {name}: {self.x_mm.size} points; a circle needs at least {FEWEST} a turn, and {USUAL} are "
                "usual"
            )
        bad = np.flatnonzero(~(np.isfinite(self.x_mm) & np.isfinite(self.y_mm)))
        if bad.size:
            raise DataError(f"direction {name}: point {bad[0] + 1} is not finite")
        covered = self.sweep
        if covered * self.sign < 0:
            other = CW if name == CCW else CCW
            raise DataError(
                f"direction {name}: the points run {other}, {abs(math.degrees(covered)):.1f} degrees; are the axes x "
                "and y swapped?"
            )
        if abs(covered) * (1.0 + 2.5 / (self.x_mm.size - 1)) < SHORTEST:
            raise DataError(
                f"direction {name}: the points cover {abs(math.degrees(covered)):.1f} degrees; expected a full turn of "
                "360"
            )

    @property
    def sign(self) -> int:
        """1 counter-clockwise, -1 clockwise."""
        return 1 if self.direction == CCW else -1

    @cached_property
    def angle(self) -> Floats:
        """Angle of each point about the set-up centre, from +x towards +y, without jumps, rad."""
        return np.asarray(np.unwrap(np.arctan2(self.y_mm, self.x_mm)))

    @property
    def sweep(self) -> float:
        """From the first point to the last, rad, positive counter-clockwise."""
        return float(self.angle[-1] - self.angle[0])

    @property
    def spacing(self) -> float:
        """Usual angle between neighbours, points measured twice left out, rad."""
        steps = np.abs(np.diff(self.angle))
        return float(np.median(steps[steps > 1e-3 * steps.max()]))

    @cached_property
    def weights(self) -> Floats:
        """Part of the turn that each point stands for, 1 in the mean."""
        if self.even:
            return np.ones_like(self.x_mm)
        angle = np.mod(self.angle, TURN)
        order = np.argsort(angle, kind="stable")
        gaps = np.diff(angle[order], append=angle[order[0]] + TURN)
        share = np.empty_like(gaps)
        share[order] = 0.5 * (gaps + np.roll(gaps, 1)) * (gaps.size / TURN)
        return np.ones_like(share) if float(np.ptp(share)) < ALIKE else share

    def deviation_um(self, radius_mm: float) -> Floats:
        """Distance from the set-up centre less the nominal radius, um."""
        return 1000.0 * (np.hypot(self.x_mm, self.y_mm) - radius_mm)


NOT_SETTLED = "the loop has not settled in one turn, or it drifts, or there is noise"
RIGHT = "is the radius right, and the unit"


@dataclass(frozen=True)
class CircularTest:
    """One circle in one or both directions, with what a report must say about how it was made.

    Raises:
        ValueRefused: a radius or feed that is not positive.
        DataError: no turn, or circles whose size or place is not that of the nominal circle.
    """

    radius_mm: float
    ccw: Turn | None
    cw: Turn | None
    feed_mm_min: float | None = None
    source: str = "path"
    """A key of :data:`SOURCES`."""
    axes: tuple[str, str] = ("X", "Y")
    start_deg: float = 0.0
    sampling: str = ""
    """How the points were taken, in words."""
    name: str = ""
    open_um: float = 0.0
    """By how much the path is elsewhere after the measured turn; of a measured file the radius."""
    recorded: tuple[str, ...] = ()
    """Notes on how the turns were found in a recording."""

    def __post_init__(self) -> None:
        positive("radius", self.radius_mm, "mm")
        if self.feed_mm_min is not None:
            positive("feed", self.feed_mm_min, "mm/min")
        if not self.turns:
            raise DataError("a circular test without a turn: expected one direction or both")

        for turn in self.turns:
            circle = least_squares_circle(turn.x_mm, turn.y_mm, turn.weights)
            if abs(circle.radius - self.radius_mm) > FARTHEST * self.radius_mm:
                raise DataError(
                    f"direction {turn.direction}: the circle has a radius of {circle.radius:.6g} mm where the nominal "
                    f"one is {self.radius_mm:g} mm; {'does the loop follow' if self.source == 'path' else RIGHT}?"
                )
            if math.hypot(circle.x, circle.y) > FARTHEST * self.radius_mm:
                raise DataError(
                    f"direction {turn.direction}: the circle lies around ({circle.x:.6g}, {circle.y:.6g}) mm; expected "
                    f"within {FARTHEST * self.radius_mm:g} mm of the set-up centre: give the centre of the nominal "
                    "circle"
                )

    @property
    def turns(self) -> list[Turn]:
        """The turns that there are, counter-clockwise first."""
        return [t for t in (self.ccw, self.cw) if t is not None]

    @property
    def directions(self) -> str:
        """In words."""
        words = {CCW: "counter-clockwise", CW: "clockwise"}
        return " and ".join(words[t.direction] for t in self.turns)

    @property
    def degrees_per_second(self) -> float | None:
        """Angular speed at the feed; none where that is not known."""
        if self.feed_mm_min is None:
            return None
        return math.degrees(self.feed_mm_min / 60.0 / self.radius_mm)

    def notes(self) -> list[str]:
        """What a reader should know before believing a number."""
        said = [*self.recorded]
        if self.source == "encoder":
            said.append(f"this circle is made of {SOURCES['encoder']}")
        if len(self.turns) == 1:
            said.append(
                f"{self.directions} only: no bi-directional quantities, and squareness and servo mismatch cannot be "
                "distinguished"
            )
        fewest = min(t.x_mm.size for t in self.turns)
        if fewest < USUAL:
            said.append(f"{fewest} points a turn where {USUAL} are usual: peaks between the points are not seen")
        if self.open_um > OPEN_UM:
            said.append(
                f"the path does not close: it ends {self.open_um:.3g} um beside its start; "
                + ("something moved or drifted" if self.source == "measured" else NOT_SETTLED)
            )
        return said


def positive(name: str, value: float, unit: str) -> float:
    """The value, if it is one that a length or a feed can have.

    Raises:
        ValueRefused: it is not a number, not finite, zero or negative.
    """
    if not (isinstance(value, int | float) and math.isfinite(value) and value > 0):
        raise ValueRefused(f"{name} = {value!r} {unit}: expected a positive number")
    return float(value)


MOST_STEPS = 50


class Circle(NamedTuple):
    """A circle in the unit of its points."""

    x: float
    y: float
    radius: float

    def distances(self, x: Floats, y: Floats) -> Floats:
        """How far points lie from the centre."""
        return np.hypot(x - self.x, y - self.y)


def least_squares_circle(x: Any, y: Any, weights: Floats | None = None) -> Circle:
    """The circle with the least sum of squared distances to the points; ``weights``: of the squares.

    Raises:
        DataError: fewer than three points, points on a line, or values that are not finite.
    """
    px, py = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if px.ndim != 1 or px.shape != py.shape:
        raise DataError(f"x and y of the points have the shapes {px.shape} and {py.shape}; expected two equal columns")
    if px.size < 3:
        raise DataError(f"{px.size} points make no circle; expected at least 3")
    if not (np.isfinite(px).all() and np.isfinite(py).all()):
        raise DataError("a point of the circle is not finite")
    # About their mean and in their own size, so that neither place nor unit costs digits.
    mean_x, mean_y = float(px.mean()), float(py.mean())
    size = float(np.max(np.hypot(px - mean_x, py - mean_y)))
    if size == 0.0:
        raise DataError("all points of the circle are the same")
    u, v = (px - mean_x) / size, (py - mean_y) / size
    root = np.ones_like(u) if weights is None else np.sqrt(weights)
    design = np.column_stack((2.0 * u, 2.0 * v, np.ones_like(u)))
    found, _, rank, _ = np.linalg.lstsq(root[:, None] * design, root * (u * u + v * v), rcond=1e-12)
    if rank < 3:
        raise DataError("the points lie on a line and make no circle")
    cx, cy = float(found[0]), float(found[1])
    radius = float(np.sqrt(found[2] + cx * cx + cy * cy))
    for _ in range(MOST_STEPS):
        du, dv = u - cx, v - cy
        distance = np.hypot(du, dv)
        if not distance.all():
            raise DataError("a point lies on the centre of the circle")
        jacobian = np.column_stack((-du / distance, -dv / distance, -np.ones_like(u)))
        step = np.linalg.lstsq(root[:, None] * jacobian, root * (radius - distance), rcond=None)[0]
        cx, cy, radius = cx + float(step[0]), cy + float(step[1]), radius + float(step[2])
        if float(np.abs(step).max()) < 1e-15:
            break
    return Circle(mean_x + size * cx, mean_y + size * cy, size * radius)
