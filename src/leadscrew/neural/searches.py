"""Searches that may stand in for the genetic algorithm of :mod:`leadscrew.neural.genetic`: CMA-ES, and pymoo's.

Both take the cost of many rows at once and give back a :class:`leadscrew.neural.genetic.Found`.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from leadscrew.kernel.errors import EngineError
from leadscrew.neural.genetic import Cost, Found, Report

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
