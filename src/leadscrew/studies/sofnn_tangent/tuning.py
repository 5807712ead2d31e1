"""What an engineer would use instead: laws tuned with the same effort, and where all of them are judged.

``leadscrew tune`` has found the gains of the controllers ``tuned.*`` (the files in ``tuned``, each with its command):
CMA-ES, 1,000 settings, each on the wave and the flower in 24 materials drawn from :data:`OVER`, for the smallest mean
RMS deviation. A table of offsets from piece to piece is no controller of one run, so :func:`search` tunes it: the same
materials, lines, goal, optimiser, budget and seed; what counts is the third piece. Its settings are kept in
``data/piece_tuning.csv``; ``python -m leadscrew.studies.sofnn_tangent.tuning`` finds them again.

Judged (:func:`judged`) are all on 40 other materials with other textures and noises, on these lines and on the rounded
rectangle, which no search has seen.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from leadscrew import controller_file
from leadscrew.controllers._tangent.taught_offset import taught_alone, taught_offset
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.sofnn_tangent.pieces import PLACES, unknown_plant
from leadscrew.studies.sofnn_tangent.scenarios import LINES, takes_cut_line
from leadscrew.studies.tuned import FOLDER as TUNED_FOLDER
from leadscrew.tangent.piece_learning import next_offsets
from leadscrew.tune.space import Space
from leadscrew.tune.statistics import Interval, paired
from leadscrew.tune.tuner import crossed, held_out_plants, training

HERE = Path(__file__).parent
FILE = HERE / "data" / "piece_tuning.csv"
OVER = Space.of(
    [
        "plant.material.shear=20:100:log",
        "plant.material.lag_s=0.015:0.12:log",
        "plant.material.gain=0.7:1",
        "plant.material.fibre=0:1.2",
        "plant.material.bias=0:1",
    ]
)
"""Materials that are drawn: they hold fabric, leather and foam."""
PLANTS, BUDGET, SEED = 24, 1000, 1
LINES_TUNED = ("wave", "flower")
JUDGED, JUDGED_PART, JUDGED_NOISE = 40, 3, 2_000_000
"""Materials that laws are judged on, the part of the seed that draws them, the number of the first run's noise."""
LOST_DEG = 1e3
"""Cost of a setting that diverges."""


class Law(NamedTuple):
    """A row of the comparison."""

    words: str
    knows: str = ""
    """What it is given beside the deviation that the camera sees."""


AHEAD, LAST = "the line ahead", "the last pieces"
LAWS: dict[str, Law] = {
    "tuned.pi": Law("PI"),
    "tuned.pid": Law("PID"),
    "tuned.observer": Law("disturbance observer"),
    "tuned.delayed_pd": Law("(3) with three gains in place of its rules"),
    "tuned.network": Law("the paper's network"),
    "tuned.accumulating": Law("the same, every correction added"),
    "tuned.sofc": Law("self-organising, the table corrects the rules"),
    "tuned.fixed": Law("fixed rules"),
    "paper.sofnn_pnn": Law("the paper's network, its own scales"),
    "tuned.feed_forward": Law("adaptive feed-forward of the curvature", AHEAD),
    "tuned.curvature": Law("rules of the curvature", AHEAD),
    "table": Law("table of offsets, third piece", LAST),
    "pid_table": Law("PID and table, third piece", LAST),
}
"""Controllers of the study, and tables (:data:`TABLES`), by name."""

TABLES: dict[str, str] = {"table": "", "pid_table": "pid"}
"""What goes from piece to piece by name, and the file of the feedback beside it, whose gains are searched anew."""
OF_THE_TABLE = {"gain": "0.05:1.2", "lead": "1:15:int", "width": "0.2:8:log", "plant_gain": "0.3:3:log"}


def space(way: str) -> Space:
    """What the search of a table may change: its settings, and the gains of the feedback in their own ranges."""
    inner = _file(TABLES[way]).tuning["vary"]["controller"] if TABLES[way] else {}
    return Space.of(OF_THE_TABLE | {f"controller.inner.{key}": text for key, text in inner.items()})


def _file(name: str) -> controller_file.ControllerFile:
    return controller_file.read(HERE / TUNED_FOLDER / f"{name}.toml")


def free_gains(name: str) -> int:
    """How many numbers the search has set."""
    if name in TABLES:
        return len(space(name))
    return len(_file(name.removeprefix("tuned.")).tuning["vary"]["controller"]) if name.startswith("tuned.") else 0


# ---- from piece to piece
def third_piece(
    lab: Lab,
    way: str,
    settings: Mapping[str, np.ndarray],
    plants: Mapping[str, np.ndarray],
    line: str,
    noise: int = 0,
    changes: Mapping[str, Any] | None = None,
) -> dict[str, np.ndarray]:
    """Metrics ``[setting, plant]`` of the third piece of a line; every setting on every plant."""
    members, count = len(settings["gain"]), len(next(iter(plants.values())))
    inner = _file(TABLES[way]).controller if TABLES[way] else ""
    block = taught_offset(lab.study.controller(inner), np.zeros(PLACES)) if inner else taught_alone(np.zeros(PLACES))
    loop = lab.loop(block, f"{line}_fabric", changes=changes)
    duration = lab.study.scenario(f"{line}_fabric").duration_s
    key = "controller.taught.table" if inner else "controller.table"
    seen = "feedback.deviation" if takes_cut_line(block) else "feedback"
    feedback = {k: v for k, v in settings.items() if k not in OF_THE_TABLE}
    columns = crossed(feedback | {"": np.zeros(members)}, plants, count)
    columns.pop("")
    table = np.zeros((members * count, PLACES))
    for piece in range(3):
        signals = ("output", seen) if piece < 2 else ()
        first = noise + piece * members * count
        batch = loop.batch(duration, {**columns, key: table}, record=signals, first=first)
        for m in range(members if signals else 0):
            mine, known = slice(m * count, (m + 1) * count), {k: float(settings[k][m]) for k in OF_THE_TABLE}
            d, e = (np.nan_to_num(batch.signals[s][mine], posinf=0.0, neginf=0.0) for s in signals)
            after = next_offsets(table[mine, : d.shape[1]], d, e, **known | {"lead": int(known["lead"])})  # type: ignore[arg-type]
            table[mine] = np.pad(after, ((0, 0), (0, PLACES - d.shape[1])), mode="edge")
    return {name: batch.metrics[name].reshape(members, count) for name in Judged._fields}


def search(lab: Lab, way: str, budget: int = BUDGET) -> tuple[float, dict[str, float]]:
    """The smallest mean RMS deviation of the third piece, deg, and its setting."""
    from leadscrew.tune.optimisers import OPTIMISERS, Answer, Search

    vary, plants = space(way), training(OVER, PLANTS, SEED)
    best: tuple[float, dict[str, float]] = (np.inf, {})

    def evaluate(points: np.ndarray) -> Answer:
        nonlocal best
        settings = vary.values(points)
        rms = np.array([third_piece(lab, way, settings, plants, line)["rms_error"] for line in LINES_TUNED])
        costs = np.where(np.isfinite(rms), rms, LOST_DEG).mean(axis=(0, 2))
        at = int(np.argmin(costs))
        if costs[at] < best[0]:
            best = float(costs[at]), {key: float(f"{column[at]:.6g}") for key, column in settings.items()}
        return Answer(costs[:, None], np.zeros((len(points), 0)))

    grain = np.array([1.0 / (d.ends[1] - d.ends[0] + 1.0) * getattr(d, "whole", False) for _, d in vary.items])
    OPTIMISERS["cma"][0](Search(evaluate, vary.units({}), budget, SEED, grain=grain))
    return best


def write(lab: Lab, file: Path = FILE) -> None:
    """Searches all tables and writes what was found."""
    with file.open("w", newline="", encoding="utf-8") as out:
        rows = csv.writer(out, lineterminator="\n")
        rows.writerow(("way", "setting", "value"))
        for way in TABLES:
            cost, values = search(lab, way)
            rows.writerows((way, key, f"{value:.6g}") for key, value in ({"cost": cost} | values).items())


def kept(way: str) -> dict[str, float]:
    """The setting of a table as kept, with its ``cost``."""
    with FILE.open(newline="", encoding="utf-8") as file:
        return {row["setting"]: float(row["value"]) for row in csv.DictReader(file) if row["way"] == way}


# ---- judged
class Judged(NamedTuple):
    """What a law does on every line in every material: arrays ``[line, material]``."""

    rms_error: np.ndarray
    """deg"""
    lateral: np.ndarray
    """mm"""


@measure
def judged(lab: Lab, name: str, mismatch: bool = False) -> Judged:
    """A law of :data:`LAWS` on materials, textures and noises that no search has seen."""
    plants, changes = held_out_plants(OVER, JUDGED, SEED, JUDGED_PART), unknown_plant(mismatch)
    rows = []
    for line in LINES:
        if name in TABLES:
            settings = {key: np.array([value]) for key, value in kept(name).items() if key != "cost"}
            found = third_piece(lab, name, settings, plants, line, JUDGED_NOISE, changes)
        else:
            scenario = lab.study.scenario(f"{line}_fabric")
            loop = lab.loop(name, scenario, changes=changes)
            found = loop.batch(scenario.duration_s, plants, first=JUDGED_NOISE).metrics
        rows.append([found[metric].ravel() for metric in Judged._fields])
    return Judged(*np.moveaxis(np.array(rows), 1, 0))


def less(lab: Lab, law: str, other: str) -> Interval:
    """Mean RMS deviation of a law less that of another, paired by material, deg; interval of 95 %."""
    a, b = (judged(lab, name).rms_error.mean(axis=0) for name in (law, other))
    fine = np.zeros(a.size, dtype=bool)
    return paired(law, other, a, b, fine, fine, SEED).difference


if __name__ == "__main__":
    from leadscrew.resolve import study

    write(Lab(study("sofnn_tangent")))
