"""What the study found, in words around the numbers that it measured."""

from __future__ import annotations

from collections.abc import Sequence

from leadscrew.report.claim import Claim


def findings(claims: Sequence[Claim]) -> list[str]:
    """The findings for the report, one sentence or two each."""
    return []
