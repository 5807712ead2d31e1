"""Trainings of the performance network: many seeds, methods and readings, kept as small CSV files.

``data/performance_trainings.csv`` has a row a training, ``data/performance_nets.csv`` the networks that the closed loop
is tried with, ``data/performance_histories.csv`` how the RMSE falls. :func:`remake` makes them again, in some
minutes; a slow test compares a part.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from leadscrew.neural.genetic import Genetic, evolve
from leadscrew.neural.performance import READINGS, TABLE, Loss, Performance, Shape, measured, polish, rmse_of
from leadscrew.neural.safety import safety
from leadscrew.neural.training import train

DATA = Path(__file__).parent / "data"
TRAININGS = DATA / "performance_trainings.csv"
NETS = DATA / "performance_nets.csv"
HISTORIES = DATA / "performance_histories.csv"
ACCEPTED = "accepted"
"""Name of the network that training gives out: genetic algorithm, polish and safety test, 18 weights, seed 0."""
NAMES = {
    "min_rmse": "the 18 weights of the smallest RMSE, which have the wrong slope",
    "biased_up": "25 weights with P(0, 0) above 0",
    "biased_down": "25 weights with P(0, 0) below 0",
    "biased_bad_slope": "25 weights with P(0, 0) off 0 and the wrong slope",
}
"""The unsafe networks, in words; see :func:`chosen`."""
SIZES = (6, 10, 12, 20, 30, 40)
"""Hidden neurons of the networks of several sizes, all with biases."""
QUARTER = 0.25
"""Step of the difference quotient ``quarter``, levels."""
COLUMNS = (
    "reading", "method", "seed", "rmse", "largest", "exact", "within_one", "slope", "quarter", "origin", "most_weight",
)  # fmt: skip


@dataclass(frozen=True)
class Row:
    """One training; levels."""

    reading: str
    method: str
    seed: int
    rmse: float
    largest: float
    exact: float
    within_one: float
    slope: float
    """``dP/dE`` at the origin."""
    quarter: float
    """The same as a difference quotient between ``E = -0.25`` and ``0.25``."""
    origin: float
    most_weight: float
    """Largest weight in size."""


def shape_named(reading: str) -> Shape:
    """A reading of the weight count, or ``hidden_N``: N hidden neurons with all biases."""
    return Shape(int(reading.split("_")[1]), "all") if reading.startswith("hidden_") else READINGS[reading]


def start(shape: Shape, seed: int) -> np.ndarray:
    """Where least squares starts: uniform in -2 .. 2."""
    return np.random.default_rng(seed).uniform(-2.0, 2.0, shape.weights)


def free_least_squares(shape: Shape, seed: int) -> np.ndarray:
    """Levenberg-Marquardt (SciPy) with neither ridge nor box."""
    from scipy.optimize import least_squares

    loss = Loss(shape, TABLE, safe=False, ridge=0.0)
    row = start(shape, seed)
    return np.asarray(least_squares(loss.residuals, row, jac=loss.jacobian, method="lm", max_nfev=2000).x)


def trained(reading: str, method: str, seed: int) -> np.ndarray:
    """The weights that a method finds, no matter whether they are safe.

    ``ga_16x200``, ``ga_80x600``, ``ga_80x2000`` (population x generations), ``pymoo_80x600``, ``cma_48k``, ``lm``
    (least squares from one start), ``lm_free`` (without ridge and box), ``ga+lm`` (least squares after ``ga_80x600``).
    """
    from leadscrew.neural.genetic import cma_search, pymoo_search

    shape = shape_named(reading)
    n, cost = shape.weights, rmse_of(shape, TABLE)
    if method == "lm":
        return polish(start(shape, seed), Loss(shape, TABLE, safe=False), most=400)
    if method == "lm_free":
        return free_least_squares(shape, seed)
    if method == "ga+lm":
        return polish(trained(reading, "ga_80x600", seed), Loss(shape, TABLE, safe=False), most=400)
    if method == "cma_48k":
        return cma_search(cost, n, seed).best
    population, generations = (int(part) for part in method.split("_")[1].split("x"))
    if method.startswith("pymoo"):
        return pymoo_search(cost, n, seed, population, generations).best
    return evolve(cost, n, Genetic(population, generations), seed).best


def row_of(reading: str, method: str, seed: int, weights: np.ndarray) -> Row:
    """What is kept of a training."""
    shape = shape_named(reading)
    found = safety(shape.net(weights))
    rmse = float(rmse_of(shape, TABLE)(weights[None])[0])
    below, above = (measured(shape.net(weights), e, 0.0) for e in (-QUARTER, QUARTER))
    return Row(reading, method, seed, rmse, found.largest, found.exact, found.within_one, found.slope,
               (above - below) / (2.0 * QUARTER), found.origin, float(np.abs(weights).max()))  # fmt: skip


def plan() -> Iterator[tuple[str, str, int]]:
    """Reading, method and seed of every training."""
    main = ("18_linear", "18", "25", "16_four_hidden")
    seeds = {"ga_16x200": 20, "ga_80x600": 12, "ga+lm": 12, "lm": 40}
    for method, count in seeds.items():
        for reading in main:
            more = {"ga_80x600": 36, "ga+lm": 36, "lm": 60}.get(method, count) if reading == "18" else count
            yield from ((reading, method, seed) for seed in range(more))
    for method, count in {"cma_48k": 5, "pymoo_80x600": 5, "ga_80x2000": 4}.items():
        for reading in main[:3]:
            yield from ((reading, method, seed) for seed in range(count))
    yield from (("18", "lm_free", seed) for seed in range(20))
    for reading in ("19", "24", "16_five_hidden"):
        yield from ((reading, "lm", seed) for seed in range(20))
    for size in SIZES:
        yield from ((f"hidden_{size}", "lm", seed) for seed in range(10))


def chosen(rows: list[Row]) -> dict[str, Row]:
    """The networks for the closed loop, by name; each is the one of its kind with the smallest RMSE.

    ``min_rmse``: of 18 weights. Of 25 weights:
    ``biased_up`` and ``biased_down`` with ``P(0, 0)`` of 0.1 to 0.3, -0.3 to -0.1 and a slope of -1.5 to -0.4, and
    ``biased_bad_slope`` with ``|P(0, 0)|`` of 0.1 or more and a slope above 0.05.
    """
    kinds: dict[str, tuple[str, Callable[[Row], bool]]] = {
        "min_rmse": ("18", lambda r: True),
        "biased_up": ("25", lambda r: 0.1 <= r.origin <= 0.3 and -1.5 <= r.slope <= -0.4),
        "biased_down": ("25", lambda r: -0.3 <= r.origin <= -0.1 and -1.5 <= r.slope <= -0.4),
        "biased_bad_slope": ("25", lambda r: abs(r.origin) >= 0.1 and r.slope > 0.05),
    }
    found = {}
    for name, (reading, fits) in kinds.items():
        of = [r for r in rows if r.reading == reading and r.method != "lm_free" and fits(r)]
        if of:
            found[name] = min(of, key=lambda r: r.rmse)
    return found


def remake(report: Callable[[int, int], None] | None = None) -> None:
    """Trains all of it again and writes both files."""
    asked = list(plan())
    rows, weights = [], {}
    for k, (reading, method, seed) in enumerate(asked):
        best = trained(reading, method, seed)
        rows.append(row_of(reading, method, seed, best))
        weights[reading, method, seed] = best
        if report is not None:
            report(k + 1, len(asked))
    with TRAININGS.open("w", newline="", encoding="utf-8") as out:
        lines = csv.writer(out, lineterminator="\n")
        lines.writerow(COLUMNS)
        for r in rows:
            numbers = (r.rmse, r.largest, r.exact, r.within_one, r.slope, r.quarter, r.origin, r.most_weight)
            lines.writerow([r.reading, r.method, r.seed, *(f"{v:.6g}" for v in numbers)])
    found = {
        name: (r.reading, r.method, r.seed, weights[r.reading, r.method, r.seed]) for name, r in chosen(rows).items()
    }
    write_nets({**found, ACCEPTED: ("18", "ga+polish", 0, READINGS["18"].row(train(seed=0).net))})
    write_histories()


def write_nets(found: Mapping[str, tuple[str, str, int, np.ndarray]]) -> None:
    """Writes the networks: name, reading, method, seed and weights."""
    with NETS.open("w", newline="", encoding="utf-8") as out:
        lines = csv.writer(out, lineterminator="\n")
        lines.writerow(["name", "reading", "method", "seed", "weights"])
        for name, (reading, method, seed, row) in found.items():
            lines.writerow([name, reading, method, seed, " ".join(f"{w:.9g}" for w in row)])


def write_histories(seeds: int = 3) -> None:
    """Writes how the RMSE falls with the evaluations: 18 weights, the three searches, some seeds each."""
    from leadscrew.neural.genetic import cma_search, pymoo_search

    shape = READINGS["18"]
    n, cost = shape.weights, rmse_of(shape, TABLE)
    with HISTORIES.open("w", newline="", encoding="utf-8") as out:
        lines = csv.writer(out, lineterminator="\n")
        lines.writerow(["method", "seed", "evaluations", "rmse"])
        for method, found in (
            (m, f(s)) for s in range(seeds) for m, f in (
                ("ga", lambda s: (s, evolve(cost, n, Genetic(80, 600), s))),
                ("cma", lambda s: (s, cma_search(cost, n, s))),
                ("pymoo", lambda s: (s, pymoo_search(cost, n, s))),
            )
        ):  # fmt: skip
            seed, search = found
            kept = np.unique(np.geomspace(1, len(search.history), 60).astype(int)) - 1
            each = search.evaluations / len(search.history)
            lines.writerows([method, seed, round(each * (k + 1)), f"{search.history[k]:.5g}"] for k in kept)


def histories() -> dict[tuple[str, int], np.ndarray]:
    """RMSE (second column) after evaluations (first), by method and seed."""
    found: dict[tuple[str, int], list[tuple[float, float]]] = {}
    with HISTORIES.open(newline="", encoding="utf-8") as lines:
        for r in csv.DictReader(lines):
            found.setdefault((r["method"], int(r["seed"])), []).append((float(r["evaluations"]), float(r["rmse"])))
    return {key: np.array(rows) for key, rows in found.items()}


def trainings() -> tuple[Row, ...]:
    """The kept trainings."""
    with TRAININGS.open(newline="", encoding="utf-8") as lines:
        return tuple(
            Row(r["reading"], r["method"], int(r["seed"]), *(float(r[name]) for name in COLUMNS[3:]))
            for r in csv.DictReader(lines)
        )


def nets() -> dict[str, Performance]:
    """The kept networks for the closed loop, by name, see :func:`chosen`."""
    with NETS.open(newline="", encoding="utf-8") as lines:
        return {
            r["name"]: READINGS[r["reading"]].net([float(w) for w in r["weights"].split()])
            for r in csv.DictReader(lines)
        }


def of(reading: str, method: str) -> list[Row]:
    """The kept trainings of one reading by one method."""
    return [r for r in trainings() if r.reading == reading and r.method == method]
