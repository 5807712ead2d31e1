"""All pictures of the study, in the order of its story."""

from __future__ import annotations

from leadscrew.studies.fsmc_ballscrew.results import Results
from leadscrew.studies.study import Picture


def all_pictures(found: Results) -> list[Picture]:
    """Friction and backlash, tracking, the ball bar."""
    return []
