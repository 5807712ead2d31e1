"""What a study shows beside the paper's claims: experiments, each one table, and figures, each drawn from measures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from leadscrew.figures.table import Table

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure
    from leadscrew.studies.lab import Lab


@dataclass(frozen=True)
class Experiment:
    """A question, how it was answered, the table, and what follows from it in a sentence."""

    name: str
    question: str
    method: str
    table: Table
    conclusion: str

    def as_dict(self) -> dict[str, Any]:
        """The experiment for JSON."""
        return {**vars(self), "table": self.table.as_dict()}


@dataclass(frozen=True)
class ExperimentOf:
    """An experiment before it is run: what ``@experiment`` makes of a function."""

    measure: Callable[[Lab], tuple[Table, str]]
    question: str

    @property
    def name(self) -> str:
        """The function's."""
        return self.measure.__name__

    def done(self, lab: Lab) -> Experiment:
        """The experiment, run."""
        table, conclusion = self.measure(lab)
        method = " ".join((self.measure.__doc__ or "").split())
        return Experiment(self.name, self.question, method, table, conclusion)


def experiment(question: str) -> Callable[[Callable[[Lab], tuple[Table, str]]], ExperimentOf]:
    """Makes a function an experiment of its study: its docstring is the method, it returns table and conclusion."""
    return lambda function: ExperimentOf(function, question)


@dataclass(frozen=True)
class FigureOf:
    """A figure of a study, drawn on demand; it simulates nothing."""

    draw: Callable[[Lab], Figure]
    caption: str
    key: bool

    @property
    def name(self) -> str:
        """The function's."""
        return self.draw.__name__


def figure(caption: str, key: bool = False) -> Callable[[Callable[[Lab], Figure]], FigureOf]:
    """Makes a function of the lab a figure of its study; ``key``: the one that stands large above all others."""
    return lambda function: FigureOf(function, caption, key)
