"""Parts that a test move is made of; each starts and ends at rest in the middle of the travel.

- *sliding*: the whole travel both ways at one speed: Coulomb and viscous friction;
- *speeding up*: short strokes at the full acceleration: mass, delay;
- *creeping*: both ways at speeds around the Stribeck speed: static friction and its fall;
- *pre-sliding*: strokes shorter than the bristles give way: stiffness, and damping in the quick ones;
- *lost motion*: short strokes each way with a rest behind: backlash.
"""

from __future__ import annotations

from typing import NamedTuple

from leadscrew.identify.excite.belief import Belief, level
from leadscrew.identify.excite.limits import SHARE, Limits
from leadscrew.identify.excite.move import Move, Stroke, there_and_back

SLIDES = (1.0, 0.5, 0.2, 0.08)
"""Of the top speed."""
SHAKES = (1.0, 0.5, 0.2)
"""Of the top speed, as peak of a stroke that only speeds up and slows down."""
CREEPS = (0.3, 0.7, 1.5, 4.0)
"""Of the Stribeck speed."""
LONGEST_S = 1.2
"""Of a stroke at an even speed, from one end to the other."""
REST_S = 0.15
GRID = 1e-9
"""Ends are whole nanometres (or nanoradians), so that samples and program agree."""


class Part(NamedTuple):
    """A block of strokes that may be run several times."""

    name: str
    purpose: str
    move: Move
    always: bool = False
    """Run once whatever the numbers say: a fit is to be judged at several speeds, not only to be narrow."""


def candidates(limits: Limits, belief: Belief) -> list[Part]:
    """All parts that the limits allow and that tell something that is wanted."""
    wanted = " ".join(belief.wanted)
    found = [_slide(limits, share * SHARE * limits.speed)._replace(always=True) for share in SLIDES]
    found += [_shake(limits, share * SHARE * limits.speed) for share in SHAKES]
    found[len(SLIDES)] = found[len(SLIDES)]._replace(always=True)
    if "stribeck" in wanted or "static" in wanted:
        scale = max(belief.side("stribeck_speed", True), belief.side("stribeck_speed", False))
        speeds = {min(c * scale, SHARE * limits.speed) for c in CREEPS}
        found += [_creep(limits, speed)._replace(always=True) for speed in sorted(speeds)]
    if "stiffness" in wanted or "damping" in wanted:
        found += [part._replace(always=True) for part in _bristles(limits, belief)]
    if "backlash" in wanted:
        found.append(_reverse(limits, belief)._replace(always=True))
    return _different(found)


def _different(parts: list[Part]) -> list[Part]:
    """Without those that limits made equal."""
    found: dict[tuple[Stroke, ...], Part] = {}
    for part in parts:
        found.setdefault(part.move.strokes, part)
    return list(found.values())


def _part(limits: Limits, name: str, purpose: str, half: float, speed: float, rest: float, times: int) -> Part:
    """Strokes from the middle to ``half`` on both sides in turn."""
    low, high = limits.reach
    half = min(half, 0.5 * (high - low))
    middle = round(limits.middle / GRID) * GRID
    half = max(round(half / GRID), 1) * GRID
    ends = (middle + half, middle - half)
    return Part(name, purpose, Move(middle, there_and_back(middle, ends, speed, rest, purpose, times), limits))


def _slide(limits: Limits, speed: float) -> Part:
    return _part(limits, f"slide {speed:g}", "sliding", 0.5 * speed * LONGEST_S, speed, REST_S, 1)


def _shake(limits: Limits, speed: float) -> Part:
    return _part(limits, f"shake {speed:g}", "speeding up", 0.5 * _ramp(limits, speed), speed, REST_S, 3)


def _ramp(limits: Limits, speed: float) -> float:
    """Length of a stroke that reaches a speed and slows down again."""
    a, j = SHARE * limits.acceleration, SHARE * limits.jerk
    if not j:
        return speed**2 / a
    return speed * (speed / a + a / j) if speed * j >= a * a else 2.0 * speed * (speed / j) ** 0.5


def _creep(limits: Limits, speed: float) -> Part:
    return _part(limits, f"creep {speed:g}", "creeping", 0.5 * speed * LONGEST_S, speed, REST_S, 1)


def _bristles(limits: Limits, belief: Belief) -> list[Part]:
    bend = 0.7 * level(belief) / belief.of("friction.stiffness")
    slow, quick = 2.0 * bend / 0.5, min(2.0 * bend / 0.02, SHARE * limits.speed)
    return [
        _part(limits, "bend", "pre-sliding", bend, slow, REST_S, 2),
        _part(limits, "shiver", "pre-sliding", bend, quick, 0.02, 10),
    ]


def _reverse(limits: Limits, belief: Belief) -> Part:
    half = max(5.0 * belief.of("backlash"), 100.0 * belief.noise)
    return _part(limits, "reverse", "lost motion", half, min(2.0 * half / 0.5, 0.2 * limits.speed), 0.3, 3)
