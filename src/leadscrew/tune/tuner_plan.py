"""What a tuning is asked for, checked; and the plants that it is done on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from leadscrew.kernel import door
from leadscrew.kernel.errors import ValueRefused
from leadscrew.tune import optimisers
from leadscrew.tune.job import Job
from leadscrew.tune.objective import Constraint, Goal, constraint, contradiction, goal
from leadscrew.tune.space import Choice, Given, Range, Space, cube

PLANTS, HELD_OUT, BUDGET = 16, 64, 400
"""What is taken unless given."""
CORNERS = 3
"""Ranges up to which the corners of their box are training plants."""

END = 0.02
"""Part of a range that counts as its end."""


def seed_of(seed: int, part: int) -> int:
    """A seed of one part of a tuning: 1 training plants, 2 held-out plants, 3 unseen plants of a comparison."""
    return int(np.random.SeedSequence([seed, part]).generate_state(1)[0])


def training(over: Space, count: int, seed: int) -> dict[str, np.ndarray]:
    """Training plants: the corners of the ranges where these are few, and a Latin hypercube."""
    points = np.zeros((0, len(over)))
    plain = all(isinstance(d, Range | Choice) for _, d in over.items)
    if 0 < len(over) <= CORNERS and plain and count > 2 ** len(over):
        points = np.array(list(product((0.0, 1.0), repeat=len(over))))
    rest = cube(count - len(points), len(over), seed_of(seed, 1))
    return over.values(np.vstack([points, rest]))


def held_out_plants(over: Space, count: int, seed: int, part: int = 2) -> dict[str, np.ndarray]:
    """Plants that no search sees: a Latin hypercube of another seed."""
    return over.values(cube(count, len(over), seed_of(seed, part)))


def at_ends(vary: Space, values: Mapping[str, float]) -> tuple[str, ...]:
    """A sentence for each value at an end of its range: there the best may lie beyond. Of a choice there is no end."""
    found = []
    for key, dist in vary.items:
        if not isinstance(dist, Range) or (dist.whole and dist.high - dist.low < 2.0):
            continue
        unit = dist.unit(values[key])
        near = END if not dist.whole else 0.75 / (dist.high - dist.low + 1.0)
        end = "lower" if unit <= near else "upper" if unit >= 1.0 - near else ""
        if end:
            found.append(
                f"{key} = {values[key]:.6g} is at the {end} end of its range {dist}: the best may lie beyond it"
            )
    return tuple(found)


@dataclass(frozen=True)
class Plan:
    """A tuning before it is done: everything checked."""

    job: Job
    vary: Space
    goals: tuple[Goal, ...]
    constraints: tuple[Constraint, ...]
    over: Space
    plants: int
    held_out: int
    budget: int
    optimiser: str
    seed: int

    def question(self) -> dict[str, Any]:
        """What a journal of this tuning answers: all that decides its numbers."""
        return {
            "what": "tune", "job": self.job.mark, "scenarios": list(self.job.where),
            "vary": {k: repr(d) for k, d in self.vary.items}, "over": {k: repr(d) for k, d in self.over.items},
            "goals": [str(g) for g in self.goals], "constraints": [repr(c) for c in self.constraints],
            "plants": self.plants, "held_out": self.held_out, "budget": self.budget, "optimiser": self.optimiser,
            "seed": self.seed, "versions": optimisers.versions(self.optimiser),
        }  # fmt: skip

    @property
    def runs(self) -> int:
        """Runs of the search and of the scores, at most; scores of a front come on top."""
        scored = 2 * (self.plants + self.held_out)
        return (self.budget * self.plants + scored) * len(self.job.where)


def plan(
    job: Job,
    vary: Given,
    goals: Sequence[str | Goal],
    constraints: Sequence[str | Constraint] = (),
    *,
    over: Given | None = None,
    plants: int | None = None,
    held_out: int | None = None,
    budget: int = BUDGET,
    optimiser: str | None = None,
    seed: int = 0,
) -> Plan:
    """Checks what a tuning is asked for; see :func:`tune`.

    Raises:
        LeadscrewError: one sentence about what cannot be.
    """
    space, other = Space.of(vary), Space.of(over or {})
    if not len(space):
        raise ValueRefused("--vary is missing: say which parameters may change, as KEY=LOW:HIGH")
    if not goals:
        raise ValueRefused("--minimise is missing: say which metric to minimise")
    wanted = tuple(goal(g) for g in goals)
    kept = tuple(constraint(c) for c in constraints)
    for text in [str(w) for w in (*wanted, *kept)]:
        if [str(w) for w in (*wanted, *kept)].count(text) > 1:
            raise ValueRefused(f"{text}: given twice")
    sheet = job.sheet()
    space, other = space.checked(sheet, "--vary"), other.checked(sheet, "--over")
    both = [k for k in space.keys if k in other.keys]
    if both:
        raise ValueRefused(f"{both[0]}: a key is either varied (--vary) or sampled (--over), not both")
    for w in (*wanted, *kept):
        w.check(job)
    if clash := contradiction(kept):
        raise ValueRefused(clash)
    name = optimiser or ("cma" if len(wanted) == 1 else "nsga2")
    optimisers.check(name, len(wanted), budget)
    return Plan(
        job, space, wanted, kept, other,
        door.whole("plants", plants if plants is not None else PLANTS if len(other) else 1, 1, 10**6),
        door.whole("held_out", held_out if held_out is not None else HELD_OUT if len(other) else 1, 1, 10**6),
        door.whole("budget", budget, 1, 10**9), name, door.whole("seed", seed, 0, 2**31 - 1),
    )  # fmt: skip
