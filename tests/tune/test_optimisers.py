"""Searches: known optima, budgets, and the same points for the same seed."""

from __future__ import annotations

import builtins

import numpy as np
import pytest

from leadscrew.tune import optimisers
from leadscrew.tune.optimisers import OPTIMISERS, Answer, Search
from leadscrew.util.errors import LeadscrewError, NameUnknown, ValueRefused
from tests.tune.shared import on_kernels


def search(name, function, d, budget, seed=1, goals=1, constraints=0, start=None, **more):
    """All points and answers that a search asked for."""
    points, answers, sizes = [], [], []

    def evaluate(u):
        answer = function(u)
        points.append(u.copy())
        answers.append(answer)
        sizes.append(len(u))
        return answer

    begin = np.full(d, 0.9) if start is None else np.asarray(start)
    OPTIMISERS[name][0](Search(evaluate, begin, budget, seed, goals, constraints, **more))
    return (
        np.vstack(points),
        Answer(np.vstack([a.objectives for a in answers]), np.vstack([a.violations for a in answers])),
        sizes,
    )


def free(u):
    return np.zeros((len(u), 0))


def sphere(u):
    return Answer(((u - 0.3) ** 2).sum(axis=1)[:, None], free(u))


def rosenbrock_in_a_disk(u):
    """The minimum of Rosenbrock's function in the disk x^2 + y^2 <= 1: f = 0.04567 at (0.7864, 0.6177)."""
    x, y = 4.0 * u.T - 2.0
    return Answer(((1 - x) ** 2 + 100 * (y - x**2) ** 2)[:, None], np.maximum(x**2 + y**2 - 1.0, 0.0)[:, None])


def best(answer):
    kept = answer.violations.sum(axis=1) <= 0.0
    return answer.objectives[kept].min()


@pytest.mark.parametrize("name", OPTIMISERS)
@pytest.mark.parametrize("d", [1, 4])
def test_finds_the_bottom_of_a_sphere(name, d):
    _, answer, _ = search(name, sphere, d, 800)
    assert best(answer) < 1e-3


@pytest.mark.parametrize(("name", "tolerance"), [("cma", 1e-3), ("de", 5e-3), ("scipy", 5e-3)])
def test_finds_the_optimum_on_the_edge_of_a_constraint(name, tolerance):
    _, answer, _ = search(name, rosenbrock_in_a_disk, 2, 3000, constraints=1)
    assert best(answer) == pytest.approx(0.04567, abs=tolerance)


def test_nsga2_finds_a_front():
    def two(u):
        x = u[:, 0]
        rest = ((u[:, 1:] - 0.5) ** 2).sum(axis=1)
        return Answer(np.column_stack([x**2 + rest, (x - 1) ** 2 + rest]), free(u))

    _, answer, _ = search("nsga2", two, 3, 3000, goals=2)
    last = answer.objectives[-40:]
    # On the front sqrt(f1) + sqrt(f2) = 1.
    assert np.abs(np.sqrt(last).sum(axis=1) - 1.0).max() < 0.15
    assert np.ptp(last[:, 0]) > 0.5


@pytest.mark.parametrize("name", OPTIMISERS)
def test_the_same_seed_asks_for_the_same_points_and_another_for_others(name):
    np.random.seed(3)  # noqa: NPY002  what else draws random numbers is of no account
    first, _, _ = search(name, sphere, 3, 300)
    np.random.seed(4)  # noqa: NPY002
    again, _, _ = search(name, sphere, 3, 300)
    other, _, _ = search(name, sphere, 3, 300, seed=2)
    assert np.array_equal(first, again)
    assert first.shape != other.shape or not np.array_equal(first, other)


@pytest.mark.parametrize("name", OPTIMISERS)
@pytest.mark.parametrize("budget", [8, 9, 50, 333])
def test_the_budget_is_kept_and_used(name, budget):
    points, _, sizes = search(name, sphere, 3, budget)
    assert len(points) == budget, "to the last evaluation"
    assert np.array_equal(points[0], np.full(3, 0.9)), "the present setting is the first"
    assert min(sizes[:-1]) >= 2, "whole populations but for the last"
    assert points.min() >= 0.0 and points.max() <= 1.0


@pytest.mark.parametrize("name", OPTIMISERS)
def test_a_larger_budget_of_the_same_population_goes_on_from_a_smaller_one(name):
    few, _, _ = search(name, sphere, 3, 301)
    more, _, _ = search(name, sphere, 3, 333)
    assert np.array_equal(more[:301], few)


def test_cma_starts_again_where_it_has_converged():
    _, answer, sizes = search("cma", sphere, 2, 4000)
    assert len(set(sizes[1:])) > 1 and best(answer) < 1e-12


ASKED = """
import hashlib, sys
import numpy as np
from leadscrew.tune import optimisers
from leadscrew.tune.optimisers import Answer, Search

if "--without-grid" in sys.argv:
    optimisers.laid = lambda points, start: np.clip(points, 0.0, 1.0)
seen = hashlib.sha256()

def evaluate(u):
    seen.update(np.ascontiguousarray(u).tobytes())
    x, y, z = 4.0 * u.T - 2.0
    return Answer(((1 - x) ** 2 + 100 * (y - x**2) ** 2 + 30 * (z - y) ** 2)[:, None], np.zeros((len(u), 0)))

for seed in range(3):
    optimisers.cma(Search(evaluate, np.full(3, 0.9), 400, seed))
print(seen.hexdigest())
"""


@pytest.mark.slow
def test_the_kernel_of_linear_algebra_does_not_matter():
    assert len(set(on_kernels(ASKED).values())) == 1


@pytest.mark.slow
def test_without_the_grid_it_would():
    assert len(set(on_kernels(ASKED, "--without-grid").values())) > 1


def test_cma_goes_on_over_steps():
    """Whole numbers make stairs; a search must not shrink to less than one."""

    def stairs(u):
        return Answer((np.abs(np.floor(u * 20) - np.array([3, 17])).sum(axis=1))[:, None], free(u))

    _, answer, _ = search("cma", stairs, 2, 1500, grain=np.array([0.05, 0.05]))
    assert best(answer) == 0.0


@pytest.mark.parametrize("name", OPTIMISERS)
def test_what_an_evaluation_refuses_comes_through_as_it_is(name):
    def refuse(u):
        raise ValueRefused("no such plant")

    with pytest.raises(ValueRefused, match="no such plant"):
        search(name, refuse, 2, 100)


def test_what_cannot_be_asked_is_refused(monkeypatch):
    with pytest.raises(NameUnknown, match="there is no optimiser 'cmaes'; did you mean cma"):
        optimisers.check("cmaes", 1, 100)
    with pytest.raises(ValueRefused, match="cma takes one goal, not 2; nsga2 takes several"):
        optimisers.check("cma", 2, 100)
    with pytest.raises(ValueRefused, match="budget = 3: a search needs 8 evaluations"):
        optimisers.check("cma", 1, 3)
    real = builtins.__import__

    def without(name, *args, **kwargs):
        if name.startswith("pymoo"):
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(LeadscrewError, match=r"needs pymoo: pip install 'leadscrew\[tune\]'"):
        optimisers.check("de", 1, 100)
    optimisers.check("cma", 1, 100)
