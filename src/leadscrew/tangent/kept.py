"""What of a program that was read a program written anew would lose, or have in another way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from leadscrew.tangent.interpreter import Moves, Step
from leadscrew.tangent.runs import SAME_HEIGHT_MM, Run, top_of
from leadscrew.tangent.settings import Settings


def as_it_is(own: Settings, steps: Sequence[Step], runs: Sequence[Run]) -> Settings:
    """Settings of a program of ours, after lines were edited by hand: not faster down, and not lifted less."""
    slowest = min((run.plunge for run in runs if run.plunge), default=own.plunge)
    lift = top_of(steps)
    if slowest < own.plunge - 0.15:
        own = replace(own, plunge=slowest)
    return replace(own, lift=lift) if lift > own.lift + 0.01 else own


def lost_of(moves: Moves, runs: list[Run], pricks: int) -> list[str]:
    """Why a program written anew would not be this one."""
    found = []
    depths = [run.steps[0].start[2] for run in runs]
    deepest, shallowest = min(depths), max(depths)
    if not moves.heights:
        return ["it has no Z word, and a new program would move Z"]
    if top_of(moves.steps) <= shallowest + SAME_HEIGHT_MM:
        return [f"it never lifts the knife above Z{shallowest:g}, and a new program would"]
    told = next(k for k, s in enumerate(moves.steps) if s.start[2] != s.end[2]) + 1
    for step in moves.steps[told:]:
        if not step.code and step.flat > 0.0 and min(step.start[2], step.end[2]) <= shallowest:
            found.append(f"line {step.line}: G0 moves X or Y in the depth of a cut, and a new program would lift there")
            break
    for run in runs:
        if run.plunge is None:
            found.append(f"line {run.steps[0].line}: nothing goes down to this cut, and a new program would")
            break
    spots = [(abs(s.words[1] - s.words[0]), s.line) for run in runs for s in run.steps if s.curve is None]
    if spots and max(spots)[0] > Settings.corner_angle:
        turn, line = max(spots)
        found.append(
            f"line {line}: the blade turns on the spot by {turn:.0f} deg, and a new program would turn it along the "
            f"last {Settings.blend:g} mm before"
        )
    holes = _holes(moves.steps, {run.steps[0].line for run in runs}, shallowest)
    if len(holes) > pricks:
        found.append(f"line {holes[pricks]}: the knife goes down and up without a cut, and a new program would not")
    unsaid = [p for p in moves.rounding if p is not None and not 1e-4 <= p <= 1.0]
    if unsaid or len({p for p in moves.rounding if p is not None}) > 1:
        found.append("its G64 P is not the same all through, or out of 0.0001 to 1 mm")
    if deepest < -1000.0:
        found.append(f"it cuts at Z{deepest:g}")
    return found


def _holes(steps: Sequence[Step], cuts: set[int], shallowest: float) -> list[int]:
    """Lines of what goes down, at a feed or as deep as a cut, without a cut after it."""
    found = []
    down: int | None = None
    for step in steps:
        if step.flat > 0.0 and step.line in cuts:
            down = None
        if step.end[2] < step.start[2] and (step.code or step.end[2] <= shallowest + SAME_HEIGHT_MM):
            down = step.line
        elif step.end[2] > step.start[2] and down is not None:
            found.append(down)
            down = None
    return found if down is None else [*found, down]


def slowed(runs: Sequence[Run], own: Settings) -> list[str]:
    """Feeds of a program of ours that were lowered by hand: its head, which makes the next, does not know of them."""
    for run in runs:
        for step in run.steps:
            turn = abs(step.words[1] - step.words[0])
            if step.flat < 0.1:
                continue
            wanted = min(own.feed, 60.0 * own.swivel * step.flat / turn if turn > 0.0 else math.inf)
            if step.feed < 0.9 * wanted:
                return [
                    f"line {step.line}: its feed is {step.feed:.4g} mm/min, and a new program would have that by the "
                    f"head of this one, {wanted:.4g}"
                ]
    return []


def changed_of(moves: Moves, runs: Sequence[Run], above: Sequence[int], settings: Settings) -> list[str]:
    """What a program written anew has in another way, for a note."""
    found = []
    if above:
        said = ", ".join(str(n) for n in above[:8]) + (", ..." if len(above) > 8 else "")
        found.append(
            f"moves above the work that lead to no cut are not kept (line {said}): each stroke is approached straight, "
            f"at Z{settings.lift:g} mm"
        )
    if not any(moves.rounding):
        found.append(f"has no G64 P: the new program rounds to {settings.tolerance:g} mm")
    plunges = {run.plunge for run in runs}
    if any(s.curve is None and s.words[0] != s.words[1] for run in runs for s in run.steps):
        found.append(f"turns on the spot: the new program turns along the last {settings.blend:g} mm before")
    if len(plunges) > 1:
        found.append(f"plunges at several feeds: the new program at the slowest, {settings.plunge:g} mm/min")
    elif plunges <= {None, 0.0}:
        found.append(f"plunges at the rapid rate: the new program at {settings.plunge:g} mm/min")
    return found
