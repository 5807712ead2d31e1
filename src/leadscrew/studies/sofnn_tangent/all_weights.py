"""All groups of weights of the inference network learn in the loop, as the paper says: v_ok, v_kj and v_ji.

``v_ok`` are the 49 consequents, ``v_kj`` become 49 certainties, ``v_ji`` ten centres of the sets. What is gained is
kept in ``data/all_weights.csv``; :func:`write` makes it again.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.controllers._sofnn.network import sofnn_all_weights
from leadscrew.studies.lab import measure
from leadscrew.studies.sofnn_tangent.cuts import along_the_line, in_material, rms, rules
from leadscrew.studies.sofnn_tangent.scenarios import LINES, MATERIAL_NAMES, samples_of

if TYPE_CHECKING:
    from leadscrew.studies.lab import Lab

LITERAL: dict[str, Any] = {"source": "network", "delay": 4, "leak": 0.0, "freeze": False}
"""The paper's scales and performance network, m_c = m, no safeguard that the paper does not have."""
TUNED: dict[str, Any] = {"k_e": 6.0 / 45.0, "target": "accumulate", "kg": 0.7}
TEXTURES = 5
FILE = Path(__file__).parent / "data" / "all_weights.csv"
VARIANTS: Mapping[str, Mapping[str, float]] = {
    "literal": LITERAL,
    "literal, centres 1e-4": LITERAL | {"q_centre": 1e-4},
    "literal, centres 0.01": LITERAL | {"q_centre": 0.01},
    "literal, certainties 0.01": LITERAL | {"q_certainty": 0.01},
    "literal, both 0.01": LITERAL | {"q_certainty": 0.01, "q_centre": 0.01},
    "tuned": TUNED,
    "tuned, centres 0.01": TUNED | {"q_centre": 0.01},
}
"""Which groups learn beside the consequents, and the variance of their random walk a sample."""


def all_weights_rms(lab: Lab, values: Mapping[str, float]) -> np.ndarray:
    """RMS deviation of the nine cells, deg ``[line, material]``, mean of five textures, the controllers' own."""

    def cell(line: str, material: str) -> float:
        changes = in_material(material) | {f"controller.{k}": v for k, v in values.items()}
        cuts = [along_the_line(lab, sofnn_all_weights, f"{line}_fabric", k, changes) for k in range(TEXTURES)]
        return float(np.mean([rms(e) for e in cuts]))

    return np.array([[cell(line, material) for material in MATERIAL_NAMES] for line in LINES])


def write(lab: Lab, path: Path = FILE) -> None:
    """Makes the table of all variants again: ten seconds."""
    lines = ["variant,line,material,rms_deg"]
    for name, values in VARIANTS.items():
        found = all_weights_rms(lab, values)
        lines += [
            f'"{name}",{line},{material},{found[i, j]:.9g}'
            for i, line in enumerate(LINES)
            for j, material in enumerate(MATERIAL_NAMES)
        ]
    path.write_text("\n".join(lines) + "\n")


def kept() -> dict[str, np.ndarray]:
    """RMS of the nine cells by variant, deg, as kept."""
    with FILE.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {
        name: np.array([float(row["rms_deg"]) for row in rows if row["variant"] == name]).reshape(len(LINES), -1)
        for name in VARIANTS
    }


@measure
def wandering_centres(lab: Lab, material: str, every: int = 5) -> np.ndarray:
    """The seven centres of E along the wave, levels, a row every few samples; walk of 0.01, the paper's loop."""
    changes = in_material(material) | {f"controller.{k}": v for k, v in (LITERAL | {"q_centre": 0.01}).items()}
    live = lab.loop(sofnn_all_weights, "wave_fabric").using(changes).start()
    rows = [rules(live).centres_e]
    for _ in range(samples_of("wave") // every):
        live.advance(every, every=0)
        rows.append(rules(live).centres_e)
    return np.array(rows)
