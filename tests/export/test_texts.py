"""Texts of a user in what an export writes: nothing of them acts as C, HTML or a format."""

import ast
import html
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from leadscrew import Loop
from leadscrew.export import hal
from leadscrew.export.c99 import shown_unit
from leadscrew.export.controller import export_controller
from leadscrew.export.core import Port
from leadscrew.export.fmu import _page
from leadscrew.export.plant import plant_files
from leadscrew.plants._mass_lugre import mass_lugre
from leadscrew.plants._xy_table import xy_table
from leadscrew.references._step import step
from leadscrew.studies.npid_xytable.tunings import table_pid
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
    assert core.manifest["integration"] == loop.integration
    files = plant_files(loop, core)
    assert any("pwned" in text for text in files.values())
    for name, text in files.items():
        outside = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL) if not name.endswith(".hal") else text
        assert "pwned" not in outside.lower(), name
    assert files["ours_plant.comp"].partition("component ")[2].split("\n")[0].count('"') == 2


def machine_of(**options):
    parts = {"reference": step(target=0.01), "controller": table_pid(kp=1.0), "metrics": {}}
    return Loop(**parts, plant=options.pop("plant", mass_lugre), **options)


def test_the_readme_of_a_stiff_machine_names_its_method_and_that_its_time_has_no_bound():
    text = hal.readme(hal_sample.core("axis"), machine_of())
    assert "integrated by rodas (rtol 1e-06, atol 1e-09), as in the recorded loop" in text
    assert "the time of a period has no bound" in text
    fixed = hal.readme(hal_sample.core("axis"), machine_of(method="sdirk3", substeps=10))
    assert "integrated by sdirk3 (10 steps a period), as in the recorded loop" in fixed and "no bound" not in fixed
    assert "integrated by" not in hal.readme(hal_sample.core("axis"), machine_of(plant=xy_table))


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
