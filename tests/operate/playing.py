"""A machine disturbed through nothing but kernel calls: what a disturbance does, apart from who asks for it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.experiment import Experiment
from leadscrew.kernel.live import Live
from leadscrew.operate.profiles import profile_of

STUDIES = ("vud_lathe", "grey_turning", "fsmc_ballscrew", "sofnn_tangent", "npid_xytable")


@dataclass
class Played:
    """Signals at full rate, the period at which the disturbance came, and the parameters at the end."""

    signals: dict[str, np.ndarray]
    at: int
    period_s: float
    before: dict[str, Any]
    after: dict[str, Any]

    def __getitem__(self, column: str) -> np.ndarray:
        return self.signals[column]

    def span(self, column: str, first_s: float, last_s: float) -> np.ndarray:
        """A column between two times, counted from the disturbance."""
        first, last = (self.at + round(x / self.period_s) for x in (first_s, last_s))
        return self.signals[column][first:last]


def loop_of(study: str, controller: str | None = None, scenario: str | None = None, **changes: Any):
    """The operated loop of a study: its profile's controller and scenario by default."""
    profile = profile_of(study)
    changes = {k.replace("__", "."): v for k, v in changes.items()}
    asked = Experiment(study, controller or profile.controller, scenario or profile.scenario, changes)
    return profile.operated(asked.loop())


def play(study: str, name: str | None, at_s: float, then_s: float, loop=None, **fields: float) -> Played:
    """A run of ``at_s + then_s`` seconds that is disturbed after ``at_s``; ``name`` None leaves it alone."""
    profile = profile_of(study)
    loop = loop_of(study) if loop is None else loop
    live, parts = loop.start(), []
    before = dict(live.loop.parameters)

    def on(periods: int) -> None:
        if periods > 0:
            parts.append(live.advance(periods, record=roots(live)).signals)

    at, rest = loop.periods(at_s), loop.periods(then_s)
    on(at)
    acts = [] if name is None else profile.disturbance(name).changes(fields, live.time, live.loop.parameters)
    for delay, changes in acts:
        due = at + round(delay / loop.period)
        if due <= at + rest:
            on(due - live.period)
            for key, value in changes.items():
                live.set(key, value)
    on(at + rest - live.period)
    assert live.diverged is None
    signals = {c: np.concatenate([p[c] for p in parts]) for c in parts[0]}
    return Played(signals, at, loop.period, before, dict(live.loop.parameters))


def roots(live: Live) -> list[str]:
    """All signals and states, by the names that stand for all their parts."""
    return list(dict.fromkeys(c.split(".")[0] for c in live.program.plan.columns if c != "time"))
