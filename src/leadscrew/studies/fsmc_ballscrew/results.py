"""What claims and pictures share: loops that keep their runs, and what is costly to make twice."""

from __future__ import annotations

from dataclasses import dataclass, field

from leadscrew.studies.fsmc_ballscrew.runs import Loops


@dataclass
class Results:
    """Of one evaluation of the study."""

    loops: Loops = field(default_factory=Loops)
