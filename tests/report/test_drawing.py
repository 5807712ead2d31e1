"""Figures drawn in copies of the process: all are there, whoever drew them, and a fault is said once."""

from __future__ import annotations

import multiprocessing
import os
import signal
from types import SimpleNamespace

import pytest

from leadscrew.report import drawing
from leadscrew.report.report import Picture, Section, StudyReport
from leadscrew.studies.exhibits import FigureOf
from leadscrew.studies.results import Contents
from leadscrew.util.errors import BlockError
from tests.tune.shared import waited

MINE = os.getpid()


def study_of(*draws):
    contents = Contents([], [], [FigureOf(draw, "", False) for draw in draws], None)
    study = SimpleNamespace(judged=lambda: contents)
    pictures = [Picture(draw.__name__, "", lambda draw=draw: draw(None)) for draw in draws]
    return study, StudyReport("s", "s", sections=[Section("figures", pictures=pictures)])


def plain(lab):
    from matplotlib.figure import Figure

    return Figure((4.0, 3.0))


def wide(lab):
    figure = plain(lab)
    figure.set_figwidth(8.0)
    return figure


def killed_if_a_copy(lab):
    if os.getpid() != MINE:
        os.kill(os.getpid(), signal.SIGKILL)
    return plain(lab)


def broken(lab):
    raise KeyError("u")


@pytest.fixture
def cores(monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 2)


@pytest.mark.parametrize("draws", [(plain, wide), (killed_if_a_copy, wide), (wide, killed_if_a_copy)])
def test_every_figure_is_there_even_if_a_copy_is_killed(cores, draws):
    study, report = study_of(*draws)
    with drawing.beside(study) as draw:
        waited(lambda: not multiprocessing.active_children(), 60)  # the copy has drawn both, or was killed
        found = draw(report, lambda what, done: None)
    assert {name: figure.width_in for name, figure in found.items()} == {
        draw.__name__: 8.0 if draw is wide else 4.0 for draw in draws
    }
    assert all(figure.source.startswith("data:image/svg+xml;base64,") for figure in found.values())


def test_a_figure_that_cannot_be_drawn_is_said(cores):
    study, report = study_of(plain, broken)
    with (
        pytest.raises(BlockError, match="broken could not be drawn: KeyError: 'u'"),
        drawing.beside(study) as draw,
    ):
        draw(report, lambda what, done: None)
