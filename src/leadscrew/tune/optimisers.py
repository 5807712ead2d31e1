"""Searches in the unit cube: CMA-ES, differential evolution, NSGA-II; each from a library, each by whole populations.

Every search takes ``evaluate(points [n, d]) -> Answer(objectives [n, m], violations [n, c])``, a number of evaluations
that it uses up and never exceeds, and a seed; the same seed asks for the same points, and no clock decides anything. Of
the last population as many points are evaluated as the budget reaches for. What is missed comes before the goal (Deb,
*An efficient constraint handling method for genetic algorithms*, 2000): of two points the one with the smaller sum of
violations is better, and only among those without any the goal decides.

==========  ============================================  ========================================================
``cma``     CMA-ES with restarts of twice the population   https://pypi.org/project/cma (Hansen); one goal
``de``      differential evolution                         pymoo; one goal
``nsga2``   NSGA-II                                        pymoo; several goals
``scipy``   differential evolution                         SciPy; one goal
==========  ============================================  ========================================================
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, NamedTuple

import numpy as np

from leadscrew.kernel.parameters import nearest
from leadscrew.tune.space import cube
from leadscrew.util.errors import LeadscrewError, NameUnknown, ValueRefused


class Answer(NamedTuple):
    """What points are worth."""

    objectives: np.ndarray
    """``[point, goal]``, finite."""
    violations: np.ndarray
    """``[point, constraint]``, 0 where it is kept."""


Evaluate = Callable[[np.ndarray], Answer]


@dataclass(frozen=True)
class Search:
    """What is asked of an optimiser."""

    evaluate: Evaluate
    start: np.ndarray
    """The point of the first population that is there already: the present setting."""
    budget: int
    """Evaluations that may be asked for."""
    seed: int
    goals: int = 1
    constraints: int = 0
    grain: np.ndarray | None = None
    """Width in the cube of one whole number or choice, 0 for what is continuous; by dimension."""

    @property
    def dimensions(self) -> int:
        return len(self.start)


class Spent(BaseException):
    """The budget is used up; leaves a library that would ask on."""


GRID = 2.0**-24
"""Width of the grid of the unit cube on which asked points lie: far below what any setting needs, and far above the
rounding of linear algebra, whose last bits depend on the processor. Of 162 searches of 400 evaluations (four kernels of
OpenBLAS) all differ without a grid, 41 at 2^-40, none at 2^-30."""


def laid(points: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Points on the grid, so that rounding does not grow from one population to the next; the start stays as it is."""
    kept = (points == start).all(axis=1, keepdims=True)
    return np.asarray(np.where(kept, points, np.round(np.clip(points, 0.0, 1.0) / GRID) * GRID))


def population(dimensions: int, budget: int) -> int:
    """The population of the first start: larger than the libraries' own, because a batch likes it so."""
    return max(4, min(12 + 4 * int(math.log(max(1, dimensions)) * 1.5), budget // 4))


def worth(answer: Answer, scale: float) -> np.ndarray:
    """One number a point with the order of Deb's rules: below 0 without violations, their sum with."""
    missed = np.maximum(answer.violations, 0.0).sum(axis=1)
    return np.where(missed > 0.0, missed, 2.0 / math.pi * np.arctan(answer.objectives[:, 0] / scale) - 1.0)


class Counted:
    """The evaluations of a search, never more than its budget."""

    def __init__(self, search: Search) -> None:
        self.search, self.left, self.scale = search, search.budget, 0.0

    def __call__(self, points: np.ndarray) -> Answer:
        """Answers of a whole population; of one that does not fit its first points are evaluated and count.

        Raises:
            Spent: the budget does not reach for all of it.
        """
        fits = points[: self.left]
        if not len(fits):
            raise Spent
        self.left -= len(fits)
        answer = self.search.evaluate(np.clip(fits, 0.0, 1.0))
        if len(fits) < len(points):
            raise Spent
        if not self.scale:
            self.scale = float(np.median(np.abs(answer.objectives[:, 0]))) or 1.0
        return answer

    def worth(self, points: np.ndarray) -> np.ndarray:
        """One number a point."""
        return worth(self(points), self.scale)


def cma(search: Search) -> None:
    """CMA-ES from the present setting; where it has converged, again from elsewhere with twice the population."""
    rng = np.random.default_rng(search.seed)
    counted = Counted(search)
    d, real = max(2, search.dimensions), search.dimensions  # the library wants two dimensions at least
    start = np.full(d, 0.5)
    start[:real] = search.start
    size = population(real, search.budget)
    try:
        while True:
            _descent(counted, start, size, rng)
            start, size = rng.random(d), 2 * size
    except Spent:
        return


def _descent(counted: Counted, start: np.ndarray, size: int, rng: np.random.Generator) -> None:
    """One start of CMA-ES, until it has converged."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import cma as library

        search = counted.search
        real, least = search.dimensions, np.zeros(len(start))
        if search.grain is not None:
            least[:real] = 0.3 * search.grain
        options = {
            "bounds": [0.0, 1.0], "popsize": size, "seed": math.nan, "verbose": -9, "minstd": least.tolist(),
            "randn": lambda *shape: rng.standard_normal(shape), "tolx": GRID, "tolfun": 1e-11, "verb_log": 0,
            "tolflatfitness": 20, "tolfunhist": 0.0,
        }  # fmt: skip
        es = library.CMAEvolutionStrategy(start, 0.25, options)
        while not es.stop():
            asked = laid(np.array(es.ask()), start)
            points = asked[:, :real]
            if counted.left == search.budget:
                values = counted.worth(np.vstack([search.start, points]))[1:]
            else:
                values = counted.worth(points)
            es.tell(list(asked), values.tolist())


def _pymoo() -> Any:
    try:
        import pymoo.optimize as found
    except ImportError:
        raise LeadscrewError("this optimiser needs pymoo: pip install 'leadscrew[tune]'") from None
    return found


def _begun(search: Search, size: int) -> np.ndarray:
    """A first population: the present setting and a Latin hypercube."""
    return np.vstack([search.start, cube(size - 1, search.dimensions, search.seed)])


def _ask_and_tell(search: Search, algorithm: Any) -> None:
    from pymoo.core.evaluator import Evaluator
    from pymoo.core.problem import Problem
    from pymoo.problems.static import StaticProblem
    from pymoo.termination.max_gen import MaximumGenerationTermination

    counted = Counted(search)
    problem = Problem(n_var=search.dimensions, n_obj=search.goals, n_ieq_constr=search.constraints, xl=0.0, xu=1.0)
    algorithm.setup(problem, termination=MaximumGenerationTermination(10**9), seed=search.seed, verbose=False)
    while True:
        infills = algorithm.ask()
        if infills is None or not len(infills):
            return
        infills.set("X", laid(np.asarray(infills.get("X"), dtype=float), search.start))
        try:
            answer = counted(infills.get("X"))
        except Spent:
            return
        told = {"F": answer.objectives} | ({"G": answer.violations} if search.constraints else {})
        Evaluator().eval(StaticProblem(problem, **told), infills)
        algorithm.tell(infills=infills)


def de(search: Search) -> None:
    """Differential evolution of pymoo."""
    _pymoo()
    from pymoo.algorithms.soo.nonconvex.de import DE

    size = max(5, population(search.dimensions, search.budget))
    _ask_and_tell(search, DE(pop_size=size, sampling=_begun(search, size), CR=0.8))


def nsga2(search: Search) -> None:
    """NSGA-II of pymoo."""
    _pymoo()
    from pymoo.algorithms.moo.nsga2 import NSGA2

    size = max(4, min(20 * search.goals + 4 * search.dimensions, search.budget // 4) // 4 * 4)
    _ask_and_tell(search, NSGA2(pop_size=size, sampling=_begun(search, size)))


def scipy(search: Search) -> None:
    """Differential evolution of SciPy, a population at a time."""
    from scipy.optimize import differential_evolution

    counted = Counted(search)
    size = max(5, population(search.dimensions, search.budget))
    refused: list[BaseException] = []

    def together(points: np.ndarray) -> np.ndarray:
        try:
            return counted.worth(points.T.reshape(-1, search.dimensions))
        except Spent:
            raise
        except Exception as error:
            refused.append(error)  # SciPy would put its own in place of some
            raise Spent from None

    try:
        differential_evolution(
            together, [(0.0, 1.0)] * search.dimensions, init=_begun(search, size), maxiter=10**6, tol=0.0, atol=-1.0,
            polish=False, vectorized=True, updating="deferred", rng=np.random.default_rng(search.seed),
        )  # fmt: skip
    except Spent:
        if refused:
            raise refused[0] from None


OPTIMISERS: dict[str, tuple[Callable[[Search], None], str, bool]] = {
    "cma": (cma, "cma", False),
    "de": (de, "pymoo", False),
    "nsga2": (nsga2, "pymoo", True),
    "scipy": (scipy, "scipy", False),
}
"""By name: the search, the package that it comes from, whether it takes several goals."""
LEAST = 8
"""Evaluations that any search needs."""


def check(name: str, goals: int, budget: int) -> None:
    """Refuses what no search can do.

    Raises:
        NameUnknown: there is no such optimiser; names the nearest.
        ValueRefused: several goals for one that takes one, or too few evaluations.
        LeadscrewError: its package is missing.
    """
    if name not in OPTIMISERS:
        raise NameUnknown(f"there is no optimiser {name!r}{nearest(name, list(OPTIMISERS))}")
    _, package, several = OPTIMISERS[name]
    if goals > 1 and not several:
        raise ValueRefused(f"the optimiser {name} takes one goal, not {goals}; nsga2 takes several")
    if budget < LEAST:
        raise ValueRefused(f"budget = {budget}: a search needs {LEAST} evaluations at least")
    if package == "pymoo":
        _pymoo()


def versions(name: str) -> dict[str, str]:
    """Of the packages that decide which points a search asks for."""
    return {p: version(p) for p in sorted({OPTIMISERS[name][1], "numpy", "scipy"})}
