"""The page of a report, the picture of a run, and the numbers in their tables."""

from __future__ import annotations

import math
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from matplotlib.figure import Figure

from leadscrew.kernel.block import controller
from leadscrew.kernel.loop import Loop
from leadscrew.references.sine import sine_motion
from leadscrew.report import html, tables
from leadscrew.report.plots import run_figure
from leadscrew.report.strict import strict
from tests.cli.plain_study import LOOP, MISSED, STUDY, evaluate, gain, slide


@controller()
def follow(command, feedback):
    """Follows a motion."""
    return command.position - feedback


@pytest.fixture(scope="module")
def result():
    return evaluate()


@pytest.fixture(scope="module")
def page(result):
    manifest = {"command": "leadscrew run plain", "numpy": "<2>"}
    folders = {"small/p": "runs/small__p"}
    return html.render(STUDY, result, manifest=manifest, folders=folders, pictures=result.pictures)


class Tags(HTMLParser):
    """Collects tags, and checks that they close in order."""

    VOID = ("meta", "img", "br", "link")

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[tuple[str, dict]] = []

    def handle_starttag(self, tag, attrs):
        self.seen.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_page_is_whole_and_needs_no_network(page):
    parser = Tags()
    parser.feed(page)
    assert parser.open == []
    links = [a.get("src") or a.get("href") for _, a in parser.seen if "src" in a or "href" in a]
    assert all(x.startswith(("data:", "runs/")) for x in links)
    assert "<script" not in page and "url(" not in page and "@import" not in page
    images = [a for tag, a in parser.seen if tag == "img"]
    assert len(images) == 1 and images[0]["alt"] == "The way."


def test_texts_are_escaped(page):
    assert "A plain &lt;study&gt;" in page and "the paper &lt;forgets&gt; a term &amp; a sign" in page
    assert "&lt;2&gt;" in page


def test_a_denial_is_as_large_as_a_confirmation(page):
    cells = re.findall(r'<td><span class="verdict v\d">([^<]+)</span></td>', page)
    assert cells == ["reproduced", "not reproduced", "cannot be checked"]
    assert not re.search(r"\.v\d[^}]*font-size", page)


def test_the_numbers_stand_in_the_column_of_whose_they_are(result):
    assert tables.three_columns(result.claims[0]) == ("1", "1", "")
    assert tables.three_columns(result.claims[2]) == ("1", tables.NOTHING, "")
    assert tables.tally(result.claims).verdicts["not reproduced"] == 1
    assert [c.id for c in tables.missed(MISSED.evaluate(lambda *_: None).claims)] == ["plain.missed"]


def test_how_to_replay_is_told(page):
    assert "leadscrew replay runs/small__p" in page and "leadscrew run plain" in page


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
    assert [tables.number(x) for x in (None, math.nan, 1 / 3, True, "", np.eye(2), 12)] == [
        "–", "–", "0.333333", "yes", "–", "array 2 x 2", "12",
    ]  # fmt: skip
    assert tables.plain("the :class:`~a.b.Motion` of ``x``") == "the Motion of x"


def test_metric_units_follow_the_loop():
    loop = Loop(reference=sine_motion, controller=follow, plant=slide, engine="python")
    units = {r.name: r.unit for r in tables.metric_rows(loop.run(0.01))}
    assert units["rms_error"] == "mm" and units["settling_time"] == "s"
    assert all("[" not in u for u in units.values())
    assert tables.signal_unit(loop, "time") == "s" and tables.signal_unit(loop, "disturbance") == ""


def test_strict_json_has_no_infinity():
    assert strict({"a": np.array([1.0, np.nan]), "b": (np.float64(2), -math.inf), "c": np.bool_(True), 1: gain}) == {
        "a": [1.0, None], "b": [2.0, None], "c": True, "1": repr(gain),
    }  # fmt: skip
