"""What claims and pictures share: loops that keep their runs, and what is costly to make twice."""

from __future__ import annotations

from dataclasses import dataclass, field

from leadscrew.studies.fsmc_ballscrew import beaten
from leadscrew.studies.fsmc_ballscrew.claims_circle import Circles
from leadscrew.studies.fsmc_ballscrew.fits import Fits
from leadscrew.studies.fsmc_ballscrew.runs import Loops


@dataclass
class Results:
    """Of one evaluation of the study."""

    loops: Loops = field(default_factory=Loops)
    circles: Circles = field(init=False)
    fits: Fits = field(init=False)
    learned: beaten.Runs = field(init=False)

    def __post_init__(self) -> None:
        self.circles = Circles(self.loops)
        self.fits = Fits(self.loops)
        self.learned = beaten.Runs(self.loops)
