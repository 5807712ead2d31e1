"""A genetic algorithm on rows of real numbers.

A generation: the ``elite`` best stay. Every other place is filled by a child of two parents, each the best of
``tournament`` drawn at random. With probability ``crossing`` each of its numbers is uniform between those of its
parents, widened by ``blend`` of their distance to either side (BLX-alpha: L. J. Eshelman, J. D. Schaffer, *Real-coded
genetic algorithms and interval-schemata*, Foundations of Genetic Algorithms 2, 1993); otherwise the child is the first
parent. Each number then changes with probability ``2 / n`` by a normal draw whose ``sigma`` falls geometrically from
the first generation to the last. Numbers are held to ``-bound .. bound``; the first are uniform in ``-start .. start``.

The paper of the study ``sofnn_tangent`` says "genetic algorithm" and no more: the operators are a
reconstruction.

CMA-ES and pymoo's genetic algorithm may stand in for it: all take the cost of many rows at once and give back a
:class:`Found`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.util.errors import EngineError, ValueRefused

Cost = Callable[[np.ndarray], np.ndarray]
"""From rows ``(n, weights)`` to their costs ``(n,)``; smaller is better."""
Report = Callable[[int, int], None]
"""Takes what is done and what there is in all."""


@dataclass(frozen=True)
class Genetic:
    """Settings.

    Raises:
        ValueRefused: a population of less than 4, no generation, no elite or more than half the population.
    """

    population: int = 80
    generations: int = 600
    tournament: int = 3
    crossing: float = 0.9
    blend: float = 0.3
    sigma_first: float = 0.8
    sigma_last: float = 0.02
    elite: int = 2
    bound: float = 8.0
    start: float = 2.0

    def __post_init__(self) -> None:
        if not 4 <= self.population <= 100_000:
            raise ValueRefused(f"population = {self.population!r} (genetic algorithm): expected 4 to 100000")
        if not 1 <= self.generations <= 1_000_000:
            raise ValueRefused(f"generations = {self.generations!r} (genetic algorithm): expected 1 to 1000000")
        if not 1 <= self.elite <= self.population // 2:
            raise ValueRefused(f"elite = {self.elite!r} (genetic algorithm): expected 1 to half the population")


@dataclass(frozen=True)
class Found:
    """The best row that a search saw, and how it came there."""

    best: np.ndarray
    cost: float
    history: np.ndarray
    """Best cost so far after every generation; the first is that of the first population."""
    evaluations: int


def evolve(cost: Cost, n: int, settings: Genetic | None = None, seed: int = 0, report: Report | None = None) -> Found:
    """The best of ``n`` numbers that the genetic algorithm finds."""
    how = settings or Genetic()
    draw = np.random.default_rng(seed)
    rows = draw.uniform(-how.start, how.start, (how.population, n))
    costs = cost(rows)
    history = np.empty(how.generations + 1)
    history[0] = costs.min()
    rate = (how.sigma_last / how.sigma_first) ** (1.0 / max(how.generations - 1, 1))
    children = how.population - how.elite
    for g in range(how.generations):
        best = np.argsort(costs, kind="stable")[: how.elite]
        rivals = draw.integers(how.population, size=(2, children, how.tournament))
        won = np.take_along_axis(rivals, np.argmin(costs[rivals], axis=2)[:, :, None], axis=2)[:, :, 0]
        first, second = rows[won[0]], rows[won[1]]
        low, high = np.minimum(first, second), np.maximum(first, second)
        reach = how.blend * (high - low)
        mixed = draw.uniform(size=first.shape) * (high - low + 2.0 * reach) + low - reach
        child = np.where(draw.uniform(size=(children, 1)) < how.crossing, mixed, first)
        sigma = how.sigma_first * rate**g
        change = draw.normal(0.0, sigma, child.shape) * (draw.uniform(size=child.shape) < 2.0 / n)
        child = np.clip(child + change, -how.bound, how.bound)
        rows = np.concatenate([rows[best], child])
        costs = np.concatenate([costs[best], cost(child)])
        history[g + 1] = costs.min()
        if report is not None:
            report(g + 1, how.generations)
    at = int(np.argmin(costs))
    evaluations = how.population + how.generations * children
    return Found(rows[at].copy(), float(costs[at]), history, evaluations)


CMA_POPULATION = 32
CMA_EVALUATIONS = 48_000


def cma_search(
    cost: Cost,
    n: int,
    seed: int = 0,
    population: int = CMA_POPULATION,
    evaluations: int = CMA_EVALUATIONS,
    bound: float = 15.0,
    report: Report | None = None,
) -> Found:
    """The best of ``n`` numbers that CMA-ES finds (N. Hansen's ``cma``), from a normal draw around 0.

    It starts again from another draw where it has come to rest before its evaluations are spent.
    """
    import cma

    draw = np.random.default_rng(seed)
    best, least, used, history = np.zeros(n), np.inf, 0, []
    while used + population <= evaluations:
        options: dict[str, Any] = {
            "popsize": population, "seed": int(draw.integers(1, 2**31)), "bounds": [-bound, bound], "verbose": -9,
            "maxfevals": evaluations - used,
        }  # fmt: skip
        search = cma.CMAEvolutionStrategy(draw.normal(0.0, 1.0, n), 1.0, options)
        while not search.stop() and used + population <= evaluations:
            rows = search.ask()
            costs = cost(np.array(rows))
            search.tell(rows, costs.tolist())
            used += population
            at = int(np.argmin(costs))
            if costs[at] < least:
                best, least = np.array(rows[at]), float(costs[at])
            history.append(least)
            if report is not None:
                report(min(used, evaluations), evaluations)
    return Found(best, least, np.array(history), used)


def pymoo_search(
    cost: Cost,
    n: int,
    seed: int = 0,
    population: int = 80,
    generations: int = 600,
    bound: float = 8.0,
    start: float = 2.0,
    report: Report | None = None,
) -> Found:
    """The best of ``n`` numbers that pymoo's genetic algorithm finds: SBX crossing (eta 10), polynomial mutation (15).

    Raises:
        EngineError: pymoo is not installed.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            from pymoo.algorithms.soo.nonconvex.ga import GA
            from pymoo.core.problem import Problem
            from pymoo.operators.crossover.sbx import SBX
            from pymoo.operators.mutation.pm import PM
            from pymoo.termination import get_termination
    except ImportError:
        raise EngineError(
            'pymoo is not installed: pip install "leadscrew[tune]", or use our genetic algorithm'
        ) from None

    class Weights(Problem):
        def __init__(self) -> None:
            super().__init__(n_var=n, n_obj=1, xl=-bound, xu=bound)

        def _evaluate(self, x: Any, out: Any, *args: Any, **kwargs: Any) -> None:
            out["F"] = cost(np.asarray(x))[:, None]

    first = np.random.default_rng(seed).uniform(-start, start, (population, n))
    search = GA(pop_size=population, sampling=first, crossover=SBX(eta=10), mutation=PM(eta=15))
    search.setup(Weights(), termination=get_termination("n_gen", generations), seed=seed, verbose=False)
    history = []
    while search.has_next():
        search.next()
        history.append(float(search.opt.get("F")[0, 0]))
        if report is not None:
            report(len(history), generations)
    found = search.result()
    return Found(np.array(found.X, float), float(found.F[0]), np.array(history), int(search.evaluator.n_eval))
