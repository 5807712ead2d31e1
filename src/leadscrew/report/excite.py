"""Test moves for reading: what they tell, what they cannot, their parts; and their picture."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.formats import NOTHING
from leadscrew.figures.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.identify.excite.design import PASSES, Proposal
from leadscrew.identify.excite.files import SHOWN
from leadscrew.util import escape

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure

SCHEMA_VERSION = 1
COLUMNS = ("parameter", "believed", "unit", "95 % +-", "percent", "target", "verdict")
NUMBERS = ("believed", "95 % +-", "percent", "target")
PART_COLUMNS = ("part", "s", "speed up to", "travel", "strokes")
COLOURS = {
    "sliding": BLUE, "speeding up": VERMILION, "creeping": GREEN, "pre-sliding": PURPLE, "lost motion": ORANGE,
}  # fmt: skip


def _num(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else NOTHING


def unit_of(key: str, proposal: Proposal) -> str:
    """Of a parameter, in the fit's own units."""
    length, force = proposal.belief.unit, proposal.belief.force_unit
    name = key.rsplit(".", 1)[-1]
    by_name = {
        "mass": f"{force} s^2/{length}", "viscous": f"{force} s/{length}", "damping": f"{force} s/{length}",
        "stiffness": f"{force}/{length}", "stribeck_speed": f"{length}/s", "backlash": length, "delay_s": "s",
    }  # fmt: skip
    if name == "mass" and force in ("N", "N m"):
        return {"N": "kg", "N m": "kg m^2"}[force]
    return by_name.get(name, force)


def rows(proposal: Proposal) -> list[list[str]]:
    """A row for each parameter that is wanted."""
    return [
        [p.key, _num(p.value), unit_of(p.key, proposal), _num(p.half), _num(p.percent), _num(p.target), p.verdict]
        for p in proposal.predicted
    ]


def part_rows(proposal: Proposal) -> list[list[str]]:
    """A row for each purpose: seconds, speeds, travel, strokes, over the whole move."""
    unit, scale = SHOWN[proposal.belief.unit]
    move, seen = proposal.move, proposal.samples
    seconds: dict[str, float] = defaultdict(float)
    numbers: dict[str, list[int]] = defaultdict(list)
    period = proposal.belief.period
    for k, stroke in enumerate(move.strokes):
        numbers[stroke.purpose].append(k)
        seconds[stroke.purpose] += period * float((seen.stroke == k).sum())
    found = []
    for purpose, mine in numbers.items():
        part = np.isin(seen.stroke, mine)
        travel = scale * float(np.ptp(seen.position[part]))
        speed = scale * float(np.abs(seen.velocity[part]).max())
        found.append(
            [purpose, f"{seconds[purpose]:.1f}", f"{speed:.3g} {unit}/s", f"{travel:.4g} {unit}", str(len(mine))]
        )
    return found


def sentences(proposal: Proposal) -> list[str]:
    """The rest in words, a line each."""
    unit, scale = SHOWN[proposal.belief.unit]
    belief, seen = proposal.belief, proposal.samples
    low, high = scale * float(seen.position.min()), scale * float(seen.position.max())
    said = [
        f"{proposal.move.duration:.1f} s in {PASSES} equal passes, from {low:.4g} to {high:.4g} {unit}; every sample "
        "keeps position, speed, acceleration" + (" and jerk" if proposal.limits.jerk else ""),
        f"intervals are of one pass, for a sensor noise of {1e3 * scale * belief.noise:.3g} "
        f"{'um' if unit == 'mm' else 'mdeg'} at {belief.period:g} s"
        + (f" and a force of {belief.force_noise:.3g} {belief.force_unit} that no model explains"
           if belief.force_noise else ""),
    ]  # fmt: skip
    said += [f"{p.key}: {p.why}" for p in proposal.predicted if p.verdict != "identifiable"]
    return said


def summary(proposal: Proposal) -> dict[str, Any]:
    """The one JSON object of ``leadscrew excite --json``."""
    return {"schema_version": SCHEMA_VERSION, "kind": "leadscrew excite", **proposal.as_dict(),
            "sentences": sentences(proposal)}  # fmt: skip


def picture(proposal: Proposal, title: str = "") -> Figure:
    """Position, velocity and acceleration, coloured by purpose."""
    from leadscrew.figures.figure import Figure

    unit, scale = SHOWN[proposal.belief.unit]
    seen, move = proposal.samples, proposal.move
    figure = Figure(figsize=(10.0, 5.6), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True)
    names = list(dict.fromkeys(s.purpose for s in move.strokes))
    purpose = np.array([names.index(s.purpose) for s in move.strokes] + [-1])[seen.stroke]
    labels = (f"position ({unit})", f"speed ({unit}/s)", f"acceleration ({unit}/s²)")
    limits = ((move.limits.low, move.limits.high), *((-x, x) for x in (move.limits.speed, move.limits.acceleration)))
    for ax, values, label, bounds in zip(axes, seen[1:4], labels, limits, strict=True):
        for k, name in enumerate(names):
            shown = np.where(purpose == k, scale * values, np.nan)
            ax.plot(seen.time, shown, color=COLOURS.get(name, SKY), linewidth=1.0, label=name)
        for bound in bounds:
            ax.axhline(scale * bound, color="0.6", linewidth=0.7, linestyle="--")
        ax.set_ylabel(label)
        ax.grid(color="0.92", linewidth=0.6)
    axes[-1].set_xlabel("time (s); dashed: the limits")
    if title:
        figure.suptitle(escape.figure(title), fontsize="medium")
    handles, words = axes[0].get_legend_handles_labels()
    figure.legend(handles, words, loc="outside lower center", ncols=len(names), frameon=False, fontsize="small")
    return figure
