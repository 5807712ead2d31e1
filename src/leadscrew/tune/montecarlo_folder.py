"""The folder of a Monte Carlo report: there when it is complete; an older one of ours is replaced at once."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

from leadscrew import reading
from leadscrew.kernel.errors import DataError
from leadscrew.newfolder import replaceable, replacing

KIND = "leadscrew montecarlo"
"""By this, in its ``summary.json``, a folder is known to be ours to replace."""
SUMMARY = "summary.json"


def claimable(folder: str | Path) -> Path:
    """The folder, if a report may be written there: it does not exist, is empty, or holds an older report.

    Raises:
        DataError: it holds something else, or cannot be written.
    """
    return replaceable(folder, _ours, "a Monte Carlo report")


def placed(folder: str | Path) -> AbstractContextManager[Path]:
    """A place to write to, which takes the place of ``folder`` at the end.

    Raises:
        DataError: see :func:`claimable`; or the disk refuses.
    """
    return replacing(folder, _ours, "a Monte Carlo report")


def _ours(folder: Path) -> bool:
    try:
        return reading.json_object(folder / SUMMARY).get("kind") == KIND
    except DataError:
        return False
