"""Texts of a user in what an export writes: nothing of them acts as C, HTML or a format."""

import ast
import html
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from leadscrew.export.c99 import shown_unit
from leadscrew.export.controller import export_controller
from leadscrew.export.core import Port
from leadscrew.export.fmu import _page
from leadscrew.export.plant import plant_files
from tests.export import hal_sample
from tests.export.table import loop_of


@pytest.mark.parametrize(
    ("unit", "shown"), [("mm", " mm"), ("%", " %"), ("%s/%d", " %s/%d"), ("1", ""), ("", ""), ('"\\n', ' "\\n')]
)
def test_a_unit_behind_a_number_of_printf_is_printed_and_takes_no_argument(unit, shown):
    text = shown_unit(Port("output", "output", "output", unit))
    # Python has C's rules of the percent sign and of quotes.
    assert ast.literal_eval(f'"{text}"') % () == shown


def test_the_name_of_a_loop_stays_inside_the_comments_of_its_simulated_machine():
    """What stands behind ``*/`` would be compiled into the machine."""
    loop = loop_of("pid").using({"controller.kp": 20.0})
    loop.name = "emps */\n#define PWNED 1\nstatic void pwned(void){}\n/*"
    core, _ = export_controller(loop, 0.05, name="ours", title='ours" "')
    files = plant_files(loop, core)
    assert any("pwned" in text for text in files.values())
    for name, text in files.items():
        outside = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL) if not name.endswith(".hal") else text
        assert "pwned" not in outside.lower(), name
    assert files["ours_plant.comp"].partition("component ")[2].split("\n")[0].count('"') == 2


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
