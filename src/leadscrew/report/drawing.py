"""The figures of a report, drawn on all cores.

Drawing and linking loops are work of Python, which one process does on one core. So the figures of a study are drawn
beside its evaluation, in copies of this process that measure by themselves what they show; when the evaluation is done,
this process draws what is left.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, NamedTuple

from leadscrew.kernel.one_thread import one_thread
from leadscrew.report.html import embedded
from leadscrew.util.errors import BlockError, LeadscrewError

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure
    from leadscrew.report.report import StudyReport
    from leadscrew.study_data import Study

MOST_COPIES = 3
"""Copies of this process; each measures anew what its figures show."""

Progress = Callable[[str, float], None]
Draw = Callable[["StudyReport", Progress], dict[str, "Drawn"]]


class Drawn(NamedTuple):
    """A figure as it stands in a page."""

    source: str
    """Of an image, as a ``data:`` address."""
    width_in: float


def drawn(name: str, draw: Callable[[], Figure]) -> Drawn:
    """A figure, drawn.

    Raises:
        BlockError: the function that draws it raised an exception.
    """
    try:
        figure = draw()
        return Drawn(embedded(figure, name), figure.get_figwidth())
    except LeadscrewError:
        raise
    except Exception as error:
        raise BlockError(f"{name} could not be drawn: {type(error).__name__}: {error}") from error


def draw_all(report: StudyReport, progress: Progress) -> dict[str, Drawn]:
    """All figures of a report, by name, drawn here and now."""
    pictures = list(report.pictures())
    found = {}
    for at, picture in enumerate(pictures):
        progress(f"drawing {picture.name}", at / len(pictures))
        found[picture.name] = drawn(picture.name, picture.draw)
    return found


def draw_none(report: StudyReport, progress: Progress) -> dict[str, Drawn]:
    """A report without figures."""
    return {}


@contextmanager
def beside(study: Study, figures: bool = True) -> Iterator[Draw]:
    """Begins to draw the figures of a study; gives a function that draws the rest and waits for all.

    Where there is one core, or the system cannot copy a process, that function draws them all.
    """
    wanted = study.judged().figures if figures else []
    copies = min((os.cpu_count() or 1) - 1, MOST_COPIES, len(wanted) - 1)
    if not figures:
        yield draw_none
    elif copies < 1 or sys.platform != "linux":
        yield draw_all
    else:
        fork = multiprocessing.get_context("fork")
        crew = _Crew([figure.name for figure in wanted], fork.Value("q", 0))
        ends = [fork.Pipe(duplex=False) for _ in range(copies)]
        helpers = [fork.Process(target=_help, args=(study, crew, send), daemon=True) for _, send in ends]
        with warnings.catch_warnings():  # Python 3.12 warns of threads: the one of the progress bar does not matter
            warnings.simplefilter("ignore", DeprecationWarning)
            for helper in helpers:
                helper.start()
        for _, send in ends:
            send.close()
        try:
            yield lambda report, progress: crew.collected(report, progress, [receive for receive, _ in ends])
        finally:
            for helper in helpers:
                helper.kill()
                helper.join()


class _Crew:
    """What processes share that draw the same figures: each takes the next that nobody has taken."""

    def __init__(self, names: Sequence[str], count: Any) -> None:
        self.names, self.count = names, count

    def taken(self) -> Iterator[int]:
        while True:
            with self.count.get_lock():
                at = self.count.value
                self.count.value += 1
            if at >= len(self.names):
                return
            yield at

    def collected(self, report: StudyReport, progress: Progress, receivers: Sequence[Any]) -> dict[str, Drawn]:
        pictures = {picture.name: picture for picture in report.pictures()}
        found: dict[str, Drawn] = {}

        def draw(name: str) -> None:
            progress(f"drawing {name}", self.names.index(name) / len(self.names))
            found[name] = drawn(name, pictures[name].draw)

        for at in self.taken():
            draw(self.names[at])
        for receiver in receivers:
            with suppress(EOFError, OSError):  # one that was killed: its figures are drawn here
                found |= receiver.recv()
        for name in self.names:
            if name not in found:
                draw(name)
        return found


def _help(study: Study, crew: _Crew, send: Any) -> None:
    """Draws in a copy of this process, and sends all at the end; what fails is left to the process that waits."""
    from leadscrew.studies.lab import Lab

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the process that waits for this one
    warnings.simplefilter("ignore")
    assert study.contents is not None
    figures, lab, found = study.contents().figures, Lab(study), {}
    with one_thread():
        for at in crew.taken():
            with suppress(Exception):
                found[crew.names[at]] = drawn(crew.names[at], lambda figure=figures[at]: figure.draw(lab))  # type: ignore[misc]
    send.send(found)
