"""The page on the force guard: its defaults are those of the block, its lines for LinuxCNC those of the example."""

import re
from pathlib import Path

from leadscrew.kernel.parameters import entries
from leadscrew.studies.grey_turning.protection import SLOW_GUARD

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "force_guard.md"


def table(header):
    """Cells of the rows of the table that begins with a header."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith(header))
    for line in lines[at + 2 :]:
        if not line.startswith("|"):
            return
        yield [c.strip() for c in line.strip("|").split("|")]


def number(cell):
    return float(re.match(r"-?[\d.]+", cell)[0])


def test_the_parameters_and_their_defaults_are_those_of_the_block():
    own = {e.key: e.default for e in entries(SLOW_GUARD.params) if not e.key.startswith("inner.")}
    said = {row[0].strip("`"): row[1] for row in table("| parameter |")}
    assert {k: v if isinstance(own[k], str) else number(v) for k, v in said.items()} == own


def test_the_lines_for_linuxcnc_are_those_of_the_example():
    text = PAGE.read_text(encoding="utf-8")
    block = next(b for b in re.findall(r"```text\n(.*?)```", text, re.S) if "net override" in b)
    example = (ROOT / "examples" / "turning_guard.hal").read_text(encoding="utf-8").splitlines()
    assert [line for line in block.splitlines() if line not in example] == []
