"""Training of a performance network off line: a search, a polish, and the test that it is safe.

    search    a genetic algorithm (:mod:`leadscrew.neural.genetic`), CMA-ES or pymoo's, on the RMSE of the cells
    polish    least squares from there on, with a loss that also asks for the right way between the cells
    test      :mod:`leadscrew.neural.safety`

A network that would drive the loop the wrong way is not given out. It is polished with more and more weight on the
surroundings of the origin, then the search starts again; :attr:`Trained.notes` says what was done, and where nothing
helps training is refused. A network that goes the right way, but knows the table less well than asked, is given out
with a note.

Source: step 1 of the paper of the study ``sofnn_tangent`` ("train PNN off line by a genetic algorithm"); methods,
weights and acceptance are ours.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np

from leadscrew.neural.genetic import Found, Genetic, Report, evolve
from leadscrew.neural.performance import TABLE, Loss, Performance, Shape, polish, rmse_of
from leadscrew.neural.safety import Safety, safety, table_faults
from leadscrew.util.errors import NameUnknown, ValueRefused

Method = Literal["ga", "ga+polish", "cma", "cma+polish", "pymoo", "pymoo+polish"]
METHODS: tuple[Method, ...] = get_args(Method)

NEAR_WEIGHTS = (0.3, 1.0, 3.0)
"""Weight of the surroundings of the origin in the polish, raised until the network is safe."""
TRIES = 8
"""Searches, each from another seed, before training gives up."""


@dataclass(frozen=True)
class Trained:
    """A network, and how it came about."""

    net: Performance
    shape: Shape
    method: Method
    seed: int
    safety: Safety
    searched: Safety
    """Of the network as the search left it, before polish and repair."""
    history: np.ndarray = field(repr=False)
    """Best RMSE (levels) after every generation of the search that led here."""
    tries: int
    """Searches that were made."""
    notes: tuple[str, ...]
    """What was done to make it safe, and what it falls short of; a sentence each."""
    wall_s: float

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data without the network, for JSON."""
        return {
            "method": self.method,
            "seed": self.seed,
            "network": self.shape.name,
            "weights": self.shape.weights,
            "searched_rmse": self.searched.rmse,
            "tries": self.tries,
            "notes": list(self.notes),
            "wall_s": self.wall_s,
            "safety": self.safety.as_dict(),
        }


def seed_of(seed: int, again: int) -> int:
    """The seed of the search after ``again`` failed ones: the seed itself, then seeds drawn from it."""
    return seed if again == 0 else int(np.random.SeedSequence([seed, again]).generate_state(1)[0])


def search(
    method: str, shape: Shape, table: np.ndarray, seed: int, population: int, generations: int,
    report: Report | None = None,
) -> Found:  # fmt: skip
    """The search of a method alone; CMA-ES gets ``population * generations`` evaluations in populations of 32."""
    cost = rmse_of(shape, table)
    kind = method.split("+")[0]
    if kind == "ga":
        return evolve(cost, shape.weights, Genetic(population, generations), seed, report)
    from leadscrew.neural.genetic import cma_search, pymoo_search

    if kind == "cma":
        return cma_search(cost, shape.weights, seed, evaluations=population * generations, report=report)
    return pymoo_search(cost, shape.weights, seed, population, generations, report=report)


def train(
    table: np.ndarray = TABLE,
    shape: Shape | None = None,
    method: Method = "ga+polish",
    seed: int = 0,
    population: int = 80,
    generations: int = 600,
    tries: int = TRIES,
    report: Report | None = None,
) -> Trained:
    """A performance network for a 13 x 13 table that drives a learning loop the right way.

    ``report`` takes generations done and all of one search.

    Raises:
        NameUnknown: no such method.
        ValueRefused: a table that is not 13 x 13, or drives the wrong way itself; settings out of range; no network
            that goes the right way was found.
        EngineError: pymoo was asked for and is not installed.
    """
    if method not in METHODS:
        raise NameUnknown(f"no method {method!r} of training; there are {', '.join(METHODS)}")
    if tries < 1:
        raise ValueRefused(f"tries = {tries!r} (training): expected 1 or more")
    if seed < 0:
        raise ValueRefused(f"seed = {seed!r} (training): expected 0 or more")
    Genetic(population, generations)
    faults = table_faults(table)
    if faults:
        raise ValueRefused(f"the table cannot be trained: {faults[0]}")
    shape = shape or Shape()
    began = time.perf_counter()
    best: _Candidate | None = None
    for again in range(tries):
        found = search(method, shape, table, seed_of(seed, again), population, generations, report)
        raw = safety(shape.net(found.best), table)
        if "+" not in method and raw.right_way:
            best = _Candidate(shape.net(found.best), raw, found, raw, again, 0.0)
            break
        for weight in NEAR_WEIGHTS:
            net = shape.net(polish(found.best, Loss(shape, table, True, near_weight=weight)))
            made = safety(net, table)
            if made.right_way and (best is None or made.rmse < best.safety.rmse):
                best = _Candidate(net, made, found, raw, again, weight)
            if made.accepted:
                break
        if best is not None and best.safety.accepted:
            break
    if best is None:
        raise ValueRefused(
            f"no safe network found: {shape.name}, {tries} searches by {method}, the last one with "
            f"{made.failures()[0]}; try another seed, more generations or no biases"
        )
    return Trained(best.net, shape, method, seed, best.safety, best.searched, best.found.history, again + 1,
                   tuple(best.notes("+" in method)), time.perf_counter() - began)  # fmt: skip


@dataclass(frozen=True)
class _Candidate:
    """A network that goes the right way, and from where it comes."""

    net: Performance
    safety: Safety
    found: Found
    searched: Safety
    again: int
    weight: float
    """Of the surroundings of the origin in its polish; 0 where it is as the search left it."""

    def notes(self, polished: bool) -> list[str]:
        """What was done to it, and what it falls short of."""
        texts = []
        if self.again:
            texts.append(f"search {self.again + 1} from another seed: what came before was unsafe or less exact")
        if self.weight and not polished:
            texts.append(f"repaired: the search left {self.searched.failures()[0]}; polished with a safe loss")
        if self.weight > NEAR_WEIGHTS[0]:
            texts.append(f"the surroundings of the origin had to count {self.weight:g} in place of {NEAR_WEIGHTS[0]:g}")
        return texts + [f"not met: {text}" for text in self.safety.failures()]
