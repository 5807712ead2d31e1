"""The last turn of a circle that two axes draw: deviation over angle, and the quantities of ISO 230-4.

The figures are those of :mod:`leadscrew.analysis.circular.quantities`, of every period of the last turn of the true
path; a turn of more than :data:`MOST` periods gives every n-th, and the text says so. The plot gets up to 720 points.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import CCW, CW, FEWEST, TURN, CircularTest, Turn
from leadscrew.analysis.circular.quantities import quantities
from leadscrew.analysis.circular.simulation import CircleParams, Machine, place_of
from leadscrew.fuzzy.views import rounded_up
from leadscrew.kernel.loop import Loop
from leadscrew.references._sine import SineParams
from leadscrew.util.errors import DataError, ValueRefused

MOST = 20_000
"""Periods of a turn, at most, that all count for the figures: 5 s at 4 kHz. A look at so many takes about 6 ms."""
DRAWN = 720
"""Points of a turn that are drawn."""
SAME = 1e-9
"""Amplitudes, frequencies and phases of two sines that differ by less make a circle."""


class Nominal(NamedTuple):
    """The circle that is commanded, in the unit of the loop."""

    radius: float
    speed: float
    """Angular speed, rad/s."""
    way: str
    centre_x: float
    centre_y: float


def nominal(loops: Sequence[Loop]) -> Nominal:
    """The circle of a reference that is one, or of two sines a quarter of a turn apart.

    Raises:
        ValueRefused: the references make no circle.
    """
    found = [block.params if (block := loop.blocks["reference"]) is not None else None for loop in loops]
    x, y = found[0], found[-1]
    if isinstance(x, CircleParams) and isinstance(y, CircleParams):
        return Nominal(x.radius, x.speed, CCW if x.turning > 0.0 else CW, x.centre_x, y.centre_y)
    if not (isinstance(x, SineParams) and isinstance(y, SineParams) and len(loops) == 2):
        raise ValueRefused(f"{loops[0].name}: its reference is no circle; start it with a circle to see one")
    ahead = (x.phase - y.phase) / (0.5 * math.pi)
    quarter = abs(math.remainder(ahead - 1.0, 4.0)) < SAME or abs(math.remainder(ahead + 1.0, 4.0)) < SAME
    alike = all(abs(a - b) <= SAME * abs(a) for a, b in ((x.amplitude, y.amplitude), (x.frequency, y.frequency)))
    if not (quarter and alike and x.amplitude > 0.0 and x.frequency > 0.0):
        raise ValueRefused(
            f"amplitudes {x.amplitude:g} and {y.amplitude:g}, frequencies {x.frequency:g} and {y.frequency:g} Hz, "
            f"phases {x.phase:g} and {y.phase:g} rad: a circle has two that are alike, above 0, a quarter turn apart"
        )
    way = CCW if abs(math.remainder(ahead - 1.0, 4.0)) < SAME else CW
    return Nominal(x.amplitude, TURN * x.frequency, way, x.offset, y.offset)


class Circle:
    """Keeps the last turn of a circle run and says what it looks like.

    Args:
        loops: the loop of both axes, or one of X and one of Y.
        columns: of the rows that are fed, in order; those of a loop of Y begin with ``y.``.
        source: ``actual``, the true path, or ``feedback``, what the sensors say.

    Raises:
        ValueRefused: the references make no circle, the loops have no length, or an axis has no column.
    """

    def __init__(self, loops: Sequence[Loop], columns: Sequence[str], source: str = "actual") -> None:
        self.scale = Machine(loops[0], loops[1] if len(loops) > 1 else None).mm()
        self.period = loops[0].period
        self.circle: Nominal | None = None
        self.why_not = ""
        self.params: list[Any] = []
        self.aim(loops)
        if self.circle is None:
            raise ValueRefused(self.why_not)
        if len(loops) > 1:
            names = [place_of(loops[0], source, "", 0)[0], f"y.{place_of(loops[1], source, '', 1)[0]}"]
        else:
            names = [place_of(loops[0], source, field, which)[0] for which, field in enumerate((".x", ".y"))]
        missing = [n for n in names if n not in columns]
        if missing:
            raise ValueRefused(f"{loops[0].name}: a circle needs the column {missing[0]}")
        self.at: list[int] = [list(columns).index(n) for n in names]

    def aim(self, loops: Sequence[Loop]) -> None:
        """Takes the circle that is commanded now; forgets the turn if it is another one than before."""
        params = [block.params if (block := loop.blocks["reference"]) is not None else None for loop in loops]
        if len(params) == len(self.params) and all(a is b for a, b in zip(params, self.params, strict=True)):
            return
        self.params = params
        try:
            circle, self.why_not = nominal(loops), ""
        except ValueRefused as error:
            circle, self.why_not = None, str(error)
        if circle != self.circle or circle is None:
            self.circle = circle
            self.restart()

    def restart(self) -> None:
        """Forgets the turn."""
        each = TURN / self.circle.speed / self.period if self.circle is not None else 1.0
        self.every = max(1, math.ceil(each / MOST))
        self.count = max(FEWEST, round(each / self.every))
        """Points of a turn, which at constant feed takes as long as any other."""
        self.ring = np.zeros((self.count, 2))
        self.filled = self.skip = self.place = 0

    def feed(self, rows: np.ndarray, loops: Sequence[Loop] = ()) -> None:
        """Takes rows of consecutive periods; ``loops`` as they are now, where the circle may have been changed."""
        if loops:
            self.aim(loops)
        taken = rows[self.skip :: self.every][:, self.at]
        self.skip = (self.skip - len(rows)) % self.every
        taken = taken[-self.count :]
        where = (self.place + np.arange(len(taken))) % self.count
        self.ring[where] = taken
        self.place = int((self.place + len(taken)) % self.count)
        self.filled = min(self.count, self.filled + len(taken))

    def look(self) -> dict[str, Any]:
        """The view ``circle``: ``points`` as angle (deg) and deviation (um), figures in um or None before a turn."""
        p, scale = self.circle, self.scale
        if p is None:
            return {"radius": None, "unit": "mm", "enlarge": 1.0, "points": [], "figures": {}, "turned": 0.0,
                    "text": self.why_not}  # fmt: skip
        order = (self.place - self.filled + np.arange(self.filled)) % self.count
        xy = scale * (self.ring[order] - (p.centre_x, p.centre_y))
        xy = xy[np.isfinite(xy).all(axis=1)]
        radius = scale * p.radius
        angle = np.arctan2(xy[:, 1], xy[:, 0])
        turned = len(xy) / self.count
        whole = turned >= 1.0
        if whole:
            xy, angle = xy[-self.count :], angle[-self.count :]
        off = 1000.0 * (np.hypot(xy[:, 0], xy[:, 1]) - radius)
        figures, text = self._figures(xy, radius, p.way) if whole else ({}, f"{turned:.2f} of the first turn")
        shown = slice(None, None, max(1, math.ceil(len(off) / DRAWN)))
        about = off[shown]
        largest = float(np.abs(about).max()) if about.size else 0.0
        return {
            "radius": radius, "unit": "mm", "enlarge": division(largest),
            "points": np.round(np.column_stack((np.degrees(angle[shown]) % 360.0, about)), 4).tolist(),
            "figures": figures, "turned": turned, "text": text,
        }  # fmt: skip

    def _figures(self, xy: np.ndarray, radius: float, way: str) -> tuple[dict[str, float], str]:
        try:
            turn = Turn(way, xy[:, 0], xy[:, 1])
            found = quantities(CircularTest(radius, turn if way == CCW else None, turn if way == CW else None))
        except DataError as error:
            return {}, str(error)
        of = found.ccw if way == CCW else found.cw
        assert of is not None
        figures = {
            "G": of.circular, "F max": of.set_up_largest, "F min": of.set_up_smallest,
            "radius error": of.mean_radial, "centre x": of.centre_x, "centre y": of.centre_y,
        }  # fmt: skip
        thinned = f", figures of every {self.every}. period" if self.every > 1 else ""
        return figures, f"last turn, {way}{thinned}"


def division(largest_um: float) -> float:
    """Micrometres a division of the polar plot: 1, 2, 5 times a power of ten, so that four hold the largest."""
    return max(rounded_up(largest_um / 4.0), 0.01) if largest_um > 0.0 else 0.01
