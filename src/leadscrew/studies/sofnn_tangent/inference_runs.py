"""All groups of weights of the inference network learn in the loop: what is gained, and where their centres go.

What is gained is kept in ``data/all_weights.csv``; :func:`write_groups` makes it again.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from leadscrew.controllers.sofnn.all_weights import sofnn_all_weights
from leadscrew.neural.groups import full_covariance
from leadscrew.neural.performance import NETWORK
from leadscrew.studies.sofnn_tangent.lines import LAPS, MATERIAL_NAMES
from leadscrew.studies.sofnn_tangent.online import deviations, in_material, rms, rules, to_the_end
from leadscrew.studies.sofnn_tangent.runs import Loops

LITERAL: dict[str, float] = {"source": NETWORK, "delay": 4, "leak": 0.0, "freeze": False}
"""The paper's scales and performance network, m_c = m, no safeguard that the paper does not have."""
TUNED: dict[str, float] = {"k_e": 6.0 / 45.0, "target": 1, "kg": 0.7}
TEXTURES = 5
GROUPS_CSV = Path(__file__).parent / "data" / "all_weights.csv"
VARIANTS: Mapping[str, Mapping[str, float]] = {
    "literal": LITERAL,
    "literal, centres 1e-4": LITERAL | {"q_centre": 1e-4},
    "literal, centres 0.01": LITERAL | {"q_centre": 0.01},
    "literal, certainties 0.01": LITERAL | {"q_certainty": 0.01},
    "literal, both 0.01": LITERAL | {"q_certainty": 0.01, "q_centre": 0.01},
    "tuned": TUNED,
    "tuned, centres 0.01": TUNED | {"q_centre": 0.01},
}
"""Which groups learn, and how far they walk."""


def all_weights_rms(loops: Loops, values: Mapping[str, float]) -> np.ndarray:
    """RMS deviation of the nine cells, deg ``[line, material]``, mean of five textures, the controllers' own."""
    return np.array([[_cell(loops, line, material, values) for material in MATERIAL_NAMES] for line in LAPS])


def _cell(loops: Loops, line: str, material: str, values: Mapping[str, float]) -> float:
    scenario = f"{line}_fabric"
    changes = in_material(material) | {f"controller.{k}": v for k, v in values.items()}
    loop = loops.get(sofnn_all_weights, scenario).using(changes)
    return float(np.mean([rms(to_the_end(loops, loop.start(run=k), scenario)) for k in range(TEXTURES)]))


def write_groups(path: Path = GROUPS_CSV) -> None:
    """Makes the table of all variants again: ten seconds."""
    loops = Loops()
    lines = ["variant,line,material,rms_deg"]
    for name, values in VARIANTS.items():
        found = all_weights_rms(loops, values)
        lines += [
            f'"{name}",{line},{material},{found[i, j]:.9g}'
            for i, line in enumerate(LAPS)
            for j, material in enumerate(MATERIAL_NAMES)
        ]
    path.write_text("\n".join(lines) + "\n")


@cache
def groups_kept() -> Mapping[str, np.ndarray]:
    """RMS of the nine cells by variant, as kept."""
    with GROUPS_CSV.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {
        name: np.array([float(row["rms_deg"]) for row in rows if row["variant"] == name]).reshape(len(LAPS), -1)
        for name in VARIANTS
    }


class Centres(NamedTuple):
    """The centres of E on the way."""

    travel_mm: np.ndarray
    centres: np.ndarray
    """``[place, 7]``, levels."""


def centres_on_the_way(
    loops: Loops, scenario: str, material: str, values: Mapping[str, float], every: int = 5
) -> Centres:
    """The centres of E along a scenario, in a material; one row every few samples."""
    changes = in_material(material) | {f"controller.{k}": v for k, v in values.items()}
    loop = loops.get(sofnn_all_weights, scenario).using(changes)
    live = loop.start()
    rows = [rules(live).centres_e]
    for _ in range(loop.periods(loops.scenarios[scenario].duration_s) // every):
        live.advance(every, every=0)
        rows.append(rules(live).centres_e)
    travel = 50.0 * 0.01 * every * np.arange(len(rows))
    return Centres(travel, np.array(rows))


class Laps(NamedTuple):
    """Lap after lap of the flower."""

    rms: np.ndarray
    """deg"""
    trace: np.ndarray
    """Of the covariance of the consequents after each lap, levels squared."""


def laps_with(loops: Loops, values: Mapping[str, float], laps: int = 20, samples: int = 790) -> Laps:
    """RMS deviation and trace of the covariance, lap by lap."""
    live = loops.get(sofnn_all_weights, "flower_laps").using({f"controller.{k}": v for k, v in values.items()}).start()
    found = []
    for _ in range(laps):
        e = deviations(live, samples - 1)
        found.append((rms(e), float(np.trace(full_covariance(rules(live).covariance)[:49, :49]))))
    return Laps(*np.array(found).T)
