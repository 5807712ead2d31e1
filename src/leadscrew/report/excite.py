"""Test moves for reading: what they tell, what they cannot, their parts; and their picture."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.figures.table import finite, fixed, unit
from leadscrew.identify.excite.design import PASSES, Proposal
from leadscrew.identify.excite.files import SHOWN
from leadscrew.report.report import File, Report, TextTable, head
from leadscrew.util import escape

if TYPE_CHECKING:
    from pathlib import Path

    from leadscrew.figures.figure import Figure

COLOURS = {
    "sliding": BLUE, "speeding up": VERMILION, "creeping": GREEN, "pre-sliding": PURPLE, "lost motion": ORANGE,
}  # fmt: skip


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


def table(proposal: Proposal) -> TextTable:
    """A row for each parameter that is wanted."""
    rows = [
        [p.key, finite(p.value, 3), unit(unit_of(p.key, proposal)), finite(p.half, 3), finite(p.percent, 3),
         finite(p.target, 3), p.verdict]
        for p in proposal.predicted
    ]  # fmt: skip
    heads = ("parameter", "believed", "unit", "95 % ±", "%", "target (%)", "verdict")
    return TextTable(heads, rows, [False, True, False, True, True, True, False])


def part_table(proposal: Proposal) -> TextTable:
    """A row for each purpose: seconds, speeds, travel, strokes, over the whole move."""
    length, scale = SHOWN[proposal.belief.unit]
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
            [purpose, fixed(seconds[purpose], 1), f"{finite(speed, 3)} {length}/s", f"{finite(travel)} {length}",
             str(len(mine))]
        )  # fmt: skip
    return TextTable(("part", "time (s)", "speed up to", "travel", "strokes"), found)


def sentences(proposal: Proposal) -> list[str]:
    """The rest in words, a line each."""
    unit, scale = SHOWN[proposal.belief.unit]
    belief, seen = proposal.belief, proposal.samples
    low, high = scale * float(seen.position.min()), scale * float(seen.position.max())
    lines = [
        f"{proposal.move.duration:.1f} s in {PASSES} equal passes, from {low:.4g} to {high:.4g} {unit}; every sample "
        "keeps position, speed, acceleration" + (" and jerk" if proposal.limits.jerk else ""),
        f"intervals are of one pass, for a sensor noise of {1e3 * scale * belief.noise:.3g} "
        f"{'um' if unit == 'mm' else 'mdeg'} at {belief.period:g} s"
        + (f" and a force of {belief.force_noise:.3g} {belief.force_unit} that no model explains"
           if belief.force_noise else ""),
    ]  # fmt: skip
    lines += [f"{p.key}: {p.why}" for p in proposal.predicted if p.verdict != "identifiable"]
    return lines


def summary(proposal: Proposal) -> dict[str, Any]:
    """The one JSON object of ``leadscrew excite --json``."""
    return {**head("excite"), **proposal.as_dict(), "sentences": sentences(proposal)}


def report_of(proposal: Proposal, out: Path | None) -> Report:
    """The report of ``leadscrew excite``."""
    return Report(
        summary(proposal),
        parts=[table(proposal), part_table(proposal), *sentences(proposal)],
        notes=["nothing is written without --out DIR"] if out is None else [],
        files=[File("out", out, "what to do with the program and the recorder: README.md")],
        figure=lambda: picture(proposal),
    )


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
