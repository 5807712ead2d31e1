"""The report of a study with contents: its page, and its lines on a terminal."""

from __future__ import annotations

from dataclasses import replace
from html.parser import HTMLParser

import pytest

from leadscrew.report import drawing, html, text
from leadscrew.report.report import File, Report, StudyReport, TextTable
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
    assert "reproduced" in words and ("tiny.proportional_error" in words or columns < 80)


def test_the_summary_of_many_claims_has_forty_lines():
    row = ["A statement that is so long that it does not fit beside its numbers at all", "a little slower", "1",
           "2", "3", "µm", VERDICTS[1]]  # fmt: skip
    heads = ["statement", "paper", "as printed", "corrected", "ours", "unit", "verdict"]
    key = TextTable(heads, [row] * 12, [False] + [True] * 4 + [False] * 2, verdict=6)
    key = replace(key, rows=[[*row[:1], "2", *row[2:]]] * 10 + [row] * 2)
    long = StudyReport("a", "Title", conclusion=["Some words. " * 30], key_table=key, lines=["words " * 30] * 13)
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


def test_a_table_that_is_too_wide_is_printed_in_blocks_and_no_word_is_cut():
    heads = ["name", *(f"column{k}" for k in range(12))]
    table = TextTable(heads, [["a b", *(f"{k},222" for k in range(12))], ["x" * 90, *["1"] * 12]])
    lines = [line.plain for line in text.table_lines(replace(table, rows=table.rows[:1]), 40)]
    assert max(map(len, lines)) <= 40 and all(any(head in line.split() for line in lines) for head in heads)
    assert sum(line.startswith("name") for line in lines) == lines.count("") + 1 > 2, "the first column in each block"
    wide = [line.plain for line in text.table_lines(table, 40)]
    assert sum("x" * 90 in line for line in wide) >= 2, "a word that is wider than the terminal stays whole"


def test_a_column_that_holds_nothing_is_left_out():
    lines = [line.plain for line in text.table_lines(TextTable(["a", "", "b"], [["1", "", "2"]]), 40)]
    assert [line.split() for line in lines] == [["a", "b"], ["─", "─"], ["1", "2"]]
    assert text.table_lines(TextTable(["", ""], []), 40) == []


def test_numbers_stand_to_the_right_and_their_column_is_known_by_its_cells():
    rows = [["a", "1.5", "3 of 7", "20.1 µm", "yes", "–"], ["b c", "−22,222", "12 of 7", "–", "x", "–"]]
    assert list(TextTable(["name", "value", "of", "with unit", "word", "none"], rows).numeric) == [
        False, True, True, True, False, False,
    ]  # fmt: skip
    lines = [line.plain for line in text.table_lines(TextTable(["name", "value"], [r[:2] for r in rows]), 40)]
    assert lines[2].endswith("    1.5") and lines[3].endswith("−22,222") and len(lines[2]) == len(lines[3])


def test_what_a_report_prints_has_an_order_and_paths_are_never_cut(tmp_path):
    path = tmp_path / "a folder with a long name" / "x.json"
    made = Report(
        {}, parts=["One sentence.", "Another.", TextTable(["a"], [["1"]])], verdict="All is well.",
        files=[File("out", path, "the certificate of all that is well"), File("csv", None, "")],
    )  # fmt: skip
    lines = [line.plain for line in text.printed(made, 40)]
    assert lines[:3] == ["One sentence.", "Another.", ""] and lines[3].strip() == "a"
    assert lines[-2:] == [f"{path}: the", "  certificate of all that is well"]
    assert "All is well." in lines[:-2]
    failed = [line.plain for line in text.printed(replace(made, code=1), 40)]
    assert "All is well." not in failed, "the verdict of a command that fails is on stderr"


def test_a_column_of_ours_stands_only_where_there_is_one(results):
    claims = results.claims
    assert "ours" in claims_table(claims).heads
    assert "ours" not in claims_table([replace(c, ours=None) for c in claims]).heads
