"""``leadscrew run`` and ``demo`` of a study with contents: what is printed, written, listed and refused."""

from __future__ import annotations

import json
import shutil
from contextlib import nullcontext
from pathlib import Path

import pytest

from leadscrew import catalogue, machine
from leadscrew.cli import demo as demo_command
from leadscrew.report import drawing, index
from tests.cli.conftest import strict_json
from tests.machine.test_machine_file import EMPS

FILE = Path(__file__).parent / "tiny_study.py"


@pytest.fixture
def tiny(tmp_path, monkeypatch):
    """The tiny study, in a working folder of the user's own."""
    shutil.copy(FILE, tmp_path / "tiny.py")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("COLUMNS", raising=False)
    return "tiny.py:STUDY"


def beside(report):
    """What lies in the folder of a report but bytecode."""
    return {p.name for p in report.parent.iterdir()} - {"__pycache__"}


@pytest.fixture
def pages(monkeypatch):
    """No figure is drawn: that takes a second."""
    monkeypatch.setattr("leadscrew.report.drawing.beside", lambda *_: nullcontext(drawing.draw_none))


def test_the_summary_has_its_order_and_the_default_folder_is_listed(call, tiny):
    shown = call("run", tiny, "--no-figures").stdout.splitlines()
    places = [
        next(k for k, line in enumerate(shown) if text in line)
        for text in (
            "The error of a <prop",
            "0.100 mm & stays.",
            "Error at rest",
            "Integral action takes",
            "report.html",
        )
    ]
    assert places == sorted(places) and len(shown) <= 40
    assert all(line == line.rstrip() for line in shown)
    (card,) = index.cards(Path("report"))
    assert (card.name, card.link, card.numbers[0][0]) == ("tiny", "tiny/report.html", "0.1 mm")
    listed = Path("report/index.html").read_text(encoding="utf-8")
    assert "The error of a &lt;proportional&gt; controller" in listed and "0.100 mm &amp; stays." in listed
    assert 'href="tiny/report.html"' in listed
    assert "identical" in call("replay", "report/tiny/runs/step__paper.p").stdout


def test_a_list_of_somebody_else_stays(call, tiny):
    Path("report").mkdir()
    Path("report/index.html").write_text("mine")
    call("run", tiny, "--no-figures")
    assert Path("report/index.html").read_text() == "mine"


def test_json_is_one_strict_object(call, tiny):
    found = strict_json(call("run", tiny, "--out", "r", "--no-figures", "--json").stdout)
    assert list(found) == [
        "study", "title", "version", "schema_version", "kind", "wall_s", "conclusion", "claims", "experiments",
        "missed", "report",
    ]  # fmt: skip
    assert found["schema_version"] == 2 and found["report"] == str(Path("r/report.html"))
    assert found["experiments"][0]["table"]["rows"]["ours.pi"][1] is None, "a number that does not exist"
    assert not Path("report").exists()


def test_accepted_numbers_are_expected_and_another_one_is_missed(call, tiny):
    said = call("run", tiny, "--out", "r", "--no-figures", "--accept").stdout
    assert "expected.csv now holds the 6 numbers measured" in said
    assert "MISSED" not in call("run", tiny, "--out", "r", "--no-figures").stdout
    rows = Path("expected.csv").read_text()
    Path("expected.csv").write_text(rows.replace("0.09999999999999976,1e-07", "0.25,0.001", 1))
    said = call("run", tiny, "--out", "r", "--no-figures", code=1).stdout
    assert "MISSED proportional_error/as printed: 0.1, expected 0.25 ± 0.001" in said
    assert "MISSED proportional_error/as printed" in Path("r/report.html").read_text(encoding="utf-8")
    found = json.loads(call("run", tiny, "--out", "r", "--no-figures", "--json", code=1).stdout)
    assert [m["id"] for m in found["missed"]] == ["proportional_error/as printed"]


def test_what_has_no_claims_or_no_place_is_refused(refused, tiny, study):
    bare = "from dataclasses import replace\nBARE = replace(STUDY, contents=None)\n"
    Path("bare.py").write_text(Path("tiny.py").read_text() + bare)
    assert "tiny has no claims to judge: leadscrew simulate, compare or tune run it" in refused("run", "bare.py:BARE")
    machine.write("emps.toml", EMPS)
    assert "has no claims to judge: leadscrew simulate, compare or tune run it" in refused("run", "emps.toml")
    Path("file").write_text("x")
    assert "cannot be written" in refused("run", tiny, "--out", "file/below")
    for more in ((), ("--accept",), ("--no-figures",)):
        assert "has no claims to judge" in refused("run", study, *more)


def test_an_older_report_is_replaced_and_nothing_else_ever_is(call, refused, tiny, tmp_path):
    out = tmp_path / "report"
    call("run", tiny, "--out", out, "--no-figures")
    (out / "stale").write_text("of the older report")
    call("run", tiny, "--out", out, "--no-figures")
    assert not (out / "stale").exists() and beside(out) == {"report", "tiny.py"}
    shutil.rmtree(out)
    out.mkdir()
    call("run", tiny, "--out", out, "--no-figures")
    (out / "report.json").write_text('{"schema_version": 1, "kind": "a report of somebody else"}')
    assert "not a report of ours" in refused("run", tiny, "--out", out)
    (out / "report.json").unlink()
    assert "not a report of ours" in refused("run", tiny, "--out", out)
    (tmp_path / "file").write_text("x")
    assert "not a folder" in refused("run", tiny, "--out", tmp_path / "file")
    assert "cannot be written" in refused("run", tiny, "--out", tmp_path / "file" / "below")


def test_a_report_that_fails_half_way_leaves_the_older_one(call, tiny, tmp_path, monkeypatch):
    out = tmp_path / "report"
    call("run", tiny, "--out", out, "--no-figures")
    before = (out / "report.json").read_text()

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("leadscrew.report.html.page", full)
    assert "No space left" in call("run", tiny, "--out", out, code=2).stderr
    assert (out / "report.json").read_text() == before
    assert beside(out) == {"report", "tiny.py"}


def test_the_demo_lists_every_study_and_says_where(call, tiny, pages, monkeypatch):
    monkeypatch.setattr(demo_command, "STUDIES", (tiny,))
    said = call("demo").stdout
    assert str(Path("report/demo/index.html").resolve()) in said.replace("\n", "") and "Then try:" in said
    assert "The error at rest is 0.100 mm & stays. A PI removes it." in said
    assert "Integral action" not in said, "the demo judges key claims alone"
    again = strict_json(call("demo", "--json").stdout)
    assert [s["study"] for s in again["studies"]] == ["tiny"] and again["studies"][0]["missed"] == []
    assert [c.name for c in index.cards(Path("report/demo"))] == ["tiny"]


def test_the_demo_has_every_study_of_the_catalogue():
    assert sorted(demo_command.STUDIES) == sorted(catalogue.STUDIES)
