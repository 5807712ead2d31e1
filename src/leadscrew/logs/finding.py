"""What a check found in a log: one sentence with place, value and fix."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

from leadscrew.util.errors import DataError

Severity = Literal["refused", "warning", "note"]


class Finding(NamedTuple):
    """One thing about a log that its user should know."""

    kind: str
    """A key for programs: ``gap``, ``clock``, ``jump``, ``clipped``, ``constant``, ``standstill``, ``unit`` ..."""
    severity: Severity
    """``refused``: nothing can be fitted to it; ``warning``: what is fitted may be off; ``note``: good to know."""
    sentence: str


def refuse(source: str, findings: Sequence[Finding]) -> None:
    """Passes where nothing is refused.

    Raises:
        DataError: something is: the source, and the first refusal.
    """
    for finding in findings:
        if finding.severity == "refused":
            raise DataError(f"{source}: {finding.sentence}")
