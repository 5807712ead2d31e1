"""The page on logs: its file, its commands and what they print."""

import re
import runpy

import numpy as np
import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.logs import look_at, plausible, signals
from leadscrew.logs.roles import ROLES
from leadscrew.logs.units import DRIVES, LENGTHS, TIMES
from leadscrew.util.reading import LOG_TEXT
from tests.docs.snippets import ROOT, blocks, python_of
from tests.fuzzy.formats_systems import shared

PAGE = ROOT / "docs" / "logs.md"


def plain(text):
    return [" ".join(line.split()) for line in text.splitlines()]


def test_what_the_page_shows_is_what_comes_out(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "page.py").write_text(python_of(PAGE), encoding="utf-8")
    runpy.run_path("page.py")
    shown = [body for _, body in blocks(PAGE, ("text",))]
    commands = [body for body in shown if body[0].startswith("$ ")]
    assert len(commands) == 2
    for body, code in zip(commands, (2, 0), strict=True):
        result = CliRunner().invoke(app, body[0].removeprefix("$ leadscrew ").split())
        assert result.exit_code == code, result.output
        assert plain(result.stdout) == plain("\n".join(body[1:]))
    printed = capsys.readouterr().out
    assert plain(printed) == plain("\n".join(shown[-1]))


def test_the_units_and_limits_of_the_page_are_those_of_the_code():
    text = PAGE.read_text(encoding="utf-8")
    for units in (LENGTHS, TIMES):
        assert all(re.search(rf"\b{unit}\b", text) for unit in units)
    assert all(unit in text for unit in DRIVES if unit != "mN m")
    assert all(role in text for role in ROLES)
    assert (signals.LEAST, signals.FEW, signals.STANDS, signals.PLACES) == (20, 200, 5.0, 6)
    assert plausible.MASS == {"m": (0.5, 5e3, "kg"), "rad": (1e-6, 1e2, "kg m^2")}
    assert "0.5 kg to 5 t or an inertia outside 1e-6 to 100 kg m^2" in text
    assert LOG_TEXT == 3e8 and "of text up to 300 MB" in text
    assert plausible.TOP["m"] == (20.0, 1e4, 100.0)


@pytest.mark.slow
def test_what_the_page_says_of_the_umich_mill_is_so():
    broken, largest = 0, 0.0
    for number in range(1, 19):
        seen = [
            look_at(
                shared(f"data/cnc_mill_umich/experiment_{number:02d}.csv"),
                {"position": f"{axis}_ActualPosition", "drive": "X1_CurrentFeedback"}, {"position": "mm"}, period=0.1,
            )
            for axis in ("X1", "Y1", "Z1")
        ]  # fmt: skip
        steps = [float(np.abs(np.diff(s.log.position)).max()) for s in seen if s.log is not None]
        assert len(steps) == 3
        if any(f.kind == "record" and "times" in f.sentence for s in seen for f in s.findings) and max(steps) > 0.03:
            broken, largest = broken + 1, max(largest, *steps)
    said = re.search(r"in (\d+) of them position and command jump by up to (\d+) mm", PAGE.read_text(encoding="utf-8"))
    assert said is not None and (broken, round(1e3 * largest, -1)) == (int(said[1]), float(said[2]))
