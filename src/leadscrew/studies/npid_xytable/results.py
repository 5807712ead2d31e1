"""What claims and pictures share: loops that keep their runs, and what is made once."""

from __future__ import annotations

from dataclasses import dataclass, field

from leadscrew.studies.npid_xytable.friction_runs import FrictionRuns
from leadscrew.studies.npid_xytable.runs import Loops
from leadscrew.studies.npid_xytable.spindle_sweep import SpindleSweep
from leadscrew.studies.npid_xytable.trials import BOX, Trial, trial
from leadscrew.studies.npid_xytable.two_mass import TwoMassMap


@dataclass
class Trials:
    """Trials of :func:`~leadscrew.studies.npid_xytable.trials.trial` by controller, each made once."""

    loops: Loops
    _kept: dict[tuple[str, str], Trial] = field(default_factory=dict)

    def nominal(self, controller: str) -> Trial:
        """Thirty draws of phases at each of the three speeds, in L*."""
        if (controller, "") not in self._kept:
            self._kept[controller, ""] = trial(self.loops, controller)
        return self._kept[controller, ""]

    def boxed(self, controller: str) -> Trial:
        """One draw at each of the three speeds on the twelve plants of the robustness box."""
        if (controller, "box") not in self._kept:
            self._kept[controller, "box"] = trial(self.loops, controller, draws=1, box=BOX)
        return self._kept[controller, "box"]


@dataclass
class Results:
    """Of one evaluation of the study."""

    loops: Loops = field(default_factory=Loops)
    trials: Trials = field(init=False)
    friction: FrictionRuns = field(init=False)
    spindle: SpindleSweep = field(init=False)
    two_mass: TwoMassMap = field(init=False)

    def __post_init__(self) -> None:
        self.trials = Trials(self.loops)
        self.friction = FrictionRuns(self.loops)
        self.spindle = SpindleSweep(self.loops)
        self.two_mass = TwoMassMap(self.loops)
