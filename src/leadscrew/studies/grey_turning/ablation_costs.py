"""The ablation under other costs: does the sign of what a predictor is worth hang on how a cut is priced?

The searches of :mod:`~leadscrew.studies.grey_turning.ablation`, with the same effort and the same noise, for the TFC,
the grey model and the line through two samples, under three more costs. What they found is kept in
``data/ablation_costs.csv``; judged is, for each cost, plant and variant, the search that ended lowest on the noise that
it was tuned on, under the same held-out noise.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from weakref import WeakKeyDictionary

from leadscrew.studies.grey_turning.ablation import COST, Cost, Judgement, Tuned, judgement, row_of
from leadscrew.studies.grey_turning.runs import Loops

COSTS: dict[str, Cost] = {
    "short": COST._replace(horizon_s=1.5),
    "long": COST._replace(horizon_s=3.0),
    "overshoot": COST._replace(penalty=10.0 * COST.penalty),
}
"""A shorter cut, a longer one, and ten times the penalty on overshoot."""
VARIANTS = ("tfc", "gpfc_b", "two_point")
FILE = Path(__file__).parent / "data" / "ablation_costs.csv"

Found = Mapping[str, Mapping[tuple[str, str], Judgement]]


@lru_cache(maxsize=1)
def tuned_for() -> Mapping[str, tuple[Tuned, ...]]:
    """What the searches found under each cost, as kept."""
    with FILE.open(newline="", encoding="utf-8") as file:
        rows = [(cells["under"], row_of(cells)) for cells in csv.DictReader(file)]
    return {name: tuple(row for under, row in rows if under == name) for name in COSTS}


def best_for(name: str) -> tuple[Tuned, ...]:
    """Of each plant and variant the search that ended lowest under a cost."""
    best: dict[tuple[str, str], Tuned] = {}
    for row in tuned_for()[name]:
        key = row.plant, row.name
        best[key] = min(best.get(key, row), row, key=lambda each: each.cost)
    return tuple(best.values())


_MADE: WeakKeyDictionary[Loops, Found] = WeakKeyDictionary()


def costs_judged(loops: Loops) -> Found:
    """Judgements by cost, plant and variant, made once for some loops."""
    if loops not in _MADE:
        _MADE[loops] = {name: judgement(loops, best_for(name), cost) for name, cost in COSTS.items()}
    return _MADE[loops]
