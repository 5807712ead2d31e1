"""What claims and pictures share: loops that keep their runs."""

from __future__ import annotations

from dataclasses import dataclass, field

from leadscrew.studies.sofnn_tangent.runs import Loops


@dataclass
class Results:
    """Of one evaluation of the study."""

    loops: Loops = field(default_factory=Loops)
