"""The report of a study with contents: its page, and its lines on a terminal."""

from __future__ import annotations

from dataclasses import replace
from html.parser import HTMLParser

import pytest

from leadscrew.report import drawing, html, text
from leadscrew.report.report import Report, TextTable
from leadscrew.report.study import claims_table, report_of
from leadscrew.studies.claims import VERDICTS
from leadscrew.studies.results import evaluate
from tests.cli.tiny_study import STUDY


@pytest.fixture(scope="module")
def results():
    return evaluate(STUDY)


@pytest.fixture(scope="module")
def report(results):
    return report_of(results, [("step/paper.p", "runs/step__paper.p")], "leadscrew run tiny.py:STUDY")


class Tags(HTMLParser):
    """Collects tags and their ids, and checks that they close in order."""

    VOID = ("meta", "img", "br", "input")

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []
        self.ids: list[str] = []

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.links += [values[k] for k in ("src", "href") if k in values]
        self.ids += [values["id"]] if "id" in values else []
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_page_is_whole_escaped_and_needs_no_network(report):
    page = html.page(report, {"numpy": "<2>"}, drawing.draw_all(report, lambda what, done: None))
    tags = Tags()
    tags.feed(page)
    assert tags.open == [] and len(set(tags.ids)) == len(tags.ids)
    assert all(link.startswith("data:") or link[1:] in tags.ids for link in tags.links)
    assert "<script" not in page and "@import" not in page and "url(" not in page
    for foreign in ("a &lt;proportional&gt; controller", "mm &amp; stays", "ours &lt;PI&gt; &amp; more", "&lt;2&gt;"):
        assert foreign in page
    assert "<proportional>" not in page and "<code>leadscrew replay runs/step__paper.p</code>" in page
    order = ["0.100 mm", 'class="key"', "Key claims", "What the paper says", "What does integral", "leadscrew replay"]
    places = [page.index(words) for words in order]
    assert places == sorted(places)
    assert "min-width: 588px" in page, "a figure of 7 inches: its text stays legible on a telephone"


@pytest.mark.parametrize("columns", [40, 80, 100, 200])
def test_a_line_is_never_wider_than_the_terminal_and_no_word_is_cut(report, columns):
    wordy = replace(report, missed=["MISSED a/b: 1, expected 2 ± 0.1"], lines=["word " * 60])
    lines = [line.plain for line in text.whole(wordy, columns)]
    assert max(map(len, lines)) <= columns
    words = {word for line in lines for word in line.split()}
    assert "reproduced" in words or columns < 80
    assert "tiny.proportional_error" in words or columns < 100


def test_the_summary_of_many_claims_has_forty_lines():
    row = ["A statement that is so long that it does not fit beside its numbers at all", "a little slower", "1",
           "2", "3", "µm", VERDICTS[1]]  # fmt: skip
    heads = ["statement", "paper", "as printed", "corrected", "ours", "unit", "verdict"]
    key = TextTable(heads, [row] * 12, [False] + [True] * 4 + [False] * 2, verdict=6)
    key = replace(key, rows=[[*row[:1], "2", *row[2:]]] * 10 + [row] * 2)
    long = Report("a", "Title", conclusion=["Some words. " * 30], key_table=key, lines=["words " * 30] * 13)
    lines = [line.plain for line in text.summary(long, 100)]
    assert len(lines) <= 39 and max(map(len, lines)) <= 100, "the path of the report comes below"
    assert sum(line.endswith("with a change") for line in lines) == 12
    many = replace(long, missed=[f"MISSED {k}: 1, expected 2" for k in range(50)])
    assert "more MISSED" in text.summary(many, 100)[-1].plain


def test_columns_of_the_environment_are_honoured(monkeypatch):
    monkeypatch.setenv("COLUMNS", "57")
    assert text.width() == 57
    for nothing in ("", "0", "wide"):
        monkeypatch.setenv("COLUMNS", nothing)
        assert text.width() == text.PIPED


def test_a_word_that_is_wider_than_its_column_alone_is_cut_and_numbers_stand_to_the_right():
    table = TextTable(["name", "value (µm)"], [["x" * 90, "1"], ["a b", "22,222"]], [False, True])
    lines = [line.plain for line in text.table_lines(table, 40)]
    assert max(map(len, lines)) <= 40 and "".join(lines).count("x") == 90
    assert lines[3].endswith("      1") and lines[-1].endswith(" 22,222") and len(lines[3]) == len(lines[-1])


def test_a_column_of_ours_stands_only_where_there_is_one(results):
    claims = results.claims
    assert "ours" in claims_table(claims).heads
    assert "ours" not in claims_table([replace(c, ours=None) for c in claims]).heads
