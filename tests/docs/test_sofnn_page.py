"""The page on the network that learns while it cuts: the defaults of its table, the output of its example."""

import contextlib
import io
from pathlib import Path

import pytest

from leadscrew.controllers._sofnn import sofnn
from leadscrew.kernel.parameters import entries
from tests.docs.snippets import python_of, shown

PAGE = Path(__file__).parents[2] / "docs" / "sofnn.md"
TEXT = PAGE.read_text(encoding="utf-8")
SHEET = {e.key: e.default for e in entries(sofnn.params)}
ARRAYS = {"table", "prior", "net.hidden", "net.hidden_bias", "net.out", "net.out_bias", "net.linear"}


def table(header):
    """Cells of the rows of the table that begins with a header."""
    lines = TEXT.splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith(header))
    for line in lines[at + 2 :]:
        if not line.startswith("|"):
            return
        yield [c.strip().strip("`") for c in line.strip("|").split("|")]


def test_the_parameters_and_their_defaults_are_those_of_the_block():
    said = {row[0]: row[1] for row in table("| parameter |")}
    options = {k: v for k, v in SHEET.items() if isinstance(v, str)}
    assert {k: said.pop(k) for k in options} == options
    numbers = {k: pytest.approx(float(v), rel=1e-3) for k, v in SHEET.items() if k not in {*ARRAYS, *options}}
    assert {k: float(v) for k, v in said.items()} == numbers


@pytest.mark.slow
def test_the_example_prints_what_the_page_shows():
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(python_of(PAGE), str(PAGE), "exec"), {"__name__": "page"})
    assert out.getvalue().split() == shown(PAGE)[0].split()
