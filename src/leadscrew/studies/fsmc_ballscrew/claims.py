"""All claims of the study, topic by topic, in the order in which the report tells its story."""

from __future__ import annotations

from collections.abc import Callable

from leadscrew.report.claim import Claim
from leadscrew.studies.fsmc_ballscrew.results import Results

Topics = list[tuple[str, list[Claim]]]


def topics(found: Results, progress: Callable[[str, float], None]) -> Topics:
    """Every claim, judged, below its heading."""
    asked: list[tuple[str, Callable[[], list[Claim]]]] = []
    judged: Topics = []
    for number, (title, claims) in enumerate(asked):
        progress(title, number / len(asked))
        judged.append((title, claims()))
    return judged
