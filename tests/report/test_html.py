"""Figures in a page, the picture of a run, and the numbers in their tables."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.figure import Figure

from leadscrew.figures import formats
from leadscrew.figures.runs import run_figure
from leadscrew.figures.signals import signal_unit
from leadscrew.figures.table import as_typed, fixed, number
from leadscrew.kernel.block import controller
from leadscrew.kernel.loop import Loop
from leadscrew.references._sine import sine_motion
from leadscrew.report import html
from leadscrew.util.strict_json import strict
from tests.cli.plain_study import LOOP, gain, slide


@controller()
def follow(command, feedback):
    """Follows a motion."""
    return command.position - feedback


@pytest.mark.slow
def test_a_figure_with_many_points_becomes_a_picture():
    figure = Figure()
    figure.subplots().scatter(*np.random.default_rng(0).normal(size=(2, 20_000)))
    assert html.embedded(figure, "many").startswith("data:image/png;base64,")


def test_the_same_figure_gives_the_same_text():
    run = LOOP.run(0.05)
    assert html.embedded(run_figure(run), "a") == html.embedded(run_figure(run), "a")


def test_the_picture_of_a_run_labels_units():
    figure = run_figure(LOOP.run(0.05))
    assert [ax.get_ylabel() for ax in figure.axes] == ["command, actual (mm)", "true error (mm)", "output (V)"]
    assert figure.axes[-1].get_xlabel() == "time (s)"


def test_the_picture_shows_what_was_recorded():
    figure = run_figure(LOOP.run(0.05, record="feedback"))
    assert [ax.get_ylabel() for ax in figure.axes] == ["feedback (mm)"]
    assert len(run_figure(LOOP.run(0.05, every=0)).axes) == 1


def test_a_motion_is_drawn_by_its_position():
    loop = Loop(reference=sine_motion, controller=follow, plant=slide, engine="python")
    figure = run_figure(loop.run(0.05))
    assert {line.get_label() for line in figure.axes[0].get_lines()} == {"command.position", "actual"}


def test_numbers_in_tables():
    values = (None, math.nan, 1 / 3, True, "", np.eye(2), [1, 2, 3], 12, -1.5e6)
    assert [as_typed(x) for x in values] == [
        "–", "–", "0.333333", "yes", "–", "array of 2 × 2", "array of 3", "12", "-1.5e+06",
    ]  # fmt: skip
    assert [number(x) for x in values[-3:]] == ["array of 3", "12", "−1,500,000"]
    assert [fixed(x, 2) for x in (-0.001, -1.5, 1234.0, math.inf)] == ["0.00", "−1.50", "1,234.00", "–"]
    assert formats.plain("the :class:`~a.b.Motion` of ``x``") == "the Motion of x"


def test_metric_units_follow_the_loop():
    loop = Loop(reference=sine_motion, controller=follow, plant=slide, engine="python")
    units = {r.name: r.unit for r in formats.metric_rows(loop.run(0.01))}
    assert units["rms_error"] == "mm" and units["settling_time"] == "s"
    assert all("[" not in u for u in units.values())
    assert signal_unit(loop, "time") == "s" and signal_unit(loop, "disturbance") == ""


def test_strict_json_has_no_infinity():
    assert strict({"a": np.array([1.0, np.nan]), "b": (np.float64(2), -math.inf), "c": np.bool_(True), 1: gain}) == {
        "a": [1.0, None], "b": [2.0, None], "c": True, "1": repr(gain),
    }  # fmt: skip
