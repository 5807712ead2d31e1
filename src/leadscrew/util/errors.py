"""What can go wrong, as exceptions whose text is one sentence a user can act on."""

from __future__ import annotations

from typing import Any, TypeVar

from leadscrew.util.frames import trimmed, trimmed_class

Entry = TypeVar("Entry")


class LeadscrewError(Exception):
    """Base of all errors that Leadscrew raises on purpose."""


class BlockError(LeadscrewError):
    """A block does not keep the block contract."""


class SubsetError(BlockError):
    """A step uses a construct outside the subset that compiles; names file, line and construct."""


class ValueRefused(LeadscrewError, ValueError):
    """A value was refused at the door: names the value, the allowed range and where it came from."""


class NameUnknown(LeadscrewError, KeyError):
    """A key, study, block, scenario or signal does not exist; names the nearest ones."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class EngineError(LeadscrewError):
    """What an engine needs is not on this machine, or does not work: says what and what else would do."""


class DataError(LeadscrewError, ValueError):
    """A file of data is malformed: names file, row and column."""


class CodeNotTrusted(LeadscrewError):
    """A file names Python that lies outside the working folder and may not run: names both, and how to allow it."""


class Diverged(LeadscrewError):
    """A loop diverged: says at what time, in which state, and keeps the run up to there as ``run``."""

    def __init__(self, message: str, run: object = None) -> None:
        super().__init__(message)
        self.run = run


def entry_point(public: Entry) -> Entry:
    """Decorates a public function or class: an error raised on purpose leaves it without the frames of this package.

    ``LEADSCREW_DEBUG=1`` keeps them.
    """
    if isinstance(public, type):
        trimmed_class(public, LeadscrewError)
        return public
    decorated: Any = trimmed(public, LeadscrewError)
    return decorated


for _error in [v for v in list(vars().values()) if isinstance(v, type) and issubclass(v, LeadscrewError)]:
    _error.__module__ = "leadscrew"  # where they are public, and short in a traceback
