"""A test move for what is wanted: parts are added, the most telling for its time first, until every interval is met.

The information of parts adds up (each starts and ends at rest), so the choice is the exchange of optimal design of
experiments with a cost in seconds (V. V. Fedorov, *Theory of Optimal Experiments*, Academic Press 1972): the next part
is the one that lowers the sum of ``ln(interval / target)`` over all intervals not yet met the most, by second. A part
of each kind is run whatever the numbers say. The whole is run twice: a fitter that keeps the second half of a log
for validation then meets in both halves the same motions. Predictions are for the first.

Parts that a test move is made of; each starts and ends at rest in the middle of the travel.

- *sliding*: the whole travel both ways at one speed: Coulomb and viscous friction;
- *speeding up*: short strokes at the full acceleration: mass, delay;
- *creeping*: both ways at speeds around the Stribeck speed: static friction and its fall;
- *pre-sliding*: strokes shorter than the bristles give way: stiffness, and damping in the quick ones;
- *lost motion*: short strokes each way with a rest behind: backlash.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from leadscrew.identify.estimation import identifiable, quantile
from leadscrew.identify.excite import belief as beliefs
from leadscrew.identify.excite import move as bounds
from leadscrew.identify.excite.belief import Belief, level
from leadscrew.identify.excite.information import Information, columns_of, information, nothing
from leadscrew.identify.excite.move import (
    SHARE,
    START_REST,
    Limits,
    Move,
    Sampled,
    Stroke,
    check,
    sampled,
    there_and_back,
)
from leadscrew.util.errors import ValueRefused

RISE = 0.05
"""Share of the rise of friction towards rest above which the force that no model explains hides it, not the sensor."""


def why_not(key: str, belief: Belief, half: float, target: float, limits: Limits, duration: float) -> str:
    """A sentence: what limits the interval of a key, and how much more of what would meet the target."""
    name, unit = key.rsplit(".", 1)[-1], belief.unit
    level = max(belief.side("coulomb", True), belief.side("coulomb", False))
    if not math.isfinite(half):
        return "no part of a test inside these limits tells it"
    more = half / target if target > 0.0 else math.inf
    longer = f"; a test of about {_round(duration * more**2)} s would" if more < 6.0 else ""
    if name == "viscous":
        force = belief.of(key) * SHARE * limits.speed
        return (
            f"at the top speed of {_shown(limits.speed, unit)}/s it is {force:.3g} of {level + force:.3g} "
            f"{belief.force_unit}{longer}; a higher top speed tells it better in proportion"
        )
    if name == "coulomb":
        force = belief.of(key.replace("coulomb", "viscous")) * SHARE * limits.speed
        return (
            f"it trades with viscous friction, which reaches {force:.3g} {belief.force_unit} at the top speed"
            f"{longer}; a higher top speed or a longer test tells them apart"
        )
    if name == "mass":
        force = belief.of(key) * SHARE * limits.acceleration
        return (
            f"at the top acceleration of {_shown(limits.acceleration, unit)}/s^2 it takes {force:.3g} "
            f"{belief.force_unit} beside {level:.3g} of friction{longer}; a higher acceleration tells it better"
        )
    if name in ("static", "stribeck_speed"):
        slow = belief.side("stribeck_speed", True)
        rise = max(belief.side("static", ahead) - belief.side("coulomb", ahead) for ahead in (True, False))
        if belief.force_noise > RISE * rise:
            return (
                f"friction rises by {rise:.3g} {belief.force_unit} from sliding to rest, and no model explains a force "
                f"of {belief.force_noise:.3g}{longer}"
            )
        return (
            f"creeping at {_shown(slow, unit)}/s moves the axis by {slow * belief.period / belief.noise:.2g} times the "
            f"sensor's noise in a period{longer}; a finer sensor tells it"
        )
    if name in ("stiffness", "damping"):
        bend = max(belief.side("static", True), level) / max(belief.of("friction.stiffness"), 1e-300)
        return f"the bristles bend by {_shown(bend, unit)}, the sensor's noise is {_shown(belief.noise, unit)}{longer}"
    if name == "backlash":
        return f"the gap is {_shown(belief.of(key), unit)}, the sensor's noise {_shown(belief.noise, unit)}{longer}"
    return f"the sensor's noise is {_shown(belief.noise, unit)}{longer or '; a longer test or a finer sensor tells it'}"


def _round(seconds: float) -> str:
    return f"{seconds:.2g}" if seconds < 100.0 else f"{round(seconds, -1):.0f}"


def _shown(value: float, unit: str) -> str:
    """In mm or um where the unit is m."""
    if unit != "m":
        return f"{value:.3g} {unit}"
    return f"{1e3 * value:.3g} mm" if abs(value) >= 1e-4 else f"{1e6 * value:.3g} um"


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


TARGETS = {"mass": 5.0, "coulomb": 5.0, "viscous": 10.0, "static": 10.0, "stribeck_speed": 25.0, "stiffness": 10.0,
           "damping": 25.0, "backlash": 20.0}  # fmt: skip
"""Half of a 95 % interval in percent of the value, where no target is given; offset: of Coulomb friction."""
END_REST = 0.5
SINGULAR = 1e-11
"""Share of the largest information below which a combination of parameters is not told at all."""
LONGEST = 400
"""Parts in a pass."""
PASSES = 2
LEAST_TRAVEL = 100.0
"""Times the sensor's noise that a test moves over, at least."""
REACHED = 1.6
"""Intervals of ``identify axis`` on simulated axes over the bound of the information, 1.2 to 2.2: its windows begin in
motion and count as a few dozen pieces of evidence."""
LEAST_SHARE = 1e-4
"""Of the value: no interval is claimed to be narrower."""
DELAY_FLOOR = 0.02
"""Of a period: no delay is told better between two samples."""


class Predicted(NamedTuple):
    """How well the move tells a parameter, half of the 95 % interval, SI."""

    key: str
    value: float
    half: float
    target: float
    verdict: Literal["identifiable", "wide", "not identifiable"]
    why: str = ""

    @property
    def percent(self) -> float:
        """Of the value."""
        return 100.0 * self.half / abs(self.value) if self.value else math.inf


@dataclass(frozen=True)
class Proposal:
    """A test move, what it will tell, and what no move within the limits can."""

    move: Move
    samples: Sampled
    belief: Belief
    predicted: list[Predicted]
    parts: dict[str, int]
    """How often each part is run in each of the two passes."""

    @property
    def limits(self) -> Limits:
        """What it keeps."""
        return self.move.limits

    def as_dict(self) -> dict[str, Any]:
        """For JSON, without samples."""
        return {
            "duration_s": self.move.duration, "limits": self.limits._asdict(), "position_unit": self.belief.unit,
            "force_unit": self.belief.force_unit, "period_s": self.belief.period, "noise": self.belief.noise,
            "force_noise": self.belief.force_noise, "parts": self.parts,
            "predicted": [{**p._asdict(), "percent": p.percent} for p in self.predicted],
            "strokes": [s._asdict() for s in self.move.strokes],
        }  # fmt: skip


def propose(
    limits: Limits,
    belief: Belief,
    target_percent: float | None = None,
    progress: Callable[[str, float], None] = lambda what, done: None,
) -> Proposal:
    """The shortest move found inside the limits whose predicted intervals meet the targets, or the best in their time.

    ``target_percent`` replaces :data:`TARGETS`, half of each 95 % interval in percent of the value.

    Raises:
        ValueRefused: limits or belief that allow no move.
    """
    limits, belief = bounds.checked(limits), beliefs.checked(belief)
    _room(limits, belief)
    if target_percent is not None and not 0.0 < target_percent <= 100.0:
        raise ValueRefused(f"target = {target_percent!r} %: allowed range is (0, 100]")
    room = (limits.duration - START_REST - END_REST) / PASSES
    parts = _fitting(candidates(limits, belief), limits, room)
    by_part = []
    for k, part in enumerate(parts):
        progress(part.name, k / len(parts))
        by_part.append(information(part.move, belief)._replace(seconds=part.move.duration - START_REST))
    targets = {key: _target(key, belief, target_percent) for key in belief.wanted}
    chosen = _chosen(by_part, _first(parts), belief, targets, room)
    counts = Counter(chosen)
    total = nothing(belief)
    for k, times in counts.items():
        total = total.plus(by_part[k], times)
    move = _move(limits, [(parts[k], counts[k]) for k in sorted(counts)])
    seen = sampled(move, belief.period)
    check(seen, limits)
    progress("checked", 1.0)
    halves = half_intervals(total, belief)
    predicted = [_predicted(key, belief, halves[key], targets[key], limits, move.duration) for key in belief.wanted]
    return Proposal(move, seen, belief, predicted, {parts[k].name: counts[k] for k in sorted(counts)})


def _room(limits: Limits, belief: Belief) -> None:
    """Passes where the sensor can see a move inside the travel: a log of a standing axis makes no limits."""
    travel = limits.high - limits.low
    if travel < LEAST_TRAVEL * belief.noise:
        raise ValueRefused(
            f"travel of {travel:.3g} {belief.unit}: only {travel / belief.noise:.2g} times the sensor's noise of "
            f"{belief.noise:.3g} {belief.unit}, expected {LEAST_TRAVEL:g} times or more; allow more with --travel"
        )
    if limits.speed * limits.duration < LEAST_TRAVEL * belief.noise:
        raise ValueRefused(
            f"top speed = {limits.speed:.3g} {belief.unit}/s: in {limits.duration:g} s that is less than "
            f"{LEAST_TRAVEL:g} times the sensor's noise of {belief.noise:.3g} {belief.unit}; allow more, --top-speed"
        )


def _fitting(parts: list[Part], limits: Limits, room: float) -> list[Part]:
    """Parts that end within a pass: the others are never sampled, however long they are."""
    seconds = [part.move.duration - START_REST for part in parts]
    if min(seconds) > room:
        shortest = PASSES * min(seconds) + START_REST + END_REST
        raise ValueRefused(f"duration = {limits.duration:g} s: the shortest test takes {shortest:.3g} s")
    return [part for part, takes in zip(parts, seconds, strict=True) if takes <= room]


def half_intervals(total: Information, belief: Belief) -> dict[str, float]:
    """Half of the 95 % interval of every key, SI; infinite where nothing is told."""
    columns = columns_of(belief)
    prior = np.zeros(len(columns))
    for k, keys in enumerate(columns.values()):
        known = [belief.known[key] for key in keys if belief.known.get(key, 0.0) > 0.0]
        prior[k] = 1.0 / min(known) ** 2 if known else 0.0
    covariance = _inverse(total.sensor + np.diag(prior))
    if belief.force_noise > 0.0:
        covariance = covariance + belief.force_noise**2 * _inverse(total.force, pseudo=True)
    found = dict.fromkeys(beliefs.KEYS, math.inf)
    for k, keys in enumerate(columns.values()):
        spread = math.sqrt(covariance[k, k]) if np.isfinite(covariance[k, k]) else math.inf
        found.update(
            dict.fromkeys(
                keys, quantile() * REACHED * spread + (DELAY_FLOOR * belief.period if keys[0] == "delay_s" else 0.0)
            )
        )
    bristles = _inverse(total.bristles)
    for k, key in enumerate(("friction.stiffness", "friction.damping")):
        found[key] = quantile() * REACHED * math.sqrt(bristles[k, k]) if np.isfinite(bristles[k, k]) else math.inf
    found.update({k: math.hypot(half, LEAST_SHARE * abs(belief.of(k))) for k, half in found.items()})
    found["backlash"] = quantile() * belief.noise * math.sqrt(2.0 / total.reversals) if total.reversals else math.inf
    return found


def _inverse(matrix: np.ndarray, pseudo: bool = False) -> np.ndarray:
    """The inverse after scaling; infinite on the diagonal where a column tells nothing of its own, else 0 there."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    good = scale > 0.0
    found = np.zeros_like(matrix)
    if good.any():
        inner = matrix[np.ix_(good, good)] / np.outer(scale[good], scale[good])
        values, vectors = np.linalg.eigh(inner)
        sound = values > SINGULAR * values[-1]
        held = (vectors[:, sound] / values[sound]) @ vectors[:, sound].T
        found[np.ix_(good, good)] = held / np.outer(scale[good], scale[good])
        good[np.flatnonzero(good)[(np.abs(vectors[:, ~sound]) > 1e-3).any(axis=1)]] = False
    if not pseudo:
        found[~good, ~good] = np.inf
    return found


def _target(key: str, belief: Belief, percent: float | None) -> float:
    """Half of the interval that is aimed at, SI."""
    name = key.rsplit(".", 1)[-1]
    if name == "delay_s":
        return 0.25 * belief.period
    of = belief.of(key)
    if name == "offset":
        of = max(abs(of), belief.side("coulomb", True), belief.side("coulomb", False))
    elif name in ("viscous", "damping") and not of:
        of = 0.1 * belief.side("coulomb", True) / max(belief.values.get("top_speed", 0.1), 1e-9)
    return 0.01 * (percent if percent is not None else TARGETS.get(name, 5.0)) * of


def _chosen(
    by_part: list[Information], always: list[int], belief: Belief, targets: Mapping[str, float], room: float
) -> list[int]:
    """Numbers of parts, in the order in which they were chosen."""
    total, chosen, used = nothing(belief), [], 0.0
    for k in always:
        if used + by_part[k].seconds <= room:
            total, used = total.plus(by_part[k]), used + by_part[k].seconds
            chosen.append(k)
    here = _missing(total, belief, targets)
    while here > 0.0 and len(chosen) < LONGEST:
        open_to = [k for k, part in enumerate(by_part) if used + part.seconds <= room]
        after = {k: _missing(total.plus(by_part[k]), belief, targets) for k in open_to}
        best = max(open_to, key=lambda k: (here - after[k]) / by_part[k].seconds, default=-1)
        if best < 0 or after[best] >= here:
            break
        total, used, here = total.plus(by_part[best]), used + by_part[best].seconds, after[best]
        chosen.append(best)
    return chosen


def _first(parts: list[Part]) -> list[int]:
    """The parts that are run whatever the numbers say: one of each purpose, then the others."""
    wanted = [k for k, part in enumerate(parts) if part.always]
    purposes = [parts[k].purpose for k in wanted]
    return sorted(wanted, key=lambda k: purposes[: wanted.index(k)].count(parts[k].purpose))


def _missing(total: Information, belief: Belief, targets: Mapping[str, float]) -> float:
    """Sum of ``ln(interval / target)`` over intervals not yet met, each at most 30."""
    halves = half_intervals(total, belief)
    return sum(min(max(math.log(max(halves[k], 1e-300) / max(t, 1e-300)), 0.0), 30.0) for k, t in targets.items())


def _move(limits: Limits, chosen: list[tuple[Part, int]]) -> Move:
    strokes: list[Stroke] = []
    for part, times in chosen:
        strokes += part.move.strokes * times
    strokes *= PASSES
    strokes[-1] = strokes[-1]._replace(rest=END_REST)
    return Move(chosen[0][0].move.start, tuple(strokes), limits)


def _predicted(key: str, belief: Belief, half: float, target: float, limits: Limits, duration: float) -> Predicted:
    if half <= 1.0001 * target:
        return Predicted(key, belief.of(key), half, target, "identifiable")
    if key == "offset" and not belief.symmetric:
        why = "with friction by direction an offset is a part of Coulomb friction: no motion separates them"
        return Predicted(key, belief.of(key), math.inf, target, "not identifiable", why)
    size = abs(belief.of(key) - _below(key, belief)) or 20.0 * target
    known = identifiable(size, half, belief.period if key == "delay_s" else 0.0)
    verdict: Literal["wide", "not identifiable"] = "wide" if known else "not identifiable"
    return Predicted(key, belief.of(key), half, target, verdict, why_not(key, belief, half, target, limits, duration))


def _below(key: str, belief: Belief) -> float:
    """What a value is counted from: static friction from Coulomb friction."""
    return belief.of(key.replace(".static", ".coulomb")) if key.endswith(".static") else 0.0
