"""Controllers tuned with the same effort: what is left of the network's lead when everything is tuned alike.

Every law of :data:`LAWS` is searched by CMA-ES in the logarithm of its parameters, from the middle of its box, with
:data:`BUDGET` evaluations and :data:`SEARCHES` seeds of the search. The cost is the RMS deviation in fabric, mean of
the three lines under two textures and noises that are the same for every candidate (:data:`TUNED_ON`). The setting with
the smallest cost of a law's searches is judged on all nine cells, on textures and noises that no search has seen.

The ranges are so wide that none holds a law back: no search ends at one, but where a filter is a small part of a period
and so none (:func:`at_ends`). A small ``k_e`` with a large ``kg`` is the same loop gain on fewer rules: both are wide.

What was found is kept in ``data/tuning.csv``; :func:`found_anew` finds it again.
"""

from __future__ import annotations

import csv
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.controllers.pid import pid
from leadscrew.controllers.sofnn import ACCUMULATE, STORED, fnn, sofc, sofnn
from leadscrew.controllers.tangent.tangent_dob import tangent_dob
from leadscrew.kernel.block import Block
from leadscrew.neural.performance import NETWORK
from leadscrew.studies.sofnn_tangent.scenarios import LINES, MAX_OFFSET_DEG

if TYPE_CHECKING:
    from leadscrew.studies.lab import Lab

BUDGET = 1000
"""Evaluations of a search."""
SEARCHES = (1, 2, 3)
"""Seeds of the search."""
TUNED_ON = 1
"""Seed of the runs of the search; :data:`RUNS` of them a line."""
RUNS = 2
LOST_DEG = 1e3
"""Cost of a setting that diverges."""
FILE = Path(__file__).parent / "data" / "tuning.csv"

Box = dict[str, tuple[float, float]]


class Law(NamedTuple):
    """A controller and what the search may change, with the ends of each range."""

    block: Block
    box: Box
    words: str


RULES: Box = {"k_e": (2e-4, 2.0), "k_ec": (2e-4, 20.0), "filter_s": (1e-4, 0.5)}
LEARNED: Box = RULES | {"kg": (0.05, 1000.0)}
WALKED: Box = LEARNED | {"q": (1e-6, 10.0)}

LAWS: dict[str, Law] = {
    "pid": Law(
        pid(max_output=MAX_OFFSET_DEG),
        {"kp": (0.02, 5.0), "ki": (0.5, 200.0), "kd": (1e-4, 0.2), "filter_s": (0.001, 0.5)},
        "PID",
    ),
    "observer": Law(
        tangent_dob,
        {"plant_gain": (0.3, 3.0), "gain": (0.1, 2.0), "filter_s": (1e-4, 0.5), "delay_s": (0.01, 0.12)},
        "disturbance observer",
    ),
    "fixed": Law(fnn, RULES, "fixed network"),
    "sofc": Law(sofc, LEARNED, "self-organising, table corrects the rules"),
    "sofnn": Law(sofnn(target=ACCUMULATE), WALKED, "SOFNN, accumulate, table"),
    "paper": Law(sofnn(target=STORED, source=NETWORK), WALKED, "SOFNN as in the paper"),
}
"""By name."""


@dataclass(frozen=True)
class Tuned:
    """What one search found."""

    law: str
    search: int
    cost: float
    """Mean RMS deviation of the six runs of the search, deg."""
    values: Mapping[str, float]

    def block(self) -> Block:
        """The controller with these values."""
        return LAWS[self.law].block(**self.values)


def at_ends(found: Tuned, share: float = 0.02) -> list[str]:
    """Parameters that lie within ``share`` of their range (in the logarithm) at one of its ends."""
    ends = []
    for key, (low, high) in LAWS[found.law].box.items():
        place = np.log(found.values[key] / low) / np.log(high / low)
        if min(place, 1.0 - place) < share:
            ends.append(key)
    return ends


def spread(points: np.ndarray, box: Box) -> dict[str, np.ndarray]:
    """Points of the unit cube as values, a column a parameter; even in the logarithm."""
    ends = np.array(list(box.values())).T
    low, high = np.log(ends)
    return dict(zip(box, np.clip(np.exp(low + (high - low) * points), *ends).T, strict=True))


def costs(lab: Lab, law: str, values: Mapping[str, np.ndarray]) -> np.ndarray:
    """Mean RMS deviation of each setting, deg; all meet the same textures and noises.

    Run by run: in a batch every run has a noise of its own.
    """
    from leadscrew.kernel.loop import DivergenceWarning

    count = len(next(iter(values.values())))
    found = np.zeros(count)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DivergenceWarning)
        for line in LINES:
            scenario = lab.study.scenario(f"{line}_fabric")
            loop = lab.loop(LAWS[law].block, scenario).using(seed=TUNED_ON)
            for n in range(count):
                asked = loop.using({f"controller.{key}": float(column[n]) for key, column in values.items()})
                for k in range(RUNS):
                    rms = asked.run(scenario.duration_s, record=(), every=0, run=k).metrics["rms_error"]
                    found[n] += (rms if np.isfinite(rms) else LOST_DEG) / (RUNS * len(LINES))
    return found


def found_anew(lab: Lab, law: str, search: int, budget: int = BUDGET) -> Tuned:
    """One search: the same law, seed and budget find the same setting."""
    from leadscrew.tune.optimisers import OPTIMISERS, Answer, Search

    box = LAWS[law].box
    best = (np.inf, np.zeros(len(box)))

    def evaluate(points: np.ndarray) -> Answer:
        nonlocal best
        columns = spread(points, box)
        found = costs(lab, law, columns)
        at = int(np.argmin(found))
        if found[at] < best[0]:
            best = float(found[at]), np.array([column[at] for column in columns.values()])
        return Answer(found[:, None], np.zeros((len(points), 0)))

    OPTIMISERS["cma"][0](Search(evaluate, np.full(len(box), 0.5), budget, search))
    return Tuned(law, search, best[0], {key: float(f"{x:.6g}") for key, x in zip(box, best[1], strict=True)})


def as_row(found: Tuned) -> dict[str, Any]:
    """A search as the file has it."""
    values = " ".join(f"{key}={x:.6g}" for key, x in found.values.items())
    return {"law": found.law, "search": found.search, "cost": f"{found.cost:.6g}", "values": values}


def of_row(cells: Mapping[str, str]) -> Tuned:
    """A row of the file."""
    pairs = (pair.split("=") for pair in cells["values"].split())
    return Tuned(cells["law"], int(cells["search"]), float(cells["cost"]), {key: float(x) for key, x in pairs})


def write(found: list[Tuned], file: Path = FILE) -> None:
    """Writes the searches to a file."""
    with file.open("w", newline="", encoding="utf-8") as out:
        rows = csv.DictWriter(out, ["law", "search", "cost", "values"], lineterminator="\n")
        rows.writeheader()
        rows.writerows(as_row(each) for each in found)


def kept() -> tuple[Tuned, ...]:
    """What the searches found, as kept."""
    with FILE.open(newline="", encoding="utf-8") as file:
        return tuple(of_row(cells) for cells in csv.DictReader(file))


def best(law: str) -> Tuned:
    """The setting of a law with the smallest cost in the search."""
    return min((each for each in kept() if each.law == law), key=lambda each: each.cost)
