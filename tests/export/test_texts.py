"""Texts of a user in what an export writes: nothing of them acts as C, HTML or a format."""

import html
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from leadscrew.export.c99 import shown_unit
from leadscrew.export.core import Port
from leadscrew.export.fmu import _page
from tests.export import hal_sample


@pytest.mark.parametrize(
    ("unit", "shown"), [("mm", " mm"), ("%", " %"), ("%s/%d", " %s/%d"), ("1", ""), ("", ""), ('"\\n', " n")]
)
def test_a_unit_behind_a_number_of_printf_is_printed_and_takes_no_argument(unit, shown):
    text = shown_unit(Port("output", "output", "output", unit))
    # Python's formats have C's rule of the percent sign.
    assert text % () == shown and '"' not in text and "\\" not in text


def test_the_page_of_an_fmu_shows_what_a_user_wrote_and_runs_none_of_it():
    text = "a < b && <script>alert(1)</script> </pre> &lt;"
    seen = []

    class Reader(HTMLParser):
        def handle_starttag(self, tag, attrs):
            seen.append(tag)

    page = _page(replace(hal_sample.core("axis"), title=f"t {text}"), text)
    Reader().feed(page)
    assert seen == ["meta", "title", "pre"]
    assert html.unescape(page.partition("<pre>\n")[2].partition("</pre>")[0]) == text
