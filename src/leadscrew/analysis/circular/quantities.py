"""The quantities of ISO 230-4 from the paths of a circular test, in um.

===========  ==========================================================================================================
G            circular deviation of one direction: largest less smallest radius about the least-squares centre of that
             path
G(b)         bi-directional circular deviation: the same of both paths about their common least-squares centre
F max, min   radial deviation: largest and smallest radius less the nominal one, about the set-up centre (it contains
             the error of centring), and about the least-squares centre (full circles only)
D            mean bi-directional radial deviation: radius of the least-squares circle of both paths less the nominal
             one
H            circular hysteresis (edition 1996): largest difference of the radii of the two paths at the same angle,
             about their common least-squares centre
===========  ==========================================================================================================

Edition 1996 has G, F and H; 2005 has G, G(b), F and D, and no H; 2022 the same four, each called an error instead of a
deviation. All are always computed; the edition chooses which are shown and how they are called.

The text of the standard was not at hand: the names are those of its public abstracts, the definitions those of public
summaries. Whether the standard averages several runs or filters is not known to us; nothing is filtered here.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import TURN, Circle, CircularTest, Floats, Turn, least_squares_circle
from leadscrew.util.errors import ValueRefused

EDITIONS = ("1996", "2005", "2022")


@dataclass(frozen=True)
class OneWay:
    """Of one direction, um."""

    circular: float
    """G."""
    largest: float
    """F max about the least-squares centre."""
    smallest: float
    """F min about the least-squares centre."""
    set_up_largest: float
    """F max about the set-up centre."""
    set_up_smallest: float
    mean_radial: float
    """Radius of the least-squares circle of this direction less the nominal one."""
    centre_x: float
    """Of the least-squares centre, from the set-up centre."""
    centre_y: float


@dataclass(frozen=True)
class BothWays:
    """Of both directions together, um."""

    circular: float
    """G(b)."""
    mean_radial: float
    """D."""
    hysteresis: float
    """H."""
    hysteresis_deg: float
    """Angle at which H occurs."""
    centre_x: float
    centre_y: float


@dataclass(frozen=True)
class Quantities:
    """What a circular test gives."""

    ccw: OneWay | None
    cw: OneWay | None
    both: BothWays | None

    def as_dict(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def quantities(test: CircularTest) -> Quantities:
    """All quantities that the turns of the test allow."""
    ccw, cw = (None if t is None else _one(t, test) for t in (test.ccw, test.cw))
    return Quantities(ccw, cw, _both(test.ccw, test.cw, test.radius_mm) if test.ccw and test.cw else None)


def _one(turn: Turn, test: CircularTest) -> OneWay:
    circle = least_squares_circle(turn.x_mm, turn.y_mm, turn.weights)
    radii = circle.distances(turn.x_mm, turn.y_mm)
    about = 1000.0 * (radii - test.radius_mm)
    set_up = turn.deviation_um(test.radius_mm)
    return OneWay(
        circular=1000.0 * float(np.ptp(radii)),
        largest=float(about.max()),
        smallest=float(about.min()),
        set_up_largest=float(set_up.max()),
        set_up_smallest=float(set_up.min()),
        mean_radial=1000.0 * (circle.radius - test.radius_mm),
        centre_x=1000.0 * circle.x,
        centre_y=1000.0 * circle.y,
    )


def _both(ccw: Turn, cw: Turn, radius: float) -> BothWays:
    x, y = np.concatenate((ccw.x_mm, cw.x_mm)), np.concatenate((ccw.y_mm, cw.y_mm))
    # Each direction counts the same, however many points it has.
    weights = np.concatenate([t.weights * (0.5 * x.size / t.x_mm.size) for t in (ccw, cw)])
    circle = least_squares_circle(x, y, weights)
    one, other = (_around(t, circle) for t in (ccw, cw))
    # At every angle of either path; the other one is interpolated there.
    angles = np.concatenate((one[0], other[0]))
    apart = np.abs(_at(one, angles) - _at(other, angles))
    worst = int(np.argmax(apart))
    return BothWays(
        circular=1000.0 * float(np.ptp(circle.distances(x, y))),
        mean_radial=1000.0 * (circle.radius - radius),
        hysteresis=1000.0 * float(apart[worst]),
        hysteresis_deg=float(np.degrees(angles[worst])),
        centre_x=1000.0 * circle.x,
        centre_y=1000.0 * circle.y,
    )


def _around(turn: Turn, circle: Circle) -> tuple[Floats, Floats]:
    """Angles in [0, 2 pi) in order, and radii, about a centre."""
    u, v = turn.x_mm - circle.x, turn.y_mm - circle.y
    angle = np.mod(np.arctan2(v, u), TURN)
    order = np.argsort(angle, kind="stable")
    return angle[order], np.hypot(u, v)[order]


def _at(path: tuple[Floats, Floats], angles: Floats) -> Floats:
    return np.asarray(np.interp(angles, path[0], path[1], period=TURN))


class Named(NamedTuple):
    """A quantity under the name of an edition."""

    name: str
    symbol: str
    value: float


def named(found: Quantities, edition: str, axes: tuple[str, str] = ("X", "Y")) -> list[Named]:
    """The quantities that an edition has, by its names, in its order.

    Raises:
        ValueRefused: no such edition.
    """
    if edition not in EDITIONS:
        raise ValueRefused(f"edition = {edition!r}: expected one of {', '.join(EDITIONS)}, the editions of ISO 230-4")
    word = "error" if edition == "2022" else "deviation"
    plane = "".join(axes)
    rows: list[Named] = []
    ways = [(way, tag) for way, tag in ((found.ccw, "CCW"), (found.cw, "CW")) if way is not None]
    if found.both is not None and edition != "1996":
        rows.append(Named(f"bi-directional circular {word}", f"G(b)_{plane}", found.both.circular))
        rows.append(Named(f"mean bi-directional radial {word}", f"D_{plane}", found.both.mean_radial))
    rows += [Named(f"circular {word}, {tag}", f"G({tag})_{plane}", way.circular) for way, tag in ways]
    if found.both is not None and edition == "1996":
        rows.append(Named("circular hysteresis", f"H_{plane}", found.both.hysteresis))
    for way, tag in ways:
        rows += [
            Named(f"radial {word}, {tag}, set-up centre", f"F({tag})_{plane},max", way.set_up_largest),
            Named(f"radial {word}, {tag}, set-up centre", f"F({tag})_{plane},min", way.set_up_smallest),
            Named(f"radial {word}, {tag}, least-squares centre", f"F({tag})_{plane},max", way.largest),
            Named(f"radial {word}, {tag}, least-squares centre", f"F({tag})_{plane},min", way.smallest),
        ]
    return rows


def about(turn: Turn, centre: Circle, radius_mm: float) -> tuple[Floats, Floats]:
    """Angles in order of travel and deviations, um, about a centre."""
    u, v = turn.x_mm - centre.x, turn.y_mm - centre.y
    return np.unwrap(np.arctan2(v, u)), 1000.0 * (np.hypot(u, v) - radius_mm)


def centred(test: CircularTest) -> dict[str, tuple[Floats, Floats]]:
    """Angles and deviations of each direction of a test, see :func:`about`, about the centre of all its paths."""
    q = quantities(test)
    way = q.both or q.ccw or q.cw
    assert way is not None
    centre = Circle(1e-3 * way.centre_x, 1e-3 * way.centre_y, test.radius_mm)
    return {t.direction: about(t, centre, test.radius_mm) for t in test.turns}
