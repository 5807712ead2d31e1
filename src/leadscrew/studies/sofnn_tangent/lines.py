"""The lines that are cut, sampled at the feed: one value a control period."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from leadscrew.paths.path import Path, Sampled

PERIOD_S = 0.01
"""Control period."""

FEED = 50.0
"""Programmed feed, mm/s."""

LENGTHS_MM = {"wave": 461.541, "flower": 394.960, "rrect": 454.248}
"""The lines of the digest, and how long they are; the paper's own (Figure 5) is a picture only."""

LAPS = {"wave": 1.0, "flower": 1.0, "rrect": 1.5}
"""How often each is gone along."""

MATERIAL_NAMES = ("fabric", "leather", "foam")


def shape(name: str) -> Path:
    """The line itself."""
    from leadscrew.paths import shapes

    makers = {"wave": shapes.wave, "flower": shapes.flower, "rrect": shapes.rounded_rectangle}
    return makers[name]()


@lru_cache
def line(name: str, feed: float = FEED) -> Sampled:
    """The line, sampled at ``feed`` times the control period."""
    from leadscrew.paths.path import sampled

    return sampled(shape(name), feed * PERIOD_S, LAPS[name])


@lru_cache
def lap(name: str, feed: float = FEED) -> Sampled:
    """One lap of a closed line in a whole number of samples: they stand a little closer than ``feed`` says."""
    from leadscrew.paths.path import sampled

    return sampled(shape(name), feed * PERIOD_S, 1, whole=True)


def line_of(scenario: str) -> str:
    """Name of the line of a scenario: its first word; ``straight`` where it is none of them."""
    first = scenario.split("_")[0]
    return first if first in LAPS else "straight"


def values_of(scenario: str, feed: float = FEED) -> dict[str, Any]:
    """Parameters of ``cut_line`` and ``cut_load`` for the line of a scenario."""
    from leadscrew.references.cut_line import tables

    name = line_of(scenario)
    if name == "straight":
        return tables(np.zeros(1), np.zeros(1))
    if scenario.endswith("_laps"):
        once = lap(name, feed)
        return tables(once.heading, once.curvature) | {"again": True, "turn": float(once.turn)}
    found = line(name, feed)
    return dict(tables(found.heading, found.curvature))


def samples_of(scenario: str, feed: float = FEED) -> int:
    """Samples of the line of a scenario; the last place is held for one more. 0 of a straight one."""
    name = line_of(scenario)
    return 0 if name == "straight" else int(LENGTHS_MM[name] / (feed * PERIOD_S)) + 1
