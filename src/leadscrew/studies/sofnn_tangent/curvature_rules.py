"""Rules of the curvature that learn on one line, are frozen, and cut that line and others again; how they were set.

:func:`chosen_anew` walks along one setting after the other (:data:`RANGES`), twice, and keeps what has the smallest
cost: the largest RMS deviation of eighteen, rules learned on one of three lines that the study does not cut
(:func:`lines_of_choice`), frozen, and asked on the two others, in three materials. All that was tried is kept in
``data/recall_choice.csv``; the row of the smallest cost is the default of
:func:`leadscrew.controllers.curvature_network`.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.controllers._tangent.curvature_network import apart_covariance, curvature_network, start_covariance
from leadscrew.kernel.block import Block
from leadscrew.neural.inference_net import RULES
from leadscrew.studies.lab import measure
from leadscrew.studies.sofnn_tangent.cuts import NONE
from leadscrew.studies.sofnn_tangent.pieces import Learned, Plan, pieces
from leadscrew.studies.sofnn_tangent.scenarios import LINES, SAMPLE_MM, samples_of

if TYPE_CHECKING:
    from leadscrew.paths.path import Path as Line
    from leadscrew.studies.lab import Lab

LESSONS = 5
"""Pieces that are learned from."""
RUNS = 2


class Recall(NamedTuple):
    """RMS deviations in fabric of what was learned on one line, deg; runs last."""

    none: np.ndarray
    """Without compensation, ``[line, run]``."""
    learning: np.ndarray
    """In the last lesson, ``[line, run]``."""
    frozen: np.ndarray
    """Frozen, with new textures: ``[line of the lessons, line, run]``."""

    def kept(self) -> float:
        """Smallest share of the gain that is kept on the line of the lessons."""
        same = np.array([self.frozen[i, i].mean() for i in range(len(LINES))])
        none = self.none.mean(axis=-1)
        return float(np.min((none - same) / (none - self.learning.mean(axis=-1))))

    def elsewhere(self) -> np.ndarray:
        """RMS on the other lines, one of six."""
        return np.asarray(self.frozen.mean(axis=-1)[~np.eye(len(LINES), dtype=bool)])


def _apart() -> np.ndarray:
    start = apart_covariance()
    start[RULES:, RULES:] = start_covariance()[RULES:, RULES:]
    return start


FORMS: dict[str, Block] = {
    "rules that know of each other, and the direction": curvature_network(gain=0.0),
    "the same without the direction": curvature_network(gain=0.0, prior_covariance=start_covariance(direction=0.0)),
    "every rule for itself, and the direction": curvature_network(gain=0.0, prior_covariance=_apart()),
    "every rule for itself": curvature_network(gain=0.0, prior_covariance=apart_covariance()),
}
"""No observer is on, so that the rules alone cut."""


@measure
def recalled(lab: Lab, form: str) -> Recall:
    """All lessons and replays of a form, in fabric."""
    block, plan = FORMS[form], Plan(LESSONS, carry=True, runs=RUNS, materials=("fabric",))
    learning, frozen = [], []
    for name in LINES:
        lessons = pieces(lab, block, plan, lines=(name,))
        start = Learned(dict.fromkeys(LINES, lessons.learned.prior[name]), {})
        again = pieces(lab, block(learning="off"), plan._replace(total=1, carry=False, first=LESSONS), start=start)
        learning.append(lessons.rms[-1, 0, 0])
        frozen.append(again.rms[0, :, 0])
    none = pieces(lab, NONE, plan._replace(total=1, carry=False, first=LESSONS))
    return Recall(none.rms[0, :, 0], np.array(learning), np.array(frozen))


# ---- how the rules were set
SEED = 71
"""Of textures and noises: no controller of the study is judged on it."""
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


def changes_of(line: Line) -> dict[str, Any]:
    """A line of the choice in place of the wave, and as long."""
    from leadscrew.paths.path import sampled
    from leadscrew.references._cut_line import tables

    samples = samples_of("wave")
    laps = np.ceil(samples * SAMPLE_MM / line.length) if line.closed else 1.0
    found = sampled(line, SAMPLE_MM, float(laps))
    values = tables(found.heading[:samples], found.curvature[:samples])
    return {f"{slot}.{key}": value for slot in ("reference", "disturbance") for key, value in values.items()}


def tried(lab: Lab, setting: Setting) -> Tried:
    """What a setting does on the lines of the choice."""
    block, lines = setting.block(), [changes_of(line) for line in lines_of_choice()]
    plan, found = Plan(LESSONS, carry=True, runs=RUNS), []
    for own in lines:
        lessons = pieces(lab, block, plan, lines=("wave",), changes=own, seed=SEED)
        start = Learned({"wave": lessons.learned.prior["wave"]}, {})
        replay = plan._replace(total=1, carry=False, first=LESSONS)
        for other in (line for line in lines if line is not own):
            again = pieces(lab, block(learning="off"), replay, ("wave",), start, other, SEED)
            found.append(again.rms[0].mean(axis=-1))
    return Tried(setting, float(np.max(found)), float(np.mean(found)))


def chosen_anew(lab: Lab) -> list[Tried]:
    """All settings that the search tries, in its order."""
    seen = {Setting(): tried(lab, Setting())}
    for name, values in [*RANGES.items(), *RANGES.items()]:
        best = min(seen.values(), key=lambda t: t.worst).setting
        for value in values:
            setting = best._replace(**{name: value})
            if setting not in seen:
                seen[setting] = tried(lab, setting)
    return list(seen.values())


def write(rows: list[Tried]) -> None:
    """Keeps what was tried."""
    with FILE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*Setting._fields, "worst_deg", "mean_deg"])
        for t in rows:
            writer.writerow([*(f"{v:g}" for v in t.setting), f"{t.worst:.6f}", f"{t.mean:.6f}"])


def kept() -> list[Tried]:
    """All settings that were tried."""
    with FILE.open(newline="", encoding="utf-8") as file:
        rows = [[float(v) for v in row] for row in list(csv.reader(file))[1:]]
    return [Tried(Setting(*row[:-2]), row[-2], row[-1]) for row in rows]


def chosen() -> Tried:
    """The setting of the smallest cost."""
    return min(kept(), key=lambda t: t.worst)
