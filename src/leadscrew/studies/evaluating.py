"""The evaluation of a study from its folder: results, claims topic by topic, pictures, findings."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from leadscrew.studies.study import StudyResult


def evaluation_of(study: str) -> Callable[..., StudyResult]:
    """The ``evaluate`` of a study whose folder has ``results.Results`` (with ``loops``), ``claims.topics``,
    ``pictures.all_pictures`` and ``findings.findings``; they are imported when it is called.
    """

    def evaluate(progress: Callable[[str, float], None] = lambda what, done: None) -> StudyResult:
        """Runs every loop that the claims and figures need, and judges the claims."""
        results, claims, pictures, said = (
            import_module(f"leadscrew.studies.{study}.{name}") for name in ("results", "claims", "pictures", "findings")
        )
        found = results.Results()
        judged = claims.topics(found, progress)
        progress("figures", 1.0)
        return StudyResult.of(judged, pictures.all_pictures(found), found.loops.runs, said.findings)

    return evaluate
