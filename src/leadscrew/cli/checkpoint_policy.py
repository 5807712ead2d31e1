"""What a long command keeps of its work when it ends before its time: the rules of every journal.

======================================  ============================================================================
done                                    the default journal goes; one that was named, with ``--journal``, stays
Ctrl-C, a full disk, a lost cluster     what is done stays, and the command says that ``--resume`` goes on with it
another refusal (every run diverges)    the same would come again: the default journal goes, one that was named stays
nothing was done yet                    the journal goes, whatever the end
======================================  ============================================================================
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from leadscrew.cli.exit_codes import INTERRUPTED, say
from leadscrew.util.errors import DataError, LeadscrewError, ValueRefused

if TYPE_CHECKING:
    from leadscrew.tune.checkpoints import Journal


GOES_ON = "keeps what is done: the same command with --resume goes on"


class Keeping:
    """The journal of a command, and what becomes of it; what happens inside the ``with`` decides.

    Raises:
        ValueRefused: ``resume`` without a journal to go on with.
    """

    def __init__(
        self, out: Path | None, named: Path | None, resume: bool, option: str, kept: Callable[[], str] | None = None
    ) -> None:
        """``out`` is what the command makes, given with ``option``; ``named`` what ``--journal`` says; ``kept`` says
        what stays and how to go on, in the command's own words.
        """
        self.named, self.resume, self.option = named is not None, resume, option
        self.at = named if named is not None or out is None else out.with_name(f"{out.name}.journal")
        self.journal: Journal | None = None
        self._kept = kept or (lambda: f"{self.at} {GOES_ON}")
        if resume and self.at is None:
            raise ValueRefused(
                f"--resume needs the journal that it goes on with: give {option} as before, or --journal"
            )

    def open(self, question: dict[str, Any]) -> Journal | None:
        """The journal, if there is to be one."""
        from leadscrew.tune.checkpoints import Journal

        self.journal = None if self.at is None else Journal(self.at, question, self.resume)
        return self.journal

    def __enter__(self) -> Keeping:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: Any) -> None:
        if kind is None:
            self._leave(self.named)
        elif isinstance(error, KeyboardInterrupt):
            say(f"leadscrew: interrupted; {self._interrupted()}")
            raise typer.Exit(INTERRUPTED) from None
        elif isinstance(error, LeadscrewError):
            from leadscrew.tune.executors import CrewLost

            if isinstance(error, DataError | CrewLost) and self._leave(True):
                raise type(error)(f"{error}; {self._kept()}") from None
            self._leave(self.named)

    def _interrupted(self) -> str:
        if self._leave(True):
            return self._kept()
        return "nothing was done yet" if self.at else f"nothing is kept without {self.option} or --journal"

    def _leave(self, keep: bool) -> bool:
        """Keeps the journal if that is wanted and it holds anything, else removes it; whether it was kept."""
        if self.journal is None:
            return False
        if keep and self.journal.chunks:
            return True
        self.journal.remove()
        return False


def undone(report: Path | None) -> None:
    """Takes away a report whose command failed after it."""
    if report is not None:
        shutil.rmtree(report, ignore_errors=True)
