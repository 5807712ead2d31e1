"""What a comparison gives."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from leadscrew.tune.compare_statistics import Pair, Standing
from leadscrew.tune.measure import Samples
from leadscrew.tune.objective import Constraint, Goal
from leadscrew.tune.tuned import Marks, Tuned


@dataclass
class Result:
    """What came of one contender."""

    name: str
    tuned: Tuned | None
    marks: Marks
    standings: dict[str, Standing]
    """By the text of a goal or a constraint's metric."""
    bad: int
    """Unseen plants on which it fails or misses a constraint."""
    samples: Samples = field(repr=False)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        standings = {
            k: {"mean": s.mean._asdict(), "p95": s.p95._asdict(), "worst": s.worst, "judged": s.judged}
            for k, s in self.standings.items()
        }
        return {"name": self.name, "tuned": None if self.tuned is None else self.tuned.as_dict(),
                "scores": self.marks.as_dict(), "metrics": standings, "bad_plants": self.bad}  # fmt: skip


@dataclass
class Comparison:
    """The result, best first."""

    results: tuple[Result, ...]
    pairs: tuple[Pair, ...]
    goals: tuple[Goal, ...]
    constraints: tuple[Constraint, ...]
    over: dict[str, str]
    scenarios: tuple[str, ...]
    unseen: int
    seed: int
    unit: str
    """Of the first goal."""
    budget: int
    plants: int
    optimiser: str
    crew: str = ""
    wall_s: float = 0.0
    units: dict[str, str] = field(default_factory=dict)
    """Of each metric, by its text in the standings; empty for a mere number."""
    integration: dict[str, dict[str, dict[str, Any]]] = field(default_factory=dict)
    """What integrates the plant, by contender and scenario."""
    same_run: bool = False
    """Whether all runs of each contender are the same run: nothing varied, so there is no confidence to state."""

    def sentence(self) -> str:
        """What may be said of it."""
        from leadscrew.tune.compare_words import sentence

        return sentence(self)

    @property
    def notes(self) -> list[str]:
        """What is to be known besides: of the plants, and of each contender's setting."""
        from leadscrew.tune.compare_words import nothing_varied

        return nothing_varied(self) + [f"{r.name}: {n}" for r in self.results if r.tuned for n in r.tuned.notes]

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        pairs = [
            {"better": p.better, "worse": p.worse, "order": p.order, "difference": p.difference._asdict(),
             "judged": p.judged, "shown": p.shown}
            for p in self.pairs
        ]  # fmt: skip
        return {
            "ranking": [r.name for r in self.results], "pairs": pairs, "results": [r.as_dict() for r in self.results],
            "goals": [str(g) for g in self.goals], "constraints": [str(c) for c in self.constraints],
            "over": self.over, "scenarios": list(self.scenarios), "unseen": self.unseen, "seed": self.seed,
            "budget": self.budget, "plants": self.plants, "optimiser": self.optimiser, "sentence": self.sentence(),
            "notes": self.notes, "units": self.units, "integration": self.integration, "same_run": self.same_run,
            "crew": self.crew, "wall_s": self.wall_s,
        }  # fmt: skip
