"""What the rules of the curvature are set to, and on what that was chosen: lines and seeds outside the study's.

:func:`chosen_anew` walks along one setting after the other (:data:`RANGES`), :data:`ROUNDS` times, and keeps what has
the smallest cost: the largest RMS deviation of eighteen, rules learned on one of three lines of its own
(:func:`lines_of_choice`), frozen, and asked on the two others, in three materials. All that was tried is kept in
``data/recall_choice.csv``; the first row of the smallest cost is the default of
:func:`leadscrew.controllers.tangent.curvature_network.curvature_network`.
"""

from __future__ import annotations

import csv
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.controllers.tangent.curvature_network import curvature_network, start_covariance
from leadscrew.kernel.block import Block
from leadscrew.studies.sofnn_tangent.lines import FEED, PERIOD_S, samples_of
from leadscrew.studies.sofnn_tangent.pieces import Learned, pieces
from leadscrew.studies.sofnn_tangent.runs import Loops

if TYPE_CHECKING:
    from leadscrew.paths.path import Path as Line

SEED = 71
"""Of textures and noises: no controller of the study is judged on it."""
LESSONS = 5
RUNS = 2
ROUNDS = 2
FILE = Path(__file__).parent / "data" / "recall_choice.csv"
SPLINE = (
    *((0, 0), (30, -45), (70, -30), (60, 30), (110, 55), (150, 10)),
    *((130, -50), (190, -60), (230, -10), (210, 45), (260, 60), (310, 20)),
)
"""Control polygon of the gentle line, mm."""


class Setting(NamedTuple):
    """What is chosen; its defaults are where the search starts."""

    highpass_s: float = 0.1
    scale: float = 30.0
    """mm, k_c and k_h."""
    level: float = 0.3
    slope: float = 1.0
    rough: float = 0.01
    reach: float = 1.5
    direction: float = 1.0

    def block(self) -> Block:
        """The rules so set, without an observer."""
        start = start_covariance(self.level, self.slope, self.rough, self.reach, self.direction)
        return curvature_network(
            prior_covariance=start, k_c=self.scale, k_h=self.scale, highpass_s=self.highpass_s, gain=0.0
        )


RANGES: dict[str, tuple[float, ...]] = {
    "highpass_s": (0.03, 0.06, 0.1, 0.15, 0.25),
    "scale": (20.0, 24.0, 30.0, 36.0, 45.0),
    "level": (0.03, 0.1, 0.3, 1.0),
    "slope": (0.1, 0.3, 1.0, 3.0),
    "rough": (0.001, 0.003, 0.01, 0.03, 0.1),
    "reach": (1.0, 1.5, 2.5),
    "direction": (0.1, 0.3, 1.0, 3.0),
}
"""Values that are tried."""


class Tried(NamedTuple):
    """A setting, and RMS deviations on lines that were not learned on, deg."""

    setting: Setting
    worst: float
    mean: float


def lines_of_choice() -> list[Line]:
    """A spline of 17 mm radius, a rosette of seven lobes and 6.7 mm, a square with fillets of 8 mm turned by 20 deg."""
    from leadscrew.paths import shapes
    from leadscrew.paths.path import Path as Line

    c, s = np.cos(np.radians(20.0)), np.sin(np.radians(20.0))
    square = shapes.rounded_rectangle(70.0, 70.0, 8.0)
    return [
        Line([shapes.clamped_spline(np.array(SPLINE, dtype=np.float64))], name="spline"),
        shapes.flower(60.0, 9.0, 7),
        square.transformed([[c, -s, 0.0], [s, c, 0.0]]),
    ]


@lru_cache
def changes_of() -> tuple[dict[str, Any], ...]:
    """The lines of the choice in place of the wave, and as long."""
    from leadscrew.paths.path import sampled
    from leadscrew.references.cut_line import tables

    most, made = samples_of("wave"), []
    for line in lines_of_choice():
        laps = np.ceil(most * FEED * PERIOD_S / line.length) if line.closed else 1.0
        found = sampled(line, FEED * PERIOD_S, float(laps))
        values = tables(found.heading[:most], found.curvature[:most])
        made.append({f"{slot}.{key}": value for slot in ("reference", "disturbance") for key, value in values.items()})
    return tuple(made)


def tried(loops: Loops, setting: Setting) -> Tried:
    """What a setting does on the lines of the choice."""
    block, lines = setting.block(), changes_of()
    found = []
    for i, own in enumerate(lines):
        taught = pieces(loops, block, LESSONS, carry=True, runs=RUNS, lines=("wave",), changes=own, seed=SEED)
        start = Learned({"wave": taught.learned.prior["wave"]}, {})
        for j, other in enumerate(lines):
            if i != j:
                again = pieces(loops, block(learning=0), 1, runs=RUNS, lines=("wave",), changes=other, start=start,
                               first=LESSONS, seed=SEED)  # fmt: skip
                found.append(again.rms[0].mean(axis=-1))
    return Tried(setting, float(np.max(found)), float(np.mean(found)))


def chosen_anew(loops: Loops) -> list[Tried]:
    """All settings that the search tries, in its order."""
    seen = {Setting(): tried(loops, Setting())}
    for _ in range(ROUNDS):
        for name, values in RANGES.items():
            best = min(seen.values(), key=lambda t: t.worst).setting
            for value in values:
                setting = best._replace(**{name: value})
                if setting not in seen:
                    seen[setting] = tried(loops, setting)
    return list(seen.values())


def write(rows: list[Tried]) -> None:
    """Keeps what was tried."""
    with FILE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*Setting._fields, "worst_deg", "mean_deg"])
        for t in rows:
            writer.writerow([*(f"{v:g}" for v in t.setting), f"{t.worst:.6f}", f"{t.mean:.6f}"])


@lru_cache
def kept() -> tuple[Tried, ...]:
    """All settings that were tried."""
    with FILE.open(newline="", encoding="utf-8") as file:
        rows = [[float(v) for v in row] for row in list(csv.reader(file))[1:]]
    return tuple(Tried(Setting(*row[:-2]), row[-2], row[-1]) for row in rows)


def chosen() -> Tried:
    """The setting of the smallest cost."""
    return min(kept(), key=lambda t: t.worst)


def next_to(name: str) -> list[Tried]:
    """What was tried that differs from the chosen setting in one value alone: the nearest on either side."""
    best = chosen().setting
    alone = [t for t in kept() if t.setting != best and t.setting._replace(**{name: getattr(best, name)}) == best]
    below = [t for t in alone if getattr(t.setting, name) < getattr(best, name)]
    above = [t for t in alone if getattr(t.setting, name) > getattr(best, name)]
    ends = [max(below, key=lambda t: getattr(t.setting, name))] if below else []
    return [*ends, *([min(above, key=lambda t: getattr(t.setting, name))] if above else [])]
