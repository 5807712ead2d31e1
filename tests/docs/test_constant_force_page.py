"""The table of the page on constant force holds what the study measures now."""

from pathlib import Path

import pytest

from leadscrew.studies.grey_turning.beyond import NAMES, TABLE, beyond_of, table_row
from leadscrew.studies.grey_turning.runs import Loops

PAGE = Path(__file__).parents[2] / "docs" / "constant_force.md"


@pytest.mark.slow
def test_the_table_of_the_page_is_measured():
    found, lines = beyond_of(Loops()), PAGE.read_text(encoding="utf-8").splitlines()
    rows = {c[1].strip(" `"): [x.strip() for x in c[2:-1]] for c in (line.split("|") for line in lines) if len(c) == 10}
    for name in TABLE:
        assert tuple(rows[NAMES[name]]) == table_row(found, name), name
