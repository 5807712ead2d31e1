"""What claims and pictures share: loops that keep their runs, and what is made once."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from leadscrew.studies.grey_turning.entry import Entries, entries
from leadscrew.studies.grey_turning.lathe import LatheRuns
from leadscrew.studies.grey_turning.removal import Removal
from leadscrew.studies.grey_turning.reproduction import Reproduction
from leadscrew.studies.grey_turning.runs import Loops


@dataclass
class Results:
    """Of one evaluation of the study."""

    loops: Loops = field(default_factory=Loops)
    lathe: LatheRuns = field(default_factory=LatheRuns)

    @cached_property
    def removal(self) -> Removal:
        """Two bars, turned in all ways."""
        return Removal(self.lathe)

    @cached_property
    def reproduction(self) -> Reproduction:
        """The paper's experiments."""
        return Reproduction(self.loops)

    @cached_property
    def entered(self) -> Entries:
        """Tool entries of the published cut of 0.416 mm/rev, with the law fitted to the series of feeds."""
        from leadscrew.identify.cutting_force import fit_forces
        from leadscrew.studies.grey_turning.force_facts import FEED_SERIES, cuts

        return entries(fit_forces(cuts(FEED_SERIES)).law)
