"""Fits of the friction, each made once for claims and pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from leadscrew.studies.fsmc_ballscrew.selftuned import identified

if TYPE_CHECKING:
    from leadscrew.identify.friction import FrictionFit
    from leadscrew.studies.fsmc_ballscrew.runs import Loops


class Fits:
    """What is found on the nominal stage, by the kind of record, ``test`` or ``sines``."""

    def __init__(self, loops: Loops) -> None:
        self.loops = loops
        self._kept: dict[str, FrictionFit] = {}

    def of(self, kind: str) -> FrictionFit:
        """The fit of a record; the second call costs nothing."""
        if kind not in self._kept:
            self._kept[kind] = identified(self.loops, kind)
        return self._kept[kind]
