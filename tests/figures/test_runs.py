"""Runs as pictures, tables and text."""

import sys

import numpy as np
import pytest

import leadscrew as ls
from leadscrew.figures.table import Table
from leadscrew.util.errors import NameUnknown, ValueRefused
from tests.cli.plain_study import LOOP, STUDY, gain


@pytest.fixture(scope="module")
def runs():
    return [LOOP.using({"controller.kp": kp}).run(0.05) for kp in (1.0, 2.0)]


def drawn(axes):
    return [line.get_ydata() for line in axes.get_lines()]


def test_runs_over_one_another_are_named_by_what_differs_and_share_a_command(runs):
    figure = ls.plot_runs(runs)
    assert [ax.get_ylabel() for ax in figure.axes] == ["command, actual (mm)", "true error (mm)", "output (V)"]
    assert [t.get_text() for t in figure.legends[0].get_texts()] == [
        "controller.kp = 1", "controller.kp = 2", "command",
    ]  # fmt: skip
    way, error, output = (drawn(ax) for ax in figure.axes)
    assert len(way) == 3 and sum(np.array_equal(y, runs[0]["command"]) for y in way) == 1
    for lines, name in ((error, "true_error"), (output, "output")):
        assert len(lines) == 2 and all(np.array_equal(y, run[name]) for y, run in zip(lines, runs, strict=True))


def test_runs_have_the_names_that_they_are_given_and_the_signals_asked_for(runs):
    figure = ls.plot_runs({"slow": runs[0], "fast": runs[1]}, signals="feedback")
    assert [ax.get_ylabel() for ax in figure.axes] == ["feedback (mm)"]
    assert [t.get_text() for t in figure.legends[0].get_texts()] == ["slow", "fast"]
    assert [ax.get_ylabel() for ax in runs[0].plot(["output", "error"]).axes] == ["output (V)", "error (mm)"]


def test_what_cannot_be_drawn_over_one_another_is_refused(runs):
    with pytest.raises(NameUnknown, match="'outputs' was not recorded; did you mean output"):
        ls.plot_runs(runs, signals=["outputs"])
    with pytest.raises(ValueRefused, match="one run at least"):
        ls.plot_runs([])
    amperes = ls.Loop(**{**{k: b for k, b in LOOP.blocks.items() if b}, "controller": in_amperes}).run(0.05)
    with pytest.raises(ValueRefused, match="output is in V and in A"):
        ls.plot_runs({"a": runs[0], "b": amperes}, signals=["output"])


@ls.controller(gain.params, unit="A")
def in_amperes(p, command, feedback):
    return p.kp * (command - feedback)


def test_a_figure_and_a_table_show_themselves_in_a_notebook(runs):
    assert runs[0].plot()._repr_png_().startswith(b"\x89PNG")
    shown = Table("case", ("error (um)",), {"a<b": (1.5,)})._repr_html_()
    assert "<th>error (µm)</th>" in shown and "<td>a&lt;b</td><td>1.5</td>" in shown


def test_a_run_is_a_table_of_pandas(runs):
    pytest.importorskip("pandas", reason="pandas is missing: pip install leadscrew[pandas]")
    frame = runs[0].to_dataframe()
    assert frame.index.name == "time" and np.array_equal(frame.index, runs[0].time)
    assert list(frame.columns) == [name for name in runs[0].signals if name != "time"]
    assert np.array_equal(frame["output"], runs[0]["output"])


def test_without_pandas_a_run_says_what_to_install(runs, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="pip install pandas"):
        runs[0].to_dataframe()


def test_what_is_printed_fits_a_line(runs):
    shown = [repr(x) for x in (LOOP, STUDY, gain, runs[0], LOOP.batch(0.05, {"controller.kp": [1.0, 2.0]}))]
    assert all(len(text) < 300 and "\n" not in text and "NamedTuple" not in text for text in shown)
    assert shown[2].startswith("<controller ") and "kp=" in shown[2]
